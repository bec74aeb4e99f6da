"""Laws of the planar active pair of legs: S3, corrected."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from quad_common.errors import PairCannotClose, PairUndetermined, ParameterError
from quad_common.planar_pair.active_pair import (
    with_hip_held,
    with_hip_joints_held,
    with_hips_placed,
    with_knee_held,
)
from quad_common.planar_pair.planar_pair import (
    ActivePair,
    JointAngles,
    PairPosture,
    PlanarLeg,
    points_of,
    posture_of,
    wrap,
)
from quad_common.planar_pair.planar_triangles import nearest_signs
from quad_common.robot_files.robot_file import load_robot

ANGLES = ('theta', 'u1_i', 'u2_i', 'u1_j', 'u2_j')
PAIRS = {
    'j in front': ActivePair(PlanarLeg(0.2, 0.17), PlanarLeg(0.21, 0.19), -0.2, 0.3),
    'j behind': ActivePair(PlanarLeg(0.2, 0.17), PlanarLeg(0.21, 0.19), 0.3, -0.2),
    'long lower links': ActivePair(PlanarLeg(0.15, 0.3), PlanarLeg(0.1, 0.25), 0.1, 0.25),
    'equal links': ActivePair(PlanarLeg(0.7, 0.7), PlanarLeg(0.7, 0.7), -1.0, 1.0),
}
PAIR = PAIRS['j in front']
UPRIGHT = posture_of(PAIR, 0.3j, 0.05, JointAngles(0.7, -1.9, 0.8, -2.0))
FEET = points_of(PAIR, UPRIGHT)

each_pair = pytest.mark.parametrize('pair', PAIRS.values(), ids=PAIRS)


def knee_held(pair, p, x, **how):
    return with_knee_held(pair, p.hip_i, x.foot_i, x.foot_j, p.u1_j, **how)


def hip_held(pair, p, x, **how):
    return with_hip_held(pair, p.hip_i, x.foot_i, x.foot_j, p.u2_j, **how)


def hips_placed(pair, p, x, **how):
    return with_hips_placed(pair, p.hip_i, p.hip_j, x.foot_i, x.foot_j, **how)


def hip_joints_held(pair, p, x, **how):
    return with_hip_joints_held(pair, p.theta, p.u2_i, p.u2_j, x.foot_i, x.foot_j, **how)


CASES = {
    'knee held': (knee_held, ('branch', 'knee_i'), ('hip_i', 'u1_j')),
    'hip held': (hip_held, ('branch', 'knee_i'), ('hip_i', 'u2_j')),
    'hips placed': (hips_placed, ('knee_i', 'knee_j'), ('hip_i', 'hip_j')),
    'hip joints held': (hip_joints_held, ('branch',), ('theta', 'u2_i', 'u2_j')),
}
each_case = pytest.mark.parametrize(('solve', 'branches', 'held'), CASES.values(), ids=CASES)


def random_postures(pair, count, seed=0):
    rng = np.random.default_rng(seed)
    place = rng.uniform(-1.0, 1.0, count) + 1j * rng.uniform(-1.0, 1.0, count)
    theta, *angles = rng.uniform(-math.pi, math.pi, (5, count))
    return posture_of(pair, place, theta, JointAngles(*angles))


def off(one, other):
    """How far two sets of postures are apart, the larger of angles and places, for each."""
    parts = [np.abs(wrap(getattr(one, name) - getattr(other, name))) for name in ANGLES]
    return np.maximum.reduce(
        [*parts, np.abs(one.hip_i - other.hip_i), np.abs(one.hip_j - other.hip_j)]
    )


def combinations(branches):
    for numbers in np.ndindex(*[2] * len(branches)):
        yield {name: ('down', 'up')[n] for name, n in zip(branches, numbers)}


def is_up(pair, p, name, solve):
    """Say of postures on which side they are, by the definition of the branch's name."""
    if name == 'knee_i':
        return p.u1_i <= 0.0
    if name == 'knee_j':
        return p.u1_j <= 0.0
    body = np.exp(-1j * p.theta)
    x = points_of(pair, p)
    if solve is knee_held:
        return ((x.foot_j - p.hip_j) * body).imag > 0.0
    to_knee, lower = x.knee_j - p.hip_i, x.foot_j - x.knee_j
    if solve is hip_held:
        return (to_knee.conj() * lower).imag * pair.span > 0.0
    # Mirrored at the line between both circles' centers, the body would be lower.
    upper_i, upper_j = x.knee_i - p.hip_i, x.knee_j - p.hip_i
    one, other = x.foot_i - upper_i, x.foot_j - upper_j
    along = (other - one) / np.abs(other - one)
    mirrored = one + along**2 * (p.hip_i - one).conj()
    return p.hip_i.imag > mirrored.imag


