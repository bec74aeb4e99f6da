"""
Walks a robot along its plan, or as it is steered, cycle by cycle from what it measures.

The controller knows no clock and no topics: it is told the time with each measurement,
and answers with the next joint trajectory when one is due.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    EmergencyStopOn,
    GaitError,
    RobotIsLame,
    RobotStaysStill,
    TrajectoryError,
)
from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import STILL, Pose2D, Twist2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.command_gate import CommandGate
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.posture import crouching_joint_angles, posture_trajectory
from quad_gait.cycle.stability import stability_margin, support_polygon
from quad_gait.faults.execution_check import ExecutionCheck
from quad_gait.faults.joint_fault import JointFault
from quad_gait.faults.joint_fault_detector import JointFaultDetector
from quad_gait.faults.safe_stop import JointRecovery, SafeStop, SafeStopOptions
from quad_gait.following.cycle_planner import CyclePlanner
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.motion_sequence import MotionSequence, ScheduledCycle
from quad_gait.following.path_follower import PathFollower
from quad_gait.following.reference_path import Piece
from quad_gait.following.slip_compensation import NO_SLIP, SlipCompensation
from quad_gait.following.steering import Steering
from quad_gait.following.step import Step
from quad_gait.following.stuck_detector import StuckDetector
from quad_gait.state.measurement import Measurement
from quad_gait.state.rest_check import RestCheck
from quad_gait.state.stance import Stance
from quad_gait.uneven.uneven_options import UnevenOptions
from quad_gait.uneven.uneven_stride import UnevenStride

Array = NDArray[np.float64]


_PATIENCE = 1.0
"""For the joints to come to rest after a cycle [s]."""

_STILL_MOVING = 'the joints are still moving'

_LONGEST_UNREST = 8.0
"""Joints that have not come to rest for so long after it never will: the robot gives up [s]."""

_UNFOLLOWED = 0.1
"""Joints that have not followed for so long say nothing of what is in the robot's way [s]."""

_FIRST_STAMP = 1e-3
"""No cycle starts before, for a stamp of zero would mean "on arrival" [s]."""

_STILL_TIME = 0.5
"""A robot out of its posture must be still for so long before it is made to stand up [s]."""

_FREEZING_TIME = 0.02
"""Time in which an emergency stop brings the joints to rest [s]."""

_LAST_MOMENT = 0.05
"""A cycle that is to follow another at once is given out at least so long before [s]."""


_SAID = (Activity.ARRIVED, Activity.BLOCKED, Activity.STOPPED)
"""What is said until something new is wished for."""


@dataclass(frozen=True)
class ControllerOptions:
    """Timing and tolerances of the controller."""

    settle_time: float = 0.2
    """After a cycle's end, before the robot's pose is measured for the next [s]."""
    lead_time: float = 0.3
    """A trajectory is given out at least so long before its first movement [s]."""
    sample_period: float = 0.02
    """Between a trajectory's points [s]."""
    least_margin: float = 0.01
    """Cycles with a smaller predicted stability margin are shortened [m]."""
    largest_tilt: float = math.radians(30.0)
    """A body tilted farther has fallen [rad]."""
    posture_tolerance: float = 0.15
    """Joints within this of the initial posture are in it [rad]."""
    rest_speed: float = 0.1
    """Joints slower than this are at rest [rad/s]."""
    stand_up_time: float = 3.0
    """How long the robot takes to regain its initial posture, and to sit down [s]."""
    twist_timeout: float = 1.0
    """Steering older than this is over [s]."""
    tracking_gain: float | None = None
    """Gain of S1's backstepping law [1/s]; None for closed-form inverse kinematics."""
    hold_course: bool = True
    """Whether steering also takes back what the robot drifts meanwhile."""
    follower: FollowerOptions = field(default_factory=FollowerOptions)
    """How plans are followed."""
    uneven: UnevenOptions | None = None
    """How to walk where the ground is not flat; None: it is flat."""
    watches_joints: bool = True
    """Whether a joint that does not answer brings the robot to a standstill."""


