"""A dynamic gait moves aside no farther in a cycle than two feet allow."""

import math

import numpy as np
import pytest

from quad_common.planar_pose import STILL, Twist2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.following.speed_change import balanced_motion, lowered_feet, natural_motion

ROBOTS = available_robots()


def random_twist(rng, robot, gait):
    size = robot.footprint_radius / gait.cycle_period
    return Twist2D(*(size * rng.uniform(-1.0, 1.0, 2)).tolist(), float(rng.uniform(-2.0, 2.0)))


@pytest.mark.parametrize('name', ROBOTS)
def test_what_the_speeds_lead_to_stays_as_it_is(name):
    robot = load_robot(name)
    gait = load_gait('trot', robot)
    rng = np.random.default_rng(1)
    for _ in range(50):
        ends = (random_twist(rng, robot, gait), random_twist(rng, robot, gait))
        motion = natural_motion(*ends, gait)
        assert balanced_motion(motion, ends, robot, gait) is motion


@pytest.mark.parametrize('name', ROBOTS)
def test_swinging_feet_are_never_tilted_down_to_the_ground(name):
    robot = load_robot(name)
    gait = load_gait('trot', robot)
    rng = np.random.default_rng(2)
    shortened = 0
    for _ in range(200):
        ends = (random_twist(rng, robot, gait), random_twist(rng, robot, gait))
        wanted = natural_motion(*ends, gait).minus(
            BodyMotion(*rng.uniform(-0.3, 0.3, 2).tolist(), float(rng.uniform(-1.0, 1.0)))
        )
        kept = balanced_motion(wanted, ends, robot, gait)
        beyond = kept.minus(natural_motion(*ends, gait))
        lowered = lowered_feet(beyond, robot, gait)
        assert lowered <= gait.swing_height * (1.0 + 1e-9)
        assert kept.turn == wanted.turn
        if kept is not wanted:
            shortened += 1
            assert lowered == pytest.approx(gait.swing_height)
            # Less of it, in the same direction.
            before = wanted.minus(natural_motion(*ends, gait))
            assert beyond.forward * before.left == pytest.approx(beyond.left * before.forward)
    assert shortened > 20


@pytest.mark.parametrize('name', ROBOTS)
def test_turns_lower_nothing_and_shifts_along_a_line_neither(name):
    robot = load_robot(name)
    gait = load_gait('trot', robot)
    assert lowered_feet(BodyMotion(turn=1.0), robot, gait) == 0.0
    # Along one diagonal: it is across the other one, by the angle between them.
    line = robot.neutral_feet[3, :2] - robot.neutral_feet[0, :2]
    other = robot.neutral_feet[2, :2] - robot.neutral_feet[1, :2]
    shift = 0.01 * line / np.linalg.norm(line)
    height = robot.center_of_mass(robot.initial_joint_angles)[2] + robot.standing_height
    sizes = float(np.linalg.norm(line) * np.linalg.norm(other))
    across = abs(float(line[0] * other[1] - line[1] * other[0])) / sizes
    arm = across * float(np.linalg.norm(line)) / 2.0
    assert lowered_feet(BodyMotion(*shift.tolist()), robot, gait) == pytest.approx(
        0.01 * across / (2.0 * height) * arm, rel=0.05
    )


@pytest.mark.parametrize('gait_name', ['crawl', 'wave', 'crab'])
def test_static_gaits_keep_every_motion(gait_name):
    robot = load_robot('cuhk')
    gait = load_gait(gait_name, robot)
    motion = BodyMotion(0.3, -0.3, math.pi)
    assert balanced_motion(motion, (STILL, STILL), robot, gait) is motion