@each_pair
@each_case
def test_random_postures_come_back_on_the_branch_that_is_theirs(pair, solve, branches, held):
    posture = random_postures(pair, 4000)
    points = points_of(pair, posture)
    checked = 0
    errors = []
    for how in combinations(branches):
        mine = np.ones(4000, dtype=bool)
        for name, side in how.items():
            mine &= is_up(pair, posture, name, solve) == (side == 'up')
        error = off(solve(pair, posture, points, **how), posture)
        errors.append(error[mine])
        checked += int(mine.sum())
        # The other branches are other postures.
        assert np.median(error[~mine]) > 0.01
    assert checked == 4000
    # Close to where both solutions meet, rounding of what is given is amplified.
    assert np.sort(np.concatenate(errors))[-4] < 1e-9


@each_pair
@each_case
def test_every_solution_has_its_feet_and_what_is_held_where_they_are_given(
    pair, solve, branches, held
):
    posture = random_postures(pair, 500, seed=1)
    points = points_of(pair, posture)
    for how in combinations(branches):
        found = solve(pair, posture, points, **how)
        feet = points_of(pair, found)
        assert feet.foot_i == pytest.approx(points.foot_i, abs=1e-9)
        assert feet.foot_j == pytest.approx(points.foot_j, abs=1e-9)
        assert found.hip_j - found.hip_i == pytest.approx(pair.span * np.exp(1j * found.theta))
        for name in held:
            given = getattr(posture, name)
            assert getattr(found, name) == pytest.approx(given, abs=1e-12)
        for name in ANGLES:
            assert (getattr(found, name) >= -math.pi).all()
            assert (getattr(found, name) < math.pi).all()


def terms_of_the_paper(pair, posture, feet):
    """a, b, c and g of S3 eqs. 35 to 44, c corrected."""
    W = pair.leg_j.upper + pair.leg_j.lower * np.exp(1j * posture.u1_j)
    Q = pair.span / W
    g = np.abs((feet.foot_j - posture.hip_i) / W)
    return 2.0 * Q.real, 2.0 * Q.imag, g**2 - 1.0 - np.abs(Q) ** 2, g


@each_pair
def test_the_knee_held_solves_the_papers_equation_with_g_squared(pair):
    posture = random_postures(pair, 500, seed=2)
    feet = points_of(pair, posture)
    a, b, c, g = terms_of_the_paper(pair, posture, feet)
    for branch in ('up', 'down'):
        u2 = knee_held(pair, posture, feet, branch=branch).u2_j
        left = a * np.cos(u2) + b * np.sin(u2)
        assert left == pytest.approx(c, rel=1e-9, abs=1e-9)
        # S3 eq. 44 as printed has g to the first power.
        assert np.median(np.abs(left - (c - g**2 + g))) > 0.05


@each_pair
def test_both_solutions_are_those_of_the_papers_arcs_with_pi_minus_psi(pair):
    posture = random_postures(pair, 500, seed=3)
    feet = points_of(pair, posture)
    a, b, c, _ = terms_of_the_paper(pair, posture, feet)
    phi = np.arctan(a / b)
    psi = np.arcsin(np.clip(np.sign(b) * c / np.hypot(a, b), -1.0, 1.0))
    of_paper = np.array([psi - phi, math.pi - psi - phi])
    found = np.array([knee_held(pair, posture, feet, branch=side).u2_j for side in ('up', 'down')])
    apart = np.abs(wrap(found[:, None] - of_paper[None]))
    # Each solution is one of the paper's, and both are found.
    assert apart.min(axis=1).max() < 1e-6
    assert apart.min(axis=0).max() < 1e-6
    assert np.median(apart.min(axis=1)) < 1e-13
    # S3 eqs. 53 and 54 as printed, psi - phi +- pi, solve another equation.
    printed = psi - phi + math.pi
    assert np.median(np.abs(a * np.cos(printed) + b * np.sin(printed) - c)) > 0.1


