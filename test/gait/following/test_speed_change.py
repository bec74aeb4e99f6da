"""A dynamic gait moves aside no farther in a cycle than two feet allow."""

import math

import numpy as np
import pytest

from quad_common.planar_pose import STILL, Twist2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.schedule import schedule_of
from quad_gait.following.speed_change import (
    balanced_motion,
    gripped_motion,
    lowered_feet,
    natural_motion,
)
from quad_gait.following.step import AT_ONCE

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
def test_swinging_feet_are_tilted_down_by_a_part_of_their_lift_at_most(name):
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
        assert lowered <= 0.4 * gait.swing_height * (1.0 + 1e-9)
        assert kept.turn == wanted.turn
        if kept is not wanted:
            shortened += 1
            assert lowered == pytest.approx(0.4 * gait.swing_height)
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


def speed_lost(motion, ends, robot, gait):
    """Return how much speed a cycle's last support takes from the body [m/s]."""
    period = gait.cycle_period
    schedule = schedule_of(gait, period / 200)
    pace = schedule.progress_rate[0] * period
    change = np.argmin(np.abs(schedule.times - gait.support_edges[-2]))
    lost = []
    for whole, entry, exit in (
        (motion.forward, ends[0].forward, ends[1].forward),
        (motion.left, ends[0].left, ends[1].left),
    ):
        mean = whole * schedule.progress_rate
        speed = mean + schedule.entry_rate * (pace * entry - mean[0])
        speed += schedule.exit_rate * (pace * exit - mean[-1])
        lost.append(speed[change] - pace * exit)
    return math.hypot(*lost)


@pytest.mark.parametrize('name', ROBOTS)
def test_no_more_speed_is_lost_over_a_support_than_friction_takes(name):
    robot = load_robot(name)
    gait = load_gait('trot', robot)
    largest = 0.8 * 9.80665 * (gait.support_edges[-1] - gait.support_edges[-2])
    rng = np.random.default_rng(3)
    shortened = 0
    for _ in range(200):
        entry, exit = (Twist2D(*rng.uniform(-2.0, 2.0, 2).tolist()) for _ in range(2))
        natural = natural_motion(entry, exit, gait)
        assert gripped_motion(natural, (entry, exit), gait) == natural
        wanted = natural.minus(BodyMotion(*rng.uniform(-0.4, 0.4, 2).tolist(), 0.3))
        kept = gripped_motion(wanted, (entry, exit), gait)
        least = max(largest, speed_lost(natural, (entry, exit), robot, gait))
        assert speed_lost(kept, (entry, exit), robot, gait) <= least * 1.001
        assert kept.turn == wanted.turn
        if kept is wanted:
            continue
        shortened += 1
        # No less than that, in the same direction.
        assert speed_lost(kept, (entry, exit), robot, gait) == pytest.approx(least, rel=1e-3)
        before, beyond = wanted.minus(natural), kept.minus(natural)
        assert beyond.forward * before.left == pytest.approx(beyond.left * before.forward)
        assert beyond.forward * before.forward + beyond.left * before.left >= 0.0
    assert shortened > 20


@pytest.mark.parametrize('name', ROBOTS)
def test_robots_that_ship_stop_as_they_would_without_friction_in_mind(name):
    robot = load_robot(name)
    gait = load_gait('trot', robot)
    gear = MotionLimits(robot, gait)
    stride = gear.largest_scale(BodyMotion(forward=1.0))
    entry = Twist2D(stride / gear.period)
    motion = BodyMotion((1.0 - gait.acceleration_fraction + AT_ONCE) * stride)
    assert gripped_motion(motion, (entry, STILL), gait) is motion
