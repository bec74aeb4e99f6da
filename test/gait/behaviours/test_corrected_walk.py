"""A robot whose odometry is corrected walks on the map, and nothing leaps but its pose."""

import math
from dataclasses import replace

import numpy as np
import pytest
from told_supervisor import ToldSupervisor

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.state.measurement import Measurement
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.simulation import Simulation

ROBOT = load_robot('titan_viii')
ORIGIN = Pose2D(0.0, 0.0, 0.0)
LARGEST_SPEED = 6.0
"""Of TITAN-VIII's joints [rad/s]."""
AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)


class CorrectedWalk:
    """A robot whose odometry is true at first; `correction` says where it is in the map."""

    def __init__(self, gait='crawl', **options):
        walking = load_gait(gait, ROBOT)
        turning = turning_gait_for(walking, ROBOT)
        self.controller = ToldSupervisor(ROBOT, walking, turning, SupervisorOptions(**options))
        self.simulation = Simulation(KinematicSimulator(ROBOT, 0.01), ROBOT, ORIGIN)
        self.correction = ORIGIN
        self.follows = True
        self.stuck_at = None
        self.trajectories: list[JointTrajectory] = []
        self.joints = []
        self.activities = set()

    @property
    def odometry(self):
        pose = self.simulation.observe().pose
        if self.follows:
            return pose
        self.stuck_at = self.stuck_at or pose
        return self.stuck_at

    @property
    def pose(self):
        return self.correction @ self.odometry

    def step(self):
        seen = self.simulation.observe()
        now = Measurement(
            seen.time,
            self.pose,
            0.0,
            seen.joint_positions,
            seen.joint_velocities,
            odometry=self.odometry,
        )
        trajectory = self.controller.update(now)
        if trajectory is not None:
            self.simulation.accept(trajectory)
            self.trajectories.append(trajectory)
        self.activities.add(self.controller.activity)
        self.joints.append(seen.joint_positions)
        self.simulation.step()

    def run(self, until, seconds=120.0):
        for _ in range(round(seconds / self.simulation.time_step)):
            if until():
                return
            self.step()
        pytest.fail(f'still {self.controller.activity}: {self.controller.reason}')

    def leap(self, jump):
        """Have a localiser say that the robot is elsewhere, seen from where it is."""
        odometry = self.odometry
        self.correction = self.correction @ odometry @ jump @ odometry.inverse()


def is_at(walk, activity):
    return lambda: walk.controller.activity is activity


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
@pytest.mark.parametrize(
    'jump',
    [
        Pose2D(0.02, -0.01, 0.01),
        Pose2D(-0.05, 0.05, -0.05),
        Pose2D(0.1, 0.2, 0.2),
        Pose2D(-0.3, 0.0, 0.0),
    ],
)
def test_whenever_its_pose_leaps_the_robot_arrives_on_the_map_and_no_joint_jumps(gait, jump):
    walk = CorrectedWalk(gait)
    walk.controller.set_plan(AHEAD)
    walk.run(lambda: walk.odometry.x > 0.3)
    walk.leap(jump)
    walk.run(lambda: walk.odometry.x > 0.5)
    walk.leap(jump.inverse() @ Pose2D(0.0, 0.02, 0.0))
    walk.run(is_at(walk, Activity.ARRIVED))
    assert walk.pose.distance_to(AHEAD.poses[-1]) < 0.02
    assert Activity.BLOCKED not in walk.activities
    # The simulator does what it is told, so its joints show the commands.
    steps = np.abs(np.diff(walk.joints, axis=0)).max(axis=0)
    assert np.all(steps <= 1.01 * LARGEST_SPEED * walk.simulation.time_step)


def test_corrections_do_not_hide_that_the_robot_is_stuck():
    walk = CorrectedWalk()
    walk.controller.set_plan(AHEAD)
    walk.run(lambda: walk.odometry.x > 0.1)
    walk.follows = False
    strides = 0
    while walk.controller.activity is not Activity.BLOCKED and strides < 6:
        before = len(walk.trajectories)
        walk.run(lambda: len(walk.trajectories) > before or is_at(walk, Activity.BLOCKED)())  # noqa: B023
        walk.leap(Pose2D(0.1, 0.0, 0.0))
        strides += 1
    assert walk.controller.activity is Activity.BLOCKED
    assert 'does not follow its commands' in walk.controller.reason


