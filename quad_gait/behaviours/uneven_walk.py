"""
Walking over uneven ground: each step is a stride whose feet feel for the ground.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_parts import are_alike
from quad_common.planar_pose import Pose2D
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, Command, Done, Shared, Walk
from quad_gait.behaviours.guidance import PlannedMotion
from quad_gait.behaviours.wishes import UseHeightMap, Wish
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.following.step import Step
from quad_gait.state.body_placement import strain_over
from quad_gait.state.robot_state import RobotState
from quad_gait.state.support import Support
from quad_gait.uneven.stride_goal import Descent, StrideGoal
from quad_gait.uneven.uneven_options import UnevenOptions
from quad_gait.uneven.uneven_stride import UnevenStride
from quad_gait.uneven.ways_out import Chosen

if TYPE_CHECKING:
    from quad_gait.footsteps.footstep_route import FootstepRoute
    from quad_gait.footsteps.pieces import Pieces


_STRAINED = 0.07
"""Distance of a foot from its initial posture that is far, after a stride was cut short [m, of
TITAN-VIII]."""

_NEGLIGIBLE = 1e-9
"""Corrections of odometry that are none but for rounding [m, rad]."""


class UnevenWalk(Walk):
    """Carries one stride out until its last foot stands."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._stride: UnevenStride | None = None
        self._begun: RobotState | None = None
        self._chosen: Chosen | None = None
        self._planning: Pieces[StrideGoal | None] | None = None
        self._height_map: HeightMap | None = None
        # What kept the last stride from being what it was to be.
        self._limit = ''
        self._goal: StrideGoal | None = None
        uneven = shared.options.uneven
        self._descent = Descent(self._robot)
        self._route: FootstepRoute | None = None
        if uneven is not None and uneven.plans_footsteps:
            self._route = self._new_route(uneven)

    def _new_route(self, uneven: UnevenOptions) -> FootstepRoute:
        # Imported late: compiled loops take time to load, and most walks need none.
        from quad_gait.footsteps.footstep_options import FootstepOptions
        from quad_gait.footsteps.footstep_route import FootstepRoute

        return FootstepRoute(self._robot, uneven, FootstepOptions())

    def prepare(self) -> None:
        """Load what plans footsteps: strides that lead nowhere ask for it at any time."""
        uneven = self._options.uneven
        assert uneven is not None
        self._route = self._route or self._new_route(uneven)
        self._route.prepare()

    def take(self, wish: Wish) -> None:
        """Take a map of the ground."""
        if isinstance(wish, UseHeightMap):
            if are_alike(self._height_map, wish.height_map):
                # Published again and again: what feet have met of it still counts.
                return
            self._height_map = wish.height_map
            self._guidance.ways_out.knows_ground = wish.height_map is not None
            self._guidance.felt.forget_map()
            if self._route is not None:
                self._route.take_map(wish.height_map)
            if self._stride is not None:
                self._stride.height_map = wish.height_map

    def in_contact_at(self, time: float) -> NDArray[np.bool_]:
        """Return which feet stand, by what was measured last, shape (4,)."""
        return np.ones(4, dtype=bool) if self._stride is None else self._stride.in_contact

    def support_at(self, time: float) -> Support:
        """Return which feet stand, as :meth:`in_contact_at` does: they stand at any height."""
        return Support(self.in_contact_at(time))

    def footholds(self) -> NDArray[np.float64]:
        """Return the footholds at the end of the stride, (4, 3) [m]; (0, 3) without one."""
        return np.empty((0, 3)) if self._stride is None else self._stride.footholds

    def forget(self) -> None:
        """Leave the stride as it is, or its planning."""
        self._stride = self._planning = None
        self._guidance.felt.forget()

    def come_to_rest(self, state: RobotState) -> bool:
        """Begin no stride; return whether one that was begun still moves the robot."""
        self._planning = None
        return super().come_to_rest(state)

    def begin(self, state: RobotState, done: Done) -> Command | Done:
        """Begin a stride, or what is tried in its place where strides lead nowhere."""
        step, guidance, options = done.step, self._guidance, self._options.uneven
        assert step is not None
        assert options is not None
        self._note_correction(state)
        chosen = guidance.ways_out.choose(step, self._limit, self._is_strained(state))
        if chosen is None:
            guidance.give_up(Activity.STOPPED, guidance.ways_out.problem)
            return GO_ON
        if chosen.is_detour:
            self._ask_for_detour(state.pose, step)
            return GO_ON
        if chosen.is_planned and self._route is None:
            self._route = self._new_route(options)
        self._limit, self._begun, self._chosen = '', state, chosen
        self._planning = self._over_footholds(state)
        return self._plan_on(state, self._planning)

    @property
    def _is_to_halt(self) -> bool:
        """Whether no stride is to begin: to stop, to wait or to sit was wished for meanwhile."""
        guidance = self._guidance
        is_over = guidance.has_new_plan and guidance.wanted_plan is None
        return is_over or guidance.is_to_sit or bool(guidance.plan_waits_for)

    def _plan_on(self, state: RobotState, planning: Pieces[StrideGoal | None]) -> Command:
        """Do one more piece of planning footsteps; begin the stride once that is done."""
        guidance = self._guidance
        try:
            next(planning)
        except StopIteration as end:
            return self._begin_stride(state, end.value)
        except GaitError as error:
            self._planning = None
            guidance.ways_out.end_footsteps()
            self._report.limit = str(error)
            guidance.give_up_or_try(Activity.STOPPED, str(error))
            return GO_ON
        self._report.say(Activity.WALKING, 'planning footsteps')
        return GO_ON

    def _begin_stride(self, state: RobotState, goal: StrideGoal | None) -> Command:
        """Begin a stride over footholds, or by the step that was chosen where none are needed."""
        begun, chosen, guidance = self._begun, self._chosen, self._guidance
        options = self._options.uneven
        assert begun is not None
        assert chosen is not None
        assert options is not None
        self._planning, step = None, chosen.step
        gait, pose = guidance.gait_pair.order_of(step), begun.pose
        if goal is None:
            motion = self._descent.shortened(step.motion, pose, self._height_map)
            step = replace(step, motion=motion)
            goal = StrideGoal.of(self._robot, gait, step.motion, pose)
        else:
            step = Step(step.is_turn, BodyMotion.reaching(pose.inverse() @ goal.place))
        self._goal = goal
        self._stride = UnevenStride(
            self._robot, gait.swing_height, goal, self._height_map, options, guidance.felt
        )
        guidance.note_begun(begun, step, PlannedMotion(step.motion, goal.place))
        self._report.limit = chosen.remark or self._report.limit
        return self._go_on(state, self._stride)

    def _is_strained(self, state: RobotState) -> bool:
        """Tell whether a stride that was cut short has left a foot far from its initial posture."""
        if not self._limit:
            return False
        robot = self._robot
        feet = state.stance(state).feet
        return strain_over(robot, feet) > robot.relative_size * _STRAINED

    def _over_footholds(self, state: RobotState) -> Pieces[StrideGoal | None]:
        """Plan a stride over footholds, where ground or ways out ask for them; None elsewhere."""
        route, pose, ways = self._route, state.pose, self._guidance.ways_out
        options, heights = self._options.uneven, self._height_map
        if route is None or options is None:
            return None
        if not (options.plans_footsteps or ways.is_stepping):
            return None
        stance = state.stance(state)
        is_out = ways.has_stepped_on and not options.plans_footsteps
        if is_out and not route.is_strained(stance):
            ways.end_footsteps()
            route.forget()
            return None
        route.use_map(None if heights is None else self._guidance.felt.moved(heights))
        targets = self._guidance.poses_ahead(pose, route.horizons)
        goal = yield from route.planning(stance, pose, targets, ways.is_stepping)
        if goal is None:
            ways.end_footsteps()
        return goal

    def _note_correction(self, state: RobotState) -> None:
        """Tell what is known of the ground that a localiser has moved the robot on the map."""
        before = self._begun
        if before is None or state.odometry is None or before.odometry is None:
            return
        correction = state.pose @ state.pose_corrected_as(before).inverse()
        if math.hypot(correction.x, correction.y) + abs(correction.yaw) > _NEGLIGIBLE:
            self._guidance.felt.note_correction(correction, state.pose)

    def _ask_for_detour(self, pose: Pose2D, step: Step) -> None:
        """Stop, and say from where there is no going on: a planner finds another path."""
        motion, guidance = step.motion, self._guidance
        heading = 0.0 if step.is_turn else math.atan2(motion.left, motion.forward)
        towards = motion.turn if step.is_turn else heading
        guidance.impassable = pose @ Pose2D(0.0, 0.0, towards)
        problem = guidance.ways_out.problem
        guidance.give_up(
            Activity.STOPPED,
            f'the robot cannot continue here, and another path is needed: {problem}',
        )

    def update(self, state: RobotState) -> Command | Done:
        """Carry planning or the stride on; be done when the robot is at rest."""
        if self._planning is not None and self._is_to_halt:
            self._planning = None
            return Done(Activity.STANDING)
        if self._planning is not None:
            return self._plan_on(state, self._planning)
        if self._stride is not None:
            return self._go_on(state, self._stride)
        return GO_ON if state.time < self._is_settled_at else Done(Activity.STANDING)

    def _go_on(self, state: RobotState, stride: UnevenStride) -> Command:
        try:
            trajectory = stride.update(state.stance(self._begun))
        except GaitError as error:
            self._end(stride)
            self._keep_out(stride.leg)
            self._report.limit = str(error)
            self._guidance.give_up_or_try(Activity.STOPPED, str(error))
            return GO_ON
        self._joints.busy_until = stride.end
        self._limit = stride.limit
        self._report.limit = stride.limit or self._report.limit
        if stride.is_over:
            self._end(stride)
            if stride.stuck is not None:
                self._keep_out(stride.stuck)
        return Command(trajectory)

    def _keep_out(self, leg: int) -> None:
        """Leave a foothold that a leg did not get to out of the next plan of footsteps."""
        if self._route is not None and self._goal is not None and self._goal.is_exact:
            self._route.block(self._goal, leg)

    def _end(self, stride: UnevenStride) -> None:
        """Let the robot stand as the stride left it: its feet are on uneven ground."""
        posture = stride.joint_positions
        if posture is not None:
            self._joints.posture = posture
        self._stride = None
