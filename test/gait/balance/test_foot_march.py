"""The march of feet over knots is the same compiled or not, in one go or knot by knot."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance import foot_march, foot_plan, joint_motion
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.balanced_motion import BalancedMotion
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import FOOT, Demand, Foot
from quad_gait.balance.foot_laws import STILL, Pace
from quad_gait.balance.foot_plan import FootPlanner
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.balance.steady_trot import SteadyTrot
from quad_gait.behaviours.gait_choice import balanced_gait
from quad_gait.cycle.gait import load_gait
from quad_gait.ground.ground_slope import LEVEL, Slope

ROBOT = load_robot('cuhk')
OPTIONS = BalanceOptions()
GAIT = balanced_gait(load_gait('trot', ROBOT), OPTIONS)
TIMES = [0.017 * k for k in range(41)]
SLOPE = Slope.along(0.2, -0.1, 1.0)
DEMANDS = {
    'pushed': Demand(Pace(0.1, 0.0, 0.2), Pace(0.3, -0.2, 0.5), 0.05, -0.03, trim=(0.01, 0.02)),
    'on a slope': Demand(Pace(0.1, 0.0, 0.2), Pace(0.1, 0.02, 0.0), slope=SLOPE),
    'on rough ground': Demand(Pace(0.1, 0.0, 0.2), STILL, roughness=0.02),
    'coming to rest': Demand(STILL, STILL, trim=(0.01, 0.0), lead=0.05),
}


def marched(demand, end=math.inf):
    planner = FootPlanner(ROBOT, GAIT, OPTIONS)
    clock = PhaseClock.of(GAIT, 0.05)._replace(end=end)
    plan = planner.at_rest(ROBOT.neutral_feet)._replace(pace=Pace(0.1, 0.05, 0.1))
    return planner, clock, plan, planner.march(plan, clock, TIMES, demand)


@pytest.mark.parametrize('demand', DEMANDS.values(), ids=list(DEMANDS))
def test_compiled_feet_march_as_uncompiled_ones(demand, monkeypatch):
    compiled = marched(demand, end=0.5)[-1]
    monkeypatch.setattr(foot_plan, 'march', foot_march.march.py_func)
    plain = marched(demand, end=0.5)[-1]
    for name in FOOT.names:
        np.testing.assert_allclose(compiled.feet[name], plain.feet[name], atol=1e-12)
    np.testing.assert_allclose(compiled.places[1:], plain.places[1:], atol=1e-12)
    np.testing.assert_allclose(compiled.paces, plain.paces, atol=1e-12)
    assert np.ptp(compiled.feet['z'][:, 0]) > 0.005


@pytest.mark.parametrize('demand', DEMANDS.values(), ids=list(DEMANDS))
def test_a_march_is_the_same_in_one_go_and_knot_by_knot(demand):
    planner, clock, plan, march = marched(demand)
    for k, times in enumerate(pairwise(TIMES)):
        plan = planner.advance(plan, clock, times, demand)
        assert plan.pace == march.at(k + 1).pace
        assert plan.feet == march.at(k + 1).feet
        assert [foot.in_body for foot in plan.feet] == [
            tuple(place) for place in march.places[k + 1].tolist()
        ]


@pytest.mark.parametrize(('tilt', 'part'), [(0.02, 0.8), (0.1125, 0.76), (0.3, 0.72)])
def test_swinging_feet_make_up_for_less_of_a_tilt_that_is_large(tilt, part):
    demand = Demand(STILL, STILL, roll=0.6 * tilt, pitch=-0.8 * tilt)
    feet = marched(demand)[-1].feet
    swinging = feet[feet['swings'] == 1.0]
    assert len(swinging) > 20
    assert swinging['roll'] == pytest.approx(part * 0.6 * tilt)
    assert swinging['pitch'] == pytest.approx(part * -0.8 * tilt)


def test_feet_that_are_lifted_low_make_up_for_more():
    robot = load_robot('genibo')
    gait = balanced_gait(load_gait('trot', robot), OPTIONS)
    planner = FootPlanner(robot, gait, OPTIONS)
    plan, clock = planner.at_rest(robot.neutral_feet), PhaseClock.of(gait, 0.05)
    feet = planner.march(plan, clock, TIMES, Demand(STILL, STILL, roll=0.4)).feet
    lift = feet['lift'].max() / (OPTIONS.low_lift * planner.height)
    assert 0.4 < lift < 0.7
    part = OPTIONS.large_tilt_leveling + OPTIONS.low_leveling * (1.0 - lift)
    assert feet[feet['swings'] == 1.0]['roll'] == pytest.approx(part * 0.4)


def test_feet_make_up_for_less_of_a_tilt_where_answers_are_late():
    def rolls(leveling):
        planner = FootPlanner(ROBOT, GAIT, OPTIONS)
        plan, clock = planner.at_rest(ROBOT.neutral_feet), PhaseClock.of(GAIT, 0.05)
        demand = Demand(STILL, STILL, roll=0.1, leveling=leveling)
        feet = planner.march(plan, clock, TIMES, demand).feet
        return feet[feet['swings'] == 1.0]['roll']

    assert rolls(0.6) == pytest.approx(0.6 * rolls(1.0))
    assert (rolls(1.0) > 0.05).all()


def test_the_capture_step_is_shorter_where_answers_are_late():
    def landing(measured, capturing):
        planner = FootPlanner(ROBOT, GAIT, OPTIONS)
        plan, clock = planner.at_rest(ROBOT.neutral_feet), PhaseClock.of(GAIT, 0.05)
        demand = Demand(STILL, measured, capturing=capturing)
        feet = planner.march(plan, clock, TIMES, demand).feet
        return feet[feet['swings'] == 1.0]['target_y']

    pushed, still = Pace(0.0, 0.1, 0.0), landing(STILL, 1.0)
    none, whole, part = (landing(pushed, k) - still for k in (0.0, 1.0, 0.85))
    assert (whole - none > 0.005).all()
    assert part - none == pytest.approx(0.85 * (whole - none))


def test_records_hold_what_a_foot_is():
    assert FOOT.names == Foot._fields
    foot = Foot(*range(13))
    plan = FootPlanner(ROBOT, GAIT, OPTIONS).at_rest(ROBOT.neutral_feet, LEVEL)
    assert plan.with_feet([foot] * 4).feet == (foot,) * 4


def test_no_decision_waits_for_code_to_be_compiled():
    # It is made with the controller; in a process of its own it is the first to need the code.
    SteadyTrot(ROBOT, GAIT, OPTIONS)
    loops = (foot_march.march, joint_motion.keep_up)
    ready = [set(loop.signatures) for loop in loops]
    assert all(ready)
    body = BodyEstimate((0.1, 0.0), 0.2, 0.01, 0.0, 0.1, 0.0)
    tilted = BodyEstimate((0.1, 0.0), 0.2, 0.01, 0.0, 0.1, 0.0, SLOPE, 0.02, (True,) * 4)
    pushed = replace(body, velocity=(0.1, 0.9), roll=-0.3)
    for start in (body, tilted, pushed):
        motion = BalancedMotion(ROBOT, GAIT, OPTIONS, 1.0, ROBOT.initial_joint_angles, start)
        for k in range(20):
            motion.update(1.0 + 0.02 * k, start, Pace(0.1, 0.0, 0.0))
        motion.rest(1.4)
        motion.update(1.4, start, STILL)
    assert [set(loop.signatures) for loop in loops] == ready
