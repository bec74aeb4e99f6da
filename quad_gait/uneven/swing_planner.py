"""
Plans motions of body and feet over ground that is not flat, from where the feet stand.

Nothing is remembered here: what has been met, and what comes next, `uneven_stride` knows.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.footing.shin import shin_points
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.state.body_balance import BodyBalance
from quad_gait.state.body_placement import (
    balanced_on_four,
    body_over,
    heading_over,
)
from quad_gait.state.stance import Stance
from quad_gait.uneven.body_pace import BodyPace
from quad_gait.uneven.candidates import (
    IN_PLACE,
    LEANS,
    LEVEL_VARIANTS,
    LOWEST,
    POSTURES,
    QUICK_SEARCHES,
    SEARCHES,
    STRAINED_VARIANTS,
    VARIANTS,
    first_possible,
)
from quad_gait.uneven.foot_aims import FootAim, FootAims
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.joint_motion import JointMotion
from quad_gait.uneven.path_motion import PlannedPaths, may_reach, motion_along, motion_back
from quad_gait.uneven.swing_course import (
    PlannedSwing,
    Posture,
    Swing,
    SwingCourse,
    SwingCourses,
    ramp,
    sample_times,
    searched,
)
from quad_gait.uneven.uneven_options import UnevenOptions

Array = NDArray[np.float64]

_STRETCHED = 0.4
"""Fraction of its speed at which a leg comes back from where there was no ground: it is stretched
then, and its knee would be too fast."""

BIT = 3
"""Number of samples of a search given out at a time: a foot presses on for no longer."""

_LARGEST_LEAN = 0.15
"""Angle by which the body turns over its feet to its heading, at most [rad]."""


class SwingPlanner:
    """
    Plans swings, searches and shifts of the body.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    swing_height : float
        Of the gait on even ground [m].
    """

    def __init__(self, robot: Robot, options: UnevenOptions, swing_height: float) -> None:
        self._robot, self._scale = robot, robot.relative_size
        self._options, self._aims = options, FootAims(robot, options, swing_height)
        self._along = partial(motion_along, robot, options)
        self._balance = BodyBalance(robot)
        self._body_pace, self._courses = BodyPace(robot, options), SwingCourses(robot, options)
        self._times = partial(sample_times, period=options.sample_period)

    def swing(
        self,
        now: Stance,
        commanded: Array | None,
        ground: GroundModel,
        leg: int,
        place: Array,
        stands: bool = True,
    ) -> PlannedSwing:
        """
        Plan a swing, shorter or with the body at a tilt if the legs do not reach.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        commanded : ndarray, shape (4, 3), or None
            Where the joints are commanded to be [rad]; None: where they are.
        ground : GroundModel
            What is known of the ground.
        leg : int
            Which one swings.
        place : ndarray, shape (2,)
            Where its foot should stand then [m].
        stands : bool
            Whether the foot still stands, and is lifted only when the others do.

        Returns
        -------
        PlannedSwing
            The first of many candidates that legs and joints can do.

        Raises
        ------
        GaitError
            If they can do none.
        """
        start, feels, aims = now.feet[leg], now.loads is not None, self._aims
        shin_clearance = self._scale * self._options.shin_clearance
        shin = shin_points(self._robot, leg, place - start[:2], now.body.yaw)
        if stands:
            self._balance.check_support(now, leg, self._scale * self._options.least_margin)

        @cache
        def target(fraction: float) -> Array:
            return aims.target(ground, start, place, fraction, shin)

        @cache
        def aim(fraction: float, clearance: float) -> FootAim:
            return aims.aim(ground, start, target(fraction), feels, clearance)

        @cache
        def course(*kind: float) -> SwingCourse:
            fraction, tilt, lower, clearance, *less = kind
            swing = Swing(leg, aim(fraction, clearance), 1.0, stands=stands)
            return self._courses.lay(now, ground, swing, Posture(tilt, lower, bool(less)))

        def plan(*kind: float) -> tuple[tuple[float, ...], PlannedSwing]:
            return kind, self._swing_along(now, commanded, course(*kind))

        def may_do(*kind: float) -> bool:
            return self._may_reach(now, course(*kind))

        def plan_free(*kind: float) -> tuple[tuple[float, ...], PlannedSwing]:
            course(*kind).check_shins(self._robot, ground, shin_clearance)
            return plan(*kind)

        (kind, swing), problem = first_possible(plan, (*VARIANTS, *STRAINED_VARIANTS), may_do)
        try:
            course(*kind).check_shins(self._robot, ground, shin_clearance)
        except GaitError as too_near:
            # A shin at an edge is the smaller evil, where there is no other way.
            with suppress(GaitError):
                (kind, swing), _ = first_possible(plan_free, LEVEL_VARIANTS, may_do)
                problem = too_near
        return swing if kind[0] == 1.0 else replace(swing, limit=f'a step was shortened: {problem}')

    def swing_onto(
        self,
        now: Stance,
        commanded: Array | None,
        ground: GroundModel,
        leg: int,
        place: Array,
        stands: bool = True,
    ) -> PlannedSwing:
        """Plan a swing just to a foothold that was chosen, or none; else as `swing`."""
        start, feels, aims = now.feet[leg], now.loads is not None, self._aims
        target = aims.foot_on(ground, place)

        @cache
        def aim(clearance: float) -> FootAim:
            return aims.aim(ground, start, target, feels, clearance)

        @cache
        def course(*kind: float) -> SwingCourse:
            tilt, lower, clearance, pace, less = kind
            swing = Swing(leg, aim(clearance), pace, stands=stands)
            return self._courses.lay(now, ground, swing, Posture(tilt, lower, less > 0.0))

        def plan(*kind: float) -> PlannedSwing:
            return self._swing_along(now, commanded, course(*kind))

        def may_do(*kind: float) -> bool:
            return self._may_reach(now, course(*kind))

        return first_possible(plan, IN_PLACE, may_do)[0]

    def swing_back(
        self, now: Stance, commanded: Array | None, ground: GroundModel, leg: int, target: Array
    ) -> PlannedSwing:
        """Plan the return to where a foot stood, its center, shape (3,) [m]; as `swing`."""
        aim = self._aims.aim(ground, now.feet[leg], target, now.loads is not None, 1.0)
        swing = Swing(leg, aim, _STRETCHED, stands=False)

        def plan(tilt: float, lower: float) -> PlannedSwing:
            course = self._courses.lay(now, ground, swing, Posture(tilt, lower))
            return self._swing_along(now, commanded, course)

        return first_possible(plan, POSTURES)[0]

    def way_back(self, now: Stance, way: list[Array]) -> PlannedSwing:
        """Plan the return of a foot by the way that the joints came since it was lifted."""
        motion = motion_back(self._robot, self._options, now, way)
        last = len(motion.times) - 1
        # It is in touch with what it has met at first.
        return PlannedSwing(motion, 0, last, last, given=last, depth=0.0)

    def search(
        self, now: Stance, commanded: Array | None, legs: list[int], quickly: bool = False
    ) -> JointMotion:
        """Plan how feet that bear nothing are lowered; quickly, and deep, where another slips."""
        depth = 2.0 * self._robot.step_height if quickly else 1.5 * self._robot.roughness

        def plan(factor: float) -> JointMotion:
            speed = factor * self._scale * self._options.search_speed
            times = self._times(depth / speed + ramp(depth))
            feet = np.repeat(now.feet[None], len(times), axis=0)
            feet[:, legs, 2] -= searched(times, speed, depth)[:, None]
            still = np.zeros(len(times))
            paths = PlannedPaths(times, now.body, still, feet, sure=2, given=BIT)
            return self._along(now, commanded, paths)

        return first_possible(plan, QUICK_SEARCHES if quickly else SEARCHES)[0]

    def search_some(
        self, now: Stance, commanded: Array | None, legs: list[int]
    ) -> tuple[JointMotion, list[int]]:
        """Plan how feet are lowered, all or the first one that can be; return which, too."""
        kinds = dict.fromkeys([tuple(legs), *((leg,) for leg in legs)])

        def plan(*some: float) -> tuple[JointMotion, list[int]]:
            lowered = [int(leg) for leg in some]
            return self.search(now, commanded, lowered), lowered

        return first_possible(plan, kinds)[0]

    def search_deeper(
        self, now: Stance, commanded: Array | None, leg: int, depth: float
    ) -> PlannedSwing:
        """Plan how the body is lowered, so that a foot gets farther down."""
        speed = self._scale * self._options.search_speed
        target = now.body.lowered(self._scale * LOWEST)
        shift = self._body_pace.duration(now, target)
        times = self._times(shift + depth / speed + ramp(depth))
        path = np.repeat(now.feet[None], len(times), axis=0)
        path[:, leg, 2] -= searched(times - shift, speed, depth)
        sure, progress = int(np.searchsorted(times, shift)), minimum_jerk(0.0, shift, times)[0]
        paths = PlannedPaths(times, target, progress, path, sure + 1, sure)
        motion = self._along(now, commanded, paths)
        return PlannedSwing(motion, 0, 0, 0, given=motion.given, depth=depth)

    def shift(
        self, now: Stance, commanded: Array | None, ground: GroundModel, place: Pose2D
    ) -> JointMotion:
        """
        Plan how the body gets to its place over its four feet.

        Footholds are chosen, so their middle is not where the body was to go: it leans there, as
        far as the legs reach. Else a robot that corrects its pose would take the same footholds
        again and again, and stay where it is.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        commanded : ndarray, shape (4, 3), or None
            Where the joints are commanded to be [rad]; None: where they are.
        ground : GroundModel
            What is known of the ground.
        place : Pose2D
            Where the body is to be.

        Returns
        -------
        JointMotion

        Raises
        ------
        GaitError
            If no posture will do.
        """
        yaw = heading_over(self._robot, now.feet)
        lean = wrap_angle(place.yaw - yaw)
        lean = float(np.clip(lean, -_LARGEST_LEAN, _LARGEST_LEAN))
        # Feet that were left behind may be behind the place, too.
        margin = self._scale * self._options.margin
        inside = partial(balanced_on_four, feet=now.feet[:, :2], margin=margin)

        def plan(fraction: float, tilt: float, lower: float) -> JointMotion:
            heading = yaw + fraction * lean
            target = body_over(self._robot, now.feet, heading, ground.slope, tilt)
            target = target.lowered(self._scale * lower)
            target = target.leaning_to(place, fraction, self._scale * self._options.foothold_reach)
            target = self._balance.balanced(target, now, inside)
            duration = self._body_pace.duration(now, target)
            times = self._times(duration)
            progress = minimum_jerk(0.0, duration, times)[0]
            feet = np.repeat(now.feet[None], len(times), axis=0)
            return self._along(now, commanded, PlannedPaths(times, target, progress, feet))

        return first_possible(plan, LEANS)[0]

    def _swing_along(
        self, now: Stance, commanded: Array | None, course: SwingCourse
    ) -> PlannedSwing:
        times, sure = course.times, course.sure
        at = course.at
        lifted_at, feels, falls = map(course.sample_at, (at.lift, at.lift_end, at.fall))
        given = len(times) - 1
        if now.loads is not None:
            # Without a map the ground may be anywhere on the way down.
            given = sure if course.aim.is_certain else course.sample_at(course.at.low)
        begun = lifted_at if course.stands and now.loads is not None else given
        # What is below the ground only matters where it is missing: as deep as legs reach.
        paths = PlannedPaths(
            times, course.body, course.progress(times), course.feet(times), sure + 1, begun
        )
        motion = self._along(now, commanded, paths)
        given = min(given, len(motion.times) - 1)
        return PlannedSwing(motion, lifted_at, feels, falls, given, course.aim.depth)

    def _may_reach(self, now: Stance, course: SwingCourse) -> bool:
        """Tell whether legs reach at a few samples: most courses that they do not, show it."""
        times = course.telling
        paths = PlannedPaths(times, course.body, course.progress(times), course.feet(times))
        return may_reach(self._robot, now, paths)
