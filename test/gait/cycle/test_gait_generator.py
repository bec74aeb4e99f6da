"""Laws of a gait cycle, recomputed from its joints alone, and the papers' figures."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import pytest

from quad_common.errors import (
    FootTargetUnreachable,
    GaitError,
    JointLimitExceeded,
    UnstableCycle,
)
from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import AT_REST, CycleEnds
from quad_gait.cycle.footholds import lean_on_curve, steady_ends
from quad_gait.cycle.gait import Gait, Swing, available_gaits, load_gait
from quad_gait.cycle.gait_generator import (
    CycleOptions,
    generate_cycle,
    generate_largest_cycle,
    generate_steady_cycle,
)
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.stability import stability_margin

ROBOT = load_robot('titan_viii')
CUHK = load_robot('cuhk')
GENIBO = load_robot('genibo')
CRAWL = load_gait('crawl')
TURN = load_gait('turn')
S_MAX, PHI_MAX = ROBOT.largest_stride, ROBOT.largest_turn
ROBOTS = ('titan_viii', 'pukyong', 'cuhk', 'genibo')
ACROSS = [1, 0, 3, 2]
"""The legs' places with left and right exchanged."""


def on_points(robot):
    """Give a robot feet so small that they do not roll; as it stands lower, with thinner legs."""
    foot, thigh = robot.links['foot'], robot.links['thigh']
    thinner = max(thigh.radius - foot.radius, 1e-3)
    links = {'foot': replace(foot, radius=1e-9), 'thigh': replace(thigh, radius=thinner)}
    return replace(robot, links={**robot.links, **links})


def in_order(gait, legs):
    return replace(
        gait, swings=tuple(replace(swing, leg=leg) for swing, leg in zip(gait.swings, legs))
    )


# S0 sec. 4: in each of four phases of a second one foot swings, the body advances S/4.
PAPER = replace(
    CRAWL,
    swings=tuple(Swing(leg, k + 1.0, k + 2.0) for k, leg in enumerate(('lh', 'lf', 'rh', 'rf'))),
    body_progress=((1.0, 0.0), (2.0, 0.25), (3.0, 0.5), (4.0, 0.75), (5.0, 1.0)),
    sway_weight=(0.0, 0.0),
)
S_OF_FIGURE_16 = 0.1077


@dataclass(frozen=True)
class Case:
    """What a cycle is generated from."""

    gait: Gait
    motion: BodyMotion
    robot: Robot = ROBOT
    ends: CycleEnds = AT_REST

    def at(self, sample_period, robot=None):
        options = CycleOptions(sample_period)
        return generate_cycle(robot or self.robot, self.gait, self.motion, self.ends, options)

    @cached_property
    def cycle(self):
        return self.at(self.gait.cycle_period / 200.0)

    @cached_property
    def fine(self):
        return self.at(self.gait.cycle_period / 4000.0)

    @property
    def feet(self):
        return feet_in_ground(self.robot, self.cycle)


def steady(gait, motion, robot=ROBOT):
    return Case(gait, motion, robot, steady_ends(robot, gait, motion))


def start(gait, motion, robot=ROBOT):
    return Case(gait, motion.scaled(0.5), robot, CycleEnds(exit=motion.rate(gait.cycle_period)))


def stop(gait, motion, robot=ROBOT):
    speed = motion.rate(gait.cycle_period)
    begun = start(gait, motion, robot).cycle
    return Case(gait, motion.scaled(0.5), robot, CycleEnds(begun.end_feet, entry=speed))


def mirrored_twist(twist):
    return Twist2D(twist.forward, -twist.left, -twist.turn)


def feet_in_ground(robot, cycle):
    """Feet in the ground frame, from the joints and the body's pose, shape (n, 4, 3)."""
    feet = robot.foot_positions(cycle.joint_positions)
    c, s = np.cos(cycle.body[:, 2, None]), np.sin(cycle.body[:, 2, None])
    x, y, z = (feet[..., k] for k in range(3))
    return np.stack(
        [
            cycle.body[:, 0, None] + c * x - s * y,
            cycle.body[:, 1, None] + s * x + c * y,
            z + robot.standing_height,
        ],
        axis=-1,
    )


WAVE, TROT = load_gait('wave', ROBOT), load_gait('trot', CUHK)
ARC = BodyMotion(forward=0.06, left=0.01, turn=0.15)

CASES = {
    'crawl': Case(CRAWL, BodyMotion(forward=S_MAX)),
    'short crawl': Case(CRAWL, BodyMotion(forward=0.05)),
    'backward': Case(CRAWL, BodyMotion(forward=-0.1)),
    'sideways': Case(CRAWL, BodyMotion(left=0.05)),
    'arc': Case(CRAWL, BodyMotion(forward=0.1, left=0.02, turn=0.2)),
    'left turn': Case(TURN, BodyMotion(turn=PHI_MAX)),
    'right turn': Case(TURN.mirrored(), BodyMotion(turn=-PHI_MAX)),
    'drifting turn': Case(TURN, BodyMotion(forward=0.03, left=-0.02, turn=0.5)),
    'on the spot': Case(CRAWL, BodyMotion()),
    'paper': Case(PAPER, BodyMotion(forward=S_OF_FIGURE_16)),
    'small crawl': Case(load_gait('crawl', GENIBO), BodyMotion(forward=0.05), GENIBO),
    'wave': steady(WAVE, BodyMotion(forward=0.3)),
    'waving arc': steady(WAVE, BodyMotion(0.1, 0.05, 0.3)),
    'start of a wave': start(WAVE, BodyMotion(forward=0.3)),
    'stop of a wave': stop(WAVE, BodyMotion(forward=0.3)),
    'trot': steady(TROT, BodyMotion(forward=0.12), CUHK),
    'trotting arc': steady(TROT, ARC, CUHK),
    'start of a trot': start(TROT, ARC, CUHK),
    'stop of a trot': stop(TROT, ARC, CUHK),
}
FROM_REST_TO_REST = {name: case for name, case in CASES.items() if case.ends is AT_REST}

