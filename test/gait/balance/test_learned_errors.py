"""What stays, or comes back in every cycle, is learned; what a push does is not."""

import math
from dataclasses import replace

import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import Demand
from quad_gait.balance.foot_laws import STILL, sway_velocity
from quad_gait.balance.foot_plan import FootPlanner
from quad_gait.balance.learned_errors import LearnedErrors
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import load_gait

ROBOT = load_robot('cuhk')
GAIT = load_gait('trot', ROBOT).with_period(0.25)
CALM = BodyEstimate((0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0)
OPTIONS = BalanceOptions()
PHASES = [0.08 * k for k in range(1500)]


def after_swaying(velocity):
    """Learn from a body that sways to the left with a velocity that depends on the phase."""
    learned = LearnedErrors(OPTIONS, unit=1.4)
    for phase in PHASES:
        learned.learn(replace(CALM, velocity=(0.0, velocity(phase))), STILL, STILL, STILL, phase)
    return learned


def test_the_sway_of_each_cycle_is_learned_with_its_phase():
    learned = after_swaying(lambda phase: 0.05 * math.sin(2.0 * math.pi * phase + 0.7))
    # What fades leaves a part of it.
    part = OPTIONS.sway_gain / (OPTIONS.sway_gain + OPTIONS.sway_fading)
    for phase in (0.0, 0.2, 0.55):
        known = sway_velocity(phase, learned.sway)
        assert known == pytest.approx(
            part * 0.05 * math.sin(2.0 * math.pi * phase + 0.7), abs=0.004
        )


def test_what_does_not_come_back_in_every_cycle_is_no_sway():
    learned = after_swaying(lambda phase: 0.05 * math.cos(2.0 * math.pi * 1.37 * phase))
    assert max(abs(sway_velocity(phase, learned.sway)) for phase in PHASES[:12]) < 0.005


def test_a_push_is_no_sway():
    assert after_swaying(lambda phase: 0.6).sway == (0.0, 0.0)


def test_standing_feet_go_with_a_body_that_sways_and_swinging_ones_land_where_they_would():
    planner, clock = FootPlanner(ROBOT, GAIT, OPTIONS), PhaseClock.of(GAIT, 0.0)
    plan, times = planner.at_rest(ROBOT.neutral_feet), [0.01 * k for k in range(26)]
    calm, swaying = (
        planner.march(plan, clock, times, Demand(STILL, STILL, sway=sway)).plans()[-1]
        for sway in ((0.0, 0.0), (0.0, 0.05))
    )
    # Feet 1 and 2 stand in the first half of the cycle, in which the sine is positive.
    half = planner.march(plan, clock, times[:13], Demand(STILL, STILL, sway=(0.0, 0.05))).plans()
    assert half[-1].feet[1].y - ROBOT.neutral_feet[1, 1] == pytest.approx(
        -0.05 * 0.25 / math.pi, rel=0.1
    )
    for foot, other in zip(calm.feet, swaying.feet, strict=True):
        assert foot.target_y == pytest.approx(other.target_y)


def test_a_sway_that_was_known_is_no_error():
    planner, clock = FootPlanner(ROBOT, GAIT, OPTIONS), PhaseClock.of(GAIT, 0.0)
    plan, times = planner.at_rest(ROBOT.neutral_feet), [0.1, 0.11]
    sways = STILL._replace(left=0.05)
    known = planner.march(plan, clock, times, Demand(STILL, sways, swaying=0.05)).plans()[-1]
    unknown = planner.march(plan, clock, times, Demand(STILL, sways)).plans()[-1]
    neutral = ROBOT.neutral_feet[1, 1]
    assert known.feet[1].y == pytest.approx(neutral, abs=1e-9)
    assert unknown.feet[1].y - neutral == pytest.approx(-0.8 * 0.05 * 0.01, rel=0.1)
