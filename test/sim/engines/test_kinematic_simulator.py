"""Without physics, feet on the ground do not slip, and the body goes where they carry it."""

import math
from functools import cache

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import tilt_from_quaternion, yaw_from_quaternion
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import CycleOptions, generate_cycle
from quad_sim.engines.kinematic_simulator import KinematicSimulator

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
STILL = np.zeros(12)
START = Pose2D(1.0, -2.0, 2.8)

MOTIONS = {
    'crawl': ('crawl', BodyMotion(forward=ROBOT.largest_stride)),
    'sideways': ('crawl', BodyMotion(left=0.05)),
    'arc': ('crawl', BodyMotion(forward=0.1, turn=0.2)),
    'turn': ('turn', BodyMotion(turn=ROBOT.largest_turn)),
}


@cache
def run(motion):
    """Run one cycle; return the simulator, the cycle, and the feet in the world."""
    gait, body_motion = MOTIONS[motion]
    cycle = generate_cycle(ROBOT, load_gait(gait), body_motion, options=CycleOptions(0.005))
    simulator = KinematicSimulator(ROBOT, 0.005)
    simulator.reset(START)
    feet = []
    for positions, velocities in zip(cycle.joint_positions, cycle.joint_velocities):
        simulator.step(positions.reshape(-1), velocities.reshape(-1))
        seen = simulator.observe()
        in_body = ROBOT.foot_positions(seen.joint_positions.reshape(4, 3))
        feet.append(seen.pose.transform(in_body) + [0.0, 0.0, seen.position[2]])
    return simulator, cycle, np.array(feet)


@pytest.mark.parametrize('motion', MOTIONS)
def test_stance_feet_only_roll_in_the_world(motion):
    _, cycle, feet = run(motion)
    for k in range(4):
        liftoff, touchdown = np.flatnonzero(~cycle.in_contact[:, k])[[0, -1]]
        for stance in (slice(None, liftoff), slice(touchdown + 1, None)):
            # As they are planned to: their balls roll a few millimetres.
            moved = feet[stance, k] - feet[stance, k][0]
            planned = cycle.feet[stance, k] - cycle.feet[stance, k][0]
            assert abs(np.hypot(*moved[-1, :2]) - np.hypot(*planned[-1, :2])) < 5e-4


@pytest.mark.parametrize('motion', MOTIONS)
def test_a_cycle_advances_by_its_motion(motion):
    simulator, cycle, _ = run(motion)
    moved = START.inverse() @ simulator.observe().pose
    end = cycle.motion.end
    assert (moved.x, moved.y) == pytest.approx((end.x, end.y), abs=5e-4)
    assert wrap_angle(moved.yaw - end.yaw) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize('motion', MOTIONS)
def test_the_body_keeps_its_height_and_stays_level(motion):
    simulator, cycle, feet = run(motion)
    seen = simulator.observe()
    assert seen.position[2] == pytest.approx(ROBOT.standing_height, abs=1e-9)
    assert tilt_from_quaternion(seen.orientation) == 0.0
    assert feet[..., 2].min() == pytest.approx(ROBOT.foot_radius, abs=1e-9)
    assert feet[..., 2][cycle.in_contact] == pytest.approx(ROBOT.foot_radius, abs=1e-9)
    assert (seen.contacts, seen.has_fallen) == ((), False)


def test_reset_stands_the_robot_at_its_pose_at_rest():
    simulator = KinematicSimulator(ROBOT)
    for _ in range(5):
        simulator.step(POSTURE + 0.02, STILL + 1.0)
    time = simulator.time
    simulator.reset(Pose2D(3.0, 4.0, -2.0))
    seen = simulator.observe()
    assert (seen.pose.x, seen.pose.y, seen.pose.yaw) == pytest.approx((3.0, 4.0, -2.0))
    assert seen.joint_positions == pytest.approx(POSTURE)
    assert seen.joint_velocities == pytest.approx(STILL)
    assert seen.linear_velocity_base_in_base == pytest.approx(np.zeros(3))
    assert seen.time == time > 0.0


def test_time_advances_by_the_step_and_nothing_else():
    simulator = KinematicSimulator(ROBOT, 0.004)
    for _ in range(250):
        simulator.step(POSTURE, STILL)
    assert simulator.time == simulator.observe().time == pytest.approx(1.0, abs=1e-12)


def test_joints_follow_their_commands_exactly():
    simulator = KinematicSimulator(ROBOT)
    rng = np.random.default_rng(1)
    joints, speeds = POSTURE + rng.uniform(-0.1, 0.1, 12), rng.normal(size=12)
    simulator.step(joints, speeds)
    seen = simulator.observe()
    assert (seen.joint_positions == joints).all()
    assert (seen.joint_velocities == speeds).all()
    assert (seen.joint_efforts == 0.0).all()


def test_velocities_of_the_base_are_the_derivative_of_its_pose_in_its_own_axes():
    cycle = generate_cycle(
        ROBOT, load_gait('turn'), BodyMotion(turn=0.5), options=CycleOptions(0.005)
    )
    simulator = KinematicSimulator(ROBOT, 0.005)
    simulator.reset(START)
    before = START
    for positions in cycle.joint_positions:
        simulator.step(positions.reshape(-1), STILL)
        seen = simulator.observe()
        moved = before.inverse() @ seen.pose
        assert seen.linear_velocity_base_in_base[:2] * 0.005 == pytest.approx((moved.x, moved.y))
        assert seen.angular_velocity_base_in_base[2] * 0.005 == pytest.approx(moved.yaw)
        before = seen.pose


def test_two_simulators_do_not_touch():
    one, other = KinematicSimulator(ROBOT), KinematicSimulator(ROBOT)
    one.reset(START)
    one.step(POSTURE + 0.01, STILL)
    seen = other.observe()
    assert (seen.time, seen.pose) == (0.0, Pose2D(0.0, 0.0, 0.0))
    assert seen.joint_positions == pytest.approx(POSTURE)


@pytest.mark.parametrize('yaw', [-3.1, -1.0, 0.0, 0.5, 3.1])
def test_yaw_of_a_quaternion_is_its_heading_and_tilt_the_angle_of_its_z_axis(yaw):
    for tilt in (0.0, 0.3, 1.5):
        # About z by yaw after about x by tilt, multiplied out by hand.
        half_y, half_t = yaw / 2.0, tilt / 2.0
        quaternion = np.array(
            [
                math.cos(half_y) * math.sin(half_t),
                math.sin(half_y) * math.sin(half_t),
                math.sin(half_y) * math.cos(half_t),
                math.cos(half_y) * math.cos(half_t),
            ]
        )
        assert yaw_from_quaternion(quaternion) == pytest.approx(yaw)
        assert tilt_from_quaternion(quaternion) == pytest.approx(tilt, abs=1e-7)