each_case = pytest.mark.parametrize('case', CASES.values(), ids=CASES)
each_whole_case = pytest.mark.parametrize('case', FROM_REST_TO_REST.values(), ids=FROM_REST_TO_REST)


def near_a_switch(case, times, steps):
    """Whether a foot lifts off or touches down within so many samples."""
    switches = np.array([t for s in case.gait.swings for t in (s.liftoff, s.touchdown)])
    return np.abs(times[:, None] - switches).min(axis=1) <= (steps + 1e-6) * times[1]


@each_case
def test_mean_contact_is_the_duty_factor(case):
    for k, leg in enumerate(LEGS):
        mean = case.fine.in_contact[:, k].mean()
        assert mean == pytest.approx(case.gait.duty_factor(leg), abs=1e-3)


@each_case
def test_feet_are_in_contact_but_for_their_swings(case):
    for k, leg in enumerate(LEGS):
        swing, times = case.gait.swing(leg), case.cycle.times
        down = (times <= swing.liftoff) | (times >= swing.touchdown)
        assert (case.cycle.in_contact[:, k] == down).all()


def calf_axes(robot, cycle):
    """Axes fixed to each calf, as columns in the ground frame, shape (n, 4, 3, 3)."""
    pitch_axis, knee, foot = robot.stacked_legs.chain(cycle.joint_positions)
    along = foot - knee
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    normal = np.cross(knee - pitch_axis, along)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    axes = np.stack([along, normal, np.cross(along, normal)], axis=-1)
    c, s = np.cos(cycle.body[:, 2]), np.sin(cycle.body[:, 2])
    zero, one = np.zeros_like(c), np.ones_like(c)
    body = np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]]).transpose(2, 0, 1)
    return body[:, None] @ axes


@each_case
def test_stance_feet_roll_on_the_ground_without_slipping(case):
    # The center of a ball of radius r moves with r (omega_y, -omega_x).
    cycle, radius = case.fine, case.robot.foot_radius
    h = cycle.times[1]
    axes = calf_axes(case.robot, cycle)
    spin = (axes[2:] - axes[:-2]) / (2.0 * h) @ axes[1:-1].swapaxes(-1, -2)
    rolling = radius * np.stack([spin[..., 0, 2], spin[..., 1, 2]], axis=-1)
    feet = feet_in_ground(case.robot, cycle)[..., :2]
    velocity = (feet[2:] - feet[:-2]) / (2.0 * h)
    standing = cycle.in_contact[2:] & cycle.in_contact[1:-1] & cycle.in_contact[:-2]
    slip, rolling = (np.where(standing[..., None], v, 0.0) for v in (velocity - rolling, rolling))
    # Rolling is computed at a few samples only: hence a few percent.
    assert np.sqrt(np.mean(slip**2)) < 0.05 * np.abs(rolling).max()
    slipped, rolled = (np.linalg.norm(v.sum(axis=0) * h, axis=-1).max() for v in (slip, rolling))
    assert slipped < 0.05 * rolled + 1e-5


@each_case
def test_feet_that_are_points_stand_still_in_the_world(case):
    robot = on_points(case.robot)
    cycle = case.at(case.gait.cycle_period / 200.0, robot)
    feet = feet_in_ground(robot, cycle)
    for k, leg in enumerate(LEGS):
        swing = case.gait.swing(leg)
        for stance in (cycle.times <= swing.liftoff, cycle.times >= swing.touchdown):
            assert np.ptp(feet[stance, k, :2], axis=0) == pytest.approx(np.zeros(2), abs=1e-7)


@each_case
def test_stance_feet_are_on_the_ground_and_swing_feet_above_it(case):
    height = case.feet[..., 2] - case.robot.foot_radius
    # Heights are from a body at standing height: feet that push down (S2's rho) lift it.
    lift = case.gait.support_depth * case.gait.swing_height
    assert height[case.cycle.in_contact] == pytest.approx(0.0, abs=lift + 1e-9)
    assert (height[~case.cycle.in_contact] > -lift - 1e-12).all()
    assert height.max() == pytest.approx(case.gait.swing_height - lift, rel=0.02)
    on_ground = case.cycle.feet[..., 2][case.cycle.in_contact]
    assert on_ground == pytest.approx(case.robot.foot_radius, abs=1e-9)


@each_case
def test_the_planned_feet_are_those_of_the_joints(case):
    planned, real = case.cycle.feet, case.feet
    assert planned[..., :2] == pytest.approx(real[..., :2], abs=1e-9)
    if not case.gait.support_depth:
        assert planned[..., 2] == pytest.approx(real[..., 2], abs=1e-9)


@each_case
def test_joint_velocities_are_the_derivative_of_joint_positions(case):
    fine = case.fine
    h = fine.times[1]
    difference = (fine.joint_positions[2:] - fine.joint_positions[:-2]) / (2.0 * h)
    error = np.abs(difference - fine.joint_velocities[1:-1]).max(axis=(1, 2))
    fastest = np.abs(fine.joint_velocities).max()
    # Where the acceleration jumps, the difference is off by half of it for one step.
    smooth = ~near_a_switch(case, fine.times, 1.5)[1:-1]
    for knot, _ in case.gait.body_progress or ():
        smooth &= np.abs(fine.times[1:-1] - knot) > 1.5 * h
    assert error[smooth].max() < 0.01 * fastest
    assert np.median(error[smooth]) < 1e-4 * fastest
    assert fastest > 0.1


@each_case
def test_feet_that_are_points_leave_and_reach_the_ground_without_a_jerk(case):
    robot = on_points(case.robot)
    fine = case.at(case.gait.cycle_period / 4000.0, robot)
    fastest = np.abs(fine.joint_velocities).max()
    assert np.abs(np.diff(fine.joint_velocities, axis=0)).max() < 0.06 * fastest


