"""
The course of a swing: where body and feet are at any time of it.

A foot feels for the ground straight down, gently at first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.footing.shin_room import ShinRoom
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.state.body_placement import BodyPose
from quad_gait.uneven.foot_aims import FootAim
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.joint_motion import JointMotion

Array = NDArray[np.float64]

_STAIRS = 0.1
"""Rise of the plane through the feet from which on shins are at edges wherever the body goes."""


@dataclass(frozen=True)
class SwingTimes:
    """When which part of a swing is done [s]."""

    shift: float
    """Time at which the body is where it goes."""
    lift: float
    """Time at which the foot is lifted."""
    lift_end: float
    """Time at which it is at the top."""
    over_end: float
    """Time at which it is over its place."""
    fall: float
    """Time at which it begins to be lowered."""
    low: float
    """Time at which it begins to feel for the ground."""


@dataclass(frozen=True)
class SwingCourse:
    """Body and feet, while one foot swings."""

    leg: int
    """Index of the leg that swings."""
    standing: Array
    """Centers of the feet before it, shape (4, 3) [m]."""
    aim: FootAim
    """Where the foot goes, and what it passes."""
    body: BodyPose
    """Pose of the body after it."""
    at: SwingTimes
    """When which part of it is done."""
    search_speed: float
    """Speed at which the foot feels for the ground [m/s]."""
    times: Array
    """Times of its samples, from 0 on, shape (n,) [s]."""
    stands: bool
    """Whether the foot still stands, and is lifted only when the others do."""

    def sample_at(self, time: float) -> int:
        """Return the first sample that is not before a time [s]."""
        return int(np.searchsorted(self.times, time))

    @property
    def sure(self) -> int:
        """Sample at which the foot is where the ground should be."""
        return self.sample_at(self.at.low + self.aim.above / self.search_speed)

    def check_shins(self, robot: Robot, ground: GroundModel, clearance: float) -> None:
        """
        Raise ShinTooNear if one comes too near to the ground where the body goes.

        Before the foot is lifted, unless it is in the air, and after it has come down; not on
        stairs.

        Parameters
        ----------
        robot : Robot
            The robot.
        ground : GroundModel
            What is known of the ground.
        clearance : float
            Distance of shins from it [m].
        """
        if ground.height_map is None or math.hypot(*ground.slope) > _STAIRS:
            return
        after = self.standing.copy()
        after[self.leg] = self.aim.target
        stances = np.stack([self.standing, after] if self.stands else [after])
        room = ShinRoom(robot, clearance, ground.height_map, ground.shift)
        room.check(self.body.position, self.body.rotation, stances)

    def progress(self, times: Array) -> Array:
        """Return which fraction of the body's motion is done at some times, (m,) [s]."""
        return minimum_jerk(0.0, self.at.shift, times)[0]

    def feet(self, times: Array) -> Array:
        """
        Place the feet.

        Parameters
        ----------
        times : ndarray, shape (m,)
            [s]

        Returns
        -------
        ndarray, shape (m, 4, 3)
            Their centers [m]; of the one that swings if it meets no ground.
        """
        at, (target, top, above, depth, _) = self.at, self.aim
        start = self.standing[self.leg]
        over = minimum_jerk((at.lift + at.lift_end) / 2.0, at.over_end, times)[0]
        height = start[2] + (top - start[2]) * minimum_jerk(at.lift, at.lift_end, times)[0]
        if at.low > at.fall:
            height += (target[2] + above - top) * minimum_jerk(at.fall, at.low, times)[0]
        height -= searched(times - at.low, self.search_speed, above + depth)
        feet = np.repeat(self.standing[None], len(times), axis=0)
        feet[:, self.leg, :2] += over[:, None] * (target - start)[:2]
        feet[:, self.leg, 2] = height
        return feet

    @property
    def telling(self) -> Array:
        """Times at which legs are most likely not to reach: foot lifted, at the top, down [s]."""
        last = len(self.times) - 1
        samples = [self.sample_at(t) for t in (self.at.lift, self.at.lift_end)]
        chosen: Array = self.times[[min(k, last) for k in (*samples, self.sure)]]
        return chosen


@dataclass(frozen=True)
class PlannedSwing:
    """A motion in which one foot swings, or feels for the ground."""

    motion: JointMotion
    """Motion of all joints."""
    lifted_at: int
    """Sample from which on the foot is in the air."""
    feels_from: int
    """Sample from which on it may meet the ground."""
    falls_from: int
    """Sample from which on it is lowered."""
    given: int
    """Sample up to which it is given out as soon as the other feet are seen to stand."""
    depth: float
    """Depth below the expected ground down to which the foot feels for it [m]."""
    limit: str = ''
    """Reason why it is shorter than wanted; empty if it is not."""


def ramp(duration: float) -> float:
    """Return how much longer a search takes because it begins gently [s]."""
    return 0.0 if duration <= 0.0 else 0.03


def searched(times: Array, speed: float, depth: float) -> Array:
    """Return how far down a foot has felt: it gathers speed, then keeps it [m]."""
    begun = 2.0 * ramp(1.0)
    gathered = np.where(times < begun, times**2 / (2.0 * begun), times - begun / 2.0)
    distances: Array = np.clip(speed * np.where(times > 0.0, gathered, 0.0), 0.0, depth)
    return distances
