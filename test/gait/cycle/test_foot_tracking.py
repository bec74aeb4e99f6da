"""S1's backstepping law: its example, its Lyapunov function, and what it must survive."""

import math

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.robot.leg_kinematics import Leg
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.foot_tracking import (
    SINGULAR,
    backstepping,
    damped_inverse,
    step_response,
    track_feet,
)
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle

ROBOT = load_robot('titan_viii')

# S1 Tables II and III, corrected: theta gives x_e0 = 3.121 cm only with half of the
# printed links. S1's z is downward, so its pitch and knee have the other sign here.
THETA = np.array([0.0, -math.pi / 4, 3 * math.pi / 4])
STEP = 0.02 * np.array([math.sin(math.pi / 4), math.cos(math.pi / 4), 0.0])


def leg_of_links(a1, a2, a3):
    """S1 eq. 9: yaw about z, straight along x at zero."""
    return Leg(
        name='lf',
        hip=np.zeros(3),
        first_axis=np.array([0.0, 0.0, 1.0]),
        radial_direction=np.array([1.0, 0.0, 0.0]),
        axial_offset=0.0,
        radial_offset=a1,
        lateral_offset=0.0,
        thigh_length=a2,
        calf_length=a3,
    )


TABLE_III = leg_of_links(0.01, 0.03, 0.05)
TABLE_II = leg_of_links(0.02, 0.06, 0.10)

both_legs = pytest.mark.parametrize('leg', [TABLE_III, TABLE_II], ids=['table III', 'table II'])


def moving_feet(duration=2.0, samples=101):
    """Four feet on smooth paths about the initial posture, and their velocities."""
    times = np.linspace(0.0, duration, samples)
    phase = 2.0 * math.pi * times[:, None] / duration + np.arange(4)
    rate = 2.0 * math.pi / duration
    size = np.array([0.10, 0.02, 0.03])
    waves = np.stack([np.sin(phase), np.cos(phase), np.sin(2.0 * phase)], axis=-1)
    slopes = np.stack([np.cos(phase), -np.sin(phase), 2.0 * np.cos(2.0 * phase)], axis=-1)
    return times, ROBOT.neutral_feet + size * waves, rate * size * slopes


def test_the_tables_of_s1_fit_together_with_half_the_links():
    foot = TABLE_III.forward(THETA)
    assert foot == pytest.approx([0.03121, 0.0, -0.02879], abs=6e-6)
    assert foot + STEP == pytest.approx([0.04535, 0.01414, -0.02879], abs=6e-6)


@both_legs
def test_the_error_of_s1s_step_dies_out_within_two_seconds(leg):
    times, q, e = step_response(leg, THETA, leg.forward(THETA) + STEP)
    size = np.linalg.norm(e, axis=1)
    assert (times[0], times[-1]) == (0.0, 2.0)
    assert e[0] == pytest.approx(STEP)
    assert np.all(np.diff(size) < 0.0)
    assert size[-1] < 0.01 * size[0]
    assert leg.forward(q[-1]) + e[-1] == pytest.approx(leg.forward(THETA) + STEP)


@both_legs
@pytest.mark.parametrize('gain', [1.0, 4.0, np.array([2.0, 3.0, 5.0])])
def test_the_error_falls_as_the_exponential_of_the_gain(leg, gain):
    times, _, e = step_response(leg, THETA, leg.forward(THETA) + STEP, gain=gain)
    assert e == pytest.approx(STEP * np.exp(-np.outer(times, gain * np.ones(3))), abs=1e-7)


@both_legs
def test_half_the_squared_error_falls_at_the_rate_of_s1_eq_17(leg):
    K = np.array([2.0, 3.0, 5.0])
    times, _, e = step_response(leg, THETA, leg.forward(THETA) + STEP, gain=K, dt=0.001)
    V = 0.5 * np.sum(e**2, axis=1)
    assert np.gradient(V, times)[1:-1] == pytest.approx(-(e**2 @ K)[1:-1], rel=1e-4, abs=1e-12)


@pytest.mark.parametrize('name', available_robots())
def test_far_from_singularities_the_inverse_is_exact(name):
    robot = load_robot(name)
    q = robot.initial_joint_angles + np.random.default_rng(1).uniform(-0.2, 0.2, (50, 4, 3))
    J = robot.foot_jacobians(q)
    assert damped_inverse(J) @ J == pytest.approx(np.broadcast_to(np.eye(3), J.shape), abs=1e-12)