@each_case
def test_joint_positions_do_not_jump(case):
    fine = case.fine
    fastest = np.abs(fine.joint_velocities).max()
    assert np.abs(np.diff(fine.joint_positions, axis=0)).max() < 1.01 * fastest * fine.times[1]


@each_whole_case
def test_a_cycle_from_rest_to_rest_starts_and_ends_in_the_initial_posture(case):
    for sample in (0, -1):
        assert case.cycle.joint_positions[sample] == pytest.approx(
            case.robot.initial_joint_angles, abs=1e-9
        )
        assert case.cycle.joint_velocities[sample] == pytest.approx(np.zeros((4, 3)), abs=1e-9)
    assert case.cycle.in_contact[[0, -1]].all()


@each_case
def test_the_body_ends_where_the_motion_says(case):
    end = case.motion.end
    assert case.cycle.body[0] == pytest.approx(np.zeros(3), abs=1e-12)
    assert case.cycle.body[-1] == pytest.approx([end.x, end.y, end.yaw], abs=1e-12)


@each_whole_case
def test_a_cycle_that_ends_at_rest_ends_over_the_initial_posture(case):
    expected = case.motion.end.transform(case.robot.neutral_feet)
    assert case.feet[-1, :, :2] == pytest.approx(expected[:, :2], abs=1e-9)


@each_case
def test_the_body_has_its_entry_and_exit_speeds_at_the_ends(case):
    fine = case.fine
    # Where a pendulum carries the body, its speed at a boundary is a little more.
    period = case.gait.cycle_period
    pace = 1.0
    if case.gait.pendulum_rate:
        quarter = case.gait.pendulum_rate * period / 4.0
        pace = quarter / math.tanh(quarter)
    h = fine.times[1]
    for sample, side, twist in ((0, 1, fine.entry), (-1, -1, fine.exit)):
        here, near, far = (fine.body[sample + k * side] for k in range(3))
        velocity = side * (4.0 * near - 3.0 * here - far) / (2.0 * h)
        c, s = math.cos(fine.body[sample, 2]), math.sin(fine.body[sample, 2])
        along = [c * velocity[0] + s * velocity[1], c * velocity[1] - s * velocity[0], velocity[2]]
        expected = [pace * twist.forward, pace * twist.left, pace * twist.turn]
        assert along == pytest.approx(expected, rel=1e-3, abs=1e-4)


@each_case
def test_joints_stay_within_their_limits_and_speeds(case):
    assert (case.cycle.joint_positions >= case.robot.lower).all()
    assert (case.cycle.joint_positions <= case.robot.upper).all()
    assert (np.abs(case.cycle.joint_velocities) <= case.robot.velocity).all()


@each_case
def test_the_margin_is_that_of_the_joints_and_the_feet_on_the_ground(case):
    center = case.robot.center_of_mass(case.cycle.joint_positions)
    feet = case.robot.foot_positions(case.cycle.joint_positions)
    # The margin does not depend on the frame: here it is the body's.
    expected = stability_margin(center[:, :2], feet[..., :2], case.cycle.in_contact)
    assert case.cycle.margin == pytest.approx(expected, abs=1e-9)
    assert case.cycle.least_margin == case.cycle.margin.min()


