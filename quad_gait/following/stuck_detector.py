"""
Whether cycles have the effect that was planned: a robot may be stuck, or nobody moves it.
"""

from __future__ import annotations

import math

from quad_common.planar_pose import Pose2D

_BLOCKED_CYCLES = 3
"""After so many cycles without the planned effect in a row the robot gives up."""

_TURN = 0.25
"""A turn of 1 rad counts as much as so many metres."""

_LARGEST_LACK = 0.7
"""A cycle of which a larger share is missing has had no effect."""

_TOO_LITTLE = 0.1
"""A share of the largest stride that tells nothing, as the first cycle of a gait that gathers
speed."""


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
        self._begun_at: tuple[Pose2D, Pose2D] | None = None
        self._without_effect = 0

    def begin(self, pose: Pose2D, odometry: Pose2D) -> None:
        """Note where the robot is, on the plan and by odometry, when its cycle is planned."""
        self._begun_at = pose, odometry

    def forget(self) -> None:
        """Leave the cycle out: something else moved the robot."""
        self._begun_at = None

    def begin_anew(self) -> None:
        """Count from here: something new is wished for."""
        self._without_effect = 0

    def problem(self, odometry: Pose2D, expected: Pose2D) -> str | None:
        """
        Say how little came of the last cycles, if they did not move the robot.

        Parameters
        ----------
        odometry : Pose2D
            Where the robot is now by odometry alone: a correction by a localiser moves nothing.
        expected : Pose2D
            Where the cycle that was begun last should have brought it by now, on the plan.

        Returns
        -------
        str or None
            A sentence; None if the cycle had effect, or too few had none.
        """
        if self._begun_at is None:
            return None
        pose_before, odometry_before = self._begun_at
        self._begun_at = None
        planned = pose_before.inverse() @ expected
        done = odometry_before.inverse() @ odometry
        size = _size(planned)
        if size < self._least:
            return None
        has_effect = _size(planned.inverse() @ done) < _LARGEST_LACK * size
        self._without_effect = 0 if has_effect else self._without_effect + 1
        if self._without_effect < _BLOCKED_CYCLES:
            return None
        self._without_effect = 0
        return (
            f'the robot does not follow its commands: {_BLOCKED_CYCLES} cycles without effect, '
            f'the last planned {math.hypot(planned.x, planned.y):.3f} m and '
            f'{math.degrees(planned.yaw):.1f} degrees and gave '
            f'{math.hypot(done.x, done.y):.3f} m and {math.degrees(done.yaw):.1f} degrees; '
            f'is it stuck, or is its joint controller not running?'
        )


def _size(way: Pose2D) -> float:
    return math.hypot(way.x, way.y, _TURN * way.yaw)
