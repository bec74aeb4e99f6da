"""What is given out goes on with what runs, keeps the limits, and ends on four feet."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_gait.balance.balance_options import BalanceOptions, EstimateOptions
from quad_gait.balance.balanced_motion import BalancedMotion
from quad_gait.balance.body_estimate import BodyEstimate, BodyEstimator, BodyReading, leg_velocity
from quad_gait.balance.feet import Demand
from quad_gait.balance.foot_laws import GRAVITY, Pace
from quad_gait.balance.foot_plan import FootPlanner
from quad_gait.balance.joint_motion import smooth_speeds
from quad_gait.balance.leg_rates import lift_height, rolling_factors, swing_use
from quad_gait.balance.phase_clock import PhaseClock, pendulum_factor
from quad_gait.behaviours.gait_choice import balanced_gait
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits

ROBOT = load_robot('cuhk')
GAIT = load_gait('trot', ROBOT).with_period(0.25)
POSTURE = ROBOT.initial_joint_angles
STILL = BodyEstimate((0.0, 0.0), 0.0, 0.0, 0.0, 0.0, 0.0)
RNG = np.random.default_rng(19)
NONE = np.zeros(3)
AHEAD = Pace(0.2, 0.0, 0.0)


def motion_with(**options):
    return BalancedMotion(ROBOT, GAIT, BalanceOptions(**options), 1.0, POSTURE)


def pushed(rng):
    """How a body moves that somebody shoves about."""
    vx, vy, turn, roll, pitch, p, q = rng.normal(0.0, 1.0, 7) * [0.4, 0.4, 1.0, 0.1, 0.1, 1.0, 1.0]
    return BodyEstimate((vx, vy), turn, roll, pitch, p, q)


def updates(motion, bodies, pace=AHEAD):
    """Answer to measurements; return the trajectories, with their times."""
    given = [(1.0 + 0.02 * k, motion.update(1.0 + 0.02 * k, b, pace)) for k, b in enumerate(bodies)]
    return [(time, trajectory) for time, trajectory in given if trajectory is not None]


def test_every_trajectory_goes_on_with_the_one_before():
    limits = JointLimits.of(ROBOT)
    executor = TrajectoryExecutor(ROBOT.joint_names, POSTURE.reshape(-1), limits)
    rng = np.random.default_rng(1)
    for time, trajectory in updates(motion_with(), [pushed(rng) for _ in range(60)]):
        for late in (0.0, 0.013):
            before = executor.command(time + late)
            if late:
                assert executor.accept(trajectory, time + late)
            after = executor.command(time + late)
            assert np.allclose(after[0], before[0], atol=1e-6)
            assert np.allclose(after[1], before[1], atol=1e-4)


def test_joints_keep_their_limits_however_the_body_is_shoved():
    limits, rng = JointLimits.of(ROBOT), np.random.default_rng(2)
    given = updates(motion_with(), [pushed(rng) for _ in range(100)])
    assert len(given) > 80
    for _, trajectory in given:
        limits.check(trajectory.times, trajectory.positions, trajectory.velocities)


def test_every_trajectory_ends_at_rest_with_all_feet_down():
    rng = np.random.default_rng(3)
    ground = ROBOT.neutral_feet[:, 2].mean()
    for _, trajectory in updates(motion_with(), [STILL] * 10 + [pushed(rng) for _ in range(20)]):
        assert not trajectory.velocities[-1].any()
        feet = ROBOT.foot_positions(trajectory.positions[-1].reshape(4, 3))
        assert np.ptp(feet[:, 2]) < 0.25 * ROBOT.hip_height
    trajectory = updates(motion_with(), [STILL] * 20, Pace(0.0, 0.0, 0.0))[-1][1]
    feet = ROBOT.foot_positions(trajectory.positions[-1].reshape(4, 3))
    assert np.allclose(feet[:, 2], ground, atol=1e-6)
    assert np.allclose(feet, ROBOT.neutral_feet, atol=1e-3)


def test_what_holds_is_not_changed_by_what_is_measured():
    calm, shoved = motion_with(), motion_with()
    bodies = [STILL] * 12
    first = updates(calm, bodies)[-1]
    other = updates(shoved, [*bodies[:-1], pushed(np.random.default_rng(4))])[-1]
    time = np.array([first[0] + 0.02])
    assert np.allclose(first[1].positions_at(time), other[1].positions_at(time))
    assert not np.allclose(first[1].positions[-1], other[1].positions[-1], atol=1e-3)


def test_nothing_follows_what_was_not_answered_to_in_time():
    motion = motion_with()
    updates(motion, [STILL] * 5)
    assert motion.is_over(1.0 + 0.02 * 30)
    assert motion.update(1.0 + 0.02 * 30, STILL, Pace(0.0, 0.0, 0.0)) is None


def test_legs_are_set_against_the_tilt_that_a_body_has_in_the_mean():
    motion, leaning = motion_with(), replace(STILL, roll=0.02, pitch=-0.01)
    updates(motion, [leaning] * 26, Pace(0.0, 0.0, 0.0))
    assert motion.learned.upright == pytest.approx(
        (-0.2 * 26 * 0.02 * 0.02, 0.2 * 26 * 0.02 * 0.01)
    )
    motion = motion_with()
    updates(motion, [replace(STILL, roll=0.5)] * 26, Pace(0.0, 0.0, 0.0))
    assert motion.learned.upright[0] == -BalanceOptions().largest_upright


def test_a_push_does_not_count_as_a_tilt_in_the_mean():
    motion = motion_with()
    shoved = replace(STILL, velocity=(0.0, 0.5), roll=0.2)
    updates(motion, [shoved] * 20, Pace(0.0, 0.0, 0.0))
    assert motion.learned.upright == (0.0, 0.0)


def test_legs_that_are_set_against_a_tilt_stand_on_a_plane_that_is_tilted_so():
    still = Pace(0.0, 0.0, 0.0)
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    clock = PhaseClock.of(GAIT, 10.0)
    plan = planner.at_rest(ROBOT.neutral_feet)
    times = [0.02 * k for k in range(60)]
    demand = Demand(still, still, upright=(0.02, -0.03))
    feet = planner.march(plan, clock, times, demand).places[-1]
    x, y, z = (feet - feet.mean(axis=0)).T
    slopes = np.linalg.lstsq(np.column_stack([x, y]), z, rcond=None)[0]
    assert slopes == pytest.approx((-0.03, -0.02), abs=1e-3)


def test_no_foot_lifts_after_the_end():
    clock = PhaseClock.of(GAIT, 1.0)._replace(end=2.0)
    assert all(clock.in_stance(t).all() for t in np.arange(2.0 + clock.longest_swing, 4.0, 0.01))
    assert not all(clock.in_stance(t).all() for t in np.arange(1.0, 2.0, 0.01))


def test_each_foot_stands_for_its_part_of_a_cycle():
    clock = PhaseClock.of(GAIT, 0.0)
    times = np.linspace(10 * GAIT.cycle_period, 12 * GAIT.cycle_period, 4000, endpoint=False)
    stands = np.mean([clock.in_stance(t) for t in times], axis=0)
    assert stands == pytest.approx(
        [GAIT.duty_factor(leg) for leg in ('lf', 'rf', 'lh', 'rh')], abs=2e-3
    )


def test_a_body_moves_over_two_feet_as_a_pendulum_and_as_far_as_at_its_mean_speed():
    clock, rate = PhaseClock.of(GAIT, 0.0), 9.0
    times = np.linspace(0.0, GAIT.cycle_period / 2.0, 2001)[1:-1]
    speeds = np.array([pendulum_factor(clock, t, rate) for t in times])
    assert np.mean(speeds) == pytest.approx(1.0, abs=1e-3)
    # From mid-stance on x'' = rate^2 x, so v'' = rate^2 v too.
    dt = times[1] - times[0]
    assert np.diff(speeds, 2) / dt**2 == pytest.approx(rate**2 * speeds[1:-1], rel=1e-3)
    assert pendulum_factor(clock, -1.0, rate) == 1.0


def test_on_a_curve_feet_land_outside_it_by_what_gives_the_acceleration_that_it_needs():
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    clock, landed = PhaseClock.of(GAIT, 0.0), []
    for pace in (Pace(0.15, 0.05, 0.6), Pace(0.15, 0.05, 0.0)):
        plan, demand = planner.at_rest(ROBOT.neutral_feet), Demand(pace, pace)
        stood = []
        for k in range(round(20 * GAIT.cycle_period / 0.01)):
            plan = planner.advance(plan, clock, (0.01 * k, 0.01 * (k + 1)), demand)
            if k * 0.01 > 10 * GAIT.cycle_period:
                stood.append(np.mean([(f.x, f.y) for f in plan.feet if not f.swings], axis=0))
        landed.append(np.mean(stood, axis=0))
    pull = -(GAIT.pendulum_rate**2) * (landed[0] - landed[1])
    # The stance's own arc bends their mean by a little more.
    assert pull == pytest.approx([-0.6 * 0.05, 0.6 * 0.15], abs=0.03)


@pytest.mark.parametrize('knot_time', [0.017, 0.013])
def test_feet_stand_as_far_ahead_of_their_place_as_behind_it_whatever_the_knots(knot_time):
    planner = FootPlanner(ROBOT, GAIT, BalanceOptions())
    clock, pace = PhaseClock.of(GAIT, 0.0), Pace(0.15, 0.0, 0.0)
    plan, demand = planner.at_rest(ROBOT.neutral_feet), Demand(pace, pace)
    stood = []
    for k in range(round(40 * GAIT.cycle_period / knot_time)):
        plan = planner.advance(plan, clock, (k * knot_time, (k + 1) * knot_time), demand)
        if k * knot_time > 5 * GAIT.cycle_period:
            stood += [
                foot.x - neutral[0]
                for foot, neutral in zip(plan.feet, ROBOT.neutral_feet)
                if not foot.swings
            ]
    # Half a knot's time off, as it would be with feet that lift and land at knots, is 1.5 mm.
    assert np.mean(stood) == pytest.approx(0.0, abs=1e-3)
    half = 0.15 * clock.stance_times[0] / 2.0
    assert max(stood) == pytest.approx(half, rel=0.2)
    assert min(stood) == pytest.approx(-half, rel=0.2)


def test_parabolas_are_differentiated_exactly_whatever_the_spacing():
    times = np.cumsum(RNG.uniform(0.01, 0.05, 12))
    a, b = RNG.normal(size=(2, 4, 3))
    positions = a * times[:, None, None] ** 2 + b
    assert np.allclose(smooth_speeds(times, positions)[1:-1], (2 * a * times[:, None, None])[1:-1])


# The estimate


def rolling(velocity, rates=NONE):
    """Joint speeds with which feet stand while the body moves, for a level body."""
    joints = POSTURE
    speeds = np.zeros((4, 3))
    for _ in range(20):
        calves = ROBOT.calf_angular_velocities(joints, speeds) + rates
        feet = ROBOT.foot_positions(joints)
        wanted = (
            ROBOT.foot_radius * np.cross(calves, [0.0, 0.0, 1.0]) - np.cross(rates, feet) - velocity
        )
        speeds = np.linalg.solve(ROBOT.foot_jacobians(joints), wanted[..., None])[..., 0]
    return speeds


def reading(time, speeds, rates=NONE, force=None, **changes):
    level = np.array([0.0, 0.0, 0.0, 1.0])
    stands = np.ones(4, dtype=bool)
    return replace(BodyReading(time, POSTURE, speeds, None, level, rates, force, stands), **changes)


def test_feet_that_roll_on_the_ground_tell_the_velocity():
    velocity, rates = np.array([0.3, -0.1, 0.0]), np.array([0.2, -0.3, 0.5])
    now = reading(1.0, rolling(velocity, rates), rates)
    assert leg_velocity(ROBOT, now, np.eye(3), np.ones(4)) == pytest.approx([0.3, -0.1])


def test_feet_that_follow_the_rolling_factors_move_the_body_as_it_is_to_move():
    velocity = np.array([0.3, -0.1])
    moves = np.array([[*(np.array(factor) @ -velocity), 0.0] for factor in rolling_factors(ROBOT)])
    speeds = np.linalg.solve(ROBOT.foot_jacobians(POSTURE), moves[..., None])[..., 0]
    found = leg_velocity(ROBOT, reading(1.0, speeds), np.eye(3), np.ones(4))
    assert found == pytest.approx(velocity)


def test_joints_need_twice_as_much_of_their_speed_for_a_swing_in_half_the_time():
    faster = GAIT.with_period(GAIT.cycle_period / 2.0)
    use = [swing_use(ROBOT, gait, GAIT.swing_height) for gait in (GAIT, faster)]
    assert use[1] == pytest.approx(2.0 * use[0])


def fastest_use(robot, gait, planner, speed):
    """Fraction of their largest speeds that joints need in a steady trot at a speed [m/s]."""
    clock, plan, joints = PhaseClock.of(gait), planner.at_rest(robot.neutral_feet), []
    count = round(2.0 * gait.cycle_period / 0.02)
    for k in range(2 * count):
        factor = pendulum_factor(clock, 0.02 * (k + 0.5), math.sqrt(GRAVITY / planner.height))
        demand = Demand(Pace(speed, 0.0, 0.0), Pace(factor * speed, 0.0, 0.0))
        plan = planner.advance(plan, clock, (0.02 * k, 0.02 * (k + 1)), demand)
        joints.append([foot.in_body for foot in plan.feet])
    angles = robot.stacked_legs.inverse(np.array(joints[count:]))
    return float((np.abs(np.diff(angles, axis=0)) / (0.02 * robot.velocity)).max())


@pytest.mark.parametrize('name', ['titan_viii', 'genibo', 'cuhk', 'pukyong'])
def test_a_trot_at_full_speed_leaves_joints_a_third_of_their_speeds(name):
    # TITAN-VIII's needed 0.91 of them, and GENIBO's 0.83.
    robot, options = load_robot(name), BalanceOptions()
    gait = balanced_gait(load_gait('trot', robot), options)
    limits = MotionLimits(robot, gait, 0.005)
    most = limits.largest_scale(BodyMotion(forward=1.0)) / gait.cycle_period
    planner = FootPlanner(robot, gait, options)
    for speed in (0.0, most):
        assert fastest_use(robot, gait, planner, speed) < 0.68


def test_feet_are_lifted_lower_by_joints_that_are_slower():
    slower = replace(ROBOT, velocity=ROBOT.velocity / 3.0)
    most = lift_height(ROBOT, GAIT, 0.1, 0.45)
    assert lift_height(slower, GAIT, 0.1, 0.45) == pytest.approx(most / 3.0)
    assert lift_height(ROBOT, GAIT.with_period(0.5), 0.1, 0.45) == pytest.approx(2.0 * most)


def test_an_estimate_comes_to_what_feet_and_accelerometer_agree_on():
    estimator = BodyEstimator(ROBOT, EstimateOptions())
    up = np.array([0.0, 0.0, 9.80665])
    speeds = rolling(np.array([0.2, 0.0, 0.0]))
    for k in range(100):
        found = estimator.update(reading(1.0 + 0.02 * k, speeds, force=up))
    assert found.velocity == pytest.approx((0.2, 0.0), abs=1e-3)


def test_the_bias_of_an_accelerometer_is_learned():
    estimator = BodyEstimator(ROBOT, EstimateOptions())
    biased = np.array([1.0, -0.5, 9.80665])
    for k in range(300):
        found = estimator.update(reading(1.0 + 0.02 * k, rolling(np.zeros(3)), force=biased))
    assert found.velocity == pytest.approx((0.0, 0.0), abs=2e-3)


def test_a_push_is_felt_by_the_accelerometer_while_no_foot_bears():
    estimator = BodyEstimator(ROBOT, EstimateOptions())
    up = np.array([0.0, 0.0, 9.80665])
    estimator.update(reading(1.0, np.zeros((4, 3)), force=up))
    none = np.zeros(4, dtype=bool)
    for k in range(1, 6):
        force = up + [0.0, 3.0, 0.0]
        found = estimator.update(
            reading(1.0 + 0.02 * k, np.zeros((4, 3)), force=force, in_stance=none)
        )
    # Trapezoids: half of the first step.
    assert found.velocity == pytest.approx((0.0, 3.0 * 0.09))


def test_a_tilt_goes_on_as_fast_as_the_body_turns():
    body = BodyEstimate((0.0, 0.0), 0.0, 0.1, -0.2, 1.0, 2.0)
    assert body.tilt_in(0.05) == pytest.approx((0.15, -0.1))
