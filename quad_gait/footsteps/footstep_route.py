"""
Footsteps along a path: planned ahead, given out as strides, planned again when feet go astray.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import FootstepsNotFound
from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_gait.footsteps.foothold_map import FootholdMap
from quad_gait.footsteps.footstep import Footstep
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.footstep_planner import FootstepPlanner, pose_over
from quad_gait.footsteps.pieces import Pieces
from quad_gait.state.body_placement import strain_over
from quad_gait.state.stance import Stance
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.stride_goal import StrideGoal
from quad_gait.uneven.uneven_options import UnevenOptions

Array = NDArray[np.float64]

_LOOK, _APART = 0.5, 0.03
"""Length of the way ahead that must be even for strides without footsteps, and distance between
the places that are looked at [m, of TITAN-VIII]."""

_HORIZONS = (1.0, 0.5, 0.25)
"""Fractions of the horizon to which footsteps are planned."""

_LARGEST_TURN = 0.6
"""Largest turn for which footsteps are planned at once [rad]."""

_MOST_BLOCKED = 20
"""Number of footholds that are kept out of plans because a leg could not get there."""


class FootstepRoute:
    """
    Gives strides over planned footholds.

    Parameters
    ----------
    robot : Robot
        The robot.
    uneven : UnevenOptions
        How it walks over uneven ground.
    options : FootstepOptions
        How footsteps are planned.
    """

    def __init__(self, robot: Robot, uneven: UnevenOptions, options: FootstepOptions) -> None:
        self._robot = robot
        self._uneven = uneven
        self._options = options
        self.horizons = [robot.relative_size * options.horizon * part for part in _HORIZONS]
        """Distances along a plan to which footsteps are planned, the next where there are none [m].
        """
        self._planner = FootstepPlanner(robot, options)
        self._map: FootholdMap | None = None
        self._planned_over: FootholdMap | None = None
        self._steps: tuple[Footstep, ...] = ()
        self._length = 0
        self._feet: Array | None = None
        self._has_begun = False
        self._target: Pose2D | None = None

    def prepare(self) -> None:
        """Load the compiled search: the robot would wait for it in the middle of a walk."""
        robot = self._robot
        cell = 0.1 * robot.footprint_radius
        side = 4.0 * robot.footprint_radius
        count = math.ceil(side / cell)
        level = HeightMap(np.zeros((count, count)), cell, (-0.5 * side, -0.5 * side))
        standing = robot.neutral_feet.copy()
        standing[:, 2] = robot.foot_radius
        ground = FootholdMap(robot, self._uneven, self._options, level)
        ahead = 0.5 * robot.relative_size * self._options.longest_step
        with suppress(FootstepsNotFound):
            self._planner.plan(standing, Pose2D(ahead, 0.0, 0.0), ground)

    def take_map(self, heights: HeightMap | None) -> None:
        """Take a map of the ground, or none."""
        self._map = None
        if heights is not None:
            self._map = FootholdMap(self._robot, self._uneven, self._options, heights)
        self.forget()

    def use_map(self, heights: HeightMap | None) -> None:
        """Plan over a map as it lies now: take it, if it is another one."""
        if heights is not (None if self._map is None else self._map.heights):
            self.take_map(heights)

    def forget(self) -> None:
        """Plan again before the next stride."""
        self._steps, self._feet = (), None

    def block(self, goal: StrideGoal, leg: int) -> None:
        """Keep a foothold out of plans: the leg could not get there."""
        if self._map is not None:
            self._map.blocked = [
                *self._map.blocked[-_MOST_BLOCKED + 1 :],
                (leg, float(goal.footholds[leg, 0]), float(goal.footholds[leg, 1])),
            ]
        self.forget()

    def planning(
        self, now: Stance, pose: Pose2D, targets: Sequence[Pose2D], is_asked: bool = False
    ) -> Pieces[StrideGoal | None]:
        """
        Find the next stride over footholds, where the ground asks for them, in pieces.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        pose : Pose2D
            Pose of its body.
        targets : sequence of Pose2D
            Where the body is to be, some strides ahead; the next where no footsteps lead to one.
        is_asked : bool
            Whether to plan on even ground, too.

        Returns
        -------
        StrideGoal or None
            None where the ground is even, unless asked, or the body is there.

        Raises
        ------
        FootstepsNotFound
            If there are none.
        """
        if not targets or not (
            is_asked or self.is_strained(now) or self.is_needed(pose, targets[0])
        ):
            self.forget()
            self._has_begun = False
            return None
        problem: FootstepsNotFound | None = None
        for target in targets:
            try:
                return (yield from self._next_stride(now, target))
            except FootstepsNotFound as error:
                problem = problem or error
        assert problem is not None
        raise problem

    def is_strained(self, now: Stance) -> bool:
        """Tell whether footsteps have left the feet where strides could not begin."""
        if self._map is None or not self._has_begun:
            return False
        strained = self._robot.relative_size * self._options.strained
        return strain_over(self._robot, now.feet) > strained

    def is_needed(self, pose: Pose2D, target: Pose2D) -> bool:
        """
        Tell whether feet would not find even ground below the body's way.

        Parameters
        ----------
        pose : Pose2D
            Where the body is.
        target : Pose2D
            Where it is to go; a part of the way is looked at.

        Returns
        -------
        bool
            False where nothing is known of the ground.
        """
        ground, scale = self._map, self._robot.relative_size
        if ground is None:
            return False
        distance = pose.distance_to(target)
        turn = wrap_angle(target.yaw - pose.yaw)
        part = min(1.0, scale * _LOOK / distance) if distance > 0.0 else 1.0
        arc = max(part * distance, self._robot.footprint_radius * abs(turn))
        way = np.linspace(0.0, part, 2 + int(arc / (scale * _APART)))
        yaw = pose.yaw + way * turn
        neutral = self._robot.neutral_feet
        for leg in range(4):
            x = pose.x + way * (target.x - pose.x)
            y = pose.y + way * (target.y - pose.y)
            x = x + np.cos(yaw) * neutral[leg, 0] - np.sin(yaw) * neutral[leg, 1]
            y = y + np.sin(yaw) * neutral[leg, 0] + np.cos(yaw) * neutral[leg, 1]
            points = np.column_stack([x, y])
            known = np.isfinite(ground.heights.height_at(points))
            if not ground.is_fit(leg, points[known], target.yaw).all():
                return True
        return False

    def _next_stride(self, now: Stance, target: Pose2D) -> Pieces[StrideGoal | None]:
        """Find the next stride: each leg swings once at most; None where the body is there."""
        if not self._holds(now, target):
            yield from self._plan(now, target)
        steps: list[Footstep] = []
        for step in self._steps:
            if any(step.leg == other.leg for other in steps):
                break
            steps.append(step)
        self._has_begun = bool(steps)
        if not steps:
            return None
        self._steps = self._steps[len(steps) :]
        self._feet = steps[-1].feet
        order = tuple(step.leg for step in steps)
        place = pose_over(self._robot, self._feet)
        return StrideGoal(order, self._feet[:, :2], place, is_exact=True)

    def _holds(self, now: Stance, target: Pose2D) -> bool:
        """Tell whether the feet are where they were to be, and what is planned leads far enough."""
        if self._feet is None or self._target is None or not self._steps:
            return False
        if self._planned_over is not self._map:
            # Another map was taken while these steps were planned.
            return False
        off = np.hypot(*(now.feet - self._feet)[:, :2].T).max()
        if off > self._robot.relative_size * self._options.off_plan:
            return False
        if 2 * len(self._steps) > self._length:
            return True
        if self._target.distance_to(target) > 0.2 * self._options.distance_tolerance:
            return False
        # As far as this half nobody has looked yet.
        ground, shift = self._ground_under(now)
        return not self._planner.touching(now.feet, self._steps, ground, shift)

    def _plan(self, now: Stance, target: Pose2D) -> Pieces[None]:
        ground, shift = self._ground_under(now)
        pose = pose_over(self._robot, now.feet)
        within = _within_turn(pose, target)
        planned = yield from self._planner.planning(now.feet, within, ground, shift)
        self._steps, self._length, self._planned_over = planned.steps, len(planned.steps), ground
        self._feet, self._target = now.feet, target

    def _ground_under(self, now: Stance) -> tuple[FootholdMap, float]:
        """Return the map, and the height that is added to it so that it fits the feet [m]."""
        assert self._map is not None
        under = now.feet - np.array([0.0, 0.0, self._robot.foot_radius])
        return self._map, GroundModel.through(under, self._map.heights).shift


def _within_turn(pose: Pose2D, target: Pose2D) -> Pose2D:
    """Return the target with a heading that is not too far from that of a pose."""
    turn = wrap_angle(target.yaw - pose.yaw)
    if abs(turn) <= _LARGEST_TURN:
        return target
    return Pose2D(target.x, target.y, pose.yaw + math.copysign(_LARGEST_TURN, turn))
