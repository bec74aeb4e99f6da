"""A robot that keeps its balance: pushed, left alone, without its imu, and at a goal."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_lab.balance.balance_case import BalanceCase, BalanceWalk
from quad_lab.balance.pushes import apart, survivors
from quad_lab.balance.rough_ground import trot_over
from quad_lab.balance.steady import silences, steady_trot
from quad_lab.balance.stops import stopped_walk
from quad_lab.balance.turns import steady_turn
from quad_lab.closed_loop.balance_loop import NOISY, BalanceLoop
from quad_lab.closed_loop.controllers import controller_for
from quad_sim.engines.registry import preferred

ROBOT = load_robot('cuhk')


@pytest.fixture(autouse=True)
def in_mujoco():
    pytest.importorskip('mujoco')
    with preferred('mujoco'):
        yield


@pytest.fixture
def loop():
    gait = load_gait('trot', ROBOT)
    options = SupervisorOptions(
        least_margin=0.005, twist_timeout=math.inf, balance=BalanceOptions()
    )
    made = BalanceLoop(ROBOT, controller_for(ROBOT, gait, options), delay=0.02, noise=NOISY)
    made.run(0.3)
    yield made
    made.close()


def test_pushes_from_all_sides_are_survived():
    case = BalanceCase('cuhk', speed=0.0)
    assert survivors(case, 0.6, directions=4, phases=1) == 1.0


def test_a_robot_with_slow_joints_survives_pushes_from_its_sides():
    # No push from a side was survived where joints used half of their speeds.
    pytest.importorskip('pybullet')
    with preferred('bullet'):
        assert survivors(BalanceCase('genibo'), 0.8, directions=4, phases=2) >= 0.75


@pytest.mark.parametrize('robot', ['cuhk', 'genibo'])
def test_a_walk_keeps_its_balance_too(robot):
    # GENIBO did not walk at all where a cycle was to be as short as a trot's.
    trot = steady_trot(BalanceCase(robot, speed=1.0, gait='walk'), 6.0)
    assert not trot.has_fallen
    assert trot.speed > 0.1
    assert abs(trot.error) < 0.03
    assert survivors(BalanceCase(robot, gait='walk'), 0.45, directions=4, phases=1) == 1.0


@pytest.mark.parametrize('side', [1, -1])
def test_a_robot_turns_on_the_spot_as_fast_as_its_limits_allow(side):
    turn = steady_turn(BalanceCase('cuhk', speed=0.0), side, 4.0)
    assert not turn.has_fallen
    assert turn.asked * side > 3.0
    assert abs(turn.error) < 0.12


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize(
    ('name', 'ground', 'seed'),
    [('cuhk', 'up', 1), ('cuhk', 'across', 1), ('genibo', 'up', 0), ('genibo', 'up', 2)],
)
def test_slopes_are_walked(name, ground, seed):
    trot = trot_over(BalanceCase(name, speed=0.6, is_noisy=True), ground, seed, duration=5.0)
    assert trot.succeeds
    assert math.degrees(trot.tilt) < 3.0


def test_bumps_that_are_higher_than_feet_are_lifted_on_level_ground_are_walked():
    # It fell where feet were lifted higher only after the ground had been rough by 0.9 of that.
    assert trot_over(BalanceCase('cuhk', speed=0.6, is_noisy=True), 'bumps', 1).succeeds


def test_with_a_height_map_feet_go_over_bumps_as_if_the_ground_were_level():
    blind = BalanceCase('a1', speed=0.6, is_noisy=True)
    trots = [trot_over(replace(blind, knows_ground=knows), 'bumps', 3) for knows in (True, False)]
    assert trots[0].succeeds
    assert trots[0].tilt < 0.5 * trots[1].tilt
    assert math.degrees(trots[0].tilt) < 2.5


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('seed', range(3))
@pytest.mark.parametrize('ground', ['onto', 'off'])
def test_with_a_height_map_an_edge_of_a_slope_is_nothing(ground, seed):
    # It fell where ground that lies farther off than a step is high counted as unknown.
    case = BalanceCase('a1', speed=0.6, is_noisy=True, knows_ground=True)
    trot = trot_over(case, ground, seed, duration=5.0)
    assert trot.succeeds
    assert math.degrees(trot.tilt) < 10.0


@pytest.mark.parametrize('every', [0.3, math.inf])
def test_random_heights_in_place_of_a_map_do_not_make_it_stumble(every):
    walk = BalanceWalk(BalanceCase('a1', is_noisy=True), seed=1)
    rng = np.random.default_rng(2)
    level = HeightMap.level((-1.0, -2.0, 6.0, 2.0), 0.02)
    begun, replaced = walk.loop.time, -math.inf
    try:
        while walk.loop.time < begun + 4.0 and not walk.is_lost:
            if walk.loop.time >= replaced + every:
                heights = rng.uniform(-0.1, 0.1, level.heights.shape)
                walk.loop.controller.set_height_map(level.with_heights(heights))
                replaced = walk.loop.time
            walk.loop.run(0.1)
        assert not walk.is_lost
        assert math.degrees(walk.tilts.max()) < 5.0
    finally:
        walk.close()


def test_a_robot_that_receives_nothing_more_comes_to_stand_on_four_feet():
    assert silences(BalanceCase('cuhk', speed=1.0), 2) == 2


def test_a_robot_that_is_answered_again_while_it_comes_to_rest_is_not_thrown():
    # A1 fell: its joints, 0.16 rad off, were to be where they should have been within 40 ms.
    pytest.importorskip('pybullet')
    with preferred('bullet'):
        walk = BalanceWalk(BalanceCase('a1', speed=1.0), seed=49)
    loop = walk.loop
    try:
        loop.controller.set_twist(Twist2D(0.0, walk.speed))
        loop.run(1.5 + 2.614 * walk.period)
        loop.is_deaf = True
        loop.run(0.3)
        loop.is_deaf = False
        before = len(walk.tilts)
        loop.run(1.5)
        assert np.max(walk.tilts[before:]) < math.radians(8.0)
        assert not walk.is_lost
    finally:
        walk.close()


def test_a_body_does_not_resist_the_sway_of_its_cycle():
    # It tilted by 1.1 degrees rms where standing legs took the sway for an error.
    pytest.importorskip('pybullet')
    with preferred('bullet'):
        trot = steady_trot(BalanceCase('cuhk', speed=1.0), 8.0)
    assert math.degrees(trot.tilt_rms) < 0.8
    assert abs(trot.error) < 0.02
    assert trot.odometry_error < 0.01


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize(
    ('name', 'silence', 'forward', 'left', 'turn'),
    [
        ('cuhk', 0.8, 1.0, 0.0, 0.0),
        ('a1', 0.8, 0.5, 0.4, 0.5),
        ('a1', 0.8, 0.0, 0.5, 0.0),
        ('titan_viii', 0.5, 1.0, 0.0, 0.0),
    ],
)
def test_a_robot_that_has_come_to_rest_unheard_goes_on(name, silence, forward, left, turn):
    # The last gate stopped it: it took the joints to be where they had not been told to be.
    pytest.importorskip('pybullet')
    for part in np.arange(4) / 4.0:
        with preferred('bullet'):
            walk = BalanceWalk(BalanceCase(name, speed=1.0))
        loop, speed = walk.loop, walk.speed
        try:
            loop.controller.set_twist(Twist2D(forward * speed, left * speed, turn))
            loop.run(1.5 + (2.0 + part) * walk.period)
            loop.is_deaf = True
            loop.run(silence)
            loop.is_deaf = False
            loop.run(1.0)
            assert not walk.is_lost, loop.controller.reason
        finally:
            walk.close()


def test_a_trial_leaves_everything_as_it_was():
    walk = BalanceWalk(BalanceCase('cuhk', speed=0.0))
    try:
        time, pose = walk.loop.time, walk.loop.simulation.observe().pose
        assert apart(partial(walk.loop.run, 0.1)) is False
        assert walk.loop.time == time
        assert walk.loop.simulation.observe().pose == pose
    finally:
        walk.close()


def test_a_robot_that_stands_counts_as_lost_where_it_is_to_trot():
    walk = BalanceWalk(BalanceCase('cuhk', speed=0.5))
    try:
        assert not walk.is_lost
        walk.loop.controller.stop()
        walk.loop.run(3.0)
        assert walk.is_lost
    finally:
        walk.close()


@pytest.mark.parametrize('speed', [0.5, 1.0])
def test_a_trot_is_as_fast_as_it_is_steered_and_its_legs_know_where_it_is(speed):
    trot = steady_trot(BalanceCase('cuhk', speed=speed), 6.0)
    # It makes up for the way that it lost as it gathered its speed.
    assert abs(trot.error) < 0.03
    assert trot.drift < 0.02
    assert trot.odometry_error < 0.02
    assert math.degrees(trot.tilt_rms) < 1.5


def test_without_its_imu_it_walks_by_plans_and_says_so(loop):
    controller = loop.controller
    controller.set_twist(Twist2D(0.15))
    loop.run(1.0)
    assert controller.activity is Activity.BALANCING
    loop.has_imu = False
    loop.run(0.5)
    assert "the imu's readings are older" in controller.limit
    assert loop.run(6.0, until=lambda: controller.activity is Activity.WALKING)
    assert 'without keeping its balance' in controller.unbalanced
    assert not loop.record.has_fallen


def test_it_arrives_where_a_plan_leads(loop):
    controller = loop.controller
    plan = Plan.through([[0.0, 0.0], [0.25, 0.0], [0.25, 0.2]], 1.57)
    controller.set_plan(plan)
    loop.run(20.0, until=lambda: controller.activity.is_terminal)
    assert controller.activity is Activity.ARRIVED
    loop.run(1.0)
    end = loop.record.poses[-1]
    assert end.distance_to(plan.poses[-1]) < 0.05
    assert abs(end.yaw - 1.57) < math.radians(5.0)


@pytest.mark.parametrize('name', ['a1', 'cuhk'])
def test_it_stops_at_turning_points_and_knows_where(name):
    # A1 went up to 0.25 m beyond them, by its full speed of 1 m/s, and came back; cuhk corrected
    # its place without end, or was taken for blocked.
    pytest.importorskip('pybullet')
    with preferred('bullet'):
        walk = stopped_walk(name, None)
    assert walk.has_arrived
    # What the bench wants of all robots; where the last foot lands is worth 25 mm either way.
    assert walk.beyond < 0.1
    assert walk.odometry_error < 0.025
    assert walk.position_error < 0.025


def test_it_stops_and_starts_again_at_once(loop):
    controller = loop.controller
    for forward in (0.2, 0.0, 0.2):
        controller.set_twist(Twist2D(forward))
        loop.run(0.45)
    loop.run(0.6)
    assert controller.activity is Activity.BALANCING
    controller.set_twist(Twist2D())
    # Feet that were put down elsewhere are lifted once more.
    assert loop.run(8.0, until=lambda: controller.activity is Activity.STANDING)
    assert not loop.record.has_fallen


def test_the_emergency_stop_holds_all_joints(loop):
    controller = loop.controller
    controller.set_twist(Twist2D(0.1))
    loop.run(1.0)
    hold = controller.freeze()
    loop.simulation.accept(hold)
    loop.run(0.3)
    before = loop.simulation.commanded
    loop.run(0.3)
    assert controller.activity is Activity.EMERGENCY_STOP
    assert np.array_equal(loop.simulation.commanded, before)


def test_the_joint_watch_finds_nothing_wrong_with_sound_joints(loop):
    controller = loop.controller
    controller.set_twist(Twist2D(0.3, 0.0, 0.3))
    loop.run(3.0)
    assert controller.activity is Activity.BALANCING
    assert controller.limit == '' or 'the most' in controller.limit
