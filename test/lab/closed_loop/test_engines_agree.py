"""Two engines, one robot: what walks in one walks in the other, and as far."""

import math

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import tilt_from_quaternion
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_lab.closed_loop.calibration import measure_motion
from quad_sim.engines.registry import ENGINES, engines_with, make_simulator
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import World

BACKENDS = engines_with('has_world')
ROBOTS = ('titan_viii', 'genibo', 'cuhk', 'pukyong')

for backend in BACKENDS:
    pytest.importorskip(ENGINES[backend].package)


def stood(backend, robot, world):
    """Let a robot stand, and return what is seen of it at the end, and the feet's forces."""
    simulator = make_simulator(backend, robot, world)
    try:
        simulator.reset(Pose2D(0.0, 0.0, 0.4))
        posture = robot.initial_joint_angles.reshape(-1)
        for _ in range(200):
            simulator.step(posture, np.zeros(12))
        return simulator.observe(), simulator.foot_forces()
    finally:
        simulator.close()


@pytest.mark.parametrize('name', ['titan_viii', 'genibo'])
@pytest.mark.parametrize('ground', ['bumps:height=0.03', 'boxes:height=0.05', 'slope:angle=0.1'])
def test_a_robot_stands_alike_on_uneven_ground(name, ground):
    robot = load_robot(name)
    start = Pose2D(0.0, 0.0, 0.0)
    terrain = make_terrain(specs_from_text(ground), (-2.0, -2.0, 2.0, 2.0), start)
    world = World(np.empty((0, 4, 2)), terrain=terrain)
    (bullet, _), (mujoco, forces) = (stood(backend, robot, world) for backend in BACKENDS)
    assert mujoco.position == pytest.approx(bullet.position, abs=0.015 * robot.relative_size)
    assert tilt_from_quaternion(mujoco.orientation) == pytest.approx(
        tilt_from_quaternion(bullet.orientation), abs=math.radians(1.5)
    )
    assert forces.sum() == pytest.approx(robot.mass * 9.81, rel=0.05)


# A single cycle of a trot scatters: by 7 % of its length for TITAN-VIII after its first steps.
@pytest.mark.parametrize(
    ('name', 'gait_name', 'fraction', 'cycles'),
    [
        ('titan_viii', 'crawl', 0.01, 1),
        ('cuhk', 'crawl', 0.01, 1),
        ('genibo', 'wave', 0.01, 1),
        ('pukyong', 'wave', 0.01, 1),
        *((name, 'trot', 0.04, 3) for name in ROBOTS),
    ],
)
@pytest.mark.sweep(kept=3)
def test_open_loop_cycles_go_as_far(name, gait_name, fraction, cycles):
    robot = load_robot(name)
    gait = load_gait(gait_name, robot)
    direction = BodyMotion(forward=1.0)
    asked = direction.scaled(0.5 * MotionLimits(robot, gait).largest_scale(direction))
    bullet, mujoco = (
        measure_motion(robot, gait, asked, cycles=cycles, backend=backend) for backend in BACKENDS
    )
    assert not mujoco.has_fallen
    assert mujoco.mean.forward == pytest.approx(bullet.mean.forward, rel=fraction)
    assert mujoco.mean.left == pytest.approx(bullet.mean.left, abs=0.03 * asked.forward)