@pytest.mark.parametrize('name', ['j in front', 'j behind'])
def test_with_a_straight_knee_both_solutions_are_the_papers_plus_and_minus_psi(name):
    pair = PAIRS[name]
    posture = random_postures(pair, 500, seed=4)
    posture = replace(posture, u1_j=np.zeros(500))
    feet = points_of(pair, posture)
    a, b, c, _ = terms_of_the_paper(pair, posture, feet)
    assert (b == 0.0).all()
    # S3 eqs. 47 and 49; a is positive with j in front, and negative with j behind (S3 eq. 48).
    assert (np.sign(a) == np.sign(pair.span)).all()
    psi = np.arccos(np.clip(c / a, -1.0, 1.0))
    assert knee_held(pair, posture, feet, branch='up').u2_j == pytest.approx(psi, abs=1e-6)
    assert knee_held(pair, posture, feet, branch='down').u2_j == pytest.approx(-psi, abs=1e-6)


@pytest.mark.parametrize('name', ['j in front', 'j behind', 'equal links'])
def test_the_branch_has_the_papers_name_where_the_two_solutions_differ_in_sign(name):
    pair = PAIRS[name]
    posture = random_postures(pair, 2000, seed=5)
    feet = points_of(pair, posture)
    up = knee_held(pair, posture, feet, branch='up').u2_j
    down = knee_held(pair, posture, feet, branch='down').u2_j
    told_apart = (up > 0.0) != (down > 0.0)
    assert 0.2 < told_apart.mean() < 0.95
    assert (up[told_apart] > 0.0).all()


def test_a_robot_on_its_feet_is_on_the_branch_that_is_taken_by_default():
    for found in (
        knee_held(PAIR, UPRIGHT, FEET),
        hips_placed(PAIR, UPRIGHT, FEET),
        hip_joints_held(PAIR, UPRIGHT, FEET),
    ):
        assert float(off(found, UPRIGHT)) < 1e-12


@each_case
def test_the_mirrored_pair_has_the_mirrored_posture(solve, branches, held):
    posture = random_postures(PAIR, 300, seed=6)
    points = points_of(PAIR, posture)
    mirrored_pair = ActivePair(PAIR.leg_i, PAIR.leg_j, -PAIR.lambda_i, -PAIR.lambda_j)

    def mirror(p):
        legs = JointAngles(-p.u1_i, math.pi - p.u2_i, -p.u1_j, math.pi - p.u2_j)
        return posture_of(mirrored_pair, -p.hip_i.conj(), -p.theta, legs)

    mirrored = mirror(posture)
    mirrored_points = points_of(mirrored_pair, mirrored)
    assert mirrored_points.foot_j == pytest.approx(-points.foot_j.conj())
    for how in combinations(branches):
        # Clockwise for counter-clockwise: knees change their names, up stays up.
        other = {
            name: side if name == 'branch' else {'up': 'down', 'down': 'up'}[side]
            for name, side in how.items()
        }
        one = mirror(solve(PAIR, posture, points, **how))
        two = solve(mirrored_pair, mirrored, mirrored_points, **other)
        assert np.quantile(off(one, two), 0.99) < 1e-9


def test_hips_may_be_given_in_either_order():
    posture = random_postures(PAIR, 200, seed=7)
    points = points_of(PAIR, posture)
    found = hips_placed(PAIR, posture, points, knee_i='up', knee_j='down')
    other = with_hips_placed(
        PAIR.swapped(),
        posture.hip_j,
        posture.hip_i,
        points.foot_j,
        points.foot_i,
        knee_i='down',
        knee_j='up',
    ).swapped()
    assert off(found, other).max() < 1e-9


def motion(count):
    """A walk-like motion of the inputs, and its true postures: knee j nearly straightens."""
    t = np.linspace(0.0, 2.0 * math.pi, count)
    return posture_of(
        PAIR,
        0.3j + 0.03 * np.exp(1j * t),
        0.1 * np.sin(t),
        JointAngles(
            -1.1 - 0.3 * np.sin(2.0 * t),
            -1.2 + 0.2 * np.cos(t),
            0.52 + 0.5 * np.cos(t),
            -2.0 + 0.3 * np.sin(t),
        ),
    )


