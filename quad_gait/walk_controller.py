"""
Walks a robot along its plan, or as it is steered, cycle by cycle from what it measures.

The controller knows no clock and no topics: it is told the time with each measurement,
and answers with the next joint trajectory when one is due.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.height_map import HeightMap
from quad_common.joint_trajectory import JointTrajectory
from quad_common.plan import Plan
from quad_common.planar_pose import STILL, Pose2D, Twist2D, wrap_angle
from quad_common.robot import Robot
from quad_gait.body_motion import BodyMotion
from quad_gait.body_placement import angles_of, rotation_of
from quad_gait.foot_tracking import track_feet
from quad_gait.gait import Gait
from quad_gait.gait_generator import Cycle, FootTracking, generate_cycle, generate_largest_cycle
from quad_gait.joint_watch import JointFault, JointWatch
from quad_gait.lame_stop import Lameness, LameStop
from quad_gait.motion_limits import MotionLimits
from quad_gait.motion_sequence import MotionSequence, ScheduledCycle
from quad_gait.path_follower import FollowerOptions, PathFollower, Step
from quad_gait.posture import crouching_joint_angles, posture_trajectory
from quad_gait.reference_path import Piece
from quad_gait.slip_compensation import NO_SLIP, SlipCompensation
from quad_gait.stability import stability_margin, support_polygon
from quad_gait.uneven_stride import Stance, UnevenOptions, UnevenStride

Array = NDArray[np.float64]


_PATIENCE = 1.0
"""For the joints to come to rest after a cycle [s]."""

_FIRST_STAMP = 1e-3
"""No cycle starts before, for a stamp of zero would mean "on arrival" [s]."""

_STILL_TIME = 0.5
"""A robot out of its posture must be still for so long before it is made to stand up [s]."""

_BLOCKED_CYCLES = 3
"""After so many cycles without the planned effect in a row the robot gives up."""

_LAST_MOMENT = 0.05
"""A cycle that is to follow another at once is given out at least so long before [s]."""

_SPEED_STEP = 0.4
"""Share of its largest speed that a dynamic gait gathers in one cycle."""

_MORE_BESIDE = 1.2
"""How much farther beside its feet the body may be in a dynamic gait's changes of speed."""

_PURE_TURN = 0.02
"""Steering that moves the body by less than this per radian is a turn on the spot [m]."""


class Activity(enum.Enum):
    """What the robot is doing, or why it is not moving."""

    WAITING = 'waiting'
    STANDING = 'standing'
    STANDING_UP = 'standing up'
    SITTING_DOWN = 'sitting down'
    SITTING = 'sitting'
    WALKING = 'walking'
    TURNING = 'turning'
    ARRIVED = 'arrived'
    STOPPED = 'stopped'
    BLOCKED = 'blocked'
    FALLEN = 'fallen'
    LAME = 'lame'


_SAID = (Activity.ARRIVED, Activity.BLOCKED, Activity.STOPPED)
"""What is said until something new is wished for."""


@dataclass(frozen=True)
class Measurement:
    """What the controller is told about the robot at one instant."""

    time: float
    """[s]"""
    pose: Pose2D
    """base_link in the plan's frame."""
    tilt: float
    """Between the body's z axis and the vertical [rad]."""
    joint_positions: Array | None
    """Shape (12,) [rad]; None before the first were heard of."""
    joint_velocities: Array | None
    """Shape (12,) [rad/s]."""
    orientation: Array | None = None
    """Of the body, quaternion xyzw, shape (4,); None: level."""
    joint_efforts: Array | None = None
    """Torques of the motors, shape (12,) [N m]; None where they do not tell."""
    joint_time: float | None = None
    """When the joints were measured [s]; None: at ``time``."""


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


