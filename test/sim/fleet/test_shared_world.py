"""Laws of worlds with several robots, in every engine."""

import numpy as np
import pytest

from quad_common.errors import PlaceTaken, RobotNameTaken, RobotNotFound
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import ENGINES, make_simulator
from quad_sim.engines.simulator import Contact
from quad_sim.fleet.shared_world import make_shared_world
from quad_sim.fleet_simulation import FleetSimulation
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.world import Obstacle

ROBOTS = {name: load_robot(name) for name in ('titan_viii', 'a1')}
STILL = np.zeros(12)
STARTS = {'titan_viii': Pose2D(0.0, 0.0, 0.3), 'a1': Pose2D(2.0, 1.0, -1.0)}
PHYSICS = [name for name, engine in ENGINES.items() if engine.has_world and engine.is_installed]
INSTALLED = [name for name, engine in ENGINES.items() if engine.is_installed]


def swaying(robot, count=120):
    """Joint angles of a body that sways over its feet."""
    feet = robot.foot_positions(robot.initial_joint_angles)
    sways = 0.008 * np.sin(0.05 * np.arange(count))
    return [robot.joint_angles(feet - [sway, 0.0, 0.0]).reshape(-1) for sway in sways]


def alone(backend, name):
    """Observations of a robot that sways alone."""
    simulator = make_simulator(backend, ROBOTS[name], None)
    simulator.reset(STARTS[name])
    seen = []
    for command in swaying(ROBOTS[name]):
        simulator.step(command, STILL)
        seen.append(simulator.observe())
    simulator.close()
    return seen


@pytest.fixture
def world(request):
    made = make_shared_world(request.param)
    yield made
    made.close()


def spawn(world, *names):
    return world.spawn({name: (ROBOTS[name], STARTS[name]) for name in names})


def sway_together(world, handles):
    commands = {name: swaying(ROBOTS[name]) for name in handles}
    seen = {name: [] for name in handles}
    for step in range(len(commands['a1'])):
        for name, handle in handles.items():
            handle.step(commands[name][step], STILL)
        world.step()
        for name, handle in handles.items():
            seen[name].append(handle.observe())
    return seen


@pytest.mark.parametrize('world', INSTALLED, indirect=True)
def test_robots_apart_do_what_each_does_alone(world, request):
    backend = request.node.callspec.params['world']
    handles = spawn(world, 'titan_viii', 'a1')
    for name, seen in sway_together(world, handles).items():
        for here, there in zip(seen, alone(backend, name)):
            assert here.position == pytest.approx(there.position, abs=1e-5)
            assert here.joint_positions == pytest.approx(there.joint_positions, abs=1e-4)
            assert here.contacts == there.contacts == ()


@pytest.mark.parametrize('world', PHYSICS, indirect=True)
def test_robots_touch_each_other_and_say_whom(world):
    handles = world.spawn(
        {
            'first': (ROBOTS['titan_viii'], Pose2D(0.0, 0.0, 0.0)),
            'second': (ROBOTS['titan_viii'], Pose2D(0.25, 0.0, 0.0)),
        }
    )
    posture = ROBOTS['titan_viii'].initial_joint_angles.reshape(-1)
    for _ in range(3):
        for handle in handles.values():
            handle.step(posture, STILL)
        world.step()
    touched = {name: handle.observe().contacts for name, handle in handles.items()}
    assert {contact.other for contact in touched['first']} == {'robot second'}
    assert {contact.other for contact in touched['second']} == {'robot first'}
    assert all(isinstance(contact, Contact) for contact in touched['first'])


@pytest.mark.parametrize('world', INSTALLED, indirect=True)
def test_robots_come_and_go_while_the_others_go_on(world):
    handles = spawn(world, 'titan_viii')
    posture = ROBOTS['titan_viii'].initial_joint_angles.reshape(-1)
    still = handles['titan_viii']
    for _ in range(20):
        still.step(posture, STILL)
        world.step()
    before = still.observe()
    handles |= spawn(world, 'a1')
    after = still.observe()
    assert after.time == before.time == pytest.approx(0.1)
    assert np.array_equal(after.position, before.position)
    assert np.array_equal(after.joint_positions, before.joint_positions)
    assert np.array_equal(after.joint_efforts, before.joint_efforts)
    world.remove('titan_viii')
    sit = ROBOTS['a1'].initial_joint_angles.reshape(-1)
    for _ in range(40):
        handles['a1'].step(sit, STILL)
        world.step()
    left = handles['a1'].observe()
    assert left.pose.distance_to(STARTS['a1']) < 0.01
    assert left.contacts == ()
    assert left.time == pytest.approx(0.3)


@pytest.mark.parametrize('world', PHYSICS, indirect=True)
def test_a_reset_moves_one_robot_and_no_other(world):
    handles = spawn(world, 'titan_viii', 'a1')
    sway_together(world, handles)
    before = handles['a1'].observe()
    handles['titan_viii'].reset(Pose2D(-1.0, 0.0, 0.0))
    assert np.array_equal(handles['a1'].observe().position, before.position)
    assert np.array_equal(handles['a1'].observe().joint_velocities, before.joint_velocities)
    assert handles['titan_viii'].observe().pose.x == pytest.approx(-1.0)


@pytest.mark.parametrize('world', PHYSICS, indirect=True)
def test_obstacles_are_there_for_every_robot_and_stay_when_one_comes(world):
    simulation = FleetSimulation(world)
    simulation.spawn({'a1': (ROBOTS['a1'], STARTS['a1'])})
    box = Obstacle.box(Pose2D(0.0, 3.0, 0.0), 0.2, 0.2, 0.3)
    simulation.change_obstacles([ObstacleChange(('boxes', 1), box)])
    simulation.spawn({'titan_viii': (ROBOTS['titan_viii'], STARTS['titan_viii'])})
    simulation.step()
    assert simulation.obstacles == {('boxes', 1): box}
    assert all(robot.obstacles == {('boxes', 1): box} for robot in simulation.robots.values())


def test_no_robot_is_put_where_another_one_is():
    simulation = FleetSimulation(make_shared_world('kinematic'))
    simulation.spawn({'one': (ROBOTS['a1'], Pose2D(0.0, 0.0, 0.0))})
    with pytest.raises(PlaceTaken, match=r"'two' would stand 0.30 m from 'one'"):
        simulation.spawn({'two': (ROBOTS['a1'], Pose2D(0.3, 0.0, 0.0))})
    with pytest.raises(RobotNameTaken, match="'one'"):
        simulation.spawn({'one': (ROBOTS['a1'], Pose2D(3.0, 0.0, 0.0))})
    with pytest.raises(RobotNotFound, match='there are: one'):
        simulation.remove('two')
    assert list(simulation.robots) == ['one']
