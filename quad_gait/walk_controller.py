"""
Walks a robot along its plan, cycle by cycle, from what it measures.

The controller knows no clock and no topics: it is told the time with each measurement,
and answers with the next joint trajectory when one is due.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.joint_trajectory import JointTrajectory
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot import Robot
from quad_gait.body_motion import minimum_jerk
from quad_gait.gait import Gait
from quad_gait.gait_generator import Cycle, generate_largest_cycle
from quad_gait.path_follower import FollowerOptions, PathFollower
from quad_gait.stability import stability_margin, support_polygon

Array = NDArray[np.float64]


_PATIENCE = 1.0
"""For the joints to come to rest after a cycle [s]."""

_FIRST_STAMP = 1e-3
"""No cycle starts before, for a stamp of zero would mean "on arrival" [s]."""

_STILL_TIME = 0.5
"""A robot out of its posture must be still for so long before it is made to stand up [s]."""

_BLOCKED_CYCLES = 3
"""After so many cycles without the planned effect in a row the robot gives up."""


class Activity(enum.Enum):
    """What the robot is doing, or why it is not moving."""

    WAITING = 'waiting'
    STANDING = 'standing'
    STANDING_UP = 'standing up'
    WALKING = 'walking'
    TURNING = 'turning'
    ARRIVED = 'arrived'
    STOPPED = 'stopped'
    BLOCKED = 'blocked'
    FALLEN = 'fallen'


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
    position_tolerance: float = 0.02
    """The robot is at a turning point or the goal when it is this near [m]."""
    heading_tolerance: float = math.radians(2.0)
    """The robot has the goal's heading when it is this near [rad]."""
    path_tolerance: float = 0.5
    """Farther from the plan the robot does not follow it [m]."""
    stand_up_time: float = 3.0
    """How long the robot takes to regain its initial posture [s]."""


