"""Laws of a gait cycle, recomputed from its joints alone, and the figures of S0."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import (
    FootTargetUnreachable,
    GaitError,
    JointLimitExceeded,
    UnstableCycle,
)
from quad_common.planar_pose import Pose2D
from quad_common.robot import LEGS, load_robot
from quad_gait.body_motion import BodyMotion
from quad_gait.gait import Swing, load_gait
from quad_gait.gait_generator import generate_cycle, generate_largest_cycle
from quad_gait.stability import stability_margin

ROBOT = load_robot('titan_viii')
CRAWL = load_gait('crawl')
TURN = load_gait('turn')
S_MAX, PHI_MAX = ROBOT.largest_stride, ROBOT.largest_turn

# S0 sec. 4: in each of four phases of a second one foot swings, the body advances S/4.
PAPER = replace(
    CRAWL,
    swings=tuple(Swing(leg, k + 1.0, k + 2.0) for k, leg in enumerate(('lh', 'lf', 'rh', 'rf'))),
    body_progress=((1.0, 0.0), (2.0, 0.25), (3.0, 0.5), (4.0, 0.75), (5.0, 1.0)),
    sway_weight=0.0,
)
S_OF_FIGURE_16 = 0.1077

CASES = {
    'crawl': (CRAWL, BodyMotion(forward=S_MAX)),
    'short crawl': (CRAWL, BodyMotion(forward=0.05)),
    'backward': (CRAWL, BodyMotion(forward=-0.1)),
    'sideways': (CRAWL, BodyMotion(left=0.05)),
    'arc': (CRAWL, BodyMotion(forward=0.1, left=0.02, turn=0.2)),
    'left turn': (TURN, BodyMotion(turn=PHI_MAX)),
    'right turn': (TURN.mirrored(), BodyMotion(turn=-PHI_MAX)),
    'drifting turn': (TURN, BodyMotion(forward=0.03, left=-0.02, turn=0.5)),
    'on the spot': (CRAWL, BodyMotion()),
    'paper': (PAPER, BodyMotion(forward=S_OF_FIGURE_16)),
}
CYCLES = {name: generate_cycle(ROBOT, *case) for name, case in CASES.items()}

each_cycle = pytest.mark.parametrize('cycle', CYCLES.values(), ids=CYCLES)


def feet_in_ground(cycle):
    """Feet in the ground frame, from the joints and the body's pose, shape (n, 4, 3)."""
    feet = ROBOT.foot_positions(cycle.joint_positions)
    c, s = np.cos(cycle.body[:, 2, None]), np.sin(cycle.body[:, 2, None])
    x, y, z = (feet[..., k] for k in range(3))
    return np.stack(
        [
            cycle.body[:, 0, None] + c * x - s * y,
            cycle.body[:, 1, None] + s * x + c * y,
            z + ROBOT.standing_height,
        ],
        axis=-1,
    )


@each_cycle
def test_mean_contact_is_the_duty_factor(cycle):
    fine = generate_cycle(ROBOT, cycle.gait, cycle.motion, sample_period=0.001)
    for k, leg in enumerate(LEGS):
        mean = fine.in_contact[:, k].mean()
        assert mean == pytest.approx(cycle.gait.duty_factor(leg), abs=1e-3)


