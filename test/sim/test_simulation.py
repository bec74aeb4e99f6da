"""The simulation steps a simulator with its trajectory's commands, and keeps the record."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import JointNotFound, NotSimulated, ParameterError, TrajectoryError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.engines.registry import BACKENDS, make_simulator
from quad_sim.engines.simulator import Contact, JointFailure
from quad_sim.simulation import Simulation

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
START = Pose2D(1.0, 2.0, 0.5)


class Scripted(KinematicSimulator):
    """A simulator that can be told what to observe."""

    told: tuple[tuple[Contact, ...], bool] = ((), False)

    def observe(self):
        contacts, has_fallen = self.told
        return replace(super().observe(), contacts=contacts, has_fallen=has_fallen)


def make_simulation(kind=KinematicSimulator):
    simulator = kind(ROBOT, 0.01)
    return simulator, Simulation(simulator, ROBOT, START)


def swaying(stamp, seconds=1.0, size=0.05):
    times = np.linspace(0.0, seconds, 51)
    fraction = np.sin(math.pi * times / seconds) ** 2
    rate = math.pi / seconds * np.sin(2.0 * math.pi * times / seconds)
    change = np.tile([size, 0.0, 0.0], 4)
    return JointTrajectory(
        ROBOT.joint_names,
        stamp,
        times,
        POSTURE + fraction[:, None] * change,
        rate[:, None] * change,
    )


def test_the_robot_stands_at_its_start_pose_until_it_is_told_to_move():
    _, simulation = make_simulation()
    for _ in range(100):
        simulation.step()
    seen = simulation.observe()
    assert (seen.pose.x, seen.pose.y, seen.pose.yaw) == pytest.approx((1.0, 2.0, 0.5))
    assert seen.joint_positions == pytest.approx(POSTURE)
    assert simulation.time == seen.time == pytest.approx(1.0)
    assert simulation.time_step == 0.01


def test_after_each_step_the_joints_are_where_the_trajectory_has_them_at_that_time():
    _, simulation = make_simulation()
    trajectory = swaying(0.5)
    simulation.accept(trajectory)
    moved = 0.0
    for _ in range(200):
        simulation.step()
        expected = 0.0
        if 0.5 <= simulation.time <= 1.5:
            expected = 0.05 * math.sin(math.pi * (simulation.time - 0.5)) ** 2
        offset = simulation.observe().joint_positions - POSTURE
        assert offset[::3] == pytest.approx(np.full(4, expected), abs=1e-5)
        moved = max(moved, offset[0])
    assert moved == pytest.approx(0.05, abs=1e-4)


def test_a_reset_drops_the_trajectory_and_the_record_but_not_the_time():
    simulator, simulation = make_simulation(Scripted)
    simulation.accept(swaying(0.0))
    for _ in range(50):
        simulation.step()
    simulator.told = ((Contact('lf_calf', 'obstacle'),), True)
    simulation.observe()
    simulator.told = ((), False)
    simulation.reset()
    assert (simulation.contacts_seen, simulation.has_fallen) == (set(), False)
    assert simulation.time == pytest.approx(0.5)
    simulation.step()
    seen = simulation.observe()
    assert seen.joint_positions == pytest.approx(POSTURE)
    assert seen.pose.distance_to(START) < 1e-9


def test_contacts_and_falls_are_kept_until_the_reset():
    simulator, simulation = make_simulation(Scripted)
    obstacle, ground = Contact('lf_calf', 'obstacle'), Contact('rh_thigh', 'ground')
    for told in (((obstacle,), False), ((ground, obstacle), True), ((), False)):
        simulator.told = told
        simulation.observe()
    assert simulation.contacts_seen == {obstacle, ground}
    assert simulation.has_fallen
    assert sorted(map(str, simulation.contacts_seen)) == [
        'lf_calf touches obstacle',
        'rh_thigh touches ground',
    ]


def test_a_trajectory_that_is_refused_leaves_the_last_one_in_force():
    _, simulation = make_simulation()
    simulation.accept(swaying(0.0))
    for _ in range(50):
        simulation.step()
    with pytest.raises(TrajectoryError, match=r'ended at 0\.2'):
        simulation.accept(swaying(0.1, seconds=0.1))
    assert simulation.late_trajectories == 1
    assert simulation.observe().joint_positions[0] - POSTURE[0] == pytest.approx(0.05, abs=1e-4)


def test_a_trajectory_that_comes_after_its_first_point_was_due_is_counted():
    _, simulation = make_simulation()
    for _ in range(50):
        simulation.step()
    # At 0.5 s: a stamp of zero means now, one to come is early enough. The third was due
    # and makes the joints jump; the fourth was due too, but goes on with what they do.
    for stamp, late in ((0.0, 0), (0.6, 0), (0.25, 1), (0.25, 1)):
        simulation.accept(swaying(stamp))
        assert simulation.late_trajectories == late


def test_simulators_are_made_by_name():
    assert isinstance(make_simulator('kinematic', ROBOT, None), KinematicSimulator)
    assert make_simulator('kinematic', ROBOT, None, time_step=0.002).time_step == 0.002
    assert 'bullet' in BACKENDS


def test_bullet_is_made_by_name():
    pytest.importorskip('pybullet')
    simulator = make_simulator('bullet', ROBOT, None, time_step=0.002)
    assert type(simulator).__name__ == 'BulletSimulator'
    assert simulator.time_step == 0.002
    simulator.close()


def test_an_unknown_backend_is_answered_with_those_that_there_are():
    with pytest.raises(ParameterError, match="'backend' is 'gazebo'; it must be one of auto, b"):
        make_simulator('gazebo', ROBOT, None)


def test_a_joint_that_sticks_keeps_its_angle_from_its_time_on_until_a_reset():
    _, simulation = make_simulation()
    simulation.plan_failure(JointFailure('rf_hip_yaw_joint', 'stuck', 0.3))
    simulation.accept(swaying(0.01))
    yaw = ROBOT.joint_index('rf_hip_yaw_joint')
    seen = []
    for _ in range(80):
        simulation.step()
        seen.append(simulation.observe().joint_positions)
    angles = np.array(seen)
    assert np.ptp(angles[:29, yaw]) > 0.02
    assert np.ptp(angles[30:, yaw]) == 0.0
    assert np.ptp(angles[30:, yaw + 3]) > 0.02
    assert simulation.failed == JointFailure('rf_hip_yaw_joint', 'stuck', 0.3)
    simulation.reset()
    assert simulation.failed is None
    simulation.accept(swaying(simulation.time + 0.01))
    for _ in range(50):
        simulation.step()
    assert simulation.observe().joint_positions[yaw] > POSTURE[yaw] + 0.04


def test_a_failure_that_is_taken_back_does_not_happen():
    _, simulation = make_simulation()
    simulation.plan_failure(JointFailure('rf_hip_yaw_joint', 'stuck', 0.3))
    simulation.plan_failure(None)
    for _ in range(50):
        simulation.step()
    assert simulation.failed is None


def test_a_failure_that_cannot_be_is_refused_with_a_sentence():
    _, simulation = make_simulation()
    with pytest.raises(NotSimulated, match=r"does not support a free joint.*'bullet'"):
        simulation.plan_failure(JointFailure('rf_hip_yaw_joint', 'free'))
    with pytest.raises(JointNotFound, match="no joint 'elbow'"):
        simulation.plan_failure(JointFailure('elbow', 'stuck'))
    with pytest.raises(ParameterError, match=r"'failure' is 'bent'.*free, stuck"):
        JointFailure('rf_hip_yaw_joint', 'bent')
