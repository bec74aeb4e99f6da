"""
The time that is shown of a recording: it runs, stands still, or is set.
"""

from __future__ import annotations

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 10.0)
"""Recorded over real time that can be chosen."""


class Timeline:
    """
    A time between two ends.

    Parameters
    ----------
    start, end : float
        First and last time of what is recorded [s].
    """

    def __init__(self, start: float, end: float) -> None:
        self.start, self.end = start, end
        """First and last time [s]."""
        self.time = start
        """Time that is shown [s]."""
        self.speed = 1.0
        """Recorded over real time, one of :data:`SPEEDS`."""
        self.is_playing = True
        """Whether it runs."""

    @property
    def duration(self) -> float:
        """Time between the two ends [s]."""
        return self.end - self.start

    @property
    def elapsed(self) -> float:
        """Time since the first end [s]."""
        return self.time - self.start

    def advance(self, passed: float) -> None:
        """Run for some real time [s]; at the end it stops."""
        if not self.is_playing:
            return
        self.seek(self.elapsed + passed * self.speed)
        if self.time >= self.end:
            self.is_playing = False

    def seek(self, elapsed: float) -> None:
        """Show the time that is so far from the first end [s], or the nearest there is."""
        self.time = self.start + min(max(elapsed, 0.0), self.duration)

    def toggle(self) -> None:
        """Stand still, or go on; from the beginning if the end has been reached."""
        if not self.is_playing and self.time >= self.end:
            self.time = self.start
        self.is_playing = not self.is_playing
