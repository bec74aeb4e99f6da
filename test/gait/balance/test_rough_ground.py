"""Feet that meet rough ground before their time stand there, and are lifted as high as it asks."""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import Demand
from quad_gait.balance.foot_laws import STILL
from quad_gait.balance.foot_plan import FootPlanner
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import load_gait
from quad_gait.ground.ground_slope import SlopeEstimator

ROBOT = load_robot('cuhk')
GAIT = load_gait('trot', ROBOT).with_period(0.24)
CLOCK = PhaseClock.of(GAIT)
KNOT = 0.01
BUMP = 0.009


def trotted(cycles, roughness=0.0, roughest=0.0):
    """A trot in place: the planner, and the plan and time after some cycles."""
    planner, plan, time = FootPlanner(ROBOT, GAIT, BalanceOptions()), None, 0.0
    plan = planner.at_rest(ROBOT.neutral_feet)
    for _ in range(round(cycles * GAIT.cycle_period / KNOT)):
        plan = gone_on(planner, plan, time, roughness, roughest)
        time += KNOT
    return planner, plan, time


def gone_on(planner, plan, time, roughness=0.0, roughest=0.0):
    demand = Demand(STILL, STILL, roughness=roughness, roughest=roughest)
    return planner.advance(plan, CLOCK, (time, time + KNOT), demand)


def highest(roughness, roughest=0.0):
    """How high feet are lifted in a cycle after a few."""
    planner, plan, time = trotted(3.0, roughness, roughest)
    heights = []
    for _ in range(round(GAIT.cycle_period / KNOT)):
        plan = gone_on(planner, plan, time, roughness, roughest)
        time += KNOT
        heights.append([foot.z for foot in plan.feet])
    return float(np.max(np.array(heights) - ROBOT.neutral_feet[:, 2]))


def test_feet_are_lifted_higher_by_as_much_as_the_ground_is_rougher_and_no_higher_than_joints_can():
    usual = highest(0.0)
    assert usual == pytest.approx(GAIT.swing_height, rel=0.02)
    assert highest(0.25 * usual) == usual
    gained = highest(0.4 * usual) - highest(0.35 * usual)
    assert gained == pytest.approx(4.0 * 0.05 * usual, rel=0.05)
    assert highest(1.0) == highest(2.0) < 2.5 * usual
    # Of what was rough a while ago, too.
    assert highest(0.0, 0.4 * usual) == highest(0.4 * usual)


def coming_down(contacts, roughness=0.0):
    """A trot in which feet are measured to bear while one diagonal is late in its swing."""
    planner, plan, time = trotted(3.0)
    while not any(f > 0.7 for f, _ in CLOCK.swing_phases(time)):
        plan, time = gone_on(planner, plan, time), time + KNOT
    body = BodyEstimate((0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0, roughness=roughness, contacts=contacts)
    return planner, plan, planner.met(plan, CLOCK, time, body), time


def test_a_foot_that_meets_the_ground_before_its_time_stands_where_it_is():
    planner, before, plan, time = coming_down((True,) * 4)
    early = [k for k, foot in enumerate(before.feet) if foot.swings]
    assert len(early) == 2
    height = [plan.feet[k].z for k in early]
    lower = before
    for _ in range(2):
        plan, lower = gone_on(planner, plan, time), gone_on(planner, lower, time)
        time += KNOT
    for k, z in zip(early, height):
        assert not plan.feet[k].swings
        # The body settles; a foot that swings comes down.
        assert abs(plan.feet[k].z - z) < 0.5 * abs(lower.feet[k].z - z)


def test_what_stands_on_a_bump_stays_above_the_others_until_it_swings_again():
    planner, before, _, time = coming_down((False,) * 4)
    k = next(k for k, foot in enumerate(before.feet) if not foot.swings)
    bumped = before.feet[k]._replace(rise=BUMP, z=before.feet[k].z + BUMP)
    plan = before.with_feet((*before.feet[:k], bumped, *before.feet[k + 1 :]))
    other = next(i for i, foot in enumerate(before.feet) if i != k and not foot.swings)
    for _ in range(3):
        plan, time = gone_on(planner, plan, time, BUMP), time + KNOT
    assert plan.feet[k].z - plan.feet[other].z == pytest.approx(BUMP, abs=1e-9)
    # The body goes up by half of it, as a whole.
    assert plan.feet[k].rise < BUMP
    for _ in range(round(GAIT.cycle_period / KNOT)):
        plan, time = gone_on(planner, plan, time, BUMP), time + KNOT
    assert plan.feet[k].rise == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize('contacts', [None, (False,) * 4])
def test_feet_swing_on_where_nothing_is_felt(contacts):
    _, before, plan, _ = coming_down(contacts)
    assert plan.feet == before.feet


def test_feet_that_stand_off_their_plane_tell_how_rough_the_ground_is_for_a_while():
    estimator = SlopeEstimator(0.3, 1.0)
    feet = ROBOT.neutral_feet.copy()
    for k in range(60):
        estimator.update(0.02, 0.0, feet[[[0, 3], [1, 2]][k // 6 % 2]])
    assert estimator.roughness < 1e-6
    feet[0, 2] += BUMP
    estimator.update(0.02, 0.0, feet[[0, 3]])
    assert estimator.roughness == pytest.approx(BUMP)
    for _ in range(200):
        estimator.update(0.02, 0.0, np.empty((0, 3)))
    assert estimator.roughness < 0.1 * BUMP
    # Between bumps there is level ground: for those feet are lifted longer.
    assert estimator.roughest > 0.5 * BUMP


def test_a_slope_on_which_it_begins_is_not_taken_for_rough_ground():
    estimator = SlopeEstimator(0.3, 1.0)
    feet = ROBOT.neutral_feet.copy()
    feet[:, 2] += 0.25 * feet[:, 0]
    estimator.update(0.0, 0.0, feet)
    for k in range(60):
        estimator.update(0.02, 0.0, feet[[[0, 3], [1, 2]][k // 6 % 2]])
    assert estimator.roughest < 0.1 * BUMP
