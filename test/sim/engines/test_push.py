"""A push against the body is a force in the world, for as long as it lasts."""

import numpy as np
import pytest

from quad_common.errors import NotSimulated
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import make_simulator
from quad_sim.simulation import Simulation

ROBOT = load_robot('cuhk')
TURNED = Pose2D(0.3, -0.2, 2.0)


def simulation_in(backend):
    module = {'bullet': 'pybullet', 'mujoco': 'mujoco'}.get(backend)
    if module is not None:
        pytest.importorskip(module)
    return Simulation(make_simulator(backend, ROBOT, None), ROBOT, TURNED)


def lifted_by(simulation, force, time):
    """How fast the robot is after a force for a time, in the world [m/s]."""
    before = simulation.observe().position
    simulation.push(np.array(force))
    steps = round(time / simulation.time_step)
    for _ in range(steps):
        simulation.step()
    simulation.push(np.zeros(3))
    after = simulation.observe().position
    simulation.close()
    return 2.0 * (after - before) / time


@pytest.mark.parametrize('backend', ['bullet', 'mujoco'])
def test_a_robot_that_is_lifted_gains_what_the_force_gives_it(backend):
    mass, g = ROBOT.mass, 9.80665
    # Twice its weight upward, and some to the side: nothing stands any more.
    velocity = lifted_by(simulation_in(backend), [0.3 * mass * g, 0.0, 2.0 * mass * g], 0.2)
    assert velocity[2] == pytest.approx(0.2 * g, rel=0.1)
    assert velocity[0] == pytest.approx(0.3 * 0.2 * g, rel=0.25)
    assert abs(velocity[1]) < 0.1 * velocity[0] + 0.05


@pytest.mark.parametrize('backend', ['bullet', 'mujoco'])
def test_a_push_ends_with_the_next_and_with_a_reset(backend):
    simulation = simulation_in(backend)
    simulation.push(np.array([0.0, 0.0, 3.0 * ROBOT.mass * 9.81]))
    simulation.reset()
    for _ in range(20):
        simulation.step()
    seen = simulation.observe()
    simulation.close()
    assert seen.position[2] == pytest.approx(ROBOT.standing_height, abs=0.01)


@pytest.mark.parametrize('backend', ['bullet', 'mujoco'])
def test_a_push_lasts_as_long_as_it_is_to(backend):
    simulation, weight = simulation_in(backend), ROBOT.mass * 9.80665
    simulation.push(np.array([0.0, 0.0, 3.0 * weight]), 0.1)
    velocities = []
    for _ in range(round(0.2 / simulation.time_step)):
        simulation.step()
        velocities.append(float(simulation.observe().linear_velocity_base_in_base[2]))
    simulation.close()
    fastest = int(np.argmax(velocities)) + 1
    assert fastest * simulation.time_step == pytest.approx(0.1, abs=1.5 * simulation.time_step)


@pytest.mark.parametrize('backend', ['bullet', 'mujoco'])
def test_the_shortest_push_lasts_for_a_step(backend):
    simulation, weight = simulation_in(backend), ROBOT.mass * 9.80665
    simulation.push(np.array([0.0, 0.0, 20.0 * weight]), 0.001)
    simulation.step()
    velocity = float(simulation.observe().linear_velocity_base_in_base[2])
    simulation.close()
    assert velocity > 0.1


def test_what_has_no_world_cannot_be_pushed():
    with pytest.raises(NotSimulated, match='a push'):
        simulation_in('kinematic').push(np.zeros(3))
