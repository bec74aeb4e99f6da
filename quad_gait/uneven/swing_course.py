"""
The course of a swing: where body and feet are at any time of it.

A foot feels for the ground straight down, gently at first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.footing.shin_room import ShinRoom
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.state.body_balance import BodyBalance
from quad_gait.state.body_placement import BodyPose, balanced, body_over, heading_over
from quad_gait.state.stance import Stance
from quad_gait.uneven.body_pace import BodyPace
from quad_gait.uneven.foot_aims import FootAim
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.joint_motion import JointMotion
from quad_gait.uneven.uneven_options import UnevenOptions

Array = NDArray[np.float64]

_LIFT_AT = 0.85
"""A foot is lifted after this fraction of the time in which the body goes over the others."""

_STAIRS = 0.1
"""Rise of the plane through the feet from which on shins are at edges wherever the body goes."""


class Swing(NamedTuple):
    """What one foot is to do."""

    leg: int
    """Index of the leg."""
    aim: FootAim
    """Where the foot goes, and what it passes."""
    pace: float
    """Fraction of its speed at which the foot goes there."""
    stands: bool
    """Whether it still stands, and is lifted only when the others do."""


class Posture(NamedTuple):
    """Pose of the body over the other feet."""

    tilt: float
    """Fraction of the ground's tilt that the body takes."""
    lower: float
    """Height by which the body is lower than in its initial posture, TITAN-VIII's [m]."""
    has_less_margin: bool = False
    """Whether the body is no farther inside the other feet than it must be."""


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


class SwingCourses:
    """
    Lays the courses of swings.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    """

    def __init__(self, robot: Robot, options: UnevenOptions) -> None:
        self._robot, self._options, self._scale = robot, options, robot.relative_size
        self._balance, self._body_pace = BodyBalance(robot), BodyPace(robot, options)

    def lay(self, now: Stance, ground: GroundModel, swing: Swing, posture: Posture) -> SwingCourse:
        """
        Lay a course, whether legs reach or not.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        ground : GroundModel
            What is known of the ground.
        swing : Swing
            What the foot is to do.
        posture : Posture
            Where the body goes meanwhile.

        Returns
        -------
        SwingCourse
        """
        options, robot, scale = self._options, self._robot, self._scale
        leg, (target, top, above, depth, _), pace, stands = swing
        start = now.feet[leg]
        feet = now.feet.copy()
        feet[leg] = 0.5 * (start + target)
        feet[leg, 2] = target[2]
        yaw = heading_over(robot, feet)
        body = body_over(robot, feet, yaw, ground.slope, posture.tilt)
        body = body.lowered(scale * posture.lower)
        margin = options.least_margin if posture.has_less_margin else options.margin
        triangle = np.delete(now.feet[:, :2], leg, axis=0)
        inside = partial(balanced, triangle=triangle, margin=scale * margin)
        body = self._balance.balanced(body, now, inside)

        shift = self._body_pace.duration(now, body)
        # The body need not be quite there: it is slow at the end of its motion.
        lift = _LIFT_AT * shift
        lift_end = lift + self._lasting(top - start[2], options.lift_time, pace)
        across = math.dist(start[:2], target[:2])
        over_end = lift_end + self._lasting(across, options.transfer_time, pace)
        fall = over_end - 0.2 * options.transfer_time
        to_feel = top - target[2] - above
        low = fall + (self._lasting(to_feel, options.lower_time, pace) if to_feel > 0.0 else 0.0)
        speed = scale * options.search_speed
        search = (above + depth) / speed
        times = sample_times(low + search + ramp(search), options.sample_period)
        at = SwingTimes(shift, lift, lift_end, over_end, fall, low)
        return SwingCourse(leg, now.feet, swing.aim, body, at, speed, times, stands)

    def _lasting(self, distance: float, least: float, pace: float) -> float:
        """Return how long a foot takes for a distance [m] at a pace [s]."""
        return max(least, float(distance) / (self._scale * pace * self._options.foot_speed))


def sample_times(duration: float, period: float) -> Array:
    """Return the times of samples of a motion, about a period apart, from 0 on [s]."""
    count = max(2, round(duration / period))
    return np.linspace(0.0, duration, count + 1, dtype=np.float64)


def ramp(duration: float) -> float:
    """Return how much longer a search takes because it begins gently [s]."""
    return 0.0 if duration <= 0.0 else 0.03


def searched(times: Array, speed: float, depth: float) -> Array:
    """Return how far down a foot has felt: it gathers speed, then keeps it [m]."""
    begun = 2.0 * ramp(1.0)
    gathered = np.where(times < begun, times**2 / (2.0 * begun), times - begun / 2.0)
    distances: Array = np.clip(speed * np.where(times > 0.0, gathered, 0.0), 0.0, depth)
    return distances
