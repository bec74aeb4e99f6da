"""The limits of a gait: what is within them works, what is well beyond does not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import GaitError
from quad_common.planar_pose import STILL, Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import CycleEnds
from quad_gait.cycle.gait import available_gaits, load_gait
from quad_gait.cycle.gait_generator import CycleOptions, generate_cycle, generate_steady_cycle
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.part_check import crossing_feet

ROBOTS = {name: load_robot(name) for name in ('titan_viii', 'pukyong', 'cuhk', 'genibo')}
LIMITS = {
    (name, gait): MotionLimits(robot, load_gait(gait, robot))
    for name, robot in ROBOTS.items()
    for gait in available_gaits()
}
DIRECTIONS = {
    'forward': BodyMotion(1.0),
    'backward': BodyMotion(-1.0),
    'left': BodyMotion(left=1.0),
    'turn': BodyMotion(turn=1.0),
    'arc': BodyMotion(0.5, 0.2, 1.0),
}
TITAN, CUHK = ROBOTS['titan_viii'], ROBOTS['cuhk']

each_gait = pytest.mark.parametrize('gait', available_gaits())
each_robot = pytest.mark.parametrize('robot', ROBOTS)
each_direction = pytest.mark.parametrize('direction', DIRECTIONS.values(), ids=DIRECTIONS)


def check(limits, robot, motion):
    """Raise if a motion is not possible: steadily, from rest, or back to rest."""
    gait, margin = limits.gait_for(motion), limits.least_margin
    cycle = generate_steady_cycle(robot, gait, motion, CycleOptions(least_margin=margin))
    if crossing := crossing_feet(robot, cycle):
        raise GaitError(crossing)
    if not gait.is_steady:
        return
    speed, half = motion.rate(gait.cycle_period), motion.scaled(0.5)
    generate_cycle(
        robot, gait, half, CycleEnds(cycle.end_feet, entry=speed), CycleOptions(least_margin=margin)
    )
    if gait.is_static:
        generate_cycle(robot, gait, half, CycleEnds(exit=speed), CycleOptions(least_margin=margin))


@pytest.mark.sweep(kept=20)
@each_robot
@each_gait
@each_direction
def test_all_of_the_share_is_possible_from_rest_steadily_and_back_to_rest(robot, gait, direction):
    limits = LIMITS[robot, gait]
    assert limits.largest_scale(direction) > 0.0
    check(limits, ROBOTS[robot], direction.scaled(limits.largest_scale(direction)))


def is_s0s_bound(limits, direction):
    return 'largest stride' in limits.reason(direction)


@each_robot
@each_gait
@each_direction
def test_well_beyond_the_limit_it_is_not_possible_but_for_s0s_reserve(robot, gait, direction):
    settings = replace(ROBOTS[robot].gaits[gait], largest_fractions=None)
    whole = replace(ROBOTS[robot], gaits={gait: settings})
    limits = MotionLimits(whole, load_gait(gait, whole))
    just_possible = limits.largest_scale(direction) / 0.95
    if is_s0s_bound(limits, direction):
        assert limits.gait.footholds == 'initial_posture'
    else:
        # Coming to rest takes more of a walk than is looked at here.
        beyond = 1.25 if gait == 'walk' else 1.1
        with pytest.raises(GaitError):
            check(limits, ROBOTS[robot], direction.scaled(beyond * just_possible))


@each_robot
@each_gait
@each_direction
def test_the_reason_names_what_forbids_more(robot, gait, direction):
    reason = LIMITS[robot, gait].reason(direction)
    named = ('largest stride', 'foot ', '_joint would go', 'stability margin', 'cross', 'mm apart')
    assert any(name in reason for name in named), reason
    assert '\n' not in reason


@each_robot
@each_gait
def test_backward_is_as_far_as_forward(robot, gait):
    limits = LIMITS[robot, gait]
    forward, backward = (limits.largest_scale(BodyMotion(sign)) for sign in (1.0, -1.0))
    # Backward a walk is a different sequence.
    assert backward == pytest.approx(forward, rel=0.05 if gait == 'walk' else 0.02)


@pytest.mark.sweep(kept=6)
@each_robot
@each_gait
def test_left_is_as_far_as_right(robot, gait):
    limits = LIMITS[robot, gait]
    for a, b in (
        (BodyMotion(left=1.0), BodyMotion(left=-1.0)),
        (BodyMotion(turn=1.0), BodyMotion(turn=-1.0)),
    ):
        assert limits.largest_scale(b) == pytest.approx(limits.largest_scale(a), rel=0.1)


@pytest.mark.parametrize('gait', ['crawl', 'wave'])
def test_backward_the_legs_go_in_another_order_that_keeps_the_margin(gait):
    limits = LIMITS['titan_viii', gait]
    there, back = (limits.gait_for(BodyMotion(sign * 0.1)) for sign in (1.0, -1.0))
    assert there == limits.gait
    # Front and hind exchanged, as if the robot's front were behind.
    orders = [[swing.leg for swing in order.swings] for order in (there, back)]
    assert orders[0] != orders[1]
    margins = [
        generate_steady_cycle(TITAN, order, BodyMotion(-0.1)).least_margin
        for order in (there, back)
    ]
    assert margins[1] > margins[0]


def test_a_turn_gait_mirrors_itself_to_turn_the_other_way():
    limits = LIMITS['titan_viii', 'turn']
    left, right = (limits.gait_for(BodyMotion(turn=sign * 0.4)) for sign in (1.0, -1.0))
    margins = [
        generate_steady_cycle(TITAN, gait, BodyMotion(turn=sign * 0.4)).least_margin
        for gait, sign in ((left, 1.0), (right, -1.0))
    ]
    assert margins[0] == pytest.approx(margins[1], rel=0.1)
    assert min(margins) > 0.03


@each_robot
def test_whatever_its_order_a_gait_keeps_its_times(robot):
    limits = LIMITS[robot, 'wave']
    for direction in DIRECTIONS.values():
        gait = limits.gait_for(direction)
        times = [(swing.liftoff, swing.touchdown) for swing in gait.swings]
        assert times == [(swing.liftoff, swing.touchdown) for swing in limits.gait.swings]
        assert sorted(swing.leg for swing in gait.swings) == ['lf', 'lh', 'rf', 'rh']


def test_a_trot_keeps_its_pairs():
    limits = LIMITS['cuhk', 'trot']
    for direction in DIRECTIONS.values():
        assert limits.gait_for(direction) == limits.gait


@pytest.mark.sweep(kept=6)
@each_robot
@each_gait
def test_a_limited_velocity_keeps_its_direction_and_works(robot, gait):
    limits, body = LIMITS[robot, gait], ROBOTS[robot]
    rng = np.random.default_rng(1)
    for parts in rng.uniform((-1.0, -1.0, -3.0), (1.0, 1.0, 3.0), (4, 3)):
        wanted = Twist2D(*parts)
        given, reason = limits.limited(wanted)
        assert reason
        fraction = given.forward / wanted.forward
        assert 0.0 < fraction < 1.0
        assert given.left == pytest.approx(fraction * wanted.left)
        assert given.turn == pytest.approx(fraction * wanted.turn)
        motion = BodyMotion.during(given, limits.period)
        generate_steady_cycle(body, limits.gait_for(motion), motion)
        # Within the limits nothing is taken away.
        again, reason = limits.limited(given.scaled(0.98))
        assert (again, reason) == (given.scaled(0.98), '')


def test_a_velocity_within_the_limits_is_left_as_it_is():
    limits = LIMITS['titan_viii', 'wave']
    wanted = Twist2D(0.02, 0.01, 0.02)
    assert limits.limited(wanted) == (wanted, '')


def test_standing_still_has_no_limit():
    limits = LIMITS['titan_viii', 'wave']
    assert limits.largest_scale(BodyMotion()) == math.inf
    assert limits.reason(BodyMotion()) == ''
    assert limits.gait_for(BodyMotion()) == limits.gait
    assert limits.limited(STILL) == (STILL, '')


def test_the_share_of_a_motion_is_inverse_to_its_size():
    limits = LIMITS['titan_viii', 'wave']
    for direction in DIRECTIONS.values():
        fraction = limits.largest_scale(direction)
        for factor in (0.01, 0.3, 7.0):
            again = limits.largest_scale(direction.scaled(factor))
            assert factor * again == pytest.approx(fraction)


@each_direction
def test_s0s_gaits_go_no_farther_than_s0s_bounds(direction):
    limits = LIMITS['titan_viii', 'crawl']
    motion = direction.scaled(limits.largest_scale(direction))
    stride, turn = TITAN.largest_stride, TITAN.largest_turn
    fraction = math.hypot(motion.forward, motion.left) / stride + abs(motion.turn) / turn
    assert fraction <= 1.01


def test_s0s_largest_stride_is_the_crawls():
    # S_max = 226 mm.
    limits = LIMITS['titan_viii', 'crawl']
    assert limits.largest_scale(BodyMotion(1.0)) == pytest.approx(0.226, abs=0.0005)
    assert is_s0s_bound(limits, BodyMotion(1.0))


def test_slower_joints_make_a_shorter_stride_and_are_named():
    slow = replace(CUHK, velocity=0.3 * CUHK.velocity)
    gait = load_gait('trot', CUHK)
    limits = MotionLimits(slow, gait)
    assert limits.largest_scale(BodyMotion(1.0)) < LIMITS['cuhk', 'trot'].largest_scale(
        BodyMotion(1.0)
    )
    assert 'rad/s' in limits.reason(BodyMotion(1.0))


def test_a_larger_margin_allows_less_and_is_the_reason():
    gait = load_gait('wave', TITAN)
    fractions = [
        MotionLimits(TITAN, gait, least_margin=margin).largest_scale(BodyMotion(1.0))
        for margin in (0.0, 0.055, 0.06)
    ]
    assert fractions == sorted(fractions, reverse=True)
    assert fractions[-1] < fractions[0]
    careful = MotionLimits(TITAN, gait, least_margin=0.06)
    assert 'margin' in careful.reason(BodyMotion(1.0))


def test_if_nothing_is_possible_the_share_is_none():
    limits = MotionLimits(TITAN, load_gait('wave', TITAN), least_margin=1.0)
    assert limits.largest_scale(BodyMotion(1.0)) == 0.0
    assert 'margin' in limits.reason(BodyMotion(1.0))
    assert limits.limited(Twist2D(0.1)) == (STILL, limits.reason(BodyMotion(1.0)))


def test_what_a_follower_needs_to_know_is_the_gaits():
    for gait in available_gaits():
        limits = LIMITS['genibo', gait]
        assert limits.period == limits.gait.cycle_period
        assert limits.is_steady == limits.gait.is_steady


@pytest.mark.parametrize('gait', ['trot', 'walk'])
@pytest.mark.parametrize('size', [1e3, 1e150, 1e300])
def test_steering_far_beyond_all_reach_is_slowed_down_to_the_limit(gait, size):
    limits = MotionLimits(CUHK, load_gait(gait, CUHK))
    twist, reason = limits.limited(Twist2D(size, 0.5 * size))
    assert reason
    known, _ = MotionLimits(CUHK, load_gait(gait, CUHK)).limited(Twist2D(10.0, 5.0))
    assert twist.forward == pytest.approx(known.forward)
    assert twist.left == pytest.approx(known.left)


@pytest.mark.parametrize('gait', ['trot', 'walk'])
def test_the_part_that_is_possible_is_that_of_the_largest_motion(gait):
    rng = np.random.default_rng(5)
    for _ in range(6):
        direction = BodyMotion(*rng.normal(size=3).tolist())
        limits = MotionLimits(CUHK, load_gait(gait, CUHK))
        largest = direction.scaled(limits.largest_scale(direction))
        for part in (0.1, 0.9, 1.5):
            fresh = MotionLimits(CUHK, load_gait(gait, CUHK))
            possible = fresh.possible_part(largest.scaled(part))
            assert possible == pytest.approx(min(1.0, 1.0 / part), rel=1e-6)
