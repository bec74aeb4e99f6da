"""Torques of the joints tell how hard each foot presses."""

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot.leg_moments import weight_torques
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.state.foot_forces import foot_forces
from quad_sim.engines.registry import ENGINES, engines_with, make_simulator
from quad_sim.simulation import Simulation

UP = np.array([0.0, 0.0, 1.0])
GRAVITY = 9.80665


@pytest.mark.parametrize('name', available_robots())
def test_legs_in_the_air_press_on_nothing(name):
    robot = load_robot(name)
    joints = robot.initial_joint_angles
    forces = foot_forces(robot, joints, weight_torques(robot, joints, UP), UP)
    assert forces == pytest.approx(np.zeros((4, 3)), abs=1e-9)


def test_a_force_on_a_foot_is_found_from_the_torques_that_balance_it():
    robot = load_robot('titan_viii')
    rng = np.random.default_rng(0)
    joints = robot.initial_joint_angles + rng.uniform(-0.2, 0.2, (4, 3))
    given = rng.uniform(-50.0, 50.0, (4, 3))
    pushed = np.einsum('kji,kj->ki', robot.foot_jacobians(joints), given)
    found = foot_forces(robot, joints, weight_torques(robot, joints, UP) - pushed, UP)
    assert found == pytest.approx(given, abs=1e-6)


def test_weight_torques_are_those_of_the_link_masses():
    robot = load_robot('titan_viii')
    torques = weight_torques(robot, robot.initial_joint_angles, UP)
    # The thigh is level, the calf hangs down from its end: both pull the pitch joint down.
    mass = {kind: link.mass for kind, link in robot.links.items()}
    arm = 0.155
    pull = GRAVITY * arm * (0.5 * mass['thigh'] + mass['calf'] + mass['foot'])
    assert torques[:, 1] == pytest.approx(np.full(4, -pull), rel=1e-4)
    assert torques[:, 0] == pytest.approx(np.zeros(4), abs=1e-6)


def test_a_stretched_leg_tells_nothing_and_the_others_do():
    robot = load_robot('titan_viii')
    joints = robot.initial_joint_angles.copy()
    joints[2, 2] = 0.0
    forces = foot_forces(robot, joints, np.zeros((4, 3)), UP)
    assert np.all(np.isnan(forces[2]))
    assert np.all(np.isfinite(np.delete(forces, 2, axis=0)))


@pytest.mark.parametrize('name', ['titan_viii', 'genibo'])
@pytest.mark.parametrize('backend', engines_with('has_world'))
def test_a_standing_robot_feels_its_weight(name, backend):
    pytest.importorskip(ENGINES[backend].package)
    robot = load_robot(name)
    simulation = Simulation(make_simulator(backend, robot, None), robot, Pose2D(0.0, 0.0, 0.0))
    try:
        for _ in range(400):
            simulation.step()
        seen = simulation.observe()
    finally:
        simulation.close()
    forces = foot_forces(
        robot, seen.joint_positions.reshape(4, 3), seen.joint_efforts.reshape(4, 3), UP
    )
    assert forces[:, 2].sum() == pytest.approx(robot.mass * GRAVITY, rel=0.06)
    assert forces[:, 2].min() > 0.0