@dataclass(frozen=True)
class Steering:
    """A velocity that somebody wants, and since when."""

    twist: Twist2D
    time: float
    """[s]"""


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
        self._compensation = compensation
        self._sequence = MotionSequence()
        self._watch = JointWatch(robot)
        self._lameness: Lameness | None = None
        self._busy_until = -math.inf
        self._stride: UnevenStride | None = None
        self._height_map: HeightMap | None = None
        self._stride_end = Pose2D(0.0, 0.0, 0.0)
        # In which the robot stands between two cycles.
        self._stance = robot.initial_joint_angles
        self._take_gaits(gait, turning_gait, options.follower)
        self._new_gaits: tuple[Gait, Gait, FollowerOptions] | None = None
        self._wanted: Plan | None = None
        self._pieces: list[Piece] | None = None
        self._stopped_goal: Pose2D | None = None
        self._has_new_plan = False
        self._steering: Steering | None = None
        self._course: Pose2D | None = None
        self._reason_to_stand = ''
        self._is_to_sit = False
        self._has_fallen = False
        self._last_time = -math.inf
        # At the end of the cycle that was planned last, without compensation for slip.
        self._speed = STILL
        # What slip takes from that cycle, by the compensation.
        self._slip = BodyMotion()
        self._decided: Pose2D | None = None
        self._decided_after = -math.inf
        self._cycles_without_effect = 0
        self._still_since = math.inf
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
    def gait(self) -> Gait:
        """The gait for walking."""
        return self._walking.gait

    def prepare(self) -> None:
        """Find the commonest limits beforehand: it takes a while, and cycles are awaited."""
        self._walking.largest_share(BodyMotion(forward=1.0))
        for side in (1.0, -1.0):
            self._turning.largest_share(BodyMotion(turn=side))

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
        if plan is not None and self._stopped_goal is not None:
            if _is_same_goal(plan.poses[-1], self._stopped_goal):
                return
            self._stopped_goal = None
        if self._lameness is not None:
            self._refuse('the plan')
            return
        self._wanted = plan
        self._pieces = pieces
        self._has_new_plan = True
        self._steering = None
        self._reason_to_stand = ''

    def set_twist(self, twist: Twist2D) -> None:
        """Walk with this velocity until the steering times out; ends the following of a plan."""
        if not self._last_time > -math.inf:
            return
        if self._lameness is not None:
            self._refuse('steering')
            return
        self._give_up_plan()
        self._reason_to_stand = ''
        if self._steering is None:
            self._course = None
        self._steering = Steering(twist, self._last_time)

    def stop(self) -> str:
        """
        Stop at the end of the cycle, until a plan to another goal or steering comes.

        Returns
        -------
        str
            What will happen.
        """
        self._give_up_plan()
        self._steering = None
        self._reason_to_stand = ''
        return 'the robot stops at the end of its gait cycle, on four feet'

    def stand(self) -> str:
        """Stop, and regain the initial posture, also after sitting or a fall; as :meth:`stop`."""
        self.stop()
        self._is_to_sit = False
        self._has_fallen = False
        if self._lameness is not None:
            self._lameness.try_again()
            return f'{self._lameness.fault.name} is tried first; if it answers the robot stands up'
        self._stance = self._robot.initial_joint_angles
        return 'the robot stops at the end of its gait cycle and stands in its initial posture'

    def sit(self) -> str:
        """Stop, and lower the body as far as it goes; only :meth:`stand` ends it."""
        if self._lameness is not None:
            return f'the robot is lame, and stays as it is: {self._lameness.fault}'
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
        if now.time < self._last_time - 1.0:
            # The clock was set back: whatever was scheduled is void.
            self._forget_schedule()
        self._last_time = now.time
        fault = self._watched(now)
        if now.tilt > options.largest_tilt:
            return self._given(self._fall(now), now)
        if fault is not None and self._lameness is None and not self._has_fallen:
            self._go_lame(fault, now)
        if self._lameness is not None:
            return self._given(self._be_lame(self._lameness, now), now)
        return self._given(self._walk_on(now), now)

    def _walk_on(self, now: Measurement) -> JointTrajectory | None:
        """Give out the next trajectory of a sound robot, if it is time."""
        options = self._options
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
        feet, center = self._level_feet(now)
        return float(stability_margin(center, feet, self.in_contact_at(now.time)))

    def measured_support_polygon(self, now: Measurement) -> Array:
        """Return the support polygon of the feet as measured, counter-clockwise, (n, 2) [m]."""
        if now.joint_positions is None:
            return np.empty((0, 2))
        polygon = support_polygon(self._level_feet(now)[0], self.in_contact_at(now.time))
        return now.pose.transform(polygon)

    def _level_feet(self, now: Measurement) -> tuple[Array, Array]:
        """Place feet and centre of mass beside base_link, seen from above, (4, 2) and (2,) [m]."""
        assert now.joint_positions is not None
        joints = now.joint_positions.reshape(4, 3)
        feet, center = self._robot.foot_positions(joints), self._robot.center_of_mass(joints)
        if now.orientation is not None:
            roll, pitch, _ = angles_of(now.orientation)
            rotation = rotation_of(np.array([roll, pitch, 0.0]))
            feet, center = feet @ rotation.T, center @ rotation.T
        return feet[:, :2], center[:2]

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

    def _begin(self, now: Measurement) -> JointTrajectory | None:
        """Decide for a robot whose last cycle has ended at rest."""
        if self._has_fallen:
            self._set_activity(
                Activity.FALLEN, 'the robot has fallen and is upright again; it waits for stand'
            )
            return None
        self._take_new_wishes(now.pose)
        if now.joint_positions is None:
            self._set_activity(Activity.WAITING, 'no joint states yet')
            return None
        if not self._is_at_rest(now):
            self._still_since = math.inf
            # A robot may swing a little after a cycle: worth a word only if it lasts.
            if now.time > self._busy_until + self._options.settle_time + _PATIENCE:
                self._set_activity(Activity.WAITING, 'the joints are still moving')
            return None
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
            problem = self._lack_of_effect(now.pose, now.pose)
            if problem is not None:
                self._give_up(Activity.BLOCKED, problem)
                return None
            step = self._next_step(now.pose, STILL)
            if step is None:
                return None
            if self._options.uneven is not None:
                return self._first_stride(now, step)
            return self._first_cycle(now, step)
        except GaitError as error:
            self._set_activity(Activity.STOPPED, str(error))
            return None

    def _go_on(self, now: Measurement, current: ScheduledCycle) -> JointTrajectory | None:
        """Decide for a robot in motion, shortly before its cycle ends."""
        expected = current.pose_at(now.time)
        end = now.pose @ self._without_slip(current, now.time, expected)
        self._take_new_plan(now.pose)
        problem = self._lack_of_effect(now.pose, expected)
        if problem is not None:
            self._give_up(Activity.BLOCKED, problem)
        if problem is not None or self._new_gaits is not None or self._is_to_sit:
            self._come_to_rest(current)
            return None
        try:
            step = self._next_step(end, self._speed)
            if step is None or self._gear(step) is not self._gear_in_use:
                self._come_to_rest(current)
                return None
            cycle = self._generate(step, current.cycle.joint_positions[-1], current.cycle)
            if cycle.limit and self._gait_for(step) != cycle.gait:
                # Another order of the legs can do more, but is taken up at rest only.
                self._come_to_rest(current)
                return None
            planned = self._with_stop(ScheduledCycle(cycle, current.end, end))
        except GaitError as error:
            self.limit = str(error)
            self._come_to_rest(current)
            return None
        self._sequence.replace(*planned)
        self._busy_until = self._sequence.end
        self._decided = now.pose
        self._say(step, cycle.motion, cycle.limit)
        return self._sequence.trajectory(self._robot, now.time)

    def _without_slip(self, current: ScheduledCycle, time: float, expected: Pose2D) -> Pose2D:
        """Return how the body will have moved at a cycle's end: slip takes back what it costs."""
        ahead = expected.inverse() @ current.end_pose
        share = (current.end - time) / current.cycle.period
        slip = self._slip
        return ahead @ BodyMotion(-share * slip.forward, -share * slip.left, -share * slip.turn).end

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
            trajectory = stride.update(self._stance_at(now))
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

    def _stance_at(self, now: Measurement) -> Stance:
        assert now.joint_positions is not None
        orientation = now.orientation
        if orientation is None:
            orientation = np.array([0.0, 0.0, 0.0, 1.0])
        return Stance.measured(
            self._robot, now.time, now.pose, orientation, now.joint_positions, now.joint_efforts
        )

    def _first_stride(self, now: Measurement, step: Step) -> JointTrajectory | None:
        """Begin a step over uneven ground."""
        options = self._options.uneven
        assert options is not None
        self._gear_in_use = self._gear(step)
        self._stride = UnevenStride(
            self._robot, self._gait_for(step), step.motion, now.pose, self._height_map, options
        )
        self._decided = now.pose
        self._stride_end = step.motion.end
        self._say(step, step.motion)
        return self._go_on_with_stride(now)

    def _first_cycle(self, now: Measurement, step: Step) -> JointTrajectory:
        """Begin to move."""
        assert now.joint_positions is not None
        cycle = self._generate(step, now.joint_positions.reshape(4, 3))
        options = self._options
        # Back to back with the last cycle, unless that is too late to be heard in time.
        earliest = now.time + options.lead_time - cycle.gait.motion_start
        start = max(self._busy_until, earliest, _FIRST_STAMP)
        planned = self._with_stop(ScheduledCycle(cycle, start, now.pose))
        self._sequence.clear()
        self._sequence.replace(*planned)
        self._busy_until = self._sequence.end
        self._decided = now.pose
        self._say(step, cycle.motion, cycle.limit)
        return self._sequence.trajectory(self._robot, start)

    def _with_stop(self, scheduled: ScheduledCycle) -> list[ScheduledCycle]:
        """Add the cycle that brings the body to rest, if it is not at rest anyway."""
        stop = self._stop_after(scheduled.cycle)
        if stop is None:
            return [scheduled]
        return [scheduled, ScheduledCycle(stop, scheduled.end, scheduled.end_pose)]

    def _stop_after(self, cycle: Cycle) -> Cycle | None:
        """Plan the cycle that brings the body to rest; None if it is at rest anyway."""
        if not cycle.exit:
            return None
        return generate_cycle(
            self._robot,
            cycle.gait,
            BodyMotion.during(cycle.exit, (1.0 - cycle.gait.gathering) * cycle.period),
            start_feet=cycle.end_feet,
            entry=cycle.exit,
            sample_period=self._options.sample_period,
            least_margin=_slack(self._gear_in_use.least_margin),
            track=self._tracking(cycle.joint_positions[-1]),
        )

    def _generate(self, step: Step, start_joints: Array, before: Cycle | None = None) -> Cycle:
        """Plan a step: from rest, or following another cycle at its speed."""
        gear = self._gear(step)
        self._gear_in_use = gear
        entry = STILL if before is None else self._speed
        motion, exit = step.motion, self._gathered(step.exit, entry, gear)
        if exit is not step.exit:
            # Less speed at the end: less way.
            lost = BodyMotion.during(step.exit.minus(exit), gear.gathering * gear.period)
            motion = motion.minus(lost)
        compensated = self._compensation.compensated
        speed = compensated(gear.gait, BodyMotion.during(exit, gear.period)).rate(gear.period)
        cycle = generate_largest_cycle(
            self._robot,
            self._gait_for(step) if before is None else before.gait,
            compensated(gear.gait, motion),
            start_feet=None if before is None else before.end_feet,
            entry=STILL if before is None else before.exit,
            exit=speed,
            sample_period=self._options.sample_period,
            least_margin=_slack(gear.least_margin),
            track=self._tracking(start_joints),
            accept=self._check_stop_after,
        )
        share = _ratio(cycle.exit, speed)
        self._speed = exit.scaled(share)
        self._slip = BodyMotion.during(speed.minus(exit), share * gear.period)
        return cycle

    def _check_stop_after(self, cycle: Cycle) -> None:
        """Raise a GaitError if the body could not be brought to rest after a cycle."""
        self._stop_after(cycle)

    def _gathered(self, wanted: Twist2D, entry: Twist2D, gear: MotionLimits) -> Twist2D:
        """Let a dynamic gait gather speed over a few cycles: it would rock otherwise."""
        if gear.gait.is_static or not wanted:
            return wanted
        way = BodyMotion.during(wanted, gear.period)
        largest = gear.largest_share(way) * gear.size(way)
        gain = wanted.minus(entry)
        size = gear.size(BodyMotion.during(gain, gear.period))
        if size <= _SPEED_STEP * largest:
            return wanted
        return entry.plus(gain.scaled(_SPEED_STEP * largest / size))

    def _tracking(self, start_joints: Array) -> FootTracking | None:
        """Return S1's law, beginning at the joints' angles, if it is to be used."""
        gain = self._options.tracking_gain
        if gain is None:
            return None
        return lambda robot, times, feet, velocities: track_feet(
            robot, times, feet, velocities, start_joints, gain
        )

    def _next_step(self, pose: Pose2D, entry: Twist2D) -> Step | None:
        """Turn what is wanted into a step; None to stay, or to come to rest."""
        if self._steering is not None:
            return self._steer(pose, entry)
        if self._follower.plan is None:
            if not entry and self.activity not in _SAID:
                self._set_activity(Activity.STANDING, self._why_standing())
            return None
        step = self._follower.next_step(pose, entry)
        if step is None:
            # Whatever moves the robot from now on, the job is done until a new plan comes.
            self._follower.follow(None, pose)
            self._set_activity(Activity.ARRIVED, 'the goal is reached')
        return step

    def _steer(self, pose: Pose2D, entry: Twist2D) -> Step | None:
        """Walk with the wanted velocity, on the course that it has described so far."""
        assert self._steering is not None
        steering, self.limit = self._steering, ''
        if self._last_time > steering.time + self._options.twist_timeout:
            self._steering = None
            self._reason_to_stand = 'the steering has timed out'
            if not entry:
                self._set_activity(Activity.STANDING, self._reason_to_stand)
            return None
        wanted = steering.twist
        gear = self.gear_for(wanted)
        twist, limit = gear.limited(wanted)
        if not wanted or not twist:
            self.limit = limit
            if not entry:
                self._set_activity(Activity.STANDING, limit or 'steered to stand')
            self._course = None
            return None
        if limit:
            self.limit = (
                f'steered at {_described(wanted)}, walking at {_described(twist)}, '
                f'the most that the {gear.gait.name} gait does: {limit}'
            )
        if entry and gear is not self._gear_in_use:
            self._course = None
            return None
        period = gear.period
        motion = BodyMotion.during(twist, period)
        if gear.is_steady:
            share = gear.gathering
            motion = BodyMotion.during(entry.scaled(1.0 - share).plus(twist.scaled(share)), period)
        target = self._on_course(pose) @ motion.end
        self._course = target
        exit_twist = twist if gear.is_steady else STILL
        return Step(
            is_turn=gear is self._turning and gear is not self._walking,
            motion=BodyMotion.reaching(pose.inverse() @ target),
            exit=exit_twist,
        )

    def _on_course(self, pose: Pose2D) -> Pose2D:
        """Return where the steering would have brought the robot; or where it is, if lost."""
        course = self._course
        if course is None or not self._options.hold_course:
            return pose
        correction = self._options.follower.largest_correction
        apart = pose.inverse() @ course
        near = math.hypot(apart.x, apart.y) <= correction
        return course if near and abs(apart.yaw) < math.radians(12.0) else pose

    def _gait_for(self, step: Step) -> Gait:
        """Choose the order of the legs by where the body goes, not by what is corrected."""
        gear = self._gear(step)
        way = BodyMotion.during(step.exit, gear.period) if step.exit else step.motion
        return gear.gait_for(way)

    def _gear(self, step: Step) -> MotionLimits:
        return self._turning if step.is_turn else self._walking

    def gear_for(self, twist: Twist2D) -> MotionLimits:
        """Return the gait that a velocity is walked with: for walking, or for turning."""
        translation = math.hypot(twist.forward, twist.left)
        is_turn = bool(twist.turn) and translation <= _PURE_TURN * abs(twist.turn)
        return self._turning if is_turn else self._walking

    @cached_property
    def _crouching(self) -> Array:
        return crouching_joint_angles(self._robot)

    # A joint that does not answer

    def _given(
        self, trajectory: JointTrajectory | None, now: Measurement
    ) -> JointTrajectory | None:
        if trajectory is not None:
            self._watch.expect(trajectory, now.time)
        return trajectory

    def _watched(self, now: Measurement) -> JointFault | None:
        """Compare the joints with their commands; return the one that has failed."""
        if now.joint_positions is None or not self._options.watches_joints:
            return None
        time = now.time if now.joint_time is None else now.joint_time
        return self._watch.update(time, now.joint_positions, now.joint_efforts)

    def _go_lame(self, fault: JointFault, now: Measurement) -> None:
        """Leave everything else, and come to a standstill."""
        commanded = self._watch.commanded(now.time)
        assert commanded is not None
        standing = self.in_contact_at(now.time)
        stop = LameStop(self._robot, fault, commanded.reshape(4, 3), standing)
        self._lameness = Lameness(self._robot, fault, stop)
        self._give_up_plan()
        self._follower.follow(None, now.pose)
        self._steering = None
        self._forget_schedule()
        self.limit = ''

    def _be_lame(self, lameness: Lameness, now: Measurement) -> JointTrajectory | None:
        """Come to a standstill, and stay so until the joint answers again."""
        if now.joint_positions is None:
            return None
        trajectory = lameness.update(self._stance_at(now))
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
        self._walking = MotionLimits(self._robot, gait, margin)
        is_same = turning_gait == gait
        self._turning = (
            self._walking if is_same else MotionLimits(self._robot, turning_gait, margin)
        )
        self._gear_in_use = self._walking
        self._follower = PathFollower(self._walking, self._turning, follower)

    def _take_new_wishes(self, pose: Pose2D) -> None:
        if self._new_gaits is not None:
            is_following = self._follower.plan is not None
            self._take_gaits(*self._new_gaits)
            self._new_gaits = None
            self._course = None
            if is_following:
                self._follower.follow(self._wanted, pose, self._pieces)
        self._take_new_plan(pose)

    def _take_new_plan(self, pose: Pose2D) -> None:
        if self._has_new_plan:
            self._has_new_plan = False
            self._follower.follow(self._wanted, pose, self._pieces)
            self._cycles_without_effect = 0
            if self.activity in _SAID:
                self._set_activity(Activity.STANDING, self._why_standing())
            self.limit = ''

    def _give_up_plan(self) -> None:
        """Forget the plan; a plan to the same goal is no reason to walk again."""
        if self._wanted is not None:
            self._stopped_goal = self._wanted.poses[-1]
            self._wanted = None
            self._has_new_plan = True

    def _refuse(self, wish: str) -> None:
        assert self._lameness is not None
        self.limit = f'{wish} is refused: {self._lameness.fault.name} does not answer'

    def _give_up(self, activity: Activity, reason: str) -> None:
        self._follower.follow(None, Pose2D(0.0, 0.0, 0.0))
        self._steering = None
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
        still = np.zeros_like(now.joint_positions)
        return JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=now.time + _LAST_MOMENT,
            times=np.array([0.0]),
            positions=now.joint_positions[None],
            velocities=still[None],
        )

    def _forget_schedule(self) -> None:
        self._busy_until = -math.inf
        self._still_since = math.inf
        self._stride = None
        self._sequence.clear()
        self._decided = None
        self._course = None
        if self._steering is not None:
            self._steering = Steering(self._steering.twist, -math.inf)

    def _lack_of_effect(self, pose: Pose2D, expected: Pose2D) -> str | None:
        """Say how little came of the last cycles, if they did not move the robot."""
        if self._decided is None:
            return None
        last = self._sequence.last
        if self._options.uneven is not None:
            expected = self._decided @ self._stride_end
        elif last is not None and expected is pose:
            expected = last.end_pose if not last.cycle.exit else self._resting_pose()
        planned = self._decided.inverse() @ expected
        done = self._decided.inverse() @ pose
        self._decided = None
        # A turn of 1 rad counts as much as a quarter of a metre.
        size = math.hypot(planned.x, planned.y, 0.25 * planned.yaw)
        error = planned.inverse() @ done
        missing = math.hypot(error.x, error.y, 0.25 * error.yaw)
        if size < 0.1 * self._robot.largest_stride:
            # Too little to tell, as the first cycle of a gait that gathers speed.
            return None
        has_effect = missing < 0.7 * size
        self._cycles_without_effect = 0 if has_effect else self._cycles_without_effect + 1
        if self._cycles_without_effect < _BLOCKED_CYCLES:
            return None
        self._cycles_without_effect = 0
        return (
            f'the robot does not follow its commands: {_BLOCKED_CYCLES} cycles without effect, '
            f'the last planned {math.hypot(planned.x, planned.y):.3f} m and '
            f'{math.degrees(planned.yaw):.1f} degrees and gave '
            f'{math.hypot(done.x, done.y):.3f} m and {math.degrees(done.yaw):.1f} degrees; '
            f'is it stuck, or is its joint controller not running?'
        )

    def _resting_pose(self) -> Pose2D:
        """Where the body is to be after the cycle that brings it to rest."""
        resting = self._sequence.final
        assert resting is not None
        return resting.end_pose

    def _take_posture(self, time: float, joint_positions: Array, posture: Array) -> JointTrajectory:
        options = self._options
        trajectory = posture_trajectory(
            self._robot,
            joint_positions,
            posture,
            stamp=time + options.lead_time,
            duration=options.stand_up_time,
            sample_period=options.sample_period,
        )
        self._sequence.clear()
        self._decided = None
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
        if self._steering is None:
            self.limit = ''
        if limit:
            self.limit = f'a cycle was shortened: {limit}'
        if step.is_turn or not math.hypot(motion.forward, motion.left) > 1e-3:
            self.activity = Activity.TURNING
            self.reason = f'turning by {math.degrees(motion.turn):.1f} degrees'
        else:
            self.activity = Activity.WALKING
            self.reason = f'walking {math.hypot(motion.forward, motion.left):.3f} m'
            if self._options.follower.turning != 'in_place' or self._steering is not None:
                self.reason += f' and turning by {math.degrees(motion.turn):.1f} degrees'

    def _set_activity(self, activity: Activity, reason: str) -> None:
        self.activity = activity
        self.reason = reason

    def _is_at_rest(self, now: Measurement) -> bool:
        speeds = now.joint_velocities
        return speeds is None or bool(np.all(np.abs(speeds) < self._options.rest_speed))

    def _is_in_posture(self, joint_positions: Array, posture: Array) -> bool:
        off = np.abs(joint_positions - posture.reshape(-1))
        return bool(off.max() < self._options.posture_tolerance)

    def _standing_margin(self) -> float:
        joints = self._robot.initial_joint_angles
        center = self._robot.center_of_mass(joints)[:2]
        feet = self._robot.neutral_feet[:, :2]
        return float(stability_margin(center, feet, np.ones(4, dtype=bool)))


def _ratio(a: Twist2D, b: Twist2D) -> float:
    """Say how much of a velocity another one with the same direction is."""
    part, whole = (abs(v.forward) + abs(v.left) + abs(v.turn) for v in (a, b))
    return part / whole if whole else 0.0


def _slack(least_margin: float) -> float:
    """Allow dynamic gaits a little more while they change their speed."""
    return least_margin if least_margin >= 0.0 else _MORE_BESIDE * least_margin


def _described(twist: Twist2D) -> str:
    return f'({twist.forward:.3f}, {twist.left:.3f}) m/s and {math.degrees(twist.turn):.1f} deg/s'


def _is_same_goal(a: Pose2D, b: Pose2D) -> bool:
    return a.distance_to(b) < 1e-3 and abs(wrap_angle(a.yaw - b.yaw)) < 1e-3