def test_near_singularities_the_inverse_is_damped_and_bounded():
    for knee in (0.0, 1e-12, 1e-6, 1e-3, 0.05, 0.2, 1.0):
        J = ROBOT.legs[0].jacobian(np.array([0.3, 0.4, knee]))
        s = np.linalg.svd(J, compute_uv=False)
        eps = SINGULAR * s[0]
        mu2 = max(eps**2 - s[2] ** 2, 0.0)
        expected = J.T @ np.linalg.inv(J @ J.T + mu2 * np.eye(3))
        assert damped_inverse(J) == pytest.approx(expected, rel=1e-6)
        assert np.linalg.norm(damped_inverse(J), 2) <= 1.0 / eps + 1e-9
    assert damped_inverse(np.zeros((3, 3))).tolist() == np.zeros((3, 3)).tolist()


def test_the_damping_sets_in_without_a_jump():
    leg, target = ROBOT.legs[0], np.array([0.1, 0.2, -0.1])
    knees = np.linspace(0.0, 0.6, 6001)
    q = np.stack([np.full_like(knees, 0.3), np.full_like(knees, 0.4), knees], axis=1)
    velocities = backstepping(leg.jacobian(q), leg.forward(q), target, np.zeros(3), np.array(4.0))
    assert np.abs(np.diff(velocities, axis=0)).max() < 0.02 * np.abs(velocities).max()


def test_through_a_straight_knee_joint_speeds_stay_bounded():
    # The foot is pulled out of reach and back: the knee straightens on the way.
    leg, bent = ROBOT.legs[0], ROBOT.initial_joint_angles
    times = np.linspace(0.0, 4.0, 201)
    outward = 0.25 * np.sin(math.pi * times / 4.0) ** 2
    rate = 0.25 * math.pi / 4.0 * np.sin(math.pi * times / 2.0)
    feet = np.repeat(ROBOT.neutral_feet[None], len(times), axis=0)
    velocities = np.zeros_like(feet)
    feet[:, 0, 1] += outward
    velocities[:, 0, 1] = rate
    assert np.linalg.norm(feet[100, 0] - np.array(leg.hip)) > leg.radial_offset + leg.reach()[1]
    q, dq = track_feet(ROBOT, times, feet, velocities, bent)
    knees = q[:, 0, 2]
    assert knees.min() < 0.1
    J = ROBOT.foot_jacobians(q)
    wanted = velocities + 4.0 * (feet - ROBOT.foot_positions(q))
    largest = np.linalg.svd(J, compute_uv=False)[..., 0]
    bound = np.linalg.norm(wanted, axis=-1) / (SINGULAR * largest)
    assert np.all(np.linalg.norm(dq, axis=-1) <= bound + 1e-9)
    assert np.abs(dq).max() < 6.0
    # Back within reach, the foot is found again.
    assert ROBOT.foot_positions(q[-1]) == pytest.approx(feet[-1], abs=2e-3)


def test_a_path_from_its_own_start_is_tracked_to_a_tenth_of_a_millimetre():
    times, feet, velocities = moving_feet()
    exact = ROBOT.joint_angles(feet)
    q, dq = track_feet(ROBOT, times, feet, velocities, exact[0])
    assert np.abs(ROBOT.foot_positions(q) - feet).max() < 1e-4
    assert q == pytest.approx(exact, abs=1e-3)
    assert dq == pytest.approx(ROBOT.joint_velocities(exact, velocities), abs=5e-3)


def test_along_a_crawl_cycle_it_agrees_with_the_closed_form():
    cycle = generate_cycle(ROBOT, load_gait('crawl'), BodyMotion(forward=0.2))
    exact = cycle.joint_positions
    feet = ROBOT.foot_positions(exact)
    velocities = (ROBOT.foot_jacobians(exact) @ cycle.joint_velocities[..., None])[..., 0]
    q, dq = track_feet(ROBOT, cycle.times, feet, velocities, exact[0])
    assert np.abs(ROBOT.foot_positions(q) - feet).max() < 1e-4
    assert q == pytest.approx(exact, abs=1e-3)
    assert dq == pytest.approx(cycle.joint_velocities, abs=5e-3)


