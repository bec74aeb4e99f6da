"""The balance is kept where it is wanted and possible, and why not is said."""

from dataclasses import replace

import numpy as np
import pytest
from told_supervisor import measurement

from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.gait_choice import GaitChoice, balanced_gait, long_gear
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.wishes import ChangeGaits
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.step import Step
from quad_gait.state.measurement import ImuMotion
from quad_gait.state.state_estimator import StateEstimator

ROBOT = load_robot('cuhk')
AHEAD = Step(is_turn=False, motion=BodyMotion(forward=0.02))
IMU = ImuMotion(np.zeros(3), None)


def choice(gait='trot', balance=BalanceOptions()):  # noqa: B008
    walking = load_gait(gait, ROBOT)
    gaits = ChangeGaits(walking, turning_gait_for(walking, ROBOT), FollowerOptions())
    return GaitChoice(ROBOT, gaits, SupervisorOptions(balance=balance))


def state(**changes):
    return StateEstimator(ROBOT).judge(measurement(ROBOT, 1.0, **changes))


def test_a_trot_keeps_the_balance_by_an_imu():
    gaits = choice()
    assert gaits.manner_of(AHEAD) is Activity.WALKING
    assert gaits.look_at(state(imu=IMU))
    assert gaits.manner_of(AHEAD) is Activity.BALANCING
    assert gaits.unbalanced == ''
    assert not gaits.look_at(state(imu=IMU))


@pytest.mark.parametrize('gait', ['trot', 'walk'])
def test_no_foot_swings_for_longer_than_a_body_may_fall(gait):
    walking, options = load_gait(gait, ROBOT), BalanceOptions()
    longest = options.longest_swing / walking.pendulum_rate
    assert walking.longest_swing > longest
    assert balanced_gait(walking, options).longest_swing == pytest.approx(longest)
    quick = walking.with_period(0.5 * longest)
    assert balanced_gait(quick, options).cycle_period == pytest.approx(quick.cycle_period)


@pytest.mark.parametrize(
    ('changes', 'what'), [({}, 'no imu'), ({'imu': IMU, 'joint_velocities': None}, 'velocities')]
)
def test_what_is_missing_is_said(changes, what):
    gaits = choice()
    gaits.look_at(state(imu=IMU))
    assert gaits.look_at(state(**changes))
    assert gaits.manner_of(AHEAD) is Activity.WALKING
    assert what in gaits.unbalanced


@pytest.mark.parametrize(('gait', 'balance'), [('crawl', BalanceOptions()), ('trot', None)])
def test_static_gaits_and_robots_that_are_not_to_keep_it_walk_as_planned(gait, balance):
    gaits = choice(gait, balance)
    assert not gaits.look_at(state(imu=IMU))
    assert gaits.manner_of(AHEAD) is Activity.WALKING
    assert gaits.unbalanced == ''


def test_a_slow_trot_steps_faster_to_keep_the_balance():
    gaits = choice()
    planned = gaits.pair.walking.gait
    gaits.look_at(state(imu=IMU))
    walking = gaits.pair.walking.gait
    assert walking.cycle_period == pytest.approx(2.6 / planned.pendulum_rate)
    assert walking.cycle_period < planned.cycle_period


def test_plans_are_followed_in_cycles_that_gather_speed_gently():
    walking = choice().pair.walking
    gear = long_gear(walking, replace(BalanceOptions(), gathering=0.01), BodyMotion(forward=1.0))
    assert gear.period > 3.0 * walking.period
    ahead = BodyMotion(forward=1.0)
    speeds = [g.largest_scale(ahead) / g.period for g in (gear, walking)]
    assert speeds[0] == pytest.approx(speeds[1])


def test_a_robot_that_keeps_its_balance_is_slower_where_its_joints_are():
    gaits = choice()
    planned = gaits.pair.walking
    gaits.look_at(state(imu=IMU))
    kept = gaits.pair.walking
    forward = BodyMotion(forward=1.0)
    assert (
        kept.largest_scale(forward) / kept.period
        < 0.95 * planned.largest_scale(forward) / planned.period
    )
    assert 'for corrections' in kept.reason(forward)
    assert 'for corrections' not in planned.reason(forward)


def test_a_turn_is_gathered_no_faster_than_the_robot_turns_faster():
    gaits, options = choice(), BalanceOptions()
    gaits.look_at(state(imu=IMU))
    _, turning = gaits.gears
    speed = turning.largest_scale(BodyMotion(turn=1.0)) / turning.period
    # It gains speed for half of the gear's cycles, as it loses it.
    assert turning.period > 0.9 * speed / options.turn_acceleration
