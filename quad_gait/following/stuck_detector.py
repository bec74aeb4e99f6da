"""
Whether cycles have the effect that was planned: a robot may be stuck, or its joints not driven.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from quad_common.planar_pose import Pose2D

_BLOCKED_CYCLES = 3
"""Number of cycles in a row without the planned effect after which the robot gives up."""

_BLOCKED_TIME = 1.5
"""Time for which they must have lasted [s]: a trot that balances sways for several cycles."""

_TURN = 0.25
"""A turn of 1 rad counts as much as so many metres."""

_LARGEST_LACK = 0.7
"""A cycle of which a larger fraction is missing has had no effect; one that went too far has."""

_MOST_LATE = 0.4
"""Fraction of a cycle for which joints may have followed it late; of one that they followed for
less of its time little effect is to be expected."""

_LATE_COUNTS = 0.25
"""Part of a cycle that such a one counts: where all are late, a robot at a wall gives up, too."""

_TOO_LITTLE = 0.1
"""A fraction of the largest stride that tells nothing, as the first cycle of a gait that gathers
speed."""


@dataclass(frozen=True)
class Begun:
    """A motion that was begun, and where it is to lead."""

    time: float
    """Time at which it was planned [s]."""
    pose: Pose2D
    """Pose of the robot when it was planned, on the plan."""
    odometry: Pose2D
    """The same by odometry alone: a correction by a localiser moves nothing."""
    expected: Pose2D
    """Pose on the plan to which it is to bring the robot."""
    late: float = 0.0
    """Time for which joints had followed late by then, since the beginning [s]."""


class StuckDetector:
    """
    Compares what cycles were planned to do with what they did.

    Parameters
    ----------
    largest_stride : float
        Of the robot [m].
    """

    def __init__(self, largest_stride: float) -> None:
        self._least = _TOO_LITTLE * largest_stride
        self._since = 0.0
        self.reset()

    def reset(self) -> None:
        """Count from here: something new is wished for."""
        self._without_effect = 0
        self._weight = 0.0

    def problem(
        self,
        begun: Begun,
        time: float,
        odometry: Pose2D,
        late: float = 0.0,
        expected: Pose2D | None = None,
    ) -> str | None:
        """
        Say how little came of the last cycles, if they did not move the robot.

        Parameters
        ----------
        begun : Begun
            The motion whose effect is looked at.
        time : float
            Now [s].
        odometry : Pose2D
            Where the robot is now, by odometry alone.
        late : float
            Time for which joints have followed late up to now, since the beginning [s].
        expected : Pose2D, optional
            Where the motion should have brought it by now, on the plan; its end if not given.

        Returns
        -------
        str or None
            A sentence; None if the cycle had effect, or too few had none.
        """
        planned = begun.pose.inverse() @ (begun.expected if expected is None else expected)
        done = begun.odometry.inverse() @ odometry
        size = _size(planned)
        if size < self._least:
            return None
        is_near = _size(planned.inverse() @ done) < _LARGEST_LACK * size
        # Odometry that is corrected, as a camera's is, may show more than was planned.
        has_effect = is_near or _along(planned, done) > (1.0 - _LARGEST_LACK) * size
        if has_effect:
            self.reset()
            return None
        if self._without_effect == 0:
            self._since = begun.time
        self._without_effect += 1
        is_late = late - begun.late > _MOST_LATE * (time - begun.time)
        self._weight += _LATE_COUNTS if is_late else 1.0
        cycles = self._without_effect
        if self._weight < _BLOCKED_CYCLES or time - self._since < _BLOCKED_TIME:
            return None
        self.reset()
        return (
            f'the robot does not follow its commands: {cycles} cycles without effect, '
            f'the last planned {math.hypot(planned.x, planned.y):.3f} m and '
            f'{math.degrees(planned.yaw):.1f} degrees and gave '
            f'{math.hypot(done.x, done.y):.3f} m and {math.degrees(done.yaw):.1f} degrees; '
            f'is it stuck, or is its joint controller not running?'
        )


def _size(motion: Pose2D) -> float:
    return math.hypot(motion.x, motion.y, _TURN * motion.yaw)


def _along(planned: Pose2D, done: Pose2D) -> float:
    """Return how far a motion went in the direction of another one."""
    turned = _TURN * planned.yaw * _TURN * done.yaw
    return (planned.x * done.x + planned.y * done.y + turned) / _size(planned)
