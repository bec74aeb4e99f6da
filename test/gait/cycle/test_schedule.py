"""The curves of a gait: smooth, their rates are their derivatives, and they run from 0 to 1."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import available_gaits, load_gait
from quad_gait.cycle.schedule import schedule_of, setback, sway_windows

ROBOTS = ('titan_viii', 'cuhk')
FITTED = {
    f'{name} of {robot}': load_gait(name, load_robot(robot))
    for name in available_gaits()
    for robot in ROBOTS
}
TROT = FITTED['trot of cuhk']
WAVE = FITTED['wave of titan_viii']

each_gait = pytest.mark.parametrize('gait', FITTED.values(), ids=FITTED)


def fine(gait, samples=4000):
    return schedule_of(gait, gait.cycle_period / samples)


@each_gait
@pytest.mark.parametrize(
    'curve', ['progress', 'entry', 'exit', 'sway', 'body_lift', 'step', 'lift']
)
def test_a_rate_is_the_derivative_of_its_curve(gait, curve):
    schedule = fine(gait)
    value, rate = getattr(schedule, curve), getattr(schedule, f'{curve}_rate')
    difference = (value[2:] - value[:-2]) / (2.0 * schedule.times[1])
    error = np.abs(difference - rate[1:-1])
    # Where the acceleration jumps, the difference is off by half of it for one step.
    largest = np.abs(rate).max() + 1e-12
    assert error.max() < 0.01 * largest
    assert np.median(error) < 1e-5 * largest


@each_gait
def test_no_rate_jumps(gait):
    schedule = fine(gait)
    for curve in ('progress', 'entry', 'exit', 'sway', 'body_lift', 'step', 'lift'):
        rate = getattr(schedule, f'{curve}_rate')
        assert np.abs(np.diff(rate, axis=0)).max() <= 0.05 * np.abs(rate).max(), curve


@each_gait
def test_progress_and_steps_run_from_0_to_1_and_never_back(gait):
    schedule = fine(gait, 500)
    for curve in (schedule.progress, schedule.step):
        assert curve[0] == pytest.approx(0.0, abs=1e-12)
        assert curve[-1] == pytest.approx(1.0)
        assert (np.diff(curve, axis=0) >= -1e-12).all()


@each_gait
def test_a_foot_moves_only_while_it_swings(gait):
    schedule = fine(gait, 500)
    standing = schedule.in_contact
    assert schedule.step_rate[standing] == pytest.approx(0.0, abs=1e-9)
    assert schedule.lift[standing] == pytest.approx(0.0, abs=1e-12)
    assert (schedule.lift[~standing] >= 0.0).all()
    assert (schedule.lift[~standing].reshape(-1) > 0.0).mean() > 0.9


@each_gait
def test_every_foot_is_lifted_to_the_swing_height_in_the_middle_of_its_swing(gait):
    schedule = fine(gait)
    assert schedule.lift.max(axis=0) == pytest.approx(np.full(4, gait.swing_height), rel=1e-4)
    for k, leg in enumerate(LEGS):
        swing = gait.swing(leg)
        highest = schedule.times[np.argmax(schedule.lift[:, k])]
        middle = (swing.liftoff + swing.touchdown) / 2.0
        assert highest == pytest.approx(middle, abs=2.0 * schedule.times[1])


@each_gait
def test_at_both_ends_all_feet_are_down_and_the_body_is_at_its_height(gait):
    schedule = fine(gait, 100)
    for sample in (0, -1):
        assert schedule.in_contact[sample].all()
        assert schedule.body_lift[sample] == pytest.approx(0.0, abs=1e-12)
        assert schedule.body_lift_rate[sample] == pytest.approx(0.0, abs=1e-12)


@each_gait
def test_contact_is_what_the_swings_leave_of_the_cycle(gait):
    schedule = fine(gait)
    for k, leg in enumerate(LEGS):
        assert schedule.in_contact[:, k].mean() == pytest.approx(gait.duty_factor(leg), abs=1e-3)


@each_gait
def test_entry_and_exit_change_one_speed_at_one_end_and_no_place(gait):
    schedule = fine(gait, 200)
    assert schedule.entry[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert schedule.exit[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert schedule.entry_rate[[0, -1]] == pytest.approx([1.0, 0.0], abs=1e-12)
    assert schedule.exit_rate[[0, -1]] == pytest.approx([0.0, 1.0], abs=1e-12)
    if gait.is_static:
        # One is the other, run through backwards.
        assert schedule.exit == pytest.approx(-schedule.entry[::-1], abs=1e-12)


@pytest.mark.parametrize('robot', ROBOTS)
def test_a_trot_gains_speed_as_a_pendulum_does_that_falls_from_a_support_set_back(robot):
    gait = load_gait('trot', load_robot(robot))
    schedule = fine(gait, 400)
    period, rate = gait.cycle_period, gait.pendulum_rate
    # From rest to a mean speed of 1: the distance in this cycle is a quarter of a period's.
    assert gait.acceleration_fraction == pytest.approx(0.25)
    distance = gait.acceleration_fraction * period
    pace = schedule.progress_rate[0] * period
    before = -schedule.progress_rate[0] * distance
    after = pace - schedule.progress_rate[-1] * distance
    body = schedule.progress * distance + before * schedule.entry + after * schedule.exit
    last = schedule.times >= period / 2.0
    assert body[~last] == pytest.approx(np.zeros((~last).sum()), abs=1e-9)
    acceleration = np.gradient(np.gradient(body, schedule.times), schedule.times)
    support = -setback(gait)
    assert setback(gait) > 0.0
    inner = np.flatnonzero(last)[3:-3]
    assert acceleration[inner] == pytest.approx(rate**2 * (body[inner] - support), rel=5e-3)


@each_gait
def test_the_body_sways_only_while_all_feet_are_down(gait):
    schedule = fine(gait, 500)
    assert schedule.sway.shape == (501, 5)
    if not gait.sways:
        assert not schedule.sway.any()
        return
    moving = np.abs(schedule.sway_rate).max(axis=1) > 1e-9
    assert schedule.in_contact[moving].all()
    assert schedule.sway[-1] == pytest.approx(np.ones(5))
    windows = sway_windows(gait)
    assert len(windows) == 5
    for k, (begin, end) in enumerate(windows):
        inside = (schedule.times > begin) & (schedule.times < end)
        assert (schedule.sway_rate[inside, k] > 0.0).all()
        assert not schedule.sway_rate[~inside, k].any()


def test_a_body_on_four_feet_moves_on_evenly():
    schedule = fine(WAVE, 100)
    assert schedule.progress == pytest.approx(schedule.times / WAVE.cycle_period)
    assert schedule.progress_rate == pytest.approx(1.0 / WAVE.cycle_period)


def test_on_two_feet_the_body_moves_as_an_inverted_pendulum_does():
    # x'' = omega^2 x over each pair of feet, from its mid-stance.
    schedule = fine(TROT)
    omega, h = TROT.pendulum_rate, schedule.times[1]
    acceleration = np.diff(schedule.progress_rate) / h
    place = (schedule.progress[1:] + schedule.progress[:-1]) / 2.0
    # The cycle is two supports: they change at its start, its middle and its end.
    first = schedule.times[1:] < TROT.cycle_period / 2.0 - h
    middle = np.where(first, 0.25, 0.75)
    smooth = np.abs(schedule.times[1:] - TROT.cycle_period / 2.0) > 2.0 * h
    expected = omega**2 * (place - middle)
    assert acceleration[smooth] == pytest.approx(expected[smooth], rel=1e-3, abs=1e-3)


def test_a_pendulum_is_slowest_over_its_feet_and_fastest_between_two_supports():
    schedule = fine(TROT, 400)
    rate = schedule.progress_rate * TROT.cycle_period
    quarter = TROT.pendulum_rate * TROT.cycle_period / 4.0
    assert rate[[0, 200, 400]] == pytest.approx(np.full(3, quarter / math.tanh(quarter)))
    assert rate[[100, 300]] == pytest.approx(np.full(2, quarter / math.sinh(quarter)))
    assert rate[0] == rate.max() > 1.0 > rate.min() == pytest.approx(rate[100])


def test_the_ellipse_is_half_an_ellipse_and_begins_and_ends_at_rest():
    schedule = fine(TROT)
    swinging = ~schedule.in_contact[:, 0]
    across = 2.0 * schedule.step[swinging, 0] - 1.0
    up = schedule.lift[swinging, 0] / TROT.swing_height
    assert across**2 + up**2 == pytest.approx(1.0, abs=1e-9)
    ends = np.flatnonzero(swinging)[[0, -1]]
    assert np.abs(schedule.lift_rate[ends, 0]).max() < 0.02 * np.abs(schedule.lift_rate).max()


def test_feet_push_down_as_deep_as_s2s_rho_says_once_in_each_half_of_the_trot():
    schedule = fine(TROT)
    depth = TROT.support_depth * TROT.swing_height
    assert schedule.body_lift.max() == pytest.approx(depth, rel=1e-4)
    half = len(schedule.times) // 2
    for part in (schedule.body_lift[:half], schedule.body_lift[half:]):
        assert part.max() == pytest.approx(depth, rel=1e-4)
    assert not fine(replace(TROT, support_depth=0.0)).body_lift.any()


@pytest.mark.parametrize('period', [0.02, 0.007, 0.3, 7.0])
def test_samples_are_evenly_spaced_no_farther_than_asked(period):
    times = schedule_of(WAVE, period).times
    assert (times[0], times[-1]) == (0.0, WAVE.cycle_period)
    assert np.diff(times) == pytest.approx(np.full(len(times) - 1, times[1]))
    assert times[1] <= period + 1e-9


def test_a_gait_is_sampled_once():
    assert schedule_of(WAVE, 0.02) is schedule_of(WAVE, 0.02)
    assert schedule_of(WAVE, 0.02) is not schedule_of(WAVE, 0.01)
    assert schedule_of(WAVE, 0.02) is not schedule_of(WAVE.mirrored(), 0.02)


def test_a_thinned_schedule_keeps_every_so_many_th_sample():
    schedule = fine(WAVE, 100)
    thin = schedule.thinned(5)
    assert thin.stride == 5
    for curve in ('times', 'in_contact', 'progress', 'sway', 'step', 'lift'):
        assert (getattr(thin, curve) == getattr(schedule, curve)[::5]).all()


def test_a_mirrored_gait_has_mirrored_curves():
    across = [1, 0, 3, 2]
    schedule, mirrored = fine(WAVE, 100), fine(WAVE.mirrored(), 100)
    for curve in ('in_contact', 'step', 'step_rate', 'lift', 'lift_rate'):
        assert (getattr(schedule, curve)[:, across] == getattr(mirrored, curve)).all()
    assert (schedule.progress == mirrored.progress).all()
