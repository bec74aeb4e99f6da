"""Whatever is measured or falls silent, the robot comes to rest within its limits."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from told_supervisor import ToldSupervisor

from quad_common.errors import CommandOutsideLimits, GaitError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits, check_command
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.state.measurement import Measurement
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.simulation import Simulation

MOVING = (Activity.WALKING, Activity.TURNING)
AHEAD = Plan.through([[0.0, 0.0], [3.0, 0.0]], 0.0)


class SafeWalk:
    """A controller and a robot that follows it, with a check of every command of its own."""

    def __init__(self, name='titan_viii', gait='crawl', watches_joints=False):
        self.robot = load_robot(name)
        walking = load_gait(gait, self.robot)
        turning = turning_gait_for(walking, self.robot)
        options = SupervisorOptions(watches_joints=watches_joints)
        self.controller = ToldSupervisor(self.robot, walking, turning, options)
        self.simulation = Simulation(
            KinematicSimulator(self.robot, 0.01), self.robot, Pose2D(0.0, 0.0, 0.0)
        )
        self.limits = JointLimits.of(self.robot)
        self.given = []
        posture = self.robot.initial_joint_angles.reshape(-1)
        self._joints = TrajectoryExecutor(self.limits.joint_names, posture, self.limits)

    @property
    def time(self):
        return self.simulation.time

    def measured(self):
        seen = self.simulation.observe()
        return Measurement(seen.time, seen.pose, 0.0, seen.joint_positions, seen.joint_velocities)

    def step(self, change=lambda now: now):
        now = change(self.measured())
        self.reported = now.joint_positions
        self.take(self.controller.update(now))
        self.simulation.step()

    def take(self, trajectory):
        if trajectory is not None:
            if self._joints is None:
                # A controller that was never commanded anything holds what it finds.
                held = self.limits.clip(self.reported)
                self._joints = TrajectoryExecutor(self.limits.joint_names, held, self.limits)
            check_command(self.limits, trajectory, self.time, *self._joints.command(self.time))
            self._joints.accept(trajectory, self.time)
            self.simulation.accept(trajectory)
            self.given.append(trajectory)

    def run(self, seconds, change=lambda now: now, until=lambda: False):
        for _ in range(round(seconds / 0.01)):
            if until():
                return True
            self.step(change)
        return False

    @property
    def is_still(self):
        return not np.any(self.simulation.observe().joint_velocities)

    @property
    def stands(self):
        posture = self.robot.initial_joint_angles.reshape(-1)
        return np.abs(self.simulation.observe().joint_positions - posture).max() < 0.3


def walking(name='titan_viii', gait='crawl', seconds=6.3, watches_joints=False):
    walk = SafeWalk(name, gait, watches_joints)
    walk.run(0.5)
    walk.controller.set_plan(AHEAD)
    walk.run(seconds)
    assert walk.controller.activity is Activity.WALKING
    return walk


def is_doing(controller, *activities):
    return controller.activity in activities


def silent(now):
    return replace(now, problem='no joint states for 1.0 s')


@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot'])
def test_without_joint_states_a_walk_ends_standing_and_goes_on_when_they_return(gait):
    walk = walking(gait=gait)
    before = len(walk.given)
    walk.run(12.0, silent)
    assert len(walk.given) == before, 'nothing is commanded blindly'
    assert walk.is_still
    assert walk.stands
    assert walk.controller.activity is Activity.WAITING
    assert walk.controller.reason == 'no joint states for 1.0 s'
    walk.controller.set_plan(Plan.through([[0.0, 0.0], [2.0, 0.0]], 0.0))
    walk.run(3.0, silent)
    assert walk.is_still
    assert walk.run(5.0, until=lambda: walk.controller.activity is Activity.WALKING)
    assert walk.controller.limit == ''


def test_a_moment_without_joint_states_is_told_of_while_it_lasts():
    walk = walking()
    walk.step(silent)
    assert 'comes to rest: no joint states' in walk.controller.limit
    walk.run(12.0)
    assert walk.controller.limit == ''
    assert walk.controller.activity is Activity.WALKING


def test_a_plan_waits_while_its_planner_is_gone_and_is_followed_again_then():
    walk = walking(gait='wave')
    walk.controller.hold_plan('the planner is gone')
    walk.run(10.0)
    assert walk.is_still
    assert (walk.controller.activity, walk.controller.reason) == (
        Activity.WAITING,
        'the planner is gone',
    )
    # Steering is no plan.
    walk.controller.set_twist(Twist2D(0.02))
    walk.run(0.9)
    assert walk.controller.activity is Activity.WALKING
    walk.run(10.0)
    walk.controller.set_plan(Plan.through([[0.0, 0.0], [2.5, 0.0]], 0.0))
    walk.run(3.0)
    assert walk.is_still
    walk.controller.hold_plan('')
    assert walk.run(3.0, until=lambda: walk.controller.activity is Activity.WALKING)


@pytest.mark.parametrize(('name', 'gait'), [('titan_viii', 'crawl'), ('cuhk', 'trot')])
def test_an_emergency_stop_freezes_all_joints_at_any_instant_until_it_is_released(name, gait):
    rng = np.random.default_rng(0)
    for seconds in 3.0 + rng.uniform(0.0, 2.0, 6):
        walk = walking(name, gait, seconds)
        controller = walk.controller
        walk.take(controller.update(walk.measured()))
        walk.take(controller.freeze())
        walk.run(0.03)
        frozen = walk.simulation.observe().joint_positions
        assert walk.is_still
        walk.controller.set_plan(AHEAD)
        walk.controller.set_twist(Twist2D(0.05))
        assert 'is refused: the emergency stop is on' in walk.controller.limit
        with pytest.raises(GaitError, match='release it first'):
            walk.controller.stand()
        given = len(walk.given)
        walk.run(3.0)
        assert walk.controller.activity is Activity.EMERGENCY_STOP
        walk.controller.release()
        walk.run(3.0)
        assert np.array_equal(walk.simulation.observe().joint_positions, frozen)
        assert len(walk.given) == given
        assert 'it waits for stand' in walk.controller.reason
        walk.controller.stand()
        walk.controller.set_plan(Plan.through([[0.0, 0.0], [2.5, 0.0]], 0.0))
        assert walk.run(8.0, until=partial(is_doing, controller, *MOVING))


@pytest.mark.parametrize('joint', [0, 4])
def test_a_joint_that_is_elsewhere_after_an_emergency_stop_is_sound(joint):
    """A simulator or a driver freezes by itself: what gait_node gives out comes too late for it."""
    walk = walking(seconds=3.5, watches_joints=True)
    controller = walk.controller
    walk.take(controller.update(walk.measured()))
    hold = controller.freeze()
    walk.take(hold)
    walk.run(0.1)
    elsewhere = hold.positions + 0.2 * np.eye(12)[joint] * np.sign(-hold.positions[:, joint])
    walk.simulation.accept(replace(hold, times=np.array([0.5]), positions=elsewhere))
    walk.run(0.6)
    controller.release()
    walk.run(1.0)
    assert walk.simulation.observe().joint_positions == pytest.approx(elsewhere[0])
    controller.stand()
    walk._joints = None
    assert not walk.run(6.0, until=partial(is_doing, controller, Activity.LAME)), controller.reason
    assert controller.activity is Activity.STANDING
    assert walk.stands


@pytest.mark.parametrize('name', available_robots())
def test_from_any_posture_that_joints_may_report_no_command_leaves_the_limits(name):
    """Joints out of range, far from their commands, fallen, lame: checked in `take`."""
    rng = np.random.default_rng(1)
    walk = SafeWalk(name)
    walk._joints = None
    for _ in range(60):
        joints = rng.uniform(walk.limits.lower - 0.25, walk.limits.upper + 0.25)
        tilt = float(rng.choice([0.0, 1.2]))
        walk.controller.stand()
        still = np.zeros(12)

        def reports(now, joints=joints, still=still, tilt=tilt):
            return replace(now, joint_positions=joints, joint_velocities=still, tilt=tilt)

        walk.run(rng.uniform(0.3, 1.5), reports)
    assert len(walk.given) > 20


def test_what_the_gate_refuses_is_not_given_out_and_the_robot_stops_and_says_so(monkeypatch):
    walk = walking(gait='wave')
    before = len(walk.given)
    fast = JointLimits.of(walk.robot)
    slow = replace(fast, velocity=0.05 * fast.velocity)
    monkeypatch.setattr(walk.controller._joints.gate, 'limits', slow)
    walk.run(12.0)
    assert len(walk.given) == before
    assert walk.is_still
    assert walk.stands
    assert walk.controller.activity is Activity.STOPPED
    assert 'would be commanded a velocity' in walk.controller.reason


def test_the_gate_checks_what_the_controller_gives_out():
    walk = SafeWalk()
    walk.run(0.5)
    walk.controller.set_plan(AHEAD)
    walk.run(1.0)
    wrong = replace(walk.given[-1], positions=walk.given[-1].positions + 9.0)
    with pytest.raises(CommandOutsideLimits):
        walk.take(wrong)


def test_a_robot_that_was_moved_in_a_walk_stands_up_before_it_walks_again():
    walk = walking()
    walk.run(1.0)
    walk.simulation.reset()
    moved = []

    def was_moved(now):
        moved.append(now)
        return replace(now, was_moved=len(moved) == 1)

    # The executor of this test is moved as well.
    walk._joints.hold(walk.robot.initial_joint_angles.reshape(-1))
    walk.run(3.0, was_moved)
    assert walk.run(5.0, until=lambda: walk.controller.activity is Activity.WALKING)
    assert not math.isnan(walk.measured().pose.x)