@each_case
def test_a_motion_is_followed_from_the_posture_before_it(solve, branches, held):
    truth = motion(2000)
    points = points_of(PAIR, truth)
    assert float(truth.u1_j.min()) == pytest.approx(0.02, abs=1e-3)
    found = solve(PAIR, truth, points, previous=truth[0])
    assert off(found, truth).max() < 1e-8
    # From one sample to the next in separate calls, as a controller does it.
    now = truth[0]
    for index in range(0, 2000, 50):
        now = solve(PAIR, truth[index], points_at(points, index), previous=now)
        assert float(off(now, truth[index])) < 1e-8


def points_at(points, index):
    return type(points)(*(point[index] for point in points))


@each_case
def test_the_posture_before_decides_and_not_the_named_branch(solve, branches, held):
    posture = posture_of(PAIR, 0.3j, 0.05, JointAngles(0.9, -1.9, 0.8, -2.4))
    feet = points_of(PAIR, posture)
    for names in combinations(branches):
        before = solve(PAIR, posture, feet, **names)
        for how in combinations(branches):
            found = solve(PAIR, posture, feet, previous=before, **how)
            assert float(off(found, before)) < 1e-12


def test_a_motion_that_crosses_the_singularity_stays_continuous_and_may_change_its_name():
    # Hip i swings leg j's triangle through its flat posture, where both solutions meet.
    truth = replace(motion(4000), u1_j=np.full(4000, 0.4))
    u2 = np.linspace(-0.6, 0.6, 4000)
    joints = JointAngles(truth.u1_i, truth.u2_i, 0.4, u2)
    truth = posture_of(PAIR, truth.hip_i, truth.theta, joints)
    points = points_of(PAIR, truth)
    found = knee_held(PAIR, truth, points, previous=truth[0])
    steps = np.abs(np.diff(found.u2_j))
    assert steps.max() < 0.05
    named = knee_held(PAIR, truth, points, branch='down')
    assert np.abs(np.diff(named.u2_j)).max() < 0.05


@pytest.mark.parametrize('shape', [(400,), (200, 3), (1,)])
@pytest.mark.parametrize('kept', [1.0, -1.0])
def test_the_nearest_solution_is_the_one_that_a_loop_over_the_samples_finds(shape, kept):
    rng = np.random.default_rng(8)
    middle = np.cumsum(rng.normal(scale=0.4, size=shape), axis=0)
    # Rounded, so that some are equally near.
    middle, half = np.round(middle, 1), np.round(rng.uniform(0.0, 1.5, shape), 1)
    before = rng.uniform(-3.0, 3.0, shape[1:])
    signs = nearest_signs(middle, half, before, kept)
    columns = (np.reshape(part, (shape[0], -1)) for part in (middle, half, signs))
    for m, h, s, last in zip(*(part.T for part in columns), np.reshape(before, -1)):
        sign = kept
        for index in range(len(m)):
            plus = abs(float(wrap(m[index] + h[index] - last)))
            minus = abs(float(wrap(m[index] - h[index] - last)))
            if plus != pytest.approx(minus, abs=1e-9):
                sign = 1.0 if plus < minus else -1.0
            elif plus != minus:
                # A tie but for rounding: either will do.
                sign = s[index]
            assert s[index] == sign
            last = m[index] + sign * h[index]


def test_inputs_broadcast_and_single_postures_agree_with_many():
    heights = np.linspace(0.28, 0.32, 5)[:, None]
    knees = np.linspace(0.6, 0.9, 4)
    grid = with_knee_held(PAIR, 1j * heights, FEET.foot_i, FEET.foot_j, knees)
    assert {getattr(grid, field.name).shape for field in fields(grid)} == {(5, 4)}
    for row, column in np.ndindex(5, 4):
        hip = complex(0.0, heights[row, 0])
        one = with_knee_held(PAIR, hip, FEET.foot_i, FEET.foot_j, knees[column])
        assert {np.shape(getattr(one, field.name)) for field in fields(one)} == {()}
        many = PairPosture(*(getattr(grid, field.name)[row, column] for field in fields(grid)))
        assert float(off(one, many)) < 1e-12