@each_case
def test_a_time_in_the_cycle_has_a_pose_and_a_sample(case):
    cycle = case.cycle
    for k in (0, 3, len(cycle.times) // 2, len(cycle.times) - 1):
        time = float(cycle.times[k])
        assert cycle.sample(time) == k
        pose = cycle.pose_at(time)
        assert (pose.x, pose.y, pose.yaw) == pytest.approx(tuple(cycle.body[k]), abs=1e-12)
    assert (cycle.sample(-1.0), cycle.sample(99.0)) == (0, len(cycle.times) - 1)


# Cycles in a row.


def shipped(name, gait_name, direction, fraction=0.7):
    """Make a good part of the largest motion in a direction."""
    robot = load_robot(name)
    limits = MotionLimits(robot, load_gait(gait_name, robot))
    motion = direction.scaled(fraction * limits.largest_scale(direction))
    return robot, limits.gait_for(motion), motion


@pytest.mark.sweep(kept=16)
@pytest.mark.parametrize('gait_name', available_gaits())
@pytest.mark.parametrize('name', ROBOTS)
@pytest.mark.parametrize(
    'direction',
    [BodyMotion(1.0), BodyMotion(-1.0), BodyMotion(turn=1.0), BodyMotion(0.5, 0.2, 1.0)],
    ids=['forward', 'backward', 'turn', 'arc'],
)
def test_equal_cycles_join_in_joint_positions_and_velocities(name, gait_name, direction):
    robot, gait, motion = shipped(name, gait_name, direction)
    cycle = generate_steady_cycle(robot, gait, motion, CycleOptions(gait.cycle_period / 400.0))
    assert cycle.joint_positions[-1] == pytest.approx(cycle.joint_positions[0], abs=1e-9)
    assert cycle.joint_velocities[-1] == pytest.approx(cycle.joint_velocities[0], abs=1e-9)
    if gait.is_steady:
        assert np.abs(cycle.joint_velocities[0]).max() > 0.05


@pytest.mark.sweep(kept=5)
@pytest.mark.parametrize('gait_name', ['wave', 'trot'])
@pytest.mark.parametrize('name', ROBOTS)
@pytest.mark.parametrize('direction', [BodyMotion(1.0), BodyMotion(0.5, 0.2, 1.0)])
def test_a_start_steady_cycles_and_a_stop_join_and_end_in_the_initial_posture(
    name, gait_name, direction
):
    robot, gait, motion = shipped(name, gait_name, direction)
    speed, half = motion.rate(gait.cycle_period), motion.scaled(0.5)
    cycles = [generate_cycle(robot, gait, half, CycleEnds(exit=speed))]
    for _ in range(2):
        feet = cycles[-1].end_feet
        cycles.append(generate_cycle(robot, gait, motion, CycleEnds(feet, entry=speed, exit=speed)))
    cycles.append(generate_cycle(robot, gait, half, CycleEnds(cycles[-1].end_feet, entry=speed)))
    fastest = max(np.abs(cycle.joint_velocities).max() for cycle in cycles)
    for before, after in pairwise(cycles):
        assert after.joint_positions[0] == pytest.approx(before.joint_positions[-1], abs=1e-9)
        # The rolling of standing feet is known to a few percent of itself.
        jump = np.abs(after.joint_velocities[0] - before.joint_velocities[-1]).max()
        assert jump < 0.01 * fastest
    for sample, cycle in ((0, cycles[0]), (-1, cycles[-1])):
        assert cycle.joint_positions[sample] == pytest.approx(robot.initial_joint_angles, abs=1e-9)
        assert cycle.joint_velocities[sample] == pytest.approx(np.zeros((4, 3)), abs=1e-9)
    # The body comes to the sum of the motions.
    pose = Pose2D(0.0, 0.0, 0.0)
    for cycle in cycles:
        pose = pose @ Pose2D(*cycle.body[-1])
    end = motion.scaled(3.0).end
    assert (pose.x, pose.y) == pytest.approx((end.x, end.y), abs=1e-9)
    assert math.remainder(pose.yaw - end.yaw, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_steady_cycle_is_what_many_equal_cycles_come_to():
    motion, speed = BodyMotion(0.2, 0.03, 0.2), BodyMotion(0.2, 0.03, 0.2).rate(WAVE.cycle_period)
    cycle = generate_cycle(ROBOT, WAVE, motion.scaled(0.5), CycleEnds(exit=speed))
    for _ in range(2):
        cycle = generate_cycle(
            ROBOT, WAVE, motion, CycleEnds(cycle.end_feet, entry=speed, exit=speed)
        )
    known = generate_steady_cycle(ROBOT, WAVE, motion)
    assert cycle.end_feet == pytest.approx(known.end_feet, abs=1e-12)
    assert cycle.joint_positions == pytest.approx(known.joint_positions, abs=1e-9)


def test_speeds_may_change_from_cycle_to_cycle():
    speeds = [
        STILL,
        Twist2D(0.04, 0.0, 0.0),
        Twist2D(0.05, 0.01, 0.03),
        Twist2D(0.0, 0.01, -0.04),
        STILL,
    ]
    feet, last = None, None
    for entry, exit in pairwise(speeds):
        mean = [
            (getattr(entry, part) + getattr(exit, part)) / 2.0
            for part in ('forward', 'left', 'turn')
        ]
        motion = BodyMotion.during(Twist2D(*mean), WAVE.cycle_period)
        cycle = generate_cycle(ROBOT, WAVE, motion, CycleEnds(feet, entry=entry, exit=exit))
        if last is not None:
            assert cycle.joint_positions[0] == pytest.approx(last.joint_positions[-1], abs=1e-9)
            assert cycle.joint_velocities[0] == pytest.approx(last.joint_velocities[-1], abs=0.005)
        feet, last = cycle.end_feet, cycle
    assert last.joint_positions[-1] == pytest.approx(ROBOT.initial_joint_angles, abs=1e-9)


def test_cycles_in_a_row_add_up_to_the_motion():
    pose = Pose2D(0.0, 0.0, 0.0)
    for _ in range(3):
        x, y, yaw = generate_cycle(ROBOT, TURN, BodyMotion(turn=math.pi / 6)).body[-1]
        pose = pose @ Pose2D(x, y, yaw)
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.0, 0.0, math.pi / 2), abs=1e-12)


# Stability.


@pytest.mark.parametrize('name', ['crawl', 'left turn', 'right turn'])
def test_with_sway_even_the_largest_motion_is_stable(name):
    assert CASES[name].cycle.least_margin > 0.03


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
    # S0's own schedule puts the center of gravity on a diagonal of the feet.
    cycle = generate_cycle(
        on_points(ROBOT), PAPER, BodyMotion(forward=stride), options=CycleOptions(0.001)
    )
    for swing in PAPER.swings:
        phase = (cycle.times > swing.liftoff) & (cycle.times < swing.touchdown)
        margin = cycle.margin[phase]
        assert min(margin[0], margin[-1]) == pytest.approx(0.0, abs=1e-4)
        assert margin.min() > -1e-6
        assert margin.max() > 0.02


def test_sway_is_what_makes_the_margin_positive():
    motion = BodyMotion(forward=S_OF_FIGURE_16)
    margins = [
        generate_cycle(ROBOT, replace(CRAWL, sway_weight=(mu, mu)), motion).least_margin
        for mu in (0.0, 0.1, 0.2, 0.4)
    ]
    assert margins == sorted(margins)
    assert margins[0] < 0.015 < 0.035 < margins[-1]


@pytest.mark.parametrize(('weight', 'still'), [((0.4, 0.0), 1), ((0.0, 0.4), 0)])
def test_the_body_sways_only_along_the_axis_that_has_a_weight(weight, still):
    gait = replace(CRAWL, sway_weight=weight)
    cycle = generate_cycle(ROBOT, gait, BodyMotion())
    assert np.ptp(cycle.body[:, still]) < 1e-12
    assert np.ptp(cycle.body[:, 1 - still]) > 0.01


def test_with_its_whole_weight_the_body_sways_to_the_centroid_of_each_support_triangle():
    gait = replace(CRAWL, sway_weight=(1.0, 1.0)).with_period(20.0)
    cycle = generate_cycle(on_points(ROBOT), gait, BodyMotion(), options=CycleOptions(0.05))
    for swing in gait.swings:
        middle = cycle.sample((swing.liftoff + swing.touchdown) / 2.0)
        down = cycle.in_contact[middle]
        centroid = cycle.feet[middle, down, :2].mean(axis=0)
        assert cycle.body[middle, :2] == pytest.approx(centroid, abs=1e-7)