@pytest.mark.parametrize('name', available_robots())
def test_every_robots_feet_take_a_step_sideways_together(name):
    # S1's crab gait: all feet by the same vector, from where they are to where they rest.
    robot = load_robot(name)
    times = np.linspace(0.0, 2.0, 101)
    step = 0.1 * robot.hip_height * np.array([math.sqrt(0.5), math.sqrt(0.5), 0.0])
    feet = np.repeat(robot.neutral_feet[None] + step, len(times), axis=0)
    q, dq = track_feet(robot, times, feet, np.zeros_like(feet), robot.initial_joint_angles)
    expected = step * np.exp(-4.0 * times)[:, None, None]
    assert feet - robot.foot_positions(q) == pytest.approx(
        np.broadcast_to(expected, feet.shape), abs=1e-6
    )
    assert np.gradient(q, times, axis=0)[1:-1] == pytest.approx(dq[1:-1], abs=0.01)


def test_starting_off_by_a_tenth_of_a_radian_it_converges():
    times, feet, velocities = moving_feet(duration=3.0, samples=151)
    exact = ROBOT.joint_angles(feet)
    off = 0.1 * np.random.default_rng(2).choice([-1.0, 1.0], (4, 3))
    q, _ = track_feet(ROBOT, times, feet, velocities, exact[0] + off)
    error = np.linalg.norm(feet - ROBOT.foot_positions(q), axis=-1)
    assert np.all(error[0] > 5e-3)
    assert np.all(np.diff(error[:100], axis=0) < 0.0)
    assert error[-1].max() < 1e-4
    # It dies out as the law says, whatever the path does meanwhile.
    expected = error[0] * np.exp(-4.0 * times[:, None])
    assert error == pytest.approx(expected, abs=1e-4)


def test_feet_that_rest_at_the_start_leave_the_joints_alone():
    times = np.array([0.0, 0.02, 0.5])
    feet = np.repeat(ROBOT.neutral_feet[None], 3, axis=0)
    q, dq = track_feet(ROBOT, times, feet, np.zeros_like(feet), ROBOT.initial_joint_angles)
    assert q == pytest.approx(np.broadcast_to(ROBOT.initial_joint_angles, q.shape), abs=1e-12)
    assert dq == pytest.approx(np.zeros_like(q), abs=1e-9)


def test_left_mirrors_right():
    times, feet, velocities = moving_feet()
    flip, order = np.array([1.0, -1.0, 1.0]), [1, 0, 3, 2]
    start = ROBOT.joint_angles(feet[0])
    off = start + 0.05
    mirrored = off[order] * np.array([-1.0, 1.0, 1.0])
    q, _ = track_feet(ROBOT, times, feet, velocities, off)
    p, _ = track_feet(ROBOT, times, feet[:, order] * flip, velocities[:, order] * flip, mirrored)
    assert p[:, order] * np.array([-1.0, 1.0, 1.0]) == pytest.approx(q, abs=1e-9)


@pytest.mark.parametrize('gain', [50.0, 500.0])
def test_a_high_gain_is_integrated_in_finer_steps(gain):
    times, feet, velocities = moving_feet()
    start = ROBOT.joint_angles(feet[0]) + 0.05
    q, _ = track_feet(ROBOT, times, feet, velocities, start, gain=gain)
    error = np.linalg.norm(feet - ROBOT.foot_positions(q), axis=-1)
    assert error[times > 10.0 / gain].max() < 1e-4


@pytest.mark.parametrize(
    ('argument', 'value'),
    [
        ('gain', 0.0),
        ('gain', -1.0),
        ('gain', math.nan),
        ('gain', np.ones(2)),
        ('times', np.zeros(101)),
        ('times', np.zeros(0)),
        ('feet', np.zeros((101, 3))),
        ('feet', np.full((101, 4, 3), math.nan)),
        ('foot_velocities', np.zeros((100, 4, 3))),
        ('start_joint_angles', np.zeros(12)),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(argument, value):
    times, feet, velocities = moving_feet()
    arguments = {
        'times': times,
        'feet': feet,
        'foot_velocities': velocities,
        'start_joint_angles': ROBOT.initial_joint_angles,
        argument: value,
    }
    with pytest.raises(ParameterError, match=argument):
        track_feet(ROBOT, **arguments)


@pytest.mark.parametrize(('argument', 'value'), [('duration', 0.0), ('dt', -1.0), ('dt', math.nan)])
def test_a_step_takes_a_positive_time(argument, value):
    with pytest.raises(ParameterError, match=argument):
        step_response(TABLE_III, THETA, TABLE_III.forward(THETA), **{argument: value})
