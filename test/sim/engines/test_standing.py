"""Laws of standing feet: they do not creep, do not sink in, and nothing of the past holds them."""

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.rotations import matrix_from_quaternion
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_sim.engines.registry import ENGINES, engines_with, make_simulator
from quad_sim.engines.simulator import GRAVITY
from quad_sim.simulation import Simulation
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import World, world_from_map

STILL = np.zeros(12)
ORIGIN = Pose2D(0.0, 0.0, 0.0)
SLOPE = 0.15


@pytest.fixture(params=engines_with('has_world'))
def make(request):
    """Make simulators of robots that are closed after the test."""
    pytest.importorskip(ENGINES[request.param].package)
    made = []

    def make_one(robot, slope=0.0, friction=0.8):
        world = world_from_map(None, friction=friction)
        if slope:
            terrain = make_terrain(
                specs_from_text(f'slope:angle={slope}'), (-3.0, -3.0, 3.0, 3.0), ORIGIN
            )
            world = World(np.empty((0, 4, 2)), friction=friction, terrain=terrain)
        made.append(make_simulator(request.param, robot, world))
        return made[-1]

    yield make_one
    for simulator in made:
        simulator.close()


def stand(simulator, robot, seconds):
    """Stand in the initial posture for a time; return the pose of the body then."""
    joints = robot.initial_joint_angles.reshape(-1)
    for _ in range(round(seconds / simulator.time_step)):
        simulator.step(joints, STILL)
    return simulator.observe().pose


def lifted(robot, leg, height, ahead=0.0):
    """Joint angles of the initial posture with one foot higher and farther ahead by so much."""
    feet = robot.foot_positions(robot.initial_joint_angles)
    feet[leg] += (ahead, 0.0, height)
    return robot.joint_angles(feet).reshape(-1)


def go(simulator, start, end, steps=100):
    """Move the joints from one posture to another at a steady speed, and stand there."""
    speed = (end - start) / (steps * simulator.time_step)
    for k in range(steps):
        simulator.step(start + (k + 1) / steps * (end - start), speed)
    for _ in range(steps):
        simulator.step(end, STILL)


def foot_of(simulator, robot, leg):
    """Center of a foot in the world [m]."""
    seen = simulator.observe()
    feet = robot.foot_positions(seen.joint_positions.reshape(4, 3))
    return seen.position + matrix_from_quaternion(seen.orientation) @ feet[leg]


@pytest.mark.sweep(kept=6)
@pytest.mark.parametrize('name', available_robots())
@pytest.mark.parametrize(('slope', 'yaw'), [(0.0, 0.5), (SLOPE, 0.0), (SLOPE, 2.0)])
def test_a_standing_robot_does_not_creep(make, name, slope, yaw):
    robot = load_robot(name)
    simulator = make(robot, slope)
    simulator.reset(Pose2D(1.0, 0.0, yaw))
    # MuJoCo's contacts stiffen for some seconds; while they do, feet rise out of the ground.
    before = stand(simulator, robot, 12.0)
    moved = before.inverse() @ stand(simulator, robot, 2.0)
    assert np.hypot(moved.x, moved.y) / 2.0 < 1e-6
    assert abs(moved.yaw) / 2.0 < np.radians(0.001)


@pytest.mark.parametrize('name', available_robots())
def test_feet_do_not_sink_into_the_ground(make, name):
    robot = load_robot(name)
    simulator = make(robot)
    stand(simulator, robot, 1.0)
    heights = [foot_of(simulator, robot, leg)[2] for leg in range(4)]
    assert heights == pytest.approx([robot.foot_radius] * 4, abs=5e-4)


def test_a_robot_on_ground_that_is_too_slippery_slides_down_a_slope(make):
    robot = load_robot('genibo')
    # Half of what the slope would take.
    simulator = make(robot, SLOPE, friction=0.5 * np.tan(SLOPE))
    simulator.reset(Pose2D(1.0, 0.0, 0.0))
    before = simulator.observe().pose
    moved = before.inverse() @ stand(simulator, robot, 0.5)
    # Half of the slope's pull is left: at most 0.5 a t^2 with a = 0.5 g sin(slope).
    farthest = 0.25 * GRAVITY * np.sin(SLOPE) * 0.5**2
    assert 0.01 < abs(moved.x) < 1.05 * farthest


def test_a_foot_that_is_put_down_elsewhere_stays_there(make):
    robot = load_robot('titan_viii')
    simulator = make(robot, SLOPE)
    simulator.reset(Pose2D(1.0, 0.0, 0.0))
    stand(simulator, robot, 1.0)
    initial = robot.initial_joint_angles.reshape(-1)
    up, down = lifted(robot, 0, 0.03, 0.03), lifted(robot, 0, 0.0, 0.03)
    go(simulator, initial, up)
    go(simulator, up, down)
    places = [foot_of(simulator, robot, 0)]
    for steps in (1200, 400):
        for _ in range(steps):
            simulator.step(down, STILL)
        places.append(foot_of(simulator, robot, 0))
    # MuJoCo's contacts stiffen for some seconds: a foot gives a little meanwhile, and then no more.
    first, settled, last = places
    assert np.linalg.norm(settled - first) < 1e-4
    assert np.linalg.norm(last - settled) < 1e-5


def test_a_walk_repeats_bit_for_bit(make):
    robot = load_robot('genibo')
    gait = load_gait('crawl', robot)
    cycle = generate_cycle(robot, gait, BodyMotion(forward=0.5 * robot.largest_stride))
    runs = []
    for _ in range(2):
        simulation = Simulation(make(robot), robot, ORIGIN)
        simulation.step()
        simulation.accept(cycle.trajectory(robot, simulation.time))
        states = []
        for _ in range(round(gait.cycle_period / simulation.time_step)):
            simulation.step()
            seen = simulation.observe()
            states.append(np.concatenate([seen.position, seen.orientation, seen.joint_efforts]))
        runs.append(np.array(states))
    assert np.ptp(runs[0][:, 0]) > 1e-3
    assert (runs[0] == runs[1]).all()