# S0's figures.


def test_in_stance_the_leg_length_runs_from_200_to_215_7_mm():
    # S0 fig. 16: sqrt(200^2 + (3 S / 4)^2) = 215.7 at the stride of figs. 15 to 17.
    cycle = CASES['paper'].at(0.02, on_points(ROBOT))
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
    # S0 fig. 17: H0 = 243 mm; rolling or not.
    cycle = CASES['paper'].cycle
    arms = ROBOT.foot_positions(cycle.joint_positions)
    assert -1e3 * arms[..., 2][cycle.in_contact] == pytest.approx(243.0, abs=1e-6)


# S2: trot on a circle.

TABLE_III = [
    # R [mm], 2 delta [deg], s_step, l_step [mm], theta1, theta2 [deg], lambda1 = lambda2
    (400.0, 18.0, 113.0, 147.6, 19.3, 14.7, 1.04),
    (400.0, 10.0, 63.0, 82.2, 20.6, 15.7, 1.11),
    (500.0, 18.0, 143.0, 178.1, 15.6, 12.5, 1.07),
    (500.0, 10.0, 79.7, 99.2, 15.9, 12.7, 1.09),
]
each_row = pytest.mark.parametrize('row', TABLE_III)


def steps_and_angles_of_s2(radius, degrees):
    """Compute S2 eqs. 1 to 4: both steps [mm], and their angles to the body [deg]."""
    W, L = 115.0, 230.0
    delta = math.radians(degrees) / 2.0
    r = math.hypot(L / 2.0, W / 2.0)
    a, b = 2.0 * r * math.sin(delta), 2.0 * radius * math.sin(delta)
    phi = math.atan(W / L)
    steps, angles = [], []
    for gamma in (math.pi / 2.0 - phi, math.pi / 2.0 + phi):
        step = math.sqrt(a**2 + b**2 - 2.0 * a * b * math.cos(gamma))
        steps.append(step)
        # (4), with the whole fraction under the arccos and the deltas cancelling.
        angles.append(math.degrees(math.acos((b**2 + step**2 - a**2) / (2.0 * b * step))))
    return steps, angles


def trot_on_a_circle(radius, degrees):
    """Trot in the way of S2: on feet without size, one step of 2 delta in each half cycle."""
    robot = on_points(CUHK)
    # S2's body is no pendulum: it does not lean into its curve, and its feet stand under it.
    gait = replace(load_gait('trot', robot), pendulum_rate=0.0)
    turn = math.radians(degrees)
    motion = BodyMotion(forward=1e-3 * radius * turn, turn=turn)
    return (
        robot,
        gait,
        generate_steady_cycle(robot, gait, motion, CycleOptions(gait.cycle_period / 800.0)),
    )


@each_row
def test_the_formulas_of_s2_give_its_table_iii(row):
    steps, angles = steps_and_angles_of_s2(*row[:2])
    assert steps == pytest.approx(row[2:4], abs=0.1)
    # The angles of the table contain the compensation of slip, lambda.
    compensated = [row[6] * angle for angle in angles]
    assert compensated == pytest.approx(row[4:6], abs=0.1)


def ground_steps(gait, cycle):
    """Where each foot goes in its swing, in the ground frame, shape (4, 2) [mm]."""
    return 1e3 * (cycle.feet[-1, :, :2] - cycle.feet[0, :, :2])


@each_row
def test_the_feet_step_as_far_as_in_table_iii_of_s2(row):
    radius, degrees, short, long = row[:4]
    _, gait, cycle = trot_on_a_circle(radius, degrees)
    lengths = np.linalg.norm(ground_steps(gait, cycle), axis=1)
    # Turning left, the left feet are the inner ones.
    assert lengths == pytest.approx([short, long, short, long], abs=0.1)


@each_row
def test_the_feet_step_at_the_angles_of_table_iii_of_s2(row):
    radius, degrees, _, _, theta1, theta2, slip = row
    _, gait, cycle = trot_on_a_circle(radius, degrees)
    _, expected = steps_and_angles_of_s2(radius, degrees)
    angles = []
    for leg, (x, y) in zip(LEGS, ground_steps(gait, cycle)):
        # From the body's axis, as that is in the middle of the swing.
        swing = gait.swing(leg)
        middle = cycle.sample((swing.liftoff + swing.touchdown) / 2.0)
        angles.append(math.degrees(math.atan2(y, x) - cycle.body[middle, 2]))
    # Front feet step to the inside, hind feet to the outside; inner ones more so.
    signs = np.array([1.0, 1.0, -1.0, -1.0])
    assert signs * angles == pytest.approx(np.tile(expected, 2), abs=0.02)
    assert slip * signs * angles == pytest.approx(np.tile([theta1, theta2], 2), abs=0.1)


@pytest.mark.parametrize('motion', [BodyMotion(forward=0.1), ARC, BodyMotion(left=0.08)])
def test_in_the_ground_frame_a_trotting_foot_runs_along_half_an_ellipse(motion):
    robot = on_points(CUHK)
    gait = load_gait('trot', robot)
    cycle = generate_steady_cycle(robot, gait, motion, CycleOptions(gait.cycle_period / 800.0))
    for k, leg in enumerate(LEGS):
        path = cycle.feet[~cycle.in_contact[:, k], k]
        first, last = cycle.feet[0, k], cycle.feet[-1, k]
        step = np.linalg.norm((last - first)[:2])
        middle = (first + last) / 2.0
        along = (path - middle)[:, :2] @ ((last - first)[:2] / step)
        height = path[:, 2] - first[2]
        ellipse = (along / (step / 2.0)) ** 2 + (height / gait.swing_height) ** 2
        assert ellipse == pytest.approx(1.0, abs=1e-6)
        across = np.linalg.norm((path - middle)[:, :2] - np.outer(along, (last - first)[:2] / step))
        assert across == pytest.approx(0.0, abs=1e-7)
        assert (height >= 0.0).all()
        assert height.max() == pytest.approx(gait.swing_height, rel=1e-3), leg