class WalkController:
    """
    Plans each cycle at the end of the last, from where the robot then is.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        For walking; fitted to the robot.
    turning_gait : Gait
        For turning on the spot; may be the same.
    options : ControllerOptions
        Timing and tolerances.
    compensation : SlipCompensation
        How much more must be asked for than is wanted; see ``quadwalk calibrate``.
    """

    def __init__(
        self,
        robot: Robot,
        gait: Gait,
        turning_gait: Gait,
        options: ControllerOptions,
        compensation: SlipCompensation = NO_SLIP,
    ) -> None:
        self._robot = robot
        self._options = options
        self._planner = CyclePlanner(
            robot, compensation, options.sample_period, options.tracking_gain
        )
        self._sequence = MotionSequence()
        self._gate = CommandGate(robot)
        self._watch = JointFaultDetector(robot)
        self._execution = ExecutionCheck()
        self._rest = RestCheck(robot, options.rest_speed)
        # What was given out to see whether joints follow again.
        self._tried: JointTrajectory | None = None
        self._lameness: JointRecovery | None = None
        self._busy_until = -math.inf
        self._stride: UnevenStride | None = None
        self._height_map: HeightMap | None = None
        # Where the stride is to bring the body, and with which correction it was begun.
        self._stride_goal = Pose2D(0.0, 0.0, 0.0)
        self._stride_begun: Measurement | None = None
        # In which the robot stands between two cycles.
        self._stance = robot.initial_joint_angles
        self._take_gaits(gait, turning_gait, options.follower)
        self._new_gaits: tuple[Gait, Gait, FollowerOptions] | None = None
        self._wanted: Plan | None = None
        self._pieces: list[Piece] | None = None
        self._stopped_goal: Pose2D | None = None
        self._has_new_plan = False
        correction = options.follower.largest_correction if options.hold_course else 0.0
        self._steering = Steering(options.twist_timeout, correction)
        self._reason_to_stand = ''
        self._lacks_sensors = False
        # Why the plan waits; empty if it does not.
        self._plan_waits_for = ''
        self._is_to_sit = False
        self._has_fallen = False
        self._is_frozen = False
        # Why nothing but stand makes the robot move again; empty if it may.
        self._waits_for_stand = ''
        self._last: Measurement | None = None
        self._last_time = -math.inf
        self._progress = StuckDetector(robot.largest_stride)
        # When the cycle began whose successor was decided on last.
        self._decided_after = -math.inf
        self._still_since = math.inf
        self._moving_since = math.inf
        self.activity = Activity.WAITING
        """What the robot is doing."""
        self.reason = 'no plan yet'
        """The same as a sentence."""
        self.limit = ''
        """What keeps the robot from doing all that was asked for; empty if nothing does."""

    @property
    def cycle(self) -> Cycle | None:
        """The cycle that was planned last."""
        last = self._sequence.last
        return None if last is None else last.cycle

    def cycle_at(self, time: float) -> ScheduledCycle | None:
        """Return the cycle that runs at a time [s]; None while the robot rests."""
        return self._sequence.at(time)

    @property
    def wanted_plan(self) -> Plan | None:
        """The plan to follow, also while something blocks the robot; None: there is none."""
        return self._wanted

    @property
    def gait(self) -> Gait:
        """The gait for walking."""
        return self.gait_pair.walking.gait

    def prepare(self) -> None:
        """Find the commonest limits beforehand: it takes a while, and cycles are awaited."""
        self.gait_pair.prepare()

    def set_gaits(self, gait: Gait, turning_gait: Gait, follower: FollowerOptions) -> None:
        """Change gaits and the way to follow plans, once the robot is at rest."""
        self._new_gaits = (gait, turning_gait, follower)

    def set_height_map(self, height_map: HeightMap | None) -> None:
        """Take a map of the ground, in the plan's frame, for walking where it is uneven."""
        self._height_map = height_map
        if self._stride is not None:
            self._stride.height_map = height_map

    def set_plan(self, plan: Plan | None, pieces: list[Piece] | None = None) -> None:
        """
        Follow this plan, or none, from the next cycle on.

        After :meth:`stop` a plan to the same goal is not followed: it is no new wish.

        Parameters
        ----------
        plan : Plan or None
            Turning points.
        pieces : list of Piece, optional
            The path to the plan's last pose, if it is not made of its turning points.
        """
        if plan is None and self._wanted is None:
            # There is none to take back: whatever else the robot does goes on.
            return
        if plan is not None and self._stopped_goal is not None:
            if _is_same_goal(plan.poses[-1], self._stopped_goal):
                return
            self._stopped_goal = None
        if plan is not None and self._is_refused('the plan'):
            return
        self._wanted = plan
        self._pieces = pieces
        self._has_new_plan = True
        self._steering.end()
        self._reason_to_stand = ''

    def set_twist(self, twist: Twist2D) -> None:
        """Walk with this velocity until the steering times out; ends the following of a plan."""
        if not self._last_time > -math.inf:
            return
        if self._is_refused('steering'):
            return
        self._give_up_plan()
        self._reason_to_stand = ''
        self._steering.wish(twist, self._last_time)

    def hold_plan(self, reason: str) -> None:
        """Let the plan wait from the next cycle on, for a reason; none: go on with it."""
        self._plan_waits_for = reason

    def freeze(self) -> JointTrajectory | None:
        """
        Stop all joints at once, and keep them as they are until :meth:`release`.

        Returns
        -------
        JointTrajectory or None
            It starts on arrival; None if nothing is known of the joints.
        """
        self._give_up_plan()
        self._follower.follow(None, Pose2D(0.0, 0.0, 0.0))
        self._forget_schedule()
        self._is_frozen = True
        if self._lameness is not None:
            self._lameness.stop.hold()
        self._waits_for_stand = 'the emergency stop was released; it waits for stand'
        self.limit = ''
        self._set_activity(Activity.EMERGENCY_STOP, 'all joints hold until it is released')
        last = self._last
        if last is None or last.joint_positions is None:
            return None
        position, velocity = self._gate.command(last.time, last.joint_positions)
        # A cubic that only slows down goes on by a third of its velocity times its duration.
        rest = self._gate.limits.clip(position + velocity * (_FREEZING_TIME / 3.0))
        hold = JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=0.0,
            times=np.array([_FREEZING_TIME]),
            positions=rest[None],
            velocities=np.zeros_like(rest)[None],
        )
        return self._given(hold, last)

    def release(self) -> str:
        """End the emergency stop; the robot stays as it is until :meth:`stand`."""
        if not self._is_frozen:
            return 'the emergency stop was not on'
        self._is_frozen = False
        return 'the emergency stop is released; call stand to make the robot stand and walk again'

    def stop(self) -> str:
        """
        Stop at the end of the cycle, until a plan to another goal or steering comes.

        Returns
        -------
        str
            What will happen.
        """
        self._give_up_plan()
        self._steering.end()
        self._reason_to_stand = ''
        return 'the robot stops at the end of its gait cycle, on four feet'

    def stand(self) -> str:
        """Stop, and regain the initial posture, also after sitting or a fall; as :meth:`stop`."""
        if self._is_frozen:
            raise EmergencyStopOn()
        self.stop()
        self._is_to_sit = False
        self._has_fallen = False
        self._waits_for_stand = ''
        if self._lameness is not None:
            self._lameness.try_again()
            return f'{self._lameness.fault.name} is tried first; if it answers the robot stands up'
        self._stance = self._robot.initial_joint_angles
        return 'the robot stops at the end of its gait cycle and stands in its initial posture'

    def sit(self) -> str:
        """Stop, and lower the body as far as it goes; only :meth:`stand` ends it."""
        if self._lameness is not None:
            raise RobotIsLame(str(self._lameness.fault))
        if self._waits_for_stand:
            raise RobotStaysStill(self._why_still())
        self.stop()
        self._is_to_sit = True
        return 'the robot stops at the end of its gait cycle and sits down, until stand is called'

    def distance_left(self, pose: Pose2D) -> float:
        """Return how far it is along the plan to the goal [m]."""
        return self._follower.distance_left(pose)

    def update(self, now: Measurement) -> JointTrajectory | None:
        """
        Take a measurement, and plan the next cycle if it is time.

        Parameters
        ----------
        now : Measurement
            What is known of the robot.

        Returns
        -------
        JointTrajectory or None
            The next trajectory; None while the last one runs, or if there is nothing
            to do: :attr:`activity` and :attr:`reason` say why.
        """
        options = self._options
        if now.was_moved or now.time < self._last_time - 1.0:
            # Something else moved the robot, or the clock was set: what was scheduled is void.
            self._forget_schedule()
            self._forget_commands()
        self._last, self._last_time = now, now.time
        if now.joint_positions is not None:
            measured_at = now.time if now.joint_time is None else now.joint_time
            self._rest.take(measured_at, now.joint_positions)
        if self._is_frozen:
            return None
        fault = self._watched(now)
        if now.tilt > options.largest_tilt:
            return self._given(self._fall(now), now)
        if self._waits_for_stand:
            # Not even a joint that fails is a reason to move.
            return self._given(self._walk_on(now), now)
        if fault is not None and self._lameness is None and not self._has_fallen:
            self._go_lame(fault, now)
        if self._lameness is not None:
            return self._given(self._be_lame(self._lameness, now), now)
        if now.problem:
            # Joints that are not heard of say nothing of who moves them.
            return self._given(self._walk_on(now), now)
        self._execution.update(now.time, self._watch.unfollowed)
        if self._execution.is_wrong:
            return self._given(self._try_to_go_on(now), now)
        return self._given(self._walk_on(now), now)

    def _walk_on(self, now: Measurement) -> JointTrajectory | None:
        """Give out the next trajectory of a sound robot, if it is time."""
        options = self._options
        if now.problem and now.joint_positions is not None:
            self._wait_for_sensors(now)
            return None
        if self._lacks_sensors:
            self._lacks_sensors = False
            self.limit = ''
        if self._stride is not None:
            return self._go_on_with_stride(now)
        follow_on = self._sequence.at(now.time)
        if follow_on is not None and follow_on.cycle.exit:
            is_time = follow_on.end - options.lead_time <= now.time < follow_on.end - _LAST_MOMENT
            if not is_time or self._decided_after == follow_on.start:
                return None
            self._decided_after = follow_on.start
            return self._go_on(now, follow_on)
        if now.time < self._busy_until + options.settle_time:
            return None
        return self._begin(now)

    def margin_at(self, time: float) -> float:
        """Return the predicted stability margin at a time [m]."""
        scheduled = self._sequence.at(time)
        if scheduled is None:
            return self._standing_margin()
        cycle = scheduled.cycle
        return float(cycle.margin[cycle.sample(time - scheduled.start)])

    def measured_margin(self, now: Measurement) -> float:
        """Return the stability margin with joints and attitude as measured [m]."""
        if now.joint_positions is None:
            return math.nan
        feet, center = now.level_feet(self._robot)
        return float(stability_margin(center, feet, self.in_contact_at(now.time)))

    def measured_support_polygon(self, now: Measurement) -> Array:
        """Return the support polygon of the feet as measured, counter-clockwise, (n, 2) [m]."""
        if now.joint_positions is None:
            return np.empty((0, 2))
        polygon = support_polygon(now.level_feet(self._robot)[0], self.in_contact_at(now.time))
        return now.pose.transform(polygon)

    def in_contact_at(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are planned to be down at a time [s], shape (4,)."""
        if self._stride is not None:
            return self._stride.in_contact
        return self._sequence.in_contact_at(time)

    def support_polygon_at(self, time: float, pose: Pose2D) -> Array:
        """
        Return the support polygon at a time, in the plan's frame.

        Parameters
        ----------
        time : float
            [s].
        pose : Pose2D
            Where the robot is; used while it stands.

        Returns
        -------
        ndarray, shape (n, 2)
            Counter-clockwise [m].
        """
        scheduled = self._sequence.at(time)
        if scheduled is None:
            feet = self._robot.neutral_feet[:, :2]
            return pose.transform(support_polygon(feet, np.ones(4, dtype=bool)))
        cycle = scheduled.cycle
        sample = cycle.sample(time - scheduled.start)
        polygon = support_polygon(cycle.feet[sample, :, :2], cycle.in_contact[sample])
        return scheduled.pose.transform(polygon)

    def footholds(self) -> Array:
        """Return the footholds at the end of the last planned cycle, shape (4, 3) [m]."""
        if self._stride is not None:
            return self._stride.footholds
        last = self._sequence.last
        if last is None:
            return np.empty((0, 3))
        return last.pose.transform(last.cycle.feet[-1])

    # What to do next

    def _wait_for_sensors(self, now: Measurement) -> None:
        """Let what was given out come to its end, which is at rest, and begin nothing."""
        self._lacks_sensors = True
        current = self._sequence.at(now.time)
        if current is not None and current.cycle.exit:
            self._come_to_rest(current)
            self._decided_after = current.start
        if current is not None or now.time < self._busy_until:
            self.limit = f'the robot comes to rest: {now.problem}'
        elif self.activity not in (Activity.FALLEN, Activity.EMERGENCY_STOP):
            self.limit = ''
            self._set_activity(Activity.WAITING, now.problem)

    def _begin(self, now: Measurement) -> JointTrajectory | None:
        """Decide for a robot whose last cycle has ended at rest."""
        if self._has_fallen:
            self._set_activity(
                Activity.FALLEN, 'the robot has fallen and is upright again; it waits for stand'
            )
            return None
        if self._waits_for_stand:
            self._set_activity(Activity.STOPPED, self._waits_for_stand)
            return None
        self._take_new_wishes(now.pose)
        if now.joint_positions is None:
            self._set_activity(Activity.WAITING, now.problem or 'no joint states yet')
            return None
        if not self._rest.is_at_rest(now.joint_velocities):
            self._wait_for_rest(now)
            return None
        self._moving_since = math.inf
        self._still_since = min(self._still_since, now.time)
        posture = self._crouching if self._is_to_sit else self._stance
        if not self._is_in_posture(now.joint_positions, posture):
            if now.time < self._still_since + _STILL_TIME:
                # It may be in the middle of a cycle that another node began.
                return None
            return self._take_posture(now.time, now.joint_positions, posture)
        if self._is_to_sit:
            self._set_activity(Activity.SITTING, 'sitting on request; it waits for stand')
            return None
        try:
            expected = self._expected_at_rest(now.pose)
            problem = self._lack_of_progress(now.motion_pose, expected)
            if problem is not None:
                self._give_up(Activity.BLOCKED, problem)
                return None
            step = self._next_step(now.pose, now.motion_pose, STILL)
            if step is None:
                return None
            if self._options.uneven is not None:
                return self._first_stride(now, step)
            return self._first_cycle(now, step)
        except GaitError as error:
            self._set_activity(Activity.STOPPED, str(error))
            return None

    def _wait_for_rest(self, now: Measurement) -> None:
        """Begin nothing while the joints move; give up what never comes to rest."""
        self._still_since = math.inf
        begun = self._moving_since = min(self._moving_since, now.time)
        is_wished_for = self._follower.plan is not None or bool(self._steering)
        if is_wished_for and now.time > begun + _LONGEST_UNREST:
            self._give_up(
                Activity.STOPPED,
                f'the joints have not come to rest for {_LONGEST_UNREST:g} s: '
                f'{self._rest.what_moves(now.joint_velocities)}; is something else moving '
                'them, or has a drive failed?',
            )
        # A robot may swing a little after a cycle: worth a word only if it lasts.
        elif now.time > self._busy_until + self._options.settle_time + _PATIENCE:
            is_said = self.activity is Activity.WAITING and self.reason.startswith(_STILL_MOVING)
            # Once, and not again with every measurement's numbers.
            if self.activity is not Activity.STOPPED and not is_said:
                what = self._rest.what_moves(now.joint_velocities)
                self._set_activity(Activity.WAITING, f'{_STILL_MOVING}: {what}')

    def _go_on(self, now: Measurement, current: ScheduledCycle) -> JointTrajectory | None:
        """Decide for a robot in motion, shortly before its cycle ends."""
        ahead = self._planner.end_with_slip(current, now.time)
        end = now.pose @ ahead
        self._take_new_plan(now.pose)
        problem = self._lack_of_progress(now.motion_pose, current.pose_at(now.time))
        if problem is not None:
            self._give_up(Activity.BLOCKED, problem)
        if problem is not None or self._new_gaits is not None or self._is_to_sit:
            self._come_to_rest(current)
            return None
        try:
            step = self._next_step(end, now.motion_pose @ ahead, self._planner.speed)
            if step is None or self.gait_pair.of(step) is not self._planner.gear:
                self._come_to_rest(current)
                return None
            cycle = self._planner.go_on(self.gait_pair, step, current.cycle)
            if cycle.limit and self.gait_pair.order_of(step) != cycle.gait:
                # Another order of the legs can do more, but is taken up at rest only.
                self._come_to_rest(current)
                return None
            planned = self._planner.with_stop(ScheduledCycle(cycle, current.end, end))
        except GaitError as error:
            self.limit = str(error)
            self._come_to_rest(current)
            return None
        self._sequence.replace(*planned)
        self._busy_until = self._sequence.end
        self._progress.begin(now.pose, now.motion_pose)
        self._say(step, cycle.motion, cycle.limit)
        return self._sequence.trajectory(self._robot, now.time)

    def _come_to_rest(self, current: ScheduledCycle) -> None:
        """Let the stop that follows this cycle happen: it was given out with it."""
        following = self._sequence.at(current.end)
        if following is not None:
            self._sequence.replace(following)

    def _go_on_with_stride(self, now: Measurement) -> JointTrajectory | None:
        """Carry a step over uneven ground on, until its last foot stands."""
        stride = self._stride
        assert stride is not None
        try:
            trajectory = stride.update(self._stance_at(now, self._stride_begun))
        except GaitError as error:
            self._end_stride(stride)
            self._give_up(Activity.STOPPED, str(error))
            return None
        self._busy_until = stride.end
        self.limit = stride.limit or self.limit
        if stride.is_over:
            self._end_stride(stride)
        return trajectory

    def _end_stride(self, stride: UnevenStride) -> None:
        end = stride.joint_positions
        if end is not None:
            self._stance = end
        self._stride = None

    def _stance_at(self, now: Measurement, since: Measurement | None = None) -> Stance:
        """Return how the robot stands, with the pose corrected as it was at a measurement."""
        assert now.joint_positions is not None
        orientation = now.orientation
        if orientation is None:
            orientation = np.array([0.0, 0.0, 0.0, 1.0])
        return Stance.measured(
            self._robot,
            now.time,
            now.motion_pose if since is None else now.pose_corrected_as(since),
            orientation,
            now.joint_positions,
            now.joint_efforts,
        )

    def _first_stride(self, now: Measurement, step: Step) -> JointTrajectory | None:
        """Begin a step over uneven ground."""
        options = self._options.uneven
        assert options is not None
        self._stride = UnevenStride(
            self._robot,
            self.gait_pair.order_of(step),
            step.motion,
            now.pose,
            self._height_map,
            options,
        )
        self._progress.begin(now.pose, now.motion_pose)
        self._stride_goal = now.pose @ step.motion.end
        self._stride_begun = now
        self._say(step, step.motion)
        return self._go_on_with_stride(now)

    def _first_cycle(self, now: Measurement, step: Step) -> JointTrajectory:
        """Begin to move."""
        assert now.joint_positions is not None
        cycle = self._planner.begin(self.gait_pair, step, now.joint_positions.reshape(4, 3))
        options = self._options
        # Back to back with the last cycle, unless that is too late to be heard in time.
        earliest = now.time + options.lead_time - cycle.gait.motion_start
        start = max(self._busy_until, earliest, _FIRST_STAMP)
        planned = self._planner.with_stop(ScheduledCycle(cycle, start, now.pose))
        self._sequence.clear()
        self._sequence.replace(*planned)
        self._busy_until = self._sequence.end
        self._progress.begin(now.pose, now.motion_pose)
        self._say(step, cycle.motion, cycle.limit)
        return self._sequence.trajectory(self._robot, start)

    def _next_step(self, pose: Pose2D, odometry: Pose2D, entry: Twist2D) -> Step | None:
        """Turn what is wanted into a step; None to stay, or to come to rest."""
        if self._steering:
            # A course is kept by odometry: a correction must not steer the robot.
            return self._steer(odometry, entry)
        if self._follower.plan is None:
            if not entry and self.activity not in _SAID:
                self._set_activity(Activity.STANDING, self._why_standing())
            return None
        if self._plan_waits_for:
            if not entry:
                self._set_activity(Activity.WAITING, self._plan_waits_for)
            return None
        step = self._follower.next_step(pose, entry)
        if step is None:
            # Whatever moves the robot from now on, the job is done until a new plan comes.
            self._follower.follow(None, pose)
            self._wanted = self._pieces = None
            self._set_activity(Activity.ARRIVED, 'the goal is reached')
        return step

    def _steer(self, pose: Pose2D, entry: Twist2D) -> Step | None:
        """Turn the velocity that is wanted into a step."""
        steered = self._steering.next_step(
            self._last_time, pose, entry, self.gait_pair, self._planner.gear
        )
        self.limit = steered.limit
        if not self._steering:
            self._reason_to_stand = steered.reason
        if steered.reason and not entry:
            self._set_activity(Activity.STANDING, steered.reason)
        return steered.step

    @cached_property
    def _crouching(self) -> Array:
        return crouching_joint_angles(self._robot)

    # A joint that does not answer

    def _given(
        self, trajectory: JointTrajectory | None, now: Measurement
    ) -> JointTrajectory | None:
        """Let a trajectory through the last gate; what does not pass stops the robot."""
        if trajectory is None:
            return None
        measured = now.joint_positions
        if measured is None:
            measured = self._robot.initial_joint_angles.reshape(-1)
        try:
            self._gate.admit(trajectory, now.time, measured)
        except TrajectoryError as error:
            self._forget_schedule()
            # The last one that passed ends at rest.
            self._busy_until = self._gate.end
            if self._lameness is None and not self._has_fallen:
                self._give_up(Activity.STOPPED, f'{error}; the robot stops')
            self.limit = str(error)
            return None
        self._watch.expect(trajectory, now.time)
        return trajectory

    def _forget_commands(self) -> None:
        """Know nothing of what the joints are commanded."""
        self._gate.forget()
        self._watch.forget()
        self._rest.forget()

    def _watched(self, now: Measurement) -> JointFault | None:
        """Compare the joints with their commands; return the one that has failed."""
        if now.joint_positions is None or now.problem or not self._options.watches_joints:
            return None
        time = now.time if now.joint_time is None else now.joint_time
        return self._watch.update(time, now.joint_positions, now.joint_efforts)

    def _lack_of_progress(self, pose: Pose2D, expected: Pose2D) -> str | None:
        """Say why the robot is blocked, if it is; not by cycles that no joint followed."""
        if self._watch.unfollowed > _UNFOLLOWED:
            self._progress.forget()
            return None
        return self._progress.problem(pose, expected)

    def _try_to_go_on(self, now: Measurement) -> JointTrajectory | None:
        """Plan nothing while no joint follows, but for a trial now and then."""
        execution = self._execution
        if execution.has_tried and self._tried is None:
            # Nothing is to be done, so nobody is missed.
            self._watch.forget()
            execution.end()
            self._set_activity(Activity.STANDING, self._why_standing())
            return None
        if execution.is_pausing:
            self._forget_schedule()
            self._tried = None
            trajectory = None
        else:
            trajectory = self._walk_on(now)
            self._tried = trajectory or self._tried
        self._set_activity(Activity.NOT_EXECUTED, str(execution))
        return trajectory

    def _go_lame(self, fault: JointFault, now: Measurement) -> None:
        """Leave everything else, and come to a standstill."""
        assert now.joint_positions is not None
        commanded, _ = self._gate.command(now.time, now.joint_positions)
        standing = self.in_contact_at(now.time)
        options = SafeStopOptions() if self.gait.is_static else SafeStopOptions.hasty()
        stop = SafeStop(self._robot, fault, commanded.reshape(4, 3), standing, options)
        self._lameness = JointRecovery(self._robot, fault, stop)
        self._give_up_plan()
        self._follower.follow(None, now.pose)
        self._steering.end()
        self._forget_schedule()
        self.limit = ''

    def _be_lame(self, lameness: JointRecovery, now: Measurement) -> JointTrajectory | None:
        """Come to a standstill, and stay so until the joint answers again."""
        if now.joint_positions is None or now.problem:
            self.limit = now.problem
            self._lacks_sensors = True
            return None
        if self._lacks_sensors:
            self._lacks_sensors, self.limit = False, ''
        commanded, _ = self._gate.command(now.time, now.joint_positions)
        trajectory = lameness.update(self._stance_at(now), commanded.reshape(4, 3))
        self._busy_until = lameness.stop.end
        self._set_activity(Activity.LAME, str(lameness))
        if lameness.is_over:
            self._lameness = None
            self._watch.forget()
            self._stance = self._robot.initial_joint_angles
            self._set_activity(Activity.STANDING, f'{lameness.fault.name} answers again')
        return trajectory

    # Wishes

    def _take_gaits(self, gait: Gait, turning_gait: Gait, follower: FollowerOptions) -> None:
        # Over uneven ground every swing is balanced anew: there only legs and joints limit.
        margin = self._options.least_margin if self._options.uneven is None else -math.inf
        self.gait_pair = GaitPair(self._robot, gait, turning_gait, margin)
        """The gaits for walking and for turning."""
        self._follower = PathFollower(self.gait_pair.walking, self.gait_pair.turning, follower)

    def _take_new_wishes(self, pose: Pose2D) -> None:
        if self._new_gaits is not None:
            is_following = self._follower.plan is not None
            self._take_gaits(*self._new_gaits)
            self._new_gaits = None
            self._steering.lose_course()
            if is_following:
                self._follower.follow(self._wanted, pose, self._pieces)
        self._take_new_plan(pose)

    def _take_new_plan(self, pose: Pose2D) -> None:
        if self._has_new_plan:
            self._has_new_plan = False
            self._follower.follow(self._wanted, pose, self._pieces)
            self._progress.begin_anew()
            if self.activity in _SAID:
                self._set_activity(Activity.STANDING, self._why_standing())
            self.limit = ''

    def _give_up_plan(self) -> None:
        """Forget the plan; a plan to the same goal is no reason to walk again."""
        if self._wanted is not None:
            self._stopped_goal = self._wanted.poses[-1]
            self._wanted = None
            self._has_new_plan = True

    def _is_refused(self, wish: str) -> bool:
        """Return, and say, whether nothing is to be begun now."""
        if self._lameness is not None:
            self.limit = f'{wish} is refused: {self._lameness.fault.name} does not answer'
        elif self._waits_for_stand:
            self.limit = f'{wish} is refused: {self._why_still()}'
        else:
            return False
        return True

    def _why_still(self) -> str:
        return 'the emergency stop is on' if self._is_frozen else self._waits_for_stand

    def _give_up(self, activity: Activity, reason: str) -> None:
        self._follower.follow(None, Pose2D(0.0, 0.0, 0.0))
        self._steering.end()
        self._set_activity(activity, reason)

    def _why_standing(self) -> str:
        if self._reason_to_stand:
            return self._reason_to_stand
        if self._stopped_goal is not None:
            return 'stopped on request; a plan to another goal makes the robot walk again'
        return 'no plan to follow'

    # Watching the robot

    def _fall(self, now: Measurement) -> JointTrajectory | None:
        """Stop all joints where they are, once."""
        is_new = not self._has_fallen
        self._has_fallen = True
        if self._lameness is not None:
            self._lameness.stop.give_up()
        self._give_up_plan()
        self._give_up(
            Activity.FALLEN,
            f'the robot has fallen: the body is tilted by {math.degrees(now.tilt):.0f} degrees'
            + ('' if self._lameness is None else f'; {self._lameness.fault}'),
        )
        self._forget_schedule()
        if not is_new or now.joint_positions is None:
            return None
        target = self._gate.limits.clip(now.joint_positions)
        duration = self._gate.time_to(now.time, now.joint_positions, target)
        return JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=now.time + max(_LAST_MOMENT, duration),
            times=np.array([0.0]),
            positions=target[None],
            velocities=np.zeros_like(target)[None],
        )

    def _forget_schedule(self) -> None:
        self._busy_until = -math.inf
        self._still_since = self._moving_since = math.inf
        self._stride = None
        self._sequence.clear()
        self._progress.forget()
        self._steering.expire()

    def _expected_at_rest(self, pose: Pose2D) -> Pose2D:
        """Return where the cycle that was begun last should have brought the robot by its end."""
        if self._options.uneven is not None:
            return self._stride_goal
        final = self._sequence.final
        return pose if final is None else final.end_pose

    def _take_posture(self, time: float, joint_positions: Array, posture: Array) -> JointTrajectory:
        options = self._options
        start = self._gate.limits.clip(joint_positions)
        lead_time = max(options.lead_time, self._gate.time_to(time, joint_positions, start))
        trajectory = posture_trajectory(
            self._robot,
            start,
            posture,
            stamp=time + lead_time,
            duration=options.stand_up_time,
            sample_period=options.sample_period,
        )
        self._sequence.clear()
        self._progress.forget()
        self._busy_until = trajectory.end
        self._stance = self._robot.initial_joint_angles if self._is_to_sit else posture
        if self._is_to_sit:
            self._set_activity(Activity.SITTING_DOWN, 'sitting down on request')
        else:
            away = np.abs(joint_positions - posture.reshape(-1)).max()
            self._set_activity(
                Activity.STANDING_UP, f'{away:.2f} rad from the initial posture: regaining it'
            )
        return trajectory

    def _say(self, step: Step, motion: BodyMotion, limit: str = '') -> None:
        if not self._steering:
            self.limit = ''
        if limit:
            self.limit = f'a cycle was shortened: {limit}'
        if step.is_turn or not math.hypot(motion.forward, motion.left) > 1e-3:
            self.activity = Activity.TURNING
            self.reason = f'turning by {math.degrees(motion.turn):.1f} degrees'
        else:
            self.activity = Activity.WALKING
            self.reason = f'walking {math.hypot(motion.forward, motion.left):.3f} m'
            if self._options.follower.turning != 'in_place' or self._steering:
                self.reason += f' and turning by {math.degrees(motion.turn):.1f} degrees'

    def _set_activity(self, activity: Activity, reason: str) -> None:
        self.activity = activity
        self.reason = reason

    def _is_in_posture(self, joint_positions: Array, posture: Array) -> bool:
        off = np.abs(joint_positions - posture.reshape(-1))
        return bool(off.max() < self._options.posture_tolerance)

    def _standing_margin(self) -> float:
        joints = self._robot.initial_joint_angles
        center = self._robot.center_of_mass(joints)[:2]
        feet = self._robot.neutral_feet[:, :2]
        return float(stability_margin(center, feet, np.ones(4, dtype=bool)))


def _is_same_goal(a: Pose2D, b: Pose2D) -> bool:
    return a.distance_to(b) < 1e-3 and abs(wrap_angle(a.yaw - b.yaw)) < 1e-3