@each_case
def test_no_posture_is_no_error(solve, branches, held):
    none = random_postures(PAIR, 0)
    assert solve(PAIR, none, points_of(PAIR, none)).theta.shape == (0,)


def test_an_arrays_first_posture_that_does_not_close_is_named_with_the_numbers():
    hips = np.array([0.3j, 0.31j, -3.0 + 0.3j, -4.0 + 0.3j])
    with pytest.raises(PairCannotClose) as caught:
        with_knee_held(PAIR, hips, FEET.foot_i, FEET.foot_j, 0.8)
    error = caught.value
    W = abs(0.21 + 0.19 * np.exp(0.8j))
    assert error.index == 2
    assert error.distance == pytest.approx(abs(FEET.foot_j - hips[2]))
    assert error.reach == pytest.approx((0.5 - W, 0.5 + W))
    assert str(error) == (
        f'posture 2: hip i and foot j are {error.distance:.3f} m apart; body and leg j with its '
        f'knee as held reach {0.5 - W:.3f} to {0.5 + W:.3f} m'
    )


def test_one_posture_has_no_number_and_one_of_a_table_has_two():
    with pytest.raises(PairCannotClose, match=r'^hip i and foot j are 3\.') as caught:
        with_knee_held(PAIR, -3.0 + 0.3j, FEET.foot_i, FEET.foot_j, 0.8)
    assert caught.value.index is None
    hips = np.array([[0.3j, 0.3j], [0.3j, -3.0 + 0.3j]])
    with pytest.raises(PairCannotClose, match=r'^posture \(1, 1\): hip i') as caught:
        with_hip_held(PAIR, hips, FEET.foot_i, FEET.foot_j, -2.0)
    assert caught.value.index == (1, 1)


@pytest.mark.parametrize(
    ('call', 'ends', 'distance', 'reach'),
    [
        # P = 0.5 + 0.21 at u2 = 0.
        (lambda: with_hip_held(PAIR, 0j, 0.3, 0.51, 0.0), 'hip i and foot j', 0.51, (0.52, 0.90)),
        (lambda: with_hip_held(PAIR, 0j, 0.3, 0.91, 0.0), 'hip i and foot j', 0.91, (0.52, 0.90)),
        (lambda: with_knee_held(PAIR, 0j, 0.3, 0.05, 0.0), 'hip i and foot j', 0.05, (0.10, 0.90)),
        (lambda: with_knee_held(PAIR, 0j, 0.38, 0.5, 0.0), 'hip i and foot i', 0.38, (0.03, 0.37)),
        (lambda: with_knee_held(PAIR, 0j, 0.02, 0.5, 0.0), 'hip i and foot i', 0.02, (0.03, 0.37)),
        (lambda: with_knee_held(PAIR, 0j, 0.0, 0.5, 0.0), 'hip i and foot i', 0.0, (0.03, 0.37)),
        (lambda: with_hips_placed(PAIR, 0, 0.5, 0.3j, 0.91), 'hip j and foot j', 0.41, (0.02, 0.4)),
        (lambda: with_hips_placed(PAIR, 0, 0.6, 0.3j, 0.9), 'hip i and hip j', 0.6, (0.5, 0.5)),
        (
            lambda: with_hip_joints_held(PAIR, 0.0, 0.0, 0.0, 0.2, 1.2),
            'the feet, less body and upper links,',
            0.49,
            (0.02, 0.36),
        ),
        (
            lambda: with_hip_joints_held(PAIR, 0.0, 0.0, 0.0, 0.2, 0.72),
            'the feet, less body and upper links,',
            0.01,
            (0.02, 0.36),
        ),
    ],
)
def test_each_condition_of_existence_has_its_error(call, ends, distance, reach):
    with pytest.raises(PairCannotClose) as caught:
        call()
    assert caught.value.distance == pytest.approx(distance)
    assert caught.value.reach == pytest.approx(reach)
    assert str(caught.value).startswith(f'{ends} are {distance:.3f} m apart; ')