def test_standing_feet_push_down_by_s2s_rho():
    # (6): rho h_step deep, as the body sees them; 0.25 x 8 mm.
    case = CASES['trot']
    feet = case.robot.foot_positions(case.fine.joint_positions)[..., 2]
    depth = case.robot.neutral_feet[:, 2].mean() - feet[case.fine.in_contact]
    assert depth.min() == pytest.approx(0.0, abs=1e-9)
    assert depth.max() == pytest.approx(0.25 * 0.008, rel=1e-3)


# S4: the proper initial posture.


def wave_of_s4(robot, beta, period=4.0):
    """S4 fig. 4: begun with all feet down, just before the first swing."""
    pause, swing = (beta - 0.75) * period, (1.0 - beta) * period
    swings, time = [], 0.0
    for leg in ('rh', 'rf', 'lh', 'lf'):
        time += pause
        swings.append(Swing(leg, time, time + swing))
        time += swing
    return replace(
        load_gait('wave', robot),
        cycle_period=period,
        swings=tuple(swings),
        sway_weight=(0.0, 0.0),
    )


@pytest.mark.parametrize('beta', [0.76, 0.8, 0.88, 0.95])
def test_steady_feet_stand_in_the_proper_initial_posture_of_s4(beta):
    robot = on_points(GENIBO)
    gait = wave_of_s4(robot, beta)
    motion = BodyMotion(forward=0.06)
    stride = beta * motion.forward  # lambda: while a foot stands
    printed = {
        'first': -(1.0 / 2.0 - (beta - 0.75) / beta) * stride,
        'second': -(1.0 / 2.0 - (beta - 0.5) / beta) * stride,
        'third': ((beta - 0.25) / beta - 1.0 / 2.0) * stride,
        'fourth': stride / 2.0,
    }
    offset = steady_ends(robot, gait, motion).start_feet - robot.neutral_feet
    for swing, expected in zip(gait.swings, printed.values()):
        assert offset[LEGS.index(swing.leg)] == pytest.approx([expected, 0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize('beta', [0.76, 0.88])
def test_the_proper_initial_posture_makes_the_swing_ranges_even(beta):
    # S4 fig. 7 b: every foot goes as far to the front of its place as to the back.
    robot = on_points(GENIBO)
    motion = BodyMotion(forward=0.06)
    cycle = generate_steady_cycle(robot, wave_of_s4(robot, beta), motion, CycleOptions(0.004))
    off = robot.foot_positions(cycle.joint_positions) - robot.neutral_feet
    for k in range(4):
        standing = off[cycle.in_contact[:, k], k, 0]
        half = beta * motion.forward / 2.0
        assert (standing.min(), standing.max()) == pytest.approx((-half, half), rel=0.02)


def test_the_proper_initial_posture_lengthens_genibos_longest_stride_by_a_quarter():
    # S4 sec. IV.1: from 60 to 75 mm. By reach alone: it is a question of where the feet are.
    robot = replace(GENIBO, velocity=np.full((4, 3), np.inf))
    gait = replace(wave_of_s4(robot, 0.88), swing_height=0.01)

    def longest(footholds):
        low, high = 0.0, 0.4
        for _ in range(20):
            middle = (low + high) / 2.0
            try:
                generate_steady_cycle(
                    robot, replace(gait, footholds=footholds), BodyMotion(forward=middle)
                )
                low = middle
            except GaitError:
                high = middle
        return low

    assert longest('mid_stance') >= 1.25 * longest('initial_posture') > 0.05


@pytest.mark.parametrize(
    'motion',
    [BodyMotion(0.1), BodyMotion(left=0.05), BodyMotion(turn=0.5), BodyMotion(0.1, 0.02, 0.3)],
)
def test_whatever_the_motion_in_mid_stance_every_foot_is_where_it_is_in_the_initial_posture(
    motion,
):
    robot = on_points(ROBOT)
    gait = replace(WAVE, sway_weight=(0.0, 0.0))
    period = gait.cycle_period
    cycle = generate_steady_cycle(robot, gait, motion, CycleOptions(period / 800.0))
    for k, leg in enumerate(LEGS):
        swing = gait.swing(leg)
        middle = (swing.touchdown + period + swing.liftoff) / 2.0 % period
        sample = cycle.sample(middle)
        foot = robot.foot_positions(cycle.joint_positions[sample])[k]
        assert foot == pytest.approx(robot.neutral_feet[k], abs=2e-4)


# Left and right.


@pytest.mark.parametrize('name', CASES)
def test_a_mirrored_motion_of_the_mirrored_gait_is_a_mirrored_cycle(name):
    case = CASES[name]
    feet = case.ends.start_feet
    ends = CycleEnds(
        None if feet is None else feet[ACROSS] * [1.0, -1.0, 1.0],
        mirrored_twist(case.ends.entry),
        mirrored_twist(case.ends.exit),
    )
    motion = BodyMotion(case.motion.forward, -case.motion.left, -case.motion.turn)
    mirrored = Case(case.gait.mirrored(), motion, case.robot, ends).cycle
    feet = case.robot.foot_positions(mirrored.joint_positions)[:, ACROSS] * [1.0, -1.0, 1.0]
    assert feet == pytest.approx(case.robot.foot_positions(case.cycle.joint_positions), abs=1e-9)
    assert mirrored.body * [1.0, -1.0, -1.0] == pytest.approx(case.cycle.body, abs=1e-12)
    assert mirrored.margin == pytest.approx(case.cycle.margin, abs=1e-9)
    assert (mirrored.in_contact[:, ACROSS] == case.cycle.in_contact).all()


def test_a_right_turn_mirrors_a_left_turn_in_every_joint():
    left, right = CASES['left turn'].cycle, CASES['right turn'].cycle
    assert right.joint_positions[:, ACROSS] * [-1.0, 1.0, 1.0] == pytest.approx(
        left.joint_positions, abs=1e-12
    )


# Samples and trajectories.


def test_feet_that_start_elsewhere_end_in_the_initial_posture_all_the_same():
    rng = np.random.default_rng(1)
    start = ROBOT.neutral_feet.copy()
    start[:, :2] += rng.uniform(-0.02, 0.02, (4, 2))
    cycle = generate_cycle(ROBOT, CRAWL, BodyMotion(forward=0.1), CycleEnds(start))
    assert ROBOT.foot_positions(cycle.joint_positions[0]) == pytest.approx(start, abs=1e-9)
    assert cycle.joint_positions[-1] == pytest.approx(ROBOT.initial_joint_angles, abs=1e-9)


def test_the_end_feet_are_those_of_the_last_joint_angles():
    for case in CASES.values():
        expected = case.robot.foot_positions(case.cycle.joint_positions[-1])
        assert case.cycle.end_feet == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize('period', [0.02, 0.03, 0.007, 5.0, 9.0])
def test_samples_are_evenly_spaced_no_farther_than_asked_and_end_with_the_cycle(period):
    times = generate_cycle(
        ROBOT, CRAWL, BodyMotion(forward=0.1), options=CycleOptions(period)
    ).times
    assert (times[0], times[-1]) == (0.0, 5.0)
    assert np.diff(times) == pytest.approx(np.full(len(times) - 1, times[1]))
    assert times[1] <= period + 1e-9


def test_how_finely_a_cycle_is_sampled_does_not_change_it():
    for case in CASES.values():
        coarse, fine = case.cycle, case.fine
        every = (len(fine.times) - 1) // (len(coarse.times) - 1)
        assert coarse.times == pytest.approx(fine.times[::every])
        assert coarse.joint_positions == pytest.approx(fine.joint_positions[::every], abs=2e-3)


def test_the_trajectory_begins_with_the_first_movement_and_ends_with_the_cycle():
    cycle = generate_cycle(ROBOT, CRAWL, BodyMotion(forward=S_MAX))
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


@pytest.mark.parametrize('name', ['wave', 'start of a wave', 'trot', 'start of a trot'])
def test_the_trajectory_of_a_steady_gait_is_the_whole_cycle(name):
    case = CASES[name]
    trajectory = case.cycle.trajectory(case.robot, stamp=3.0)
    assert trajectory.times == pytest.approx(case.cycle.times)
    assert trajectory.end == pytest.approx(3.0 + case.gait.cycle_period)


@pytest.mark.parametrize('period', [0.02, 0.03, 0.07])
def test_whatever_the_sample_period_no_movement_is_cut_off(period):
    cycle = generate_cycle(ROBOT, TURN, BodyMotion(turn=0.5), options=CycleOptions(period))
    trajectory = cycle.trajectory(ROBOT, stamp=0.0)
    assert trajectory.times[0] <= TURN.motion_start + 1e-9 < trajectory.times[0] + period + 1e-9
    # Rolling is interpolated, and so begins a little before the first movement.
    assert np.abs(trajectory.velocities[0]).max() < 0.01
    assert trajectory.positions[0] == pytest.approx(ROBOT.initial_joint_angles.flat, abs=5e-4)


def test_foot_paths_may_be_tracked_in_another_way_than_by_inverse_kinematics():
    seen = {}

    def track(robot, times, feet, velocities):
        seen.update(times=times, feet=feet, velocities=velocities)
        positions = robot.joint_angles(feet) + 0.001
        return positions, robot.joint_velocities(positions, velocities)

    plain = CASES['crawl'].cycle
    tracked = generate_cycle(
        ROBOT, CRAWL, BodyMotion(forward=S_MAX), options=CycleOptions(5.0 / 200.0, track=track)
    )
    assert tracked.joint_positions == pytest.approx(plain.joint_positions + 0.001)
    assert (seen['times'] == plain.times).all()
    assert seen['feet'] == pytest.approx(ROBOT.foot_positions(plain.joint_positions), abs=1e-9)


# What is not possible.


@pytest.mark.parametrize('stride', [0.8, -0.8])
def test_a_motion_beyond_the_legs_is_refused(stride):
    with pytest.raises(FootTargetUnreachable, match='foot '):
        generate_cycle(ROBOT, CRAWL, BodyMotion(forward=stride))


def test_a_joint_that_would_leave_its_range_is_named():
    stiff = replace(ROBOT, upper=np.tile([0.2, 1.45, 2.8], (4, 1)))
    with pytest.raises(JointLimitExceeded, match=r'hip_yaw_joint would go to .* to 0\.200 rad'):
        generate_cycle(stiff, CRAWL, BodyMotion(forward=S_MAX))


def test_a_joint_that_would_be_too_fast_is_named_with_its_speed():
    slow = replace(ROBOT, velocity=np.tile([6.0, 6.0, 0.5], (4, 1)))
    with pytest.raises(JointLimitExceeded, match=r'knee_pitch_joint .* -0\.500 to 0\.500 rad/s'):
        generate_cycle(slow, CRAWL, BodyMotion(forward=S_MAX))


def test_of_four_different_legs_the_one_that_is_too_fast_is_named():
    velocity = ROBOT.velocity.copy()
    velocity[2, 2] = 0.1
    with pytest.raises(JointLimitExceeded, match=r'lh_knee_pitch_joint .* -0\.100 to 0\.100'):
        generate_cycle(replace(ROBOT, velocity=velocity), CRAWL, BodyMotion(forward=0.1))


def test_a_cycle_below_the_least_margin_is_refused_with_both_numbers():
    with pytest.raises(UnstableCycle, match=r'margin of -?\d\.\d mm; it must be at least 10\.0'):
        generate_cycle(
            ROBOT, PAPER, BodyMotion(forward=0.1), options=CycleOptions(least_margin=0.01)
        )


def test_a_dynamic_gait_may_have_its_centre_of_mass_beside_its_two_feet_so_far_and_no_farther():
    cycle = generate_cycle(CUHK, TROT, BodyMotion(forward=0.05))
    assert cycle.least_margin < 0.0
    for margin in (-math.inf, cycle.least_margin - 1e-6):
        generate_cycle(
            CUHK, TROT, BodyMotion(forward=0.05), options=CycleOptions(least_margin=margin)
        )
    with pytest.raises(UnstableCycle):
        generate_cycle(
            CUHK,
            TROT,
            BodyMotion(forward=0.05),
            options=CycleOptions(least_margin=cycle.least_margin + 1e-6),
        )


def test_the_largest_cycle_is_the_whole_one_if_that_is_possible():
    motion = BodyMotion(forward=0.2)
    assert (
        generate_largest_cycle(ROBOT, CRAWL, motion, options=CycleOptions(least_margin=0.01)).motion
        == motion
    )


def test_the_largest_cycle_may_be_asked_for_more_than_the_legs_and_the_margin_require():
    def accept(cycle):
        if cycle.motion.forward > 0.11:
            raise GaitError('too far')

    cycle = generate_largest_cycle(ROBOT, CRAWL, BodyMotion(forward=0.2), accept=accept)
    assert cycle.motion == BodyMotion(forward=0.1)


def test_the_largest_cycle_shrinks_a_motion_by_eighths_until_it_is_possible():
    motion = BodyMotion(forward=0.7, left=0.1, turn=0.2)
    cycle = generate_largest_cycle(ROBOT, CRAWL, motion, options=CycleOptions(least_margin=0.01))
    fraction = cycle.motion.forward / motion.forward
    assert 0.0 < fraction < 1.0
    assert 8.0 * fraction == pytest.approx(round(8.0 * fraction))
    assert cycle.motion.left == pytest.approx(fraction * motion.left)
    assert cycle.motion.turn == pytest.approx(fraction * motion.turn)
    assert cycle.least_margin >= 0.01
    with pytest.raises(GaitError):
        generate_cycle(
            ROBOT, CRAWL, motion.scaled(fraction + 0.125), options=CycleOptions(least_margin=0.01)
        )


def test_a_robot_on_its_way_that_is_asked_too_much_comes_nearer_to_rest():
    motion = BodyMotion(forward=0.3)
    speed = motion.rate(WAVE.cycle_period)
    feet = steady_ends(ROBOT, WAVE, motion).start_feet
    cycle = generate_largest_cycle(
        ROBOT, WAVE, BodyMotion(forward=2.0), CycleEnds(feet, entry=speed, exit=speed.scaled(6.0))
    )
    fraction = cycle.exit.forward / (6.0 * speed.forward)
    assert 0.0 <= fraction < 1.0
    assert 8.0 * fraction == pytest.approx(round(8.0 * fraction))
    # What is left of the motion: from all of it down to stopping in half a cycle's distance.
    assert cycle.motion.forward == pytest.approx(fraction * 2.0 + (1.0 - fraction) * 0.15)
    assert cycle.joint_positions[0] == pytest.approx(
        generate_steady_cycle(ROBOT, WAVE, motion).joint_positions[0], abs=1e-9
    )


def test_if_not_even_an_eighth_is_possible_the_reason_is_told():
    with pytest.raises(UnstableCycle):
        generate_largest_cycle(
            ROBOT, CRAWL, BodyMotion(forward=0.1), options=CycleOptions(least_margin=1.0)
        )
    with pytest.raises(FootTargetUnreachable):
        generate_largest_cycle(ROBOT, CRAWL, BodyMotion(forward=50.0))


# Curves: a pendulum over its feet.


@pytest.mark.parametrize('velocity', [(0.3, 0.0, 0.8), (-0.2, 0.0, 0.8), (0.1, 0.2, -1.0)])
def test_a_trot_stands_as_far_outside_its_curve_as_gives_the_acceleration_that_it_needs(velocity):
    forward, left, turn = velocity
    ahead, aside = lean_on_curve(TROT, Twist2D(*velocity))
    # omega^2 times the lead of the body over its feet is omega_z x v.
    pull = -(TROT.pendulum_rate**2) * np.array([ahead, aside])
    assert pull == pytest.approx([-turn * left, turn * forward])


@pytest.mark.parametrize(
    ('gait', 'velocity'),
    [('trot', (0.3, 0.1, 0.0)), ('trot', (0.0, 0.0, 1.0)), ('wave', (0.1, 0.0, 0.5))],
)
def test_straight_on_in_place_and_in_a_static_gait_nothing_leans(gait, velocity):
    assert lean_on_curve(load_gait(gait, CUHK), Twist2D(*velocity)) == (0.0, 0.0)


def test_on_a_curve_the_feet_of_a_trot_are_outside_it_in_mid_stance():
    motion = BodyMotion(forward=0.1, turn=0.3)
    velocity = motion.rate(TROT.cycle_period)
    ahead, aside = lean_on_curve(TROT, velocity)
    cycle = generate_steady_cycle(CUHK, TROT, motion, CycleOptions(0.002))
    beside, means = CUHK.foot_positions(cycle.joint_positions)[..., :2], []
    for k, leg in enumerate(LEGS):
        swing = TROT.swing(leg)
        middle = (swing.touchdown + TROT.cycle_period + swing.liftoff) / 2.0
        row = np.argmin(np.abs(cycle.times - middle % TROT.cycle_period))
        means.append(beside[row, k] - CUHK.neutral_feet[k, :2])
    assert aside < -1e-3
    assert np.mean(means, axis=0) == pytest.approx([ahead, aside], abs=1e-4)
