"""
Notices that trajectories are not executed, and when they are again.

A trajectory controller that was stopped, or never started, leaves the joints where they are.
That is no fault of a joint. The robot then stops planning, and tries again now and then:
for ``trial`` seconds after every ``pause``.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ExecutionOptions:
    """Times after which trajectories count as not executed, and to try again."""

    silence: float = 3.0
    """Time that the joints must not follow for that [s]."""
    pause: float = 2.0
    """Time in which nothing is planned then [s]."""
    trial: float = 4.0
    """Time after it in which the robot tries to go on [s]."""


class ExecutionCheck:
    """
    Decides whether to plan, by how long the joints have not followed.

    Parameters
    ----------
    options : ExecutionOptions, optional
        After how long.
    """

    def __init__(self, options: ExecutionOptions | None = None) -> None:
        self._options = ExecutionOptions() if options is None else options
        self.end()

    def end(self) -> None:
        """Find nothing wrong any more."""
        self._since = 0.0
        self._unfollowed = 0.0
        self.is_wrong = False
        """Whether the trajectories seem not to be executed."""
        self.is_pausing = False
        """Whether nothing is to be planned now."""
        self.has_tried = False
        """Whether the robot has had the time of a trial since the last pause."""

    def __str__(self) -> str:
        """Say what is wrong, with the numbers."""
        return (
            f'no joint has followed a trajectory for {self._unfollowed:.0f} s: '
            "is the controller that executes 'joint_trajectory' running, and nothing in the way?"
        )

    def update(self, time: float, unfollowed: float) -> None:
        """
        Take notice of the joints.

        Parameters
        ----------
        time : float
            Time now [s].
        unfollowed : float
            Time for which the joints have not followed what was given out [s]; 0 as soon as
            they follow.
        """
        options = self._options
        if unfollowed <= 0.0 or time < self._since:
            if self.is_wrong:
                self.end()
            return
        if not self.is_wrong:
            if unfollowed < options.silence:
                return
            self.is_wrong, self._since = True, time
        self._unfollowed = unfollowed
        was_pausing = self.is_pausing
        self.is_pausing = (time - self._since) % (options.pause + options.trial) < options.pause
        self.has_tried = self.is_pausing and not was_pausing and time > self._since
