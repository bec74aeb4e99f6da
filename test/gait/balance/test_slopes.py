"""The ground's gradient is found by the feet, and feet and body go along with it."""

import math

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import matrix_from_angles
from quad_gait.balance.balance_options import BalanceOptions, EstimateOptions
from quad_gait.balance.balanced_motion import BalancedMotion
from quad_gait.balance.body_estimate import BodyEstimate, BodyEstimator, BodyReading
from quad_gait.balance.feet import Demand
from quad_gait.balance.foot_laws import STILL, Pace
from quad_gait.balance.foot_plan import FootPlanner
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import load_gait
from quad_gait.ground.ground_slope import LEVEL, Slope, SlopeEstimator

ROBOT = load_robot('cuhk')
GAIT = load_gait('trot', ROBOT).with_period(0.25)
DIAGONALS = [0, 3], [1, 2]
STEEP = 0.22, -0.13
KNOT = 0.02


def feet_on(ahead, aside):
    """Feet of a robot on a plane, in level axes, shape (4, 3)."""
    feet = ROBOT.neutral_feet.copy()
    feet[:, 2] = feet[:, :2] @ [ahead, aside] - 0.08
    return feet


def gradient_by(estimator):
    return estimator.slope.ahead, estimator.slope.aside


def test_two_diagonals_in_turn_tell_the_gradient():
    estimator = SlopeEstimator(0.3, 1.0)
    for k in range(60):
        estimator.update(KNOT, 0.0, feet_on(*STEEP)[DIAGONALS[k // 6 % 2]])
    assert gradient_by(estimator) == pytest.approx(STEEP, abs=1e-3)


def test_one_diagonal_tells_of_its_own_line_only():
    estimator = SlopeEstimator(0.3, 1.0)
    feet = feet_on(*STEEP)[DIAGONALS[0]]
    for _ in range(60):
        estimator.update(KNOT, 0.0, feet)
    line = feet[1] - feet[0]
    found = np.array(gradient_by(estimator))
    assert found @ line[:2] == pytest.approx(line[2], rel=1e-3)
    assert found @ [-line[1], line[0]] == pytest.approx(0.0, abs=1e-6)


def test_what_is_known_of_the_ground_stays_where_it_is_while_the_robot_turns():
    estimator = SlopeEstimator(0.3, 1.0)
    estimator.update(0.0, 0.0, feet_on(*STEEP))
    for _ in range(10):
        estimator.update(KNOT, math.pi / 20.0, np.empty((0, 3)))
    assert gradient_by(estimator) == pytest.approx((STEEP[1], -STEEP[0]), abs=2e-3)


def test_ground_that_changes_is_followed_within_the_memory():
    estimator = SlopeEstimator(0.3, 1.0)
    for k in range(200):
        ground = STEEP if k < 100 else (0.0, 0.2)
        estimator.update(KNOT, 0.0, feet_on(*ground)[DIAGONALS[k // 6 % 2]])
    assert gradient_by(estimator) == pytest.approx((0.0, 0.2), abs=0.01)


@pytest.mark.parametrize('gradient', [(0.0, 0.0), (0.03, -0.02), (-0.02, 0.03)])
def test_ground_that_is_almost_level_is_level(gradient):
    estimator = SlopeEstimator(0.3, 1.0)
    estimator.update(0.0, 0.0, feet_on(*gradient))
    assert estimator.slope == LEVEL


def test_no_wall_is_believed():
    estimator = SlopeEstimator(0.3, 1.0)
    estimator.update(0.0, 0.0, feet_on(3.0, 0.0))
    assert estimator.slope.ahead < 0.5


@pytest.mark.parametrize('gradient', [STEEP, (-0.3, 0.0), (0.0, 0.25), (0.1, 0.1)])
def test_a_body_that_goes_along_stands_upright_on_the_plane(gradient):
    slope = Slope.along(*gradient, 1.0)
    up = matrix_from_angles(np.array([slope.roll, slope.pitch, 0.0]))[:, 2]
    assert up == pytest.approx(slope.normal)
    assert Slope.along(*gradient, 0.0)[2:] == pytest.approx((0.0, 0.0))


@pytest.mark.parametrize('fraction', [0.0, 0.5, 1.0])
def test_standing_feet_lie_on_the_plane_and_on_average_below_the_center_of_mass(fraction):
    slope = Slope.along(*STEEP, fraction)
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    clock, plan = PhaseClock.of(GAIT, 0.0), planner.at_rest(ROBOT.neutral_feet)
    demand = Demand(STILL, STILL, slope=slope)
    for k in range(100):
        plan = planner.advance(plan, clock, (k * KNOT, (k + 1) * KNOT), demand)
    rotation = matrix_from_angles(np.array([slope.roll, slope.pitch, 0.0]))
    feet = np.array([foot.in_body for foot in plan.feet]) @ rotation.T
    contacts = feet - ROBOT.foot_radius * np.array(slope.normal)
    stands = np.array([not foot.swings for foot in plan.feet])
    heights = feet[stands] @ slope.normal
    assert np.ptp(heights) < 2e-4
    assert feet[~stands] @ slope.normal > heights.max() if (~stands).any() else True
    center = rotation @ ROBOT.center_of_mass(ROBOT.initial_joint_angles)
    level = ROBOT.neutral_feet[:, :2].mean(axis=0)
    offset = level - ROBOT.center_of_mass(ROBOT.initial_joint_angles)[:2]
    assert contacts[:, :2].mean(axis=0) == pytest.approx(center[:2] + offset, abs=2e-3)


def test_no_standing_foot_jumps_when_the_ground_turns_out_to_be_another():
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    clock, plan = PhaseClock.of(GAIT, 0.0), planner.at_rest(ROBOT.neutral_feet)
    pace, rng, slope = Pace(0.1, 0.0, 0.0), np.random.default_rng(5), LEVEL
    largest = 0.0
    for k in range(200):
        if k % 20 == 0:
            slope = Slope.along(*rng.uniform(-0.3, 0.3, 2), 1.0)
        before = plan
        times = (k * KNOT, (k + 1) * KNOT)
        plan = planner.advance(plan, clock, times, Demand(pace, pace, slope=slope))
        for old, new in zip(before.feet, plan.feet):
            if not (old.swings or new.swings):
                step = np.subtract(new.in_body, old.in_body)
                largest = max(largest, float(np.abs(step).max()))
    # The ground itself has jumped by 20 mm and more under feet that are 0.11 m ahead.
    assert 0.002 < largest < 0.016


def test_a_robot_leans_uphill_before_its_first_step_and_stands_as_it_stood_at_first():
    slope = Slope.along(0.25, 0.0, 1.0)
    body = BodyEstimate((0.0, 0.0), 0.0, 0.0, slope.pitch, 0.0, 0.0, slope)
    options = BalanceOptions()
    joints = ROBOT.initial_joint_angles
    motion = BalancedMotion(ROBOT, GAIT, options, 1.0, joints, body)
    trajectory = motion.update(1.0, body, Pace(0.1, 0.0, 0.0))
    assert trajectory is not None
    assert trajectory.positions[0] == pytest.approx(joints.reshape(-1))
    assert motion.clock.start > 1.0 + 4.0 * options.leaning_time
    assert motion.is_leaning(1.2)
    feet = ROBOT.foot_positions(trajectory.positions.reshape(-1, 4, 3))
    before = trajectory.times < 4.0 * options.leaning_time
    # All feet go backward beside the body, together: none slides.
    shifts = feet[before] - feet[0]
    assert (np.diff(shifts[:, :, 0], axis=0) <= 1e-9).all()
    assert np.ptp(shifts[-1, :, 0]) < 2e-3
    assert shifts[-1, :, 0].mean() < -0.015


def test_level_ground_is_walked_as_if_no_slope_were_known():
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    still = BodyEstimate((0.0, 0.0), 0.0, 0.05, 0.02, 0.0, 0.0)
    plain = BalancedMotion(ROBOT, GAIT, BalanceOptions(), 1.0, ROBOT.initial_joint_angles)
    told = BalancedMotion(ROBOT, GAIT, BalanceOptions(), 1.0, ROBOT.initial_joint_angles, still)
    assert plain.clock == told.clock
    assert planner.at_rest(ROBOT.neutral_feet, LEVEL).feet[0].rise == 0.0
    assert not told.is_leaning(1.0)


def test_feet_of_a_robot_that_is_pushed_tell_nothing_of_the_ground():
    tilted = np.array([0.0, math.sin(0.1), 0.0, math.cos(0.1)])
    stands, still = np.ones(4, dtype=bool), np.zeros(3)
    found = {}
    for tells in (True, False):
        estimator = BodyEstimator(ROBOT, EstimateOptions())
        joints, speeds = ROBOT.initial_joint_angles, np.zeros((4, 3))
        reading = BodyReading(1.0, joints, speeds, None, tilted, still, None, stands, tells)
        found[tells] = estimator.update(reading).slope
    assert found[False] == LEVEL
    assert found[True].pitch == pytest.approx(0.2, abs=2e-3)
