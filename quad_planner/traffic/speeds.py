"""
How fast robots walk, as they were seen to.
"""

from __future__ import annotations

from quad_common.planar_pose import Pose2D

_SHORTEST = 0.15
"""Least time between two poses that tell a speed [s]."""

_FASTEST = 3.0
"""A robot that seems faster was moved, or relocalised [m/s]."""


class Speeds:
    """The largest speed that each robot was seen to have."""

    def __init__(self) -> None:
        self._seen: dict[str, float] = {}
        self._last: dict[str, tuple[float, Pose2D]] = {}

    def take(self, name: str, time: float, pose: Pose2D) -> None:
        """Take a robot's pose at a time [s]."""
        before, last = self._last.get(name, (time, pose))
        if name in self._last and 0.0 <= time - before < _SHORTEST:
            return
        self._last[name] = time, pose
        if time > before:
            speed = pose.distance_to(last) / (time - before)
            if speed < _FASTEST:
                self._seen[name] = max(speed, self._seen.get(name, 0.0))

    def of(self, name: str, unseen: float) -> float:
        """Return a robot's speed [m/s]; another number for one that was not seen to walk."""
        speed = self._seen.get(name, 0.0)
        return speed if speed > 0.0 else unseen

    def bring_over(self, before: Pose2D) -> None:
        """Go on in another frame, in which the one before has a pose: no robot has moved."""
        self._last = {name: (at, before @ pose) for name, (at, pose) in self._last.items()}

    def forget(self, name: str) -> None:
        """Forget a robot that has left."""
        self._seen.pop(name, None)
        self._last.pop(name, None)