@each_cycle
def test_stance_feet_stand_still_in_the_world(cycle):
    feet = feet_in_ground(cycle)
    for k, leg in enumerate(LEGS):
        swing = next(swing for swing in cycle.gait.swings if swing.leg == leg)
        before, after = cycle.times <= swing.liftoff, cycle.times >= swing.touchdown
        assert (cycle.in_contact[:, k] == (before | after)).all()
        assert np.ptp(feet[before, k], axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
        assert np.ptp(feet[after, k], axis=0) == pytest.approx(np.zeros(3), abs=1e-9)


@each_cycle
def test_stance_feet_are_on_the_ground_and_swing_feet_above_it(cycle):
    height = feet_in_ground(cycle)[..., 2] - ROBOT.foot_radius
    assert height[cycle.in_contact] == pytest.approx(0.0, abs=1e-9)
    assert (height[~cycle.in_contact] > -1e-12).all()
    assert height.max() == pytest.approx(cycle.gait.swing_height, rel=0.02)


@each_cycle
def test_the_planned_feet_are_those_of_the_joints(cycle):
    assert cycle.feet == pytest.approx(feet_in_ground(cycle), abs=1e-9)


@each_cycle
def test_joint_velocities_are_the_derivative_of_joint_positions(cycle):
    fine = generate_cycle(ROBOT, cycle.gait, cycle.motion, sample_period=0.001)
    h = fine.times[1]
    difference = (fine.joint_positions[2:] - fine.joint_positions[:-2]) / (2.0 * h)
    error = np.abs(difference - fine.joint_velocities[1:-1]).max(axis=(1, 2))
    # Where the acceleration jumps, the difference is off by half of it for one step.
    jumps = [time for time, _ in cycle.gait.body_progress]
    jumps += [t for swing in cycle.gait.swings for t in (swing.liftoff, swing.touchdown)]
    smooth = np.abs(fine.times[1:-1, None] - jumps).min(axis=1) > 1.5 * h
    assert error[smooth].max() < 1e-3
    assert error.max() < 0.02
    assert np.abs(fine.joint_velocities).max() > 0.1


@each_cycle
def test_joints_do_not_jump_at_liftoff_and_touchdown(cycle):
    fine = generate_cycle(ROBOT, cycle.gait, cycle.motion, sample_period=0.001)
    assert np.abs(np.diff(fine.joint_velocities, axis=0)).max() < 0.2


@each_cycle
def test_a_cycle_starts_and_ends_in_the_initial_posture_at_rest(cycle):
    for sample in (0, -1):
        assert cycle.joint_positions[sample] == pytest.approx(ROBOT.initial_joint_angles, abs=1e-9)
        assert cycle.joint_velocities[sample] == pytest.approx(np.zeros((4, 3)), abs=1e-9)
    assert cycle.in_contact[[0, -1]].all()


@each_cycle
def test_the_body_ends_where_the_motion_says_over_the_initial_posture(cycle):
    end = cycle.motion.end
    assert cycle.body[0] == pytest.approx(np.zeros(3), abs=1e-12)
    assert cycle.body[-1] == pytest.approx([end.x, end.y, end.yaw], abs=1e-12)
    expected = end.transform(ROBOT.neutral_feet)
    assert feet_in_ground(cycle)[-1, :, :2] == pytest.approx(expected[:, :2], abs=1e-9)


@each_cycle
def test_joints_stay_within_their_limits_and_speeds(cycle):
    assert (cycle.joint_positions >= ROBOT.lower).all()
    assert (cycle.joint_positions <= ROBOT.upper).all()
    assert (np.abs(cycle.joint_velocities) <= ROBOT.velocity).all()


@each_cycle
def test_the_margin_is_that_of_the_joints_and_the_feet_on_the_ground(cycle):
    center = ROBOT.center_of_mass(cycle.joint_positions)
    feet = ROBOT.foot_positions(cycle.joint_positions)
    # The margin does not depend on the frame: here it is the body's.
    expected = stability_margin(center[:, :2], feet[..., :2], cycle.in_contact)
    assert cycle.margin == pytest.approx(expected, abs=1e-9)
    assert cycle.least_margin == cycle.margin.min()


@pytest.mark.parametrize('name', ['crawl', 'left turn', 'right turn'])
def test_with_sway_even_the_largest_motion_is_stable(name):
    assert CYCLES[name].least_margin > 0.03


@pytest.mark.parametrize('stride', [0.0, 0.05, 0.1, 0.15, 0.2])
@pytest.mark.parametrize('kind', ['crawl', 'turn', 'mirrored turn'])
def test_smaller_motions_are_stable_as_well(kind, stride):
    gait, motion = {
        'crawl': (CRAWL, BodyMotion(forward=stride)),
        'turn': (TURN, BodyMotion(turn=stride / S_MAX * PHI_MAX)),
        'mirrored turn': (TURN.mirrored(), BodyMotion(turn=-stride / S_MAX * PHI_MAX)),
    }[kind]
    assert generate_cycle(ROBOT, gait, motion).least_margin > 0.03


@pytest.mark.parametrize('stride', [S_OF_FIGURE_16, S_MAX])
def test_without_sway_the_margin_starts_or_ends_at_zero_in_each_phase(stride):
    # S0's own schedule puts the centre of gravity on a diagonal of the feet.
    cycle = generate_cycle(ROBOT, PAPER, BodyMotion(forward=stride), sample_period=0.001)
    for swing in PAPER.swings:
        phase = (cycle.times > swing.liftoff) & (cycle.times < swing.touchdown)
        margin = cycle.margin[phase]
        assert min(margin[0], margin[-1]) == pytest.approx(0.0, abs=1e-4)
        assert margin.min() > -1e-6
        assert margin.max() > 0.02


def test_sway_is_what_makes_the_margin_positive():
    motion = BodyMotion(forward=S_OF_FIGURE_16)
    margins = [
        generate_cycle(ROBOT, replace(CRAWL, sway_weight=mu), motion).least_margin
        for mu in (0.0, 0.1, 0.2, 0.4)
    ]
    assert margins == sorted(margins)
    assert margins[0] < 0.015 < 0.035 < margins[-1]


def test_in_stance_the_leg_length_runs_from_200_to_215_7_mm():
    # S0 fig. 16: sqrt(200^2 + (3 S / 4)^2) = 215.7 at the stride of figs. 15 to 17.
    cycle = CYCLES['paper']
    hips = np.array([leg.hip for leg in ROBOT.legs])
    arms = ROBOT.foot_positions(cycle.joint_positions) - hips
    length = 1e3 * np.hypot(arms[..., 0], arms[..., 1])
    in_stance = length[cycle.in_contact]
    assert in_stance.min() == pytest.approx(200.0, abs=0.05)
    assert in_stance.max() == pytest.approx(215.7, abs=0.05)
    # A foot lags behind by a quarter of the stride for each phase that it waits.
    for phase, swing in enumerate(PAPER.swings):
        longest = length[cycle.times <= swing.liftoff, LEGS.index(swing.leg)].max()
        lag = 1e3 * S_OF_FIGURE_16 * phase / 4.0
        assert longest == pytest.approx(math.hypot(200.0, lag), abs=0.05)


def test_in_stance_the_height_of_every_leg_is_constant():
    # S0 fig. 17: H0 = 243 mm.
    arms = ROBOT.foot_positions(CYCLES['paper'].joint_positions)
    assert -1e3 * arms[..., 2][CYCLES['paper'].in_contact] == pytest.approx(243.0, abs=1e-6)


def test_a_right_turn_mirrors_a_left_turn():
    left, right = CYCLES['left turn'], CYCLES['right turn']
    across = [1, 0, 3, 2]
    assert right.joint_positions[:, across] * [-1.0, 1.0, 1.0] == pytest.approx(
        left.joint_positions, abs=1e-12
    )
    assert right.body * [1.0, -1.0, -1.0] == pytest.approx(left.body, abs=1e-12)
    assert right.margin == pytest.approx(left.margin, abs=1e-12)


def test_a_mirrored_crawl_mirrors_the_crawl():
    motion = BodyMotion(forward=0.15, left=0.03, turn=0.1)
    mirrored = generate_cycle(
        ROBOT, CRAWL.mirrored(), BodyMotion(forward=0.15, left=-0.03, turn=-0.1)
    )
    cycle = generate_cycle(ROBOT, CRAWL, motion)
    assert mirrored.joint_positions[:, [1, 0, 3, 2]] * [-1.0, 1.0, 1.0] == pytest.approx(
        cycle.joint_positions, abs=1e-12
    )


def test_feet_that_start_elsewhere_end_in_the_initial_posture_all_the_same():
    rng = np.random.default_rng(1)
    start = ROBOT.neutral_feet.copy()
    start[:, :2] += rng.uniform(-0.02, 0.02, (4, 2))
    cycle = generate_cycle(ROBOT, CRAWL, BodyMotion(forward=0.1), start_feet=start)
    assert ROBOT.foot_positions(cycle.joint_positions[0]) == pytest.approx(start, abs=1e-9)
    assert cycle.joint_positions[-1] == pytest.approx(ROBOT.initial_joint_angles, abs=1e-9)


@pytest.mark.parametrize('period', [0.02, 0.03, 0.007, 5.0, 9.0])
def test_samples_are_evenly_spaced_no_farther_than_asked_and_end_with_the_cycle(period):
    times = generate_cycle(ROBOT, CRAWL, BodyMotion(forward=0.1), sample_period=period).times
    assert (times[0], times[-1]) == (0.0, 5.0)
    assert np.diff(times) == pytest.approx(np.full(len(times) - 1, times[1]))
    assert times[1] <= period + 1e-9


def test_the_trajectory_begins_with_the_first_movement_and_ends_with_the_cycle():
    cycle = CYCLES['crawl']
    trajectory = cycle.trajectory(ROBOT, stamp=12.5)
    assert trajectory.joint_names == ROBOT.joint_names
    assert (trajectory.stamp, trajectory.end) == (12.5, 17.5)
    assert trajectory.times[0] == pytest.approx(CRAWL.motion_start)
    assert trajectory.positions[0] == pytest.approx(ROBOT.initial_joint_angles.reshape(-1))
    assert trajectory.velocities[0] == pytest.approx(np.zeros(12), abs=1e-12)
    before = cycle.times < trajectory.times[0]
    assert np.ptp(cycle.joint_positions[before], axis=0).max() == 0.0
    for k, t in enumerate(trajectory.times):
        sample = int(np.argmin(np.abs(cycle.times - t)))
        assert (trajectory.positions[k] == cycle.joint_positions[sample].reshape(-1)).all()


@pytest.mark.parametrize('period', [0.02, 0.03, 0.07])
def test_whatever_the_sample_period_no_movement_is_cut_off(period):
    cycle = generate_cycle(ROBOT, TURN, BodyMotion(turn=0.5), sample_period=period)
    trajectory = cycle.trajectory(ROBOT, stamp=0.0)
    assert trajectory.times[0] <= TURN.motion_start + 1e-9 < trajectory.times[0] + period + 1e-9
    assert np.abs(trajectory.velocities[0]).max() < 1e-9


@pytest.mark.parametrize('stride', [0.8, -0.8])
def test_a_motion_beyond_the_legs_is_refused(stride):
    with pytest.raises(FootTargetUnreachable, match='foot '):
        generate_cycle(ROBOT, CRAWL, BodyMotion(forward=stride))


def test_a_joint_that_would_leave_its_range_is_named():
    stiff = replace(ROBOT, upper=np.array([0.2, 1.45, 2.8]))
    with pytest.raises(JointLimitExceeded, match=r'hip_yaw_joint would go to .* to 0\.200 rad'):
        generate_cycle(stiff, CRAWL, BodyMotion(forward=S_MAX))


def test_a_joint_that_would_be_too_fast_is_named_with_its_speed():
    slow = replace(ROBOT, velocity=np.array([6.0, 6.0, 0.5]))
    with pytest.raises(JointLimitExceeded, match=r'knee_pitch_joint .* -0\.500 to 0\.500 rad/s'):
        generate_cycle(slow, CRAWL, BodyMotion(forward=S_MAX))


def test_a_cycle_below_the_least_margin_is_refused_with_both_numbers():
    with pytest.raises(UnstableCycle, match=r'margin of 0\.0 mm; it must be at least 10\.0 mm'):
        generate_cycle(ROBOT, PAPER, BodyMotion(forward=0.1), least_margin=0.01)


def test_the_largest_cycle_is_the_whole_one_if_that_is_possible():
    motion = BodyMotion(forward=0.2)
    assert generate_largest_cycle(ROBOT, CRAWL, motion, least_margin=0.01).motion == motion


def test_the_largest_cycle_shrinks_a_motion_by_eighths_until_it_is_possible():
    motion = BodyMotion(forward=0.7, left=0.1, turn=0.2)
    cycle = generate_largest_cycle(ROBOT, CRAWL, motion, least_margin=0.01)
    share = cycle.motion.forward / motion.forward
    assert 0.0 < share < 1.0
    assert 8.0 * share == pytest.approx(round(8.0 * share))
    assert cycle.motion.left == pytest.approx(share * motion.left)
    assert cycle.motion.turn == pytest.approx(share * motion.turn)
    assert cycle.least_margin >= 0.01
    larger = share + 0.125
    with pytest.raises(GaitError):
        generate_cycle(
            ROBOT,
            CRAWL,
            BodyMotion(larger * motion.forward, larger * motion.left, larger * motion.turn),
            least_margin=0.01,
        )


def test_if_not_even_an_eighth_is_possible_the_reason_is_told():
    with pytest.raises(UnstableCycle):
        generate_largest_cycle(ROBOT, CRAWL, BodyMotion(forward=0.1), least_margin=1.0)
    with pytest.raises(FootTargetUnreachable):
        generate_largest_cycle(ROBOT, CRAWL, BodyMotion(forward=50.0))


def test_cycles_in_a_row_add_up_to_the_motion():
    pose = Pose2D(0.0, 0.0, 0.0)
    for _ in range(3):
        x, y, yaw = generate_cycle(ROBOT, TURN, BodyMotion(turn=math.pi / 6)).body[-1]
        pose = pose @ Pose2D(x, y, yaw)
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.0, 0.0, math.pi / 2), abs=1e-12)