def test_corrections_that_undo_each_stride_do_not_block_a_robot_that_walks():
    walk = CorrectedWalk()
    walk.controller.set_plan(Plan.through([[0.0, 0.0], [5.0, 0.0]], 0.0))
    for _ in range(8):
        before = len(walk.trajectories)
        walk.run(lambda: len(walk.trajectories) > before)  # noqa: B023
        walk.run(lambda: walk.simulation.time > walk.trajectories[-1].end - 1.0)
        walk.leap(Pose2D(-0.12, 0.0, 0.0))
    assert Activity.BLOCKED not in walk.activities
    assert walk.odometry.x > 0.5


@pytest.mark.parametrize('gait', ['crawl', 'trot'])
def test_steering_does_not_see_corrections(gait):
    def steered(jump):
        walk = CorrectedWalk(gait)
        walk.step()
        for _ in range(30):
            walk.controller.set_twist(Twist2D(0.02, 0.0, 0.02))
            for _ in range(50):
                walk.step()
            walk.leap(jump)
        return np.concatenate([trajectory.positions for trajectory in walk.trajectories])

    leaping = steered(Pose2D(0.03, -0.04, 0.05))
    assert leaping == pytest.approx(steered(ORIGIN), abs=1e-9)


def test_relocalised_far_from_its_path_the_robot_stands_says_so_and_takes_a_new_plan():
    walk = CorrectedWalk()
    walk.controller.set_plan(AHEAD)
    walk.run(lambda: walk.odometry.x > 0.3)
    walk.leap(Pose2D(0.0, 0.8, 0.0))
    walk.run(is_at(walk, Activity.STOPPED))
    assert 'm from its path' in walk.controller.reason
    stance = walk.simulation.observe().joint_positions
    assert np.abs(stance - ROBOT.initial_joint_angles.reshape(-1)).max() < 1e-6
    assert walk.controller.wanted_plan is AHEAD
    pose = walk.pose
    again = Plan.through([[pose.x, pose.y], [1.0, 0.0]], 0.0)
    walk.controller.set_plan(again)
    walk.run(is_at(walk, Activity.ARRIVED))
    assert walk.pose.distance_to(again.poses[-1]) < 0.02


def test_a_pose_can_be_had_by_an_earlier_correction():
    rng = np.random.default_rng(4)
    joints = ROBOT.initial_joint_angles.reshape(-1)
    for _ in range(20):
        odometry, moved, first, second = (
            Pose2D(*rng.uniform(-3.0, 3.0, 3).tolist()) for _ in range(4)
        )
        then = Measurement(0.0, first @ odometry, 0.0, joints, None, odometry=odometry)
        now = replace(then, pose=second @ odometry @ moved, odometry=odometry @ moved)
        pose, expected = now.pose_corrected_as(then), first @ odometry @ moved
        assert pose.distance_to(expected) < 1e-9
        assert math.isclose(math.cos(pose.yaw - expected.yaw), 1.0)


def test_the_wanted_plan_ends_with_arrival_steering_and_stop_but_not_with_a_block():
    walk = CorrectedWalk()
    assert walk.controller.wanted_plan is None
    here = Plan((ORIGIN,))
    walk.controller.set_plan(here)
    assert walk.controller.wanted_plan is here
    walk.run(is_at(walk, Activity.ARRIVED))
    assert walk.controller.wanted_plan is None
    for end in (walk.controller.stop, lambda: walk.controller.set_twist(Twist2D(0.01))):
        plan = Plan.through([[0.0, 0.0], [1.0, 0.1 * len(walk.trajectories)]], 0.0)
        walk.controller.set_plan(plan)
        walk.step()
        assert walk.controller.wanted_plan is plan
        end()
        assert walk.controller.wanted_plan is None
        walk.run(lambda: walk.controller.activity is Activity.STANDING)
    walk.controller.set_plan(AHEAD)
    walk.follows = False
    walk.run(is_at(walk, Activity.BLOCKED))
    assert walk.controller.wanted_plan is AHEAD
