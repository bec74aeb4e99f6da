"""The controller walks a robot from what it measures, one trajectory after the other."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from told_supervisor import ToldSupervisor

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D, distance_to_polyline, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import tilt_from_quaternion
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.faults.joint_fault_detector import JointFaultDetector
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.slip_compensation import NO_SLIP, Calibration, SlipCompensation
from quad_gait.state.measurement import Measurement
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.simulation import Simulation

ROBOT = load_robot('titan_viii')
CRAWL, TURN = load_gait('crawl'), load_gait('turn')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
ORIGIN = Pose2D(0.0, 0.0, 0.0)

BACK = Plan.through([[0.0, 0.0], [-1.0, 0.0]], math.pi)
AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)
CORNER = Plan.through([[0.0, 0.0], [0.6, 0.0], [0.6, 0.4]], math.pi / 2)


def make_controller(robot=ROBOT, gait=None, compensation=NO_SLIP, **options):
    walking, turning = (CRAWL, TURN) if gait is None else gaits_for(robot, gait)
    return ToldSupervisor(robot, walking, turning, SupervisorOptions(**options), compensation)


def gaits_for(robot, name):
    """Load a gait for walking and its gait for turning."""
    gait = load_gait(name, robot)
    return gait, turning_gait_for(gait, robot)


def standing(time, pose=ORIGIN, **changes):
    """What is measured of a robot that stands in its initial posture."""
    measurement = Measurement(time, pose, 0.0, POSTURE.copy(), np.zeros(12))
    return replace(measurement, **changes)


def measured(simulation):
    seen = simulation.observe()
    tilt = tilt_from_quaternion(seen.orientation)
    return Measurement(seen.time, seen.pose, tilt, seen.joint_positions, seen.joint_velocities)


class Walk:
    """
    A controller and a simulated robot, with a record of all that happened.

    The robot may go only a fraction of the distance, and veer for each metre [rad/m].
    """

    def __init__(
        self,
        start=ORIGIN,
        robot=ROBOT,
        gait=None,
        compensation=NO_SLIP,
        follows=1.0,
        veer=0.0,
        time_step=0.01,
        **options,
    ):
        self.simulation = Simulation(KinematicSimulator(robot, time_step), robot, start)
        self.controller = make_controller(robot, gait, compensation, **options)
        self.robot = robot
        self.posture = robot.initial_joint_angles.reshape(-1)
        self.follows, self.veer = follows, veer
        self.pose = self.kinematic_pose = start
        self.trajectories = []
        self.told_at = []
        self.activities = []
        self.poses = []
        self.joints = []

    def step(self):
        now = self.measured()
        trajectory = self.controller.update(now)
        if trajectory is not None:
            self.simulation.accept(trajectory)
            self.trajectories.append(trajectory)
            self.told_at.append(now.time)
        self.poses.append(now.pose)
        self.joints.append(now.joint_positions)
        if not self.activities or self.activities[-1] is not self.controller.activity:
            self.activities.append(self.controller.activity)
        self.simulation.step()

    def measured(self):
        now = measured(self.simulation)
        moved = self.kinematic_pose.inverse() @ now.pose
        self.kinematic_pose = now.pose
        fraction = self.follows
        self.pose = self.pose @ Pose2D(
            fraction * moved.x, fraction * moved.y, fraction * moved.yaw + self.veer * moved.x
        )
        return replace(now, pose=self.pose)

    @property
    def time(self):
        return self.simulation.time

    def run(self, until, seconds=200.0):
        """Step until a condition holds."""
        for _ in range(round(seconds / self.simulation.time_step)):
            if until():
                return
            self.step()
        pytest.fail(f'still {self.controller.activity} after {seconds} s')

    def run_for(self, seconds):
        for _ in range(round(seconds / self.simulation.time_step)):
            self.step()

    def steer(self, twist, seconds):
        """Say again and again how the robot is to walk."""
        for _ in range(round(seconds / 0.5)):
            self.controller.set_twist(twist)
            self.run_for(0.5)

    def stands(self):
        """Whether the robot is in its initial posture, and its joints are at rest."""
        now = measured(self.simulation)
        in_posture = np.abs(now.joint_positions - self.posture).max() < 1e-9
        return in_posture and np.abs(now.joint_velocities).max() < 1e-9

    def arrives(self):
        self.run(lambda: self.controller.activity is Activity.ARRIVED)


@pytest.fixture(scope='module')
def walked():
    """Let the robot walk round a corner."""
    walk = Walk()
    walk.controller.set_plan(CORNER)
    walk.arrives()
    return walk


def test_a_plan_with_a_corner_is_walked_to_its_goal(walked):
    end, goal = walked.poses[-1], CORNER.poses[-1]
    assert end.distance_to(goal) < 0.02
    assert abs(wrap_angle(end.yaw - goal.yaw)) < math.radians(2.0)
    assert walked.controller.reason == 'the goal is reached'
    assert walked.activities[-4:] == [
        Activity.WALKING,
        Activity.TURNING,
        Activity.WALKING,
        Activity.ARRIVED,
    ]


def test_on_the_way_the_body_stays_near_the_path(walked):
    # Sway included: mu = 0.4 of the distance to a support triangle's centroid.
    sway = 0.4 * np.abs(ROBOT.neutral_feet[:, 1]).max()
    for pose in walked.poses:
        assert distance_to_polyline((pose.x, pose.y), CORNER.corners) < sway


def test_consecutive_trajectories_join_without_a_jump_or_a_jerk(walked):
    assert len(walked.trajectories) == 3 + 3 + 2
    for before, after in pairwise(walked.trajectories):
        assert before.positions[-1] == pytest.approx(after.positions[0], abs=1e-9)
        assert before.velocities[-1] == pytest.approx(np.zeros(12), abs=1e-9)
        assert after.velocities[0] == pytest.approx(np.zeros(12), abs=1e-9)
        assert before.end <= after.stamp + after.times[0]


def test_a_trajectory_is_given_out_its_lead_time_before_it_moves_anything(walked):
    for told_at, trajectory in zip(walked.told_at, walked.trajectories):
        lead = trajectory.stamp + trajectory.times[0] - told_at
        assert lead >= SupervisorOptions().lead_time - 1e-9
        moving = np.flatnonzero(np.abs(trajectory.velocities).max(axis=1) > 1e-6)
        assert trajectory.stamp + trajectory.times[moving[0]] > told_at + 0.3


def test_cycles_follow_each_other_without_a_pause(walked):
    # Cycles of 5 s each, planned from what is measured 0.2 s after the last one's end.
    stamps = [trajectory.stamp for trajectory in walked.trajectories]
    assert np.diff(stamps) == pytest.approx(np.full(len(stamps) - 1, 5.0), abs=1e-9)
    ends = np.array([trajectory.end for trajectory in walked.trajectories[:-1]])
    assert walked.told_at[1:] == pytest.approx(ends + 0.2, abs=0.011)


def test_even_at_the_beginning_of_time_a_trajectory_says_when_it_starts():
    # A stamp of zero means "on arrival", and would put controller and robot out of step.
    controller = make_controller()
    controller.set_plan(AHEAD)
    trajectory = controller.update(standing(0.0))
    assert 0.0 < trajectory.stamp < 0.1
    assert controller.update(standing(trajectory.end + 0.19, AHEAD.poses[0])) is None
    assert controller.update(standing(trajectory.end + 0.21, AHEAD.poses[0])) is not None


@pytest.fixture
def begun():
    """Let a controller begin its first cycle at a pose in the middle of nowhere."""
    controller = make_controller()
    pose = Pose2D(3.0, -2.0, 0.5)
    ahead = pose @ Pose2D(1.0, 0.0, 0.0)
    controller.set_plan(Plan.through([[pose.x, pose.y], [ahead.x, ahead.y]], 0.5))
    trajectory = controller.update(standing(1.0, pose))
    return controller, trajectory.stamp, pose


def test_the_predicted_margin_is_the_cycles_and_positive(begun):
    controller, start, _ = begun
    cycle = controller.cycle
    for k in range(0, len(cycle.times) - 1, 10):
        assert controller.support.margin_at(start + cycle.times[k]) == cycle.margin[k] > 0.03
    # Between cycles the robot stands on four feet, 402 mm by 602 mm.
    for controller_, time in ((controller, start + 5.0), (make_controller(), 0.0)):
        assert controller_.support.margin_at(time) == pytest.approx(0.201, abs=1e-6)


def test_the_support_polygon_is_of_the_feet_on_the_ground_in_the_plans_frame(begun):
    controller, start, pose = begun
    swing = CRAWL.swings[0]
    assert len(controller.support.polygon_at(start + swing.liftoff + 0.2, pose)) == 3
    feet = pose.transform(ROBOT.neutral_feet)[:, :2]
    for time in (start, start + 0.5, start + 6.0):
        corners = controller.support.polygon_at(time, pose)
        assert np.sort(corners, axis=0) == pytest.approx(np.sort(feet, axis=0), abs=1e-9)


def test_footholds_are_the_initial_posture_under_the_end_of_the_cycle(begun):
    controller, _, pose = begun
    end = pose @ controller.cycle.motion.end
    feet = end.transform(ROBOT.neutral_feet)[:, :2]
    assert controller.footholds()[:, :2] == pytest.approx(feet, abs=1e-9)
    assert controller.footholds()[:, 2] == pytest.approx(np.full(4, ROBOT.foot_radius))
    assert make_controller().footholds().shape == (0, 3)


def test_after_arrival_the_robot_rests_even_if_it_is_pushed():
    controller = make_controller()
    controller.set_plan(Plan((ORIGIN,)))
    assert controller.update(standing(1.0)) is None
    assert controller.activity is Activity.ARRIVED
    assert controller.update(standing(2.0, Pose2D(0.3, 0.0, 1.0))) is None
    assert controller.activity is Activity.ARRIVED


def test_without_a_plan_the_robot_stands():
    controller = make_controller()
    assert (controller.activity, controller.reason) == (Activity.WAITING, 'no plan yet')
    assert controller.update(standing(1.0)) is None
    assert (controller.activity, controller.reason) == (Activity.STANDING, 'no plan to follow')


def test_without_joint_states_the_robot_waits():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0, joint_positions=None, joint_velocities=None)) is None
    assert (controller.activity, controller.reason) == (Activity.WAITING, 'no joint states yet')
    assert controller.update(standing(1.1)) is not None


def test_while_the_joints_move_the_robot_waits():
    controller = make_controller()
    controller.set_plan(AHEAD)
    speeds = np.zeros(12)
    speeds[5] = 0.3
    assert controller.update(standing(1.0, joint_velocities=speeds)) is None
    assert controller.reason.startswith('the joints are still moving: rf_knee_pitch_joint by 0.000')
    assert controller.update(standing(1.1)) is not None


def moving(time, joint=5, sway=0.1, speed=0.5, **changes):
    """A measurement of a joint that goes to and fro at 2 Hz."""
    joints, speeds = POSTURE.copy(), np.zeros(12)
    joints[joint] += sway / 2.0 * math.sin(4.0 * math.pi * time)
    speeds[joint] = speed
    return standing(time, joint_positions=joints, joint_velocities=speeds, **changes)


def test_a_joint_that_trembles_where_it_is_does_not_keep_the_robot_waiting():
    controller = make_controller()
    controller.set_plan(AHEAD)
    begun = None
    for time in np.arange(1.0, 3.0, 0.02):
        if begun is None and controller.update(moving(time, sway=0.02)) is not None:
            begun = time
    assert begun == pytest.approx(1.3, abs=0.03)
    assert controller.activity is Activity.WALKING


def test_joints_that_never_come_to_rest_are_given_up_with_the_reason():
    controller = make_controller()
    controller.set_plan(AHEAD)
    said = {}
    for time in np.arange(1.0, 12.0, 0.02):
        assert controller.update(moving(time)) is None
        said.setdefault(controller.activity, (time, controller.reason))
    assert said[Activity.WAITING][0] == 1.0
    time, reason = said[Activity.STOPPED]
    assert time == pytest.approx(9.0, abs=0.1)
    assert reason.startswith('the joints have not come to rest for 8 s: rf_knee_pitch_joint by 0.')
    assert 'has a drive failed?' in reason
    # At rest again it waits for a new wish.
    for time in np.arange(12.0, 13.0, 0.02):
        assert controller.update(standing(time)) is None
    assert (controller.activity, controller.reason) == (Activity.STOPPED, reason)
    controller.set_plan(BACK)
    assert controller.update(standing(13.0)) is not None


def test_without_a_wish_joints_may_be_moved_for_as_long_as_one_likes():
    controller = make_controller()
    for time in np.arange(1.0, 12.0, 0.02):
        assert controller.update(moving(time)) is None
        assert controller.activity is Activity.WAITING
    assert controller.update(standing(12.02)) is None
    assert controller.activity is Activity.STANDING


@pytest.mark.parametrize('until', [4.0, 10.5])
def test_absent_joint_states_are_said_whatever_was_said_of_the_joints(until):
    controller = make_controller()
    controller.set_plan(AHEAD)
    for time in np.arange(1.0, until, 0.02):
        controller.update(moving(time))
    words = 'no joint states for 0.3 s'
    controller.update(moving(until, joint_time=until - 0.3, problem=words))
    assert (controller.activity, controller.reason) == (Activity.WAITING, words)


def test_absent_joint_states_are_said_though_nobody_executes_the_trajectories():
    controller = make_controller()
    for time in np.arange(1.0, 30.0, 0.02):
        controller.set_twist(Twist2D(0.05))
        controller.update(standing(time))
        if controller.activity is Activity.NOT_EXECUTED:
            break
    assert controller.activity is Activity.NOT_EXECUTED
    words = 'no joint states for 0.3 s'
    controller.set_twist(Twist2D(0.0))
    controller.update(standing(time + 12.0, joint_time=time, problem=words))
    assert (controller.activity, controller.reason) == (Activity.WAITING, words)


@pytest.mark.parametrize('tilt', [0.6, math.pi / 2])
def test_a_fallen_robots_joints_are_held_once_where_they_are(tilt):
    controller = make_controller()
    controller.set_plan(AHEAD)
    joints = POSTURE + np.linspace(-0.3, 0.3, 12)
    hold = controller.update(standing(1.0, tilt=tilt, joint_positions=joints))
    assert controller.activity is Activity.FALLEN
    assert f'tilted by {math.degrees(tilt):.0f} degrees' in controller.reason
    assert hold.positions == pytest.approx(joints[None])
    assert hold.velocities == pytest.approx(np.zeros((1, 12)))
    assert 1.0 < hold.stamp + hold.times[0] < 1.1
    assert controller.update(standing(1.1, tilt=tilt)) is None
    assert controller.distance_left(ORIGIN) == 0.0


def test_a_robot_that_falls_before_its_joints_are_known_is_told_nothing():
    controller = make_controller()
    assert controller.update(standing(1.0, tilt=1.0, joint_positions=None)) is None
    assert controller.activity is Activity.FALLEN


def test_a_fall_in_mid_cycle_is_noticed_at_once():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0)) is not None
    assert controller.update(standing(2.0, tilt=0.1)) is None
    assert controller.activity is Activity.WALKING
    hold = controller.update(standing(2.1, tilt=1.0))
    # The joints are commanded elsewhere, and are led back no faster than they turn.
    assert 2.15 <= hold.end < 2.4
    assert controller.activity is Activity.FALLEN
    assert controller.cycle_at(2.1) is None


def test_upright_again_the_robot_waits_for_stand_and_then_for_a_new_wish():
    controller = make_controller()
    controller.set_plan(AHEAD)
    controller.update(standing(1.0, tilt=1.0))
    lying = POSTURE + 0.3
    for wish in (lambda: None, controller.stop, controller.sit, lambda: controller.set_plan(BACK)):
        wish()
        for time in (3.0, 3.6):
            assert controller.update(standing(time, joint_positions=lying)) is None
            assert controller.activity is Activity.FALLEN
            assert 'it waits for stand' in controller.reason
    controller.stand()
    assert controller.update(standing(4.0, joint_positions=lying)) is None
    trajectory = controller.update(standing(4.5, joint_positions=lying))
    assert controller.activity is Activity.STANDING_UP
    assert trajectory.positions[-1] == pytest.approx(POSTURE)
    assert controller.update(standing(trajectory.end + 0.3)) is None
    assert controller.activity is Activity.STANDING
    # The plan from before the fall is no new wish; another one is.
    controller.set_plan(BACK)
    assert controller.update(standing(trajectory.end + 0.4)) is None
    controller.set_plan(AHEAD)
    assert controller.update(standing(trajectory.end + 0.5)) is not None


def test_out_of_its_posture_the_robot_stands_up_smoothly_before_it_walks():
    offset = np.random.default_rng(1).uniform(-0.4, 0.4, 12)
    controller = make_controller()
    controller.set_plan(AHEAD)
    lying = POSTURE + offset
    # It might be in the middle of a cycle that another node began: first it must be still.
    assert controller.update(standing(1.0, joint_positions=lying)) is None
    assert controller.update(standing(1.4, joint_positions=lying)) is None
    trajectory = controller.update(standing(1.5, joint_positions=lying))
    assert controller.activity is Activity.STANDING_UP
    assert f'{np.abs(offset).max():.2f} rad from the initial posture' in controller.reason
    assert trajectory.positions[0] == pytest.approx(POSTURE + offset)
    assert trajectory.positions[-1] == pytest.approx(POSTURE)
    assert trajectory.velocities[[0, -1]] == pytest.approx(np.zeros((2, 12)), abs=1e-12)
    h = np.diff(trajectory.times)[:, None]
    means = (trajectory.velocities[1:] + trajectory.velocities[:-1]) / 2.0
    assert np.diff(trajectory.positions, axis=0) / h == pytest.approx(means, abs=1e-3)
    assert controller.update(standing(trajectory.end)) is None
    walking = controller.update(standing(trajectory.end + 0.2))
    assert controller.activity is Activity.WALKING
    assert walking.stamp + walking.times[0] >= trajectory.end + 0.5 - 1e-9


def test_within_the_tolerance_of_its_posture_the_robot_walks_at_once():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0, joint_positions=POSTURE + 0.14)) is not None
    assert controller.activity is Activity.WALKING


def test_a_new_plan_takes_effect_at_the_end_of_the_cycle():
    walk = Walk()
    walk.controller.set_plan(AHEAD)
    walk.run(lambda: len(walk.trajectories) == 1)
    walk.run_for(2.0)
    walk.controller.set_plan(Plan((Pose2D(0.2, 0.0, math.pi / 2),)))
    walk.run_for(2.0)
    assert (len(walk.trajectories), walk.controller.activity) == (1, Activity.WALKING)
    walk.run(lambda: len(walk.trajectories) == 2, 2.0)
    assert walk.controller.activity is Activity.TURNING
    assert walk.trajectories[1].stamp == pytest.approx(walk.trajectories[0].end)
    walk.arrives()
    assert walk.poses[-1].yaw == pytest.approx(math.pi / 2, abs=math.radians(2.0))


def test_taking_the_plan_back_stops_the_robot_at_the_end_of_the_cycle():
    walk = Walk()
    walk.controller.set_plan(AHEAD)
    walk.run(lambda: len(walk.trajectories) == 1)
    walk.run_for(1.0)
    walk.controller.set_plan(None)
    walk.run_for(8.0)
    assert len(walk.trajectories) == 1
    assert (walk.controller.activity, walk.controller.reason) == (
        Activity.STANDING,
        'no plan to follow',
    )
    assert measured(walk.simulation).joint_positions == pytest.approx(POSTURE, abs=1e-9)
    assert walk.controller.distance_left(walk.poses[-1]) == 0.0


def test_a_new_plan_after_arrival_is_walked():
    controller = make_controller()
    controller.set_plan(Plan((ORIGIN,)))
    controller.update(standing(1.0))
    controller.set_plan(AHEAD)
    assert controller.update(standing(2.0)) is not None
    assert controller.activity is Activity.WALKING


def test_when_the_clock_is_set_back_the_robot_does_not_wait_for_the_old_time():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1000.0)) is not None
    assert controller.update(standing(1001.0)) is None
    trajectory = controller.update(standing(3.0))
    assert trajectory is not None
    assert 3.0 + 0.3 <= trajectory.stamp + trajectory.times[0] + 1e-9 < 4.0


def test_a_robot_carried_away_stops_and_says_why():
    controller = make_controller()
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0)) is not None
    assert controller.update(standing(6.5, Pose2D(0.5, 2.0, 0.0))) is None
    assert controller.activity is Activity.STOPPED
    assert 'the robot is 2.00 m from its path' in controller.reason
    assert controller.update(standing(7.0, Pose2D(0.5, 0.0, 0.0))) is not None
    assert controller.activity is Activity.WALKING


def test_a_margin_that_cannot_be_had_stops_the_robot():
    controller = make_controller(least_margin=0.5)
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.0)) is None
    assert controller.activity is Activity.STOPPED
    assert 'cannot walk along its path' in controller.reason
    controller.set_twist(Twist2D(0.01))
    assert controller.update(standing(1.5)) is None
    assert 'it must be at least 500.0 mm' in controller.limit
    assert controller.reason == controller.limit


@pytest.mark.parametrize('follows', [0.0, 0.2, 0.5, 1.0])
def test_a_robot_that_does_not_follow_its_commands_is_blocked_after_three_cycles(follows):
    controller, pose, time = make_controller(), ORIGIN, 1.0
    controller.set_plan(Plan.through([[0.0, 0.0], [5.0, 0.0]], 0.0))
    cycles = 0
    while cycles < 5:
        trajectory = controller.update(standing(time, pose))
        if trajectory is None:
            break
        cycles += 1
        pose = pose @ Pose2D(follows * controller.cycle.motion.forward, 0.0, 0.0)
        time = trajectory.end + 0.2
    if follows > 0.3:
        assert controller.activity is Activity.WALKING
        return
    assert (cycles, controller.activity) == (3, Activity.BLOCKED)
    assert '3 cycles without effect' in controller.reason
    assert controller.update(standing(time + 1.0, pose)) is None
    assert controller.activity is Activity.BLOCKED
    controller.set_plan(AHEAD)
    assert controller.update(standing(time + 2.0)) is not None


@pytest.mark.parametrize(('late', 'cycles'), [(0.05, 3), (0.5, 12)])
def test_cycles_that_the_joints_followed_late_block_later(late, cycles, monkeypatch):
    controller, time, following = make_controller(), 1.0, 0.0
    monkeypatch.setattr(
        JointFaultDetector, 'late', property(lambda _: following, lambda *_: None), raising=False
    )
    controller.set_plan(Plan.through([[0.0, 0.0], [5.0, 0.0]], 0.0))
    done = 0
    while (trajectory := controller.update(standing(time))) is not None and done < 20:
        done += 1
        following += late * (trajectory.end + 0.2 - time)
        time = trajectory.end + 0.2
    assert (done, controller.activity) == (cycles, Activity.BLOCKED)


@pytest.mark.parametrize('side', [1, -1])
def test_a_turn_to_either_side_has_the_order_of_legs_that_its_limits_choose(side):
    controller = make_controller()
    controller.set_plan(Plan((Pose2D(0.0, 0.0, side * 0.7),)))
    trajectory = controller.update(standing(1.0))
    motion = controller.cycle.motion
    gait = MotionLimits(ROBOT, TURN, SupervisorOptions().least_margin).gait_for(motion)
    assert controller.cycle.gait == gait
    expected = generate_cycle(ROBOT, gait, motion).trajectory(ROBOT, 0.0)
    assert trajectory.positions == pytest.approx(expected.positions, abs=1e-12)
    assert controller.reason == f'turning by {math.degrees(side * 0.7):.1f} degrees'
    # To the right it is as stable as to the left.
    left = generate_cycle(ROBOT, TURN, BodyMotion(turn=0.7))
    assert controller.cycle.least_margin == pytest.approx(left.least_margin, abs=2e-3)


@pytest.mark.parametrize('lead', [0.0, 0.3, 2.0])
def test_a_longer_lead_time_delays_the_cycle_as_far_as_it_must(lead):
    controller = make_controller(lead_time=lead)
    controller.set_plan(AHEAD)
    trajectory = controller.update(standing(10.0))
    assert trajectory.stamp + trajectory.times[0] == pytest.approx(10.0 + lead)


# Gaits that keep their speed

ROBOTS = ('titan_viii', 'pukyong', 'cuhk', 'genibo')

each_steady_gait = pytest.mark.parametrize('gait', ['wave', 'trot', 'walk'])


def steady_walk(robot='titan_viii', gait='wave', **options):
    return Walk(robot=load_robot(robot), gait=gait, **{'least_margin': 0.005, **options})


def gentle(robot, gait, turn=0.1):
    """Return a velocity of a third of the largest stride in a cycle."""
    period = load_gait(gait, robot).cycle_period
    return Twist2D(robot.largest_stride / 3.0 / period, 0.0, turn / period)


@pytest.fixture(scope='module', params=['wave titan_viii', 'trot titan_viii', 'trot genibo'])
def steered(request):
    """Steer a robot for some cycles, then say no more."""
    gait, robot = request.param.split()
    walk = steady_walk(robot, gait)
    walk.steer(gentle(walk.robot, gait), 4.0 * walk.controller.gait.cycle_period)
    walk.run_for(1.0 + 3.0 * walk.controller.gait.cycle_period)
    return walk


def test_each_trajectory_of_a_steady_gait_goes_on_where_the_last_one_was(steered):
    assert len(steered.trajectories) >= 4
    for told_at, (before, after) in zip(steered.told_at[1:], pairwise(steered.trajectories)):
        times, new_times = before.stamp + before.times, after.stamp + after.times
        # Up to the beginning of the cycle that takes the place of the stop.
        start = next(t for t in after_joins(steered, after) if t > told_at)
        both = [
            (k, int(j))
            for k, t in enumerate(times)
            for j in np.flatnonzero(np.abs(new_times - t) < 1e-9)
            if t <= start + 1e-9
        ]
        assert len(both) >= 3
        # The new one is there before it is needed.
        assert new_times[0] <= told_at + 0.02 < start
        old, new = np.array(both).T
        assert after.positions[new] == pytest.approx(before.positions[old], abs=1e-6)
        assert after.velocities[new] == pytest.approx(before.velocities[old], abs=1e-6)


def after_joins(walk, trajectory):
    """Times at which cycles of a trajectory end."""
    period = walk.controller.gait.cycle_period
    return sorted(trajectory.end - k * period for k in range(4))


def test_at_the_joins_of_a_steady_gait_no_joint_jumps(steered):
    for trajectory in steered.trajectories:
        h = np.diff(trajectory.times)[:, None]
        assert h.min() > 1e-6
        speeds = np.diff(trajectory.positions, axis=0) / h
        means = (trajectory.velocities[1:] + trajectory.velocities[:-1]) / 2.0
        # A foot begins to swing while it still rolls: radius times the calf's turning.
        assert np.abs(speeds - means).max() < 0.1 * np.abs(trajectory.velocities).max()


def test_every_trajectory_of_a_steady_gait_ends_at_rest_in_the_initial_posture(steered):
    for trajectory in steered.trajectories:
        assert trajectory.positions[-1] == pytest.approx(steered.posture, abs=1e-9)
        assert trajectory.velocities[-1] == pytest.approx(np.zeros(12), abs=1e-12)


def test_steered_no_more_a_steady_gait_stops_on_four_feet(steered):
    assert steered.stands()
    assert steered.controller.activity is Activity.STANDING
    assert steered.controller.in_contact_at(steered.time).all()
    assert steered.poses[-1].distance_to(steered.poses[-2]) < 1e-9


@each_steady_gait
def test_if_nothing_more_is_heard_the_last_trajectory_stops_the_robot(gait):
    walk = steady_walk(gait=gait)
    walk.steer(gentle(ROBOT, gait), 2.0 * walk.controller.gait.cycle_period)
    assert not walk.stands()
    for _ in range(round(3.0 * walk.controller.gait.cycle_period / 0.01)):
        walk.simulation.step()
    assert walk.stands()


# Steering


@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
def test_a_steered_robot_walks_until_the_steering_times_out(gait):
    walk = steady_walk(gait=gait, twist_timeout=2.0)
    walk.step()
    walk.controller.set_twist(gentle(ROBOT, gait))
    walk.run(lambda: walk.controller.activity is Activity.WALKING, 1.0)
    walk.run(lambda: walk.controller.activity is Activity.STANDING, 15.0)
    walk.run(walk.stands, 10.0)
    assert walk.poses[-1].x > 0.3 * ROBOT.largest_stride
    assert walk.controller.limit == ''


def test_steering_before_the_first_measurement_is_not_heeded():
    controller = make_controller()
    controller.set_twist(Twist2D(0.02))
    assert controller.update(standing(1.0)) is None
    assert controller.activity is Activity.STANDING


def test_steered_with_zero_the_robot_stands_and_gives_up_its_plan():
    controller = make_controller()
    controller.set_plan(AHEAD)
    controller.update(standing(0.0))
    controller.set_twist(Twist2D())
    trajectory_end = 5.0
    assert controller.update(standing(trajectory_end + 0.5)) is None
    controller.set_twist(Twist2D())
    assert controller.update(standing(trajectory_end + 0.6)) is None
    assert (controller.activity, controller.reason) == (Activity.STANDING, 'steered to stand')
    assert controller.distance_left(ORIGIN) == 0.0


def test_a_plan_ends_the_steering():
    controller = make_controller()
    controller.update(standing(1.0))
    controller.set_twist(Twist2D(-0.02))
    controller.set_plan(AHEAD)
    assert controller.update(standing(1.1)) is not None
    assert controller.cycle.motion.forward > 0.0


@pytest.mark.sweep(kept=3)
@pytest.mark.parametrize('wanted', [Twist2D(1.0, 0.5, 0.3), Twist2D(0.0, -1.0), Twist2D(turn=-3.0)])
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
def test_a_limit_that_bites_is_reported_and_keeps_the_direction(gait, wanted):
    walk = steady_walk(gait=gait)
    walk.step()
    walk.controller.set_twist(wanted.scaled(3.0))
    walk.run(lambda: walk.controller.cycle is not None, 2.0)
    controller = walk.controller
    twist, reason = controller.gait_pair.of_twist(wanted).limited(wanted.scaled(3.0))
    assert reason
    for velocity in (wanted.scaled(3.0), twist):
        said = f'({velocity.forward:.3f}, {velocity.left:.3f}) m/s'
        assert f'{said} and {math.degrees(velocity.turn):.1f} deg/s' in controller.limit
    assert controller.limit.endswith(reason)
    parts = np.array([wanted.forward, wanted.left, wanted.turn])
    motion = controller.cycle.motion
    done = np.array([motion.forward, motion.left, motion.turn])
    assert done / np.linalg.norm(done) == pytest.approx(parts / np.linalg.norm(parts), abs=1e-3)
    # Slower it does not bite.
    walk.steer(twist.scaled(0.5), 2.0 * controller.gait.cycle_period)
    assert controller.limit == ''


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
def test_holding_its_course_takes_back_what_the_robot_drifts(gait):
    ends = []
    for hold_course in (True, False):
        walk = steady_walk(gait=gait, veer=0.3, hold_course=hold_course, time_step=0.02)
        period = walk.controller.gait.cycle_period
        walk.steer(Twist2D(ROBOT.largest_stride / 2.0 / period), 12.0 * period)
        walk.run(walk.stands, 15.0)
        ends.append(walk.poses[-1])
    held, drifted = ends
    veered = 0.3 * drifted.x
    assert drifted.yaw == pytest.approx(veered, rel=0.1)
    assert abs(held.yaw) < veered / 3.0
    assert abs(held.y) < abs(drifted.y) / 3.0


# Changing gaits


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('robot', ROBOTS)
def test_gaits_change_at_rest_and_without_a_jump(robot):
    walk = steady_walk(robot, 'crawl', twist_timeout=math.inf, time_step=0.02)
    controller = walk.controller
    walk.step()
    twist = gentle(walk.robot, 'crawl')
    for name in ('wave', 'trot', 'crawl'):
        before = controller.gait
        controller.set_twist(twist)
        walk.run_for(0.6 + 1.5 * before.cycle_period)
        assert not walk.stands()
        gaits = gaits_for(walk.robot, name)
        controller.set_gaits(*gaits, FollowerOptions())
        walk.step()
        assert controller.gait == before
        walk.run(lambda gait=gaits[0]: controller.gait == gait, 15.0)
        assert np.abs(walk.joints[-1] - walk.posture).max() < 1e-9
    walk.run(lambda: controller.activity is Activity.WALKING, 1.0)
    walk.run_for(2.0)
    speeds = np.abs(np.diff(walk.joints, axis=0)).max() / 0.02
    fastest = max(np.abs(trajectory.velocities).max() for trajectory in walk.trajectories)
    assert speeds <= 1.02 * fastest
    assert walk.poses[-1].x > walk.robot.largest_stride


def test_with_new_gaits_the_plan_is_walked_to_its_end():
    walk = steady_walk(gait='wave', time_step=0.02)
    walk.controller.set_plan(CORNER)
    walk.run_for(6.0)
    trot = gaits_for(ROBOT, 'trot')
    walk.controller.set_gaits(*trot, FollowerOptions(turning='arc'))
    walk.arrives()
    assert walk.controller.gait == trot[0]
    assert walk.poses[-1].distance_to(CORNER.poses[-1]) < 0.02


# Standing, sitting, stopping


def sits(walk):
    if walk.controller.activity is not Activity.SITTING:
        return False
    crouching = crouching_joint_angles(walk.robot).reshape(-1)
    return np.allclose(measured(walk.simulation).joint_positions, crouching)


def test_sitting_and_standing_again():
    walk = Walk()
    walk.run_for(0.1)
    assert walk.controller.sit().endswith('until stand is called')
    walk.run(lambda: sits(walk), 6.0)
    assert walk.activities[-2:] == [Activity.SITTING_DOWN, Activity.SITTING]
    # Neither wishes nor asking again move a sitting robot.
    count = len(walk.trajectories)
    walk.controller.sit()
    walk.controller.set_plan(AHEAD)
    walk.run_for(1.0)
    walk.controller.stop()
    walk.steer(Twist2D(0.02), 1.0)
    assert sits(walk)
    assert len(walk.trajectories) == count
    walk.controller.stand()
    walk.run(walk.stands, 6.0)
    walk.run_for(0.5)
    assert walk.activities[-2:] == [Activity.STANDING_UP, Activity.STANDING]
    # Nor is the plan remembered that came meanwhile.
    assert len(walk.trajectories) == count + 1
    walk.controller.sit()
    walk.run(lambda: sits(walk), 6.0)


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
@pytest.mark.parametrize('wish', ['stop', 'stand', 'sit', 'no plan'])
def test_in_mid_walk_the_robot_stops_on_four_feet_first(gait, wish):
    walk = steady_walk(gait=gait, time_step=0.02)
    walk.controller.set_plan(Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0))
    period = walk.controller.gait.cycle_period
    walk.run_for(0.5 + 1.3 * period)
    controller = walk.controller
    if wish == 'no plan':
        controller.set_plan(None)
    else:
        assert 'on four feet' in controller.stop() or wish
        getattr(controller, wish)()
    walk.run(walk.stands, 3.0 * period)
    walk.run_for(1.0)
    if wish == 'sit':
        walk.run(lambda: sits(walk), 6.0)
        return
    assert walk.stands()
    assert controller.activity is Activity.STANDING
    if wish == 'no plan':
        assert controller.reason == 'no plan to follow'
        return
    assert controller.reason.startswith('stopped on request')
    controller.set_plan(Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0))
    walk.run_for(1.0)
    assert controller.activity is Activity.STANDING
    controller.set_plan(AHEAD)
    walk.run_for(1.0)
    assert controller.activity is Activity.WALKING


def test_a_goal_that_was_stopped_counts_again_once_the_planner_knows_of_the_stop():
    walk = steady_walk()
    plan = Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0)
    walk.controller.set_plan(plan)
    walk.run_for(2.0)
    walk.controller.stop()
    walk.run(walk.stands, 20.0)
    # A plan that was under way when the robot was stopped.
    walk.controller.set_plan(plan)
    walk.run_for(1.0)
    assert walk.controller.activity is Activity.STANDING
    # The planner takes it back, and is given the goal again.
    walk.controller.set_plan(None)
    walk.controller.set_plan(plan)
    walk.run_for(1.0)
    assert walk.controller.activity is Activity.WALKING


@each_steady_gait
def test_while_it_comes_to_rest_the_robot_does_not_say_that_it_stands_and_walks(gait):
    walk = steady_walk(gait=gait)
    walk.controller.set_plan(AHEAD)
    period = walk.controller.gait.cycle_period
    walk.run_for(0.5 + 1.3 * period)
    walk.controller.stop()
    said = set()
    for _ in range(round(3.0 * period / 0.01)):
        walk.step()
        said.add((walk.controller.activity, walk.controller.reason.split()[0]))
    assert said == {(Activity.WALKING, 'walking'), (Activity.STANDING, 'stopped')}


# Plans with a corner


@pytest.mark.sweep(kept=5)
@pytest.mark.parametrize('turning', ['in_place', 'crab', 'arc'])
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
@pytest.mark.parametrize('robot', ['titan_viii', 'genibo'])
def test_every_gait_arrives_behind_a_corner_in_every_way_of_turning(robot, gait, turning):
    walk = steady_walk(robot, gait, follower=FollowerOptions(turning=turning), time_step=0.02)
    side = 1.5 * walk.robot.largest_stride
    plan = Plan.through([[0.0, 0.0], [side, 0.0], [side, side]], math.pi / 2)
    walk.controller.set_plan(plan)
    walk.arrives()
    goal = plan.poses[-1]
    assert walk.poses[-1].distance_to(goal) < 0.02
    assert abs(wrap_angle(walk.poses[-1].yaw - goal.yaw)) < math.radians(2.0)
    assert walk.stands()


# What goes wrong on the way


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('gait', ['crawl', 'wave'])
def test_by_backstepping_a_plan_is_walked_as_by_closed_form(gait):
    plan = Plan.through([[0.0, 0.0], [0.3, 0.0], [0.3, 0.2]], math.pi / 2)
    walks = []
    for gain in (None, 4.0):
        walk = steady_walk(gait=gait, tracking_gain=gain, time_step=0.02)
        walk.controller.set_plan(plan)
        walk.arrives()
        walks.append(walk)
    closed_form, tracked = walks
    assert tracked.poses[-1].distance_to(closed_form.poses[-1]) < 5e-3
    # Open loop in each cycle, the last error decays with the gain: e^(-4 x 1 s).
    assert tracked.joints[-1] == pytest.approx(tracked.posture, abs=5e-3)
    assert len(tracked.trajectories) == len(closed_form.trajectories)


@each_steady_gait
@pytest.mark.parametrize('is_steered', [True, False])
def test_a_steady_gait_without_effect_is_noticed(gait, is_steered):
    walk = steady_walk(gait=gait, follows=0.0, twist_timeout=math.inf, time_step=0.02)
    walk.step()
    period = walk.controller.gait.cycle_period
    if is_steered:
        walk.controller.set_twist(Twist2D(0.6 * ROBOT.largest_stride / period))
    else:
        walk.controller.set_plan(Plan.through([[0.0, 0.0], [5.0, 0.0]], 0.0))
    walk.run(lambda: walk.controller.activity is Activity.BLOCKED, 2.0 + 6.0 * period)
    assert '3 cycles without effect' in walk.controller.reason
    assert 'is it stuck' in walk.controller.reason
    walk.run(walk.stands, 3.0 * period)
    walk.run_for(1.0)
    assert walk.stands()
    assert walk.controller.activity is Activity.BLOCKED


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
def test_a_robot_that_goes_five_percent_short_is_asked_for_as_much_more(gait):
    limits = MotionLimits(ROBOT, load_gait(gait, ROBOT), 0.005)
    stride = 0.5 * limits.largest_scale(BodyMotion(forward=1.0))
    wanted = BodyMotion(forward=stride)
    calibrations = (
        Calibration(gait, limits.period, wanted, wanted.scaled(1.0 / 0.95)),
        Calibration(gait, limits.period, wanted.scaled(0.5), wanted.scaled(0.5 / 0.95)),
    )
    advances = []
    for compensation in (NO_SLIP, SlipCompensation(calibrations)):
        walk = steady_walk(
            gait=gait,
            compensation=compensation,
            follows=0.95,
            hold_course=False,
            twist_timeout=math.inf,
        )
        walk.step()
        walk.controller.set_twist(wanted.rate(limits.period))
        walk.run(lambda walk=walk: walk.controller.cycle is not None, 2.0)
        starts = []
        for _ in range(6):
            walk.run(
                lambda walk=walk: (
                    walk.controller.cycle_at(walk.time) is None
                    or bool(walk.controller.cycle_at(walk.time).start > walk.time - 0.011)
                ),
                10.0,
            )
            starts.append(walk.poses[-1].x)
            walk.run_for(0.5 * limits.period)
        advances.append(starts[-1] - starts[-2])
    without, compensated = advances
    assert without == pytest.approx(0.95 * stride, rel=0.005)
    assert compensated == pytest.approx(stride, rel=0.005)