class WalkController:
    """
    Plans each cycle at the end of the last, from where the robot then is.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        For walking straight.
    turning_gait : Gait
        For turning on the spot to the left; mirrored for the right.
    options : ControllerOptions
        Timing and tolerances.
    """

    def __init__(
        self, robot: Robot, gait: Gait, turning_gait: Gait, options: ControllerOptions
    ) -> None:
        self._robot = robot
        self._gait = gait
        self._turning_gait = turning_gait
        self._options = options
        self._follower = PathFollower(
            FollowerOptions(
                largest_stride=robot.largest_stride,
                largest_turn=robot.largest_turn,
                position_tolerance=options.position_tolerance,
                heading_tolerance=options.heading_tolerance,
                path_tolerance=options.path_tolerance,
            )
        )
        self._wanted: Plan | None = None
        self._stopped_goal: Pose2D | None = None
        self._has_new_plan = False
        self._busy_until = -math.inf
        self._last_time = -math.inf
        self._cycle: Cycle | None = None
        self._cycle_start = 0.0
        self._cycle_pose = Pose2D(0.0, 0.0, 0.0)
        self._cycles_without_effect = 0
        self._still_since = math.inf
        self.activity = Activity.WAITING
        """What the robot is doing."""
        self.reason = 'no plan yet'
        """The same as a sentence."""

    @property
    def cycle(self) -> Cycle | None:
        """The cycle that was planned last."""
        return self._cycle

    def set_plan(self, plan: Plan | None) -> None:
        """
        Follow this plan, or none, from the next cycle on.

        After :meth:`stop` a plan to the same goal is not followed: it is no new wish.
        """
        if plan is not None and self._stopped_goal is not None:
            if _is_same_goal(plan.poses[-1], self._stopped_goal):
                return
            self._stopped_goal = None
        self._wanted = plan
        self._has_new_plan = True

    def stop(self) -> None:
        """Stop at the end of the cycle, until a plan to another goal comes."""
        if self._wanted is not None:
            self._stopped_goal = self._wanted.poses[-1]
        self._wanted = None
        self._has_new_plan = True

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
        if now.time < self._last_time - 1.0:
            # The clock was set back: whatever was scheduled is void.
            self._busy_until = -math.inf
            self._still_since = math.inf
            self._cycle = None
        self._last_time = now.time
        if now.tilt > self._options.largest_tilt:
            self._set_activity(
                Activity.FALLEN,
                f'the robot has fallen: the body is tilted by {math.degrees(now.tilt):.0f} degrees',
            )
            return None
        if now.time < self._busy_until + self._options.settle_time:
            return None
        if self._has_new_plan:
            self._has_new_plan = False
            self._follower.follow(self._wanted, now.pose)
            self._cycles_without_effect = 0
            self.activity = Activity.STANDING
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
        if not self._is_in_posture(now.joint_positions):
            if now.time < self._still_since + _STILL_TIME:
                # It may be in the middle of a cycle that another node began.
                return None
            return self._stand_up(now.time, now.joint_positions)
        if self._follower.plan is None:
            if self.activity in (Activity.ARRIVED, Activity.BLOCKED):
                return None
            why = 'no plan to follow'
            if self._stopped_goal is not None:
                why = 'stopped on request; a plan to another goal makes the robot walk again'
            self._set_activity(Activity.STANDING, why)
            return None
        try:
            return self._plan_cycle(now)
        except GaitError as error:
            self._set_activity(Activity.STOPPED, str(error))
            return None

    def margin_at(self, time: float) -> float:
        """Return the predicted stability margin at a time [m]."""
        cycle = self._cycle
        if cycle is None or time >= self._cycle_start + cycle.gait.cycle_period:
            return self._standing_margin()
        return float(cycle.margin[self._sample(cycle, time)])

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
        cycle = self._cycle
        if cycle is None or time >= self._cycle_start + cycle.gait.cycle_period:
            feet = self._robot.neutral_feet[:, :2]
            return pose.transform(support_polygon(feet, np.ones(4, dtype=bool)))
        sample = self._sample(cycle, time)
        polygon = support_polygon(cycle.feet[sample, :, :2], cycle.in_contact[sample])
        return self._cycle_pose.transform(polygon)

    def footholds(self) -> Array:
        """Return the footholds at the end of the last planned cycle, shape (4, 3) [m]."""
        if self._cycle is None:
            return np.empty((0, 3))
        return self._cycle_pose.transform(self._cycle.feet[-1])

    def _plan_cycle(self, now: Measurement) -> JointTrajectory | None:
        problem = self._lack_of_effect(now.pose)
        if problem is not None:
            self._follower.follow(None, now.pose)
            self._set_activity(Activity.BLOCKED, problem)
            return None
        step = self._follower.next_step(now.pose)
        if step is None:
            # Whatever moves the robot from now on, the job is done until a new plan comes.
            self._follower.follow(None, now.pose)
            self._set_activity(Activity.ARRIVED, 'the goal is reached')
            return None
        gait = self._turning_gait if step.is_turn else self._gait
        if step.motion.turn < 0.0:
            gait = gait.mirrored()
        options = self._options
        cycle = generate_largest_cycle(
            self._robot,
            gait,
            step.motion,
            sample_period=options.sample_period,
            least_margin=options.least_margin,
        )
        # Back to back with the last cycle, unless that is too late to be heard in time.
        earliest = now.time + options.lead_time - gait.motion_start
        self._cycle_start = max(self._busy_until, earliest, _FIRST_STAMP)
        self._cycle_pose = now.pose
        self._cycle = cycle
        self._busy_until = self._cycle_start + gait.cycle_period
        motion = cycle.motion
        if step.is_turn:
            self.activity = Activity.TURNING
            self.reason = f'turning by {math.degrees(motion.turn):.1f} degrees'
        else:
            self.activity = Activity.WALKING
            self.reason = f'walking {math.hypot(motion.forward, motion.left):.3f} m'
        return cycle.trajectory(self._robot, self._cycle_start)

    def _lack_of_effect(self, pose: Pose2D) -> str | None:
        """Say how little came of the last cycles, if they did not move the robot."""
        if self._cycle is None:
            return None
        planned = self._cycle.motion.end
        done = self._cycle_pose.inverse() @ pose
        self._cycle = None
        # A turn of 1 rad counts as much as a quarter of a metre.
        size = math.hypot(planned.x, planned.y, 0.25 * planned.yaw)
        error = planned.inverse() @ done
        missing = math.hypot(error.x, error.y, 0.25 * error.yaw)
        has_effect = size < 0.02 or missing < 0.7 * size
        self._cycles_without_effect = 0 if has_effect else self._cycles_without_effect + 1
        if self._cycles_without_effect < _BLOCKED_CYCLES:
            return None
        return (
            f'the robot does not follow its commands: {_BLOCKED_CYCLES} cycles without effect, '
            f'the last planned {math.hypot(planned.x, planned.y):.3f} m and '
            f'{math.degrees(planned.yaw):.1f} degrees and gave '
            f'{math.hypot(done.x, done.y):.3f} m and {math.degrees(done.yaw):.1f} degrees; '
            f'is it stuck, or is its joint controller not running?'
        )

    def _stand_up(self, time: float, joint_positions: Array) -> JointTrajectory:
        options = self._options
        steps = int(np.ceil(options.stand_up_time / options.sample_period))
        times = np.linspace(0.0, options.stand_up_time, steps + 1)
        share, rate = minimum_jerk(0.0, options.stand_up_time, times)
        change = self._robot.initial_joint_angles.reshape(-1) - joint_positions
        trajectory = JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=time + options.lead_time,
            times=times,
            positions=joint_positions + share[:, None] * change,
            velocities=rate[:, None] * change,
        )
        self._cycle = None
        self._busy_until = trajectory.end
        self._set_activity(
            Activity.STANDING_UP,
            f'{np.abs(change).max():.2f} rad from the initial posture: regaining it',
        )
        return trajectory

    def _set_activity(self, activity: Activity, reason: str) -> None:
        self.activity = activity
        self.reason = reason

    def _is_at_rest(self, now: Measurement) -> bool:
        speeds = now.joint_velocities
        return speeds is None or bool(np.all(np.abs(speeds) < self._options.rest_speed))

    def _is_in_posture(self, joint_positions: Array) -> bool:
        off = np.abs(joint_positions - self._robot.initial_joint_angles.reshape(-1))
        return bool(off.max() < self._options.posture_tolerance)

    def _standing_margin(self) -> float:
        joints = self._robot.initial_joint_angles
        center = self._robot.center_of_mass(joints)[:2]
        feet = self._robot.neutral_feet[:, :2]
        return float(stability_margin(center, feet, np.ones(4, dtype=bool)))

    def _sample(self, cycle: Cycle, time: float) -> int:
        index = round((time - self._cycle_start) / float(cycle.times[1]))
        return min(max(index, 0), len(cycle.times) - 1)


def _is_same_goal(a: Pose2D, b: Pose2D) -> bool:
    return a.distance_to(b) < 1e-3 and abs(wrap_angle(a.yaw - b.yaw)) < 1e-3
