"""
Trotting with a new decision at every measurement: the robot keeps its balance.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_parts import are_alike
from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_gait.balance.answer_delay import AnswerDelay
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.balanced_motion import BalancedMotion
from quad_gait.balance.body_estimate import BodyEstimate, BodyEstimator, BodyReading
from quad_gait.balance.course import Course, Guide, Start
from quad_gait.balance.foot_laws import Pace
from quad_gait.balance.known_ground import KnownGround
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, Command, Done, Shared, Walk
from quad_gait.behaviours.guidance import PlannedMotion
from quad_gait.behaviours.wishes import UseHeightMap, Wish
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.following.step import Departure, Step
from quad_gait.state.robot_state import RobotState
from quad_gait.state.support import BY_FEET, Support

_CALM_SPEED = 0.06
"""Velocity, as a fraction of sqrt(g h), below which a body is calm."""

_CALM_TILT = math.radians(3.0)
"""Tilt below which a body is calm [rad]."""

_PATIENCE = 3.0
"""Time after which a robot that is to stand stops trotting, calm or not [s]."""

_LONGEST_OVERRUN = 0.25
"""Time that the next step makes up for, at most, as a fraction of its own."""

_WAY_TO_GO = 0.1
"""Distance to the goal from which on a robot that stops on its way goes on at once [m]."""


class BalancedTrot(Walk):
    """Follows steps as they come, cycle after cycle, until nothing is wanted and it is calm."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._balance = shared.options.balance or BalanceOptions()
        self._estimator = BodyEstimator(shared.robot, self._balance.estimate)
        self._motion: BalancedMotion | None = None
        self._delay = AnswerDelay(self._balance)
        self._course: Course | None = None
        self._height_map: HeightMap | None = None
        self._ground: KnownGround | None = None
        self._steered: Twist2D | None = None
        self._pose = Pose2D(0.0, 0.0, 0.0)
        self._stops_since = self._calm_since = math.inf
        self._pushed_at = self._taken_at = -math.inf
        self._is_ending = False

    def take(self, wish: Wish) -> None:
        """Take a map of the ground."""
        if isinstance(wish, UseHeightMap) and not are_alike(self._height_map, wish.height_map):
            self._height_map = wish.height_map
            if self._ground is None or wish.height_map is None:
                self._ground = self._known_ground()
            else:
                self._ground.take(wish.height_map)

    def _known_ground(self) -> KnownGround | None:
        heights = self._height_map
        return None if heights is None else KnownGround(heights, self._robot)

    def in_contact_at(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are planned to be down at a time [s], shape (4,)."""
        if self._motion is None or time >= self._joints.busy_until:
            return np.ones(4, dtype=bool)
        return self._motion.clock.in_stance(time)

    def support_at(self, time: float) -> Support:
        """Return which feet stand and bear at a time [s], and how fast the body is."""
        motion = self._motion
        if motion is None or time >= self._joints.busy_until:
            return BY_FEET
        # Feet that land and slip tell less than what the body can have gained meanwhile.
        return Support(
            motion.clock.in_stance(time) & self._estimator.bears, self._estimator.velocity_at(time)
        )

    def footholds(self) -> NDArray[np.float64]:
        """Return where the feet are to land, (4, 3) [m]; (0, 3) without a motion."""
        if self._motion is None:
            return np.empty((0, 3))
        return self._pose.transform(self._motion.footholds())

    def forget(self) -> None:
        """Know of no motion."""
        self._motion = self._course = None
        self._ground = self._known_ground()

    def come_to_rest(self, state: RobotState) -> bool:
        """Give nothing more out: what was given out brings the robot to rest."""
        self._is_ending = True
        return super().come_to_rest(state)

    def begin(self, state: RobotState, done: Done) -> Command | Done:
        """Begin to trot."""
        assert done.step is not None
        gait = self._guidance.gait_pair.of(done.step).gait
        positions, _ = self._joints.gate.command(state.time, state.joints.reshape(-1))
        self._pushed_at = -math.inf
        body = self._estimate(state, np.ones(4, dtype=bool))
        self._motion = BalancedMotion(
            self._robot, gait, self._balance, state.time, positions.reshape(4, 3), body
        )
        self._delay = AnswerDelay(self._balance)
        self._cycles.clear()
        self._stops_since = self._calm_since = math.inf
        self._is_ending = False
        self._take_step(state, done.step, Start(state.motion_pose))
        return self._balanced(state, self._motion)

    def update(self, state: RobotState) -> Command | Done:
        """Answer to a measurement; be done when the robot is at rest."""
        motion = self._motion
        if motion is None or self._is_ending or motion.is_over(state.time):
            return GO_ON if state.time < self._is_settled_at else Done(Activity.STANDING)
        problem = state.balance_problem
        if problem:
            self._is_ending = True
            self._report.limit = (
                f'the robot comes to rest, and keeps its balance no more: {problem}'
            )
            return GO_ON
        if not motion.is_due(state.time):
            return GO_ON
        return self._balanced(state, motion)

    def _balanced(self, state: RobotState, motion: BalancedMotion) -> Command:
        """Give out how it goes on."""
        self._pose = state.pose
        body = self._estimate(state, motion.clock.in_stance(state.time))
        course = self._next_course(state)
        if motion.is_pushed(body):
            self._pushed_at = state.time
        if motion.is_pushed(body) or motion.is_leaning(state.time):
            # It is caught where it is; what it was pushed off is taken back by the next steps.
            self._course = course = self._steered_from_here(state, course)
        guide = Guide(
            self._balance.course_gain,
            self._balance.largest_correction * motion.unit,
            self._lead,
            turns_back=not self._is_caught(state.time),
        )
        pace = course.pace(state.time, state.motion_pose, guide)
        due = course.pace(state.time, state.motion_pose, guide._replace(lead=0.0))
        self._stop_when_calm(state, motion, body, pace)
        ground = self._ground
        if ground is not None:
            poses = state.pose, state.motion_pose
            stance = motion.clock.stance_times[0]
            ground.locate(state.time, poses, self._estimator.feet, self._estimator.bears, stance)
        delay = self._delay.take(state.time, state.joints, motion.given)
        followed = motion.follow(state.time, state.joints)
        if followed is not None:
            self._joints.gate.go_back_to(followed)
        trajectory = motion.update(state.time, body, pace, due, ground, delay)
        if trajectory is not None:
            self._joints.busy_until = trajectory.end
        return Command(trajectory)

    def _estimate(self, state: RobotState, in_stance: NDArray[np.bool_]) -> BodyEstimate:
        assert state.imu is not None
        assert state.orientation is not None
        assert state.joint_velocities is not None
        efforts = state.joint_efforts
        return self._estimator.update(
            BodyReading(
                state.time,
                state.joints,
                state.joint_velocities.reshape(4, 3),
                None if efforts is None else efforts.reshape(4, 3),
                state.orientation,
                state.imu.angular_velocity,
                state.imu.specific_force,
                in_stance,
                tells_slope=not self._is_caught(state.time),
            )
        )

    def _is_caught(self, time: float) -> bool:
        """Return whether the robot was pushed within a cycle before a time [s]."""
        motion = self._motion
        return motion is not None and time < self._pushed_at + motion.clock.period

    @property
    def _lead(self) -> float:
        """Time after which the body has a velocity that is asked for [s]."""
        return 0.0 if self._motion is None else self._motion.lead

    @property
    def _farthest_off(self) -> float:
        """Distance from its course from which on a robot is drawn back no more [m]."""
        options = self._balance
        unit = 0.0 if self._motion is None else self._motion.unit
        return options.largest_correction * unit / options.course_gain

    def _next_course(self, state: RobotState) -> Course:
        """Return the course that holds now: the next one, if its time has come."""
        course, guidance = self._course, self._guidance
        assert course is not None
        steered = guidance.steering.twist
        half = self._taken_at + course.period / 2.0
        is_other = steered is not None and steered != self._steered and state.time >= half
        ends = self._decides_at(state, course)
        is_over = state.time >= ends
        if math.isfinite(self._stops_since):
            is_over = is_over and (guidance.has_new_plan or bool(steered))
        if not is_over and not is_other:
            return course
        if is_other:
            # What was steered led to the end of this step.
            self._steered_from_here(state, course)
        # Measurements come between the ends of steps: what the last one overran, the next makes up.
        # While the robot comes to rest there is none that follows at once.
        is_next = is_over and not math.isfinite(self._stops_since)
        overrun = state.time - ends if is_next else 0.0
        start = course.start_after(state.time, state.motion_pose, self._farthest_off)
        if steered is not None:
            entry = course.at(state.time)[1]
            back = BodyMotion.during(entry, -overrun).end
            start = Start(state.motion_pose @ back, entry)
        to_map = state.pose @ state.motion_pose.inverse()
        try:
            departure = Departure(
                to_map @ start.pose,
                start.pose,
                start.entry,
                guidance.gait_pair.walking if start.entry else None,
            )
            expected = to_map @ course.at(state.time)[0]
            step = guidance.next_in_motion(state, expected, departure)
        except GaitError as error:
            self._report.limit = str(error)
            step = None
        if step is not None and guidance.gait_pair.of(step).gait.is_static:
            step = None
        return self._take_step(state, step, start, overrun)

    def _decides_at(self, state: RobotState, course: Course) -> float:
        """
        Return when the next step is decided on [s].

        That is when this one is over; where the plan goes on after a stop, so much before that the
        body sets off at once.
        """
        plan = self._guidance.wanted_plan
        goes_on = plan is not None and state.pose.distance_to(plan.poses[-1]) > _WAY_TO_GO
        is_stop = not course.exit and math.isinf(self._stops_since)
        return course.end - (self._lead if is_stop and goes_on else 0.0)

    def _steered_from_here(self, state: RobotState, course: Course) -> Course:
        """Let the course go through where the robot is; its heading stays as it was planned."""
        here = course.through(state.time, state.motion_pose)
        self._guidance.steering.take_course(here.at(state.time)[0])
        return here

    def _take_step(
        self, state: RobotState, step: Step | None, start: Start, overrun: float = 0.0
    ) -> Course:
        """Follow a step from now on, or none, which should have been taken so long ago [s]."""
        guidance, entry = self._guidance, start.entry
        period = guidance.gaits.period_of(step, guidance.steering.twist is not None)
        self._steered = guidance.steering.twist
        motion, after = BodyMotion(), STILL
        if step is None:
            self._stops_since = min(self._stops_since, state.time)
            motion = BodyMotion.during(entry, period / 3.0)
            if not self._report.activity.is_verdict:
                self._report.say(Activity.BALANCING, 'coming to rest')
        else:
            self._stops_since = math.inf
            motion, after = step.motion, step.exit
            end = state.pose @ (state.motion_pose.inverse() @ (start.pose @ motion.end))
            guidance.note_begun(state, step, PlannedMotion(motion, end))
            self._report.say(Activity.BALANCING, self._report.reason)
        self._taken_at = state.time
        # A body at rest sets off so much later than it is asked to.
        begins = state.time - min(overrun, _LONGEST_OVERRUN * period)
        if not entry:
            begins += self._lead
        self._course = Course.from_start(start, (begins, period), motion, after)
        return self._course

    def _stop_when_calm(
        self, state: RobotState, motion: BalancedMotion, body: BodyEstimate, pace: Pace
    ) -> None:
        """Let no foot lift any more once nothing is wanted and the body is calm."""
        fastest = max(math.hypot(*body.velocity), math.hypot(pace.forward, pace.left))
        is_calm = fastest < _CALM_SPEED * motion.unit and body.tilt < _CALM_TILT
        self._calm_since = min(self._calm_since, state.time) if is_calm else math.inf
        waited = state.time - self._stops_since
        if waited < motion.clock.period:
            return
        if state.time - self._calm_since >= motion.clock.period / 2.0 or waited > _PATIENCE:
            motion.rest(state.time)
            self._is_ending = True