def test_the_very_edge_of_the_reach_is_reached_and_a_hair_beyond_is_not():
    for side in ('up', 'down'):
        straight = with_hip_held(PAIR, 0.0, 0.37, 0.9, 0.0, branch=side, knee_i=side)
        assert float(straight.theta) == pytest.approx(0.0, abs=1e-6)
        assert float(straight.u1_j) == pytest.approx(0.0, abs=1e-6)
        assert float(straight.u1_i) == pytest.approx(0.0, abs=1e-6)
    with pytest.raises(PairCannotClose, match=r'0\.900000100 m apart.* 0\.900000000 m'):
        with_hip_held(PAIR, 0.0, 0.37, 0.9 + 1e-7, 0.0)


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
@each_case
def test_what_is_not_finite_is_refused(solve, branches, held, bad):
    for name in (*held, 'foot_j'):
        given, points = UPRIGHT, FEET
        if name == 'foot_j':
            points = FEET._replace(foot_j=FEET.foot_j + bad)
        else:
            given = replace(UPRIGHT, **{name: getattr(UPRIGHT, name) + bad})
        with pytest.raises(PairCannotClose), np.errstate(invalid='ignore'):
            solve(PAIR, given, points)


def test_where_two_points_coincide_the_pair_may_turn_and_that_is_said():
    pair = PAIRS['equal links']
    with pytest.raises(PairUndetermined, match='may still turn: foot i is at hip i'):
        with_knee_held(pair, 1j, 1j, 2.0 + 0j, 0.2)
    # Body and straight leg are of one length: foot j at hip i.
    even = replace(pair, lambda_j=0.4)
    with pytest.raises(PairUndetermined, match='foot j is at hip i or at hip j'):
        with_knee_held(even, 1j, 0j, 1j, 0.0)
    with pytest.raises(PairUndetermined, match='foot j or knee j is at hip i'):
        with_hip_held(replace(pair, lambda_j=-0.3), 0j, 0.5, 0.7, -math.pi)
    with pytest.raises(PairUndetermined, match=r'posture 1: .* lower links may turn in parallel'):
        with_hip_joints_held(pair, 0.0, -2.0, [-1.9, -2.0], 0.0, 2.0)


def test_measures_that_are_no_pair_and_names_that_are_no_branch_are_refused():
    with pytest.raises(ParameterError, match=r"'upper' is 0\.0"):
        PlanarLeg(0.0, 0.1)
    with pytest.raises(ParameterError, match="'lower' is nan"):
        PlanarLeg(0.1, math.nan)
    with pytest.raises(ParameterError, match=r"'lambda_j' is .* must be another than lambda_i"):
        ActivePair(PlanarLeg(0.1, 0.1), PlanarLeg(0.1, 0.1), 0.1, 0.1)
    with pytest.raises(ParameterError, match="'branch' is 'left'; it must be 'up' or 'down'"):
        knee_held(PAIR, UPRIGHT, FEET, branch='left')
    with pytest.raises(ParameterError, match="'knee_i' is 'left'"):
        knee_held(PAIR, UPRIGHT, FEET, knee_i='left')


def test_angles_of_a_robots_leg_are_those_of_the_plane_by_the_documented_formula():
    robot = load_robot('genibo')
    front, hind = robot.legs[0], robot.legs[2]
    links = PlanarLeg(float(front.thigh_length), float(front.calf_length))
    pair = ActivePair(links, links, float(hind.hip[0]), float(front.hip[0]))
    pitch = 0.2
    legs = np.array([(0.0, 0.5, -0.9), (0.0, -0.3, 0.7)])
    posture = posture_of(
        pair,
        pair.lambda_i * np.exp(-1j * pitch),
        -pitch,
        JointAngles(
            -legs[0, 2] * float(hind.signs[2]),
            -math.pi / 2.0 - legs[0, 1] * float(hind.signs[1]),
            -legs[1, 2] * float(front.signs[2]),
            -math.pi / 2.0 - legs[1, 1] * float(front.signs[1]),
        ),
    )
    points = points_of(pair, posture)
    c, s = math.cos(pitch), math.sin(pitch)
    for leg, angles, foot in ((hind, legs[0], points.foot_i), (front, legs[1], points.foot_j)):
        x, _, z = leg.forward(angles) - leg.hip + [leg.hip[0], 0.0, 0.0]
        axial, radial = float(leg.axial_offset), float(leg.radial_offset)
        x, z = x - axial, z + radial
        assert complex(c * x + s * z, c * z - s * x) == pytest.approx(complex(foot), abs=1e-12)
