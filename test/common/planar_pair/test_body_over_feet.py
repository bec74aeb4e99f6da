"""Laws of a body over a front and a hind foot."""

import math

import numpy as np
import pytest

from quad_common.errors import BodyOutOfReach, PairCannotClose, ParameterError
from quad_common.planar_pair.body_over_feet import body_over_feet, pose_with_free_joint
from quad_common.planar_pair.planar_pair import (
    ActivePair,
    JointAngles,
    PlanarLeg,
    points_of,
    posture_of,
)

PAIR = ActivePair(PlanarLeg(0.2, 0.17), PlanarLeg(0.21, 0.19), -0.2, 0.3)
MIRRORED = ActivePair(PAIR.leg_i, PAIR.leg_j, 0.2, -0.3)
JOINTS = ('u1_i', 'u2_i', 'u1_j', 'u2_j')
HELD = JointAngles(u1_i=0.5, u2_i=-1.8, u1_j=0.6, u2_j=-1.9)

each_side = pytest.mark.parametrize('pair', [PAIR, MIRRORED], ids=['j in front', 'j behind'])


@each_side
def test_legs_have_their_lengths_the_body_its_own_and_its_middle_is_over_the_feets(pair):
    rng = np.random.default_rng(0)
    side = np.sign(pair.span)
    feet_i, feet_j = rng.uniform(-0.05, 0.05, (2, 2000)) + 1j * rng.uniform(-0.05, 0.05, (2, 2000))
    feet_j = feet_j + 0.5 * side
    lengths = rng.uniform(0.2, 0.36, (2, 2000))
    theta, hip_i, hip_j = body_over_feet(pair, feet_i, feet_j, *lengths)
    assert np.abs(hip_i - feet_i) == pytest.approx(lengths[0], abs=1e-12)
    assert np.abs(hip_j - feet_j) == pytest.approx(lengths[1], abs=1e-12)
    assert hip_j == pytest.approx(hip_i + pair.span * np.exp(1j * theta), abs=1e-12)
    assert (hip_i + hip_j).real == pytest.approx((feet_i + feet_j).real, abs=1e-11)
    assert (hip_i.imag > feet_i.imag).all()
    assert (hip_j.imag > feet_j.imag).all()


@each_side
def test_on_level_ground_with_equal_legs_the_body_is_level(pair):
    theta, hip_i, _ = body_over_feet(pair, 0.0, pair.span, 0.3, 0.3)
    assert float(theta) == pytest.approx(0.0, abs=1e-12)
    assert complex(hip_i) == pytest.approx(0.3j)


@each_side
def test_a_higher_foot_j_turns_the_body_up_there(pair):
    theta, hip_i, hip_j = body_over_feet(pair, 0.0, pair.span + 0.06j, 0.3, 0.3)
    assert hip_j.imag - hip_i.imag == pytest.approx(0.06, abs=0.005)
    assert np.sign(theta) == np.sign(pair.span)


def test_the_mirrored_stance_has_the_mirrored_pose():
    one = body_over_feet(PAIR, 0.02j, 0.52, 0.3, 0.28, middle=0.3)
    other = body_over_feet(MIRRORED, 0.02j, -0.52, 0.3, 0.28, middle=-0.3)
    assert complex(other.hip_i) == pytest.approx(-complex(one.hip_i).conjugate())
    assert float(other.theta) == pytest.approx(-float(one.theta))


def test_the_middle_goes_where_it_is_wanted_over_the_whole_range():
    wanted = np.concatenate([-0.05 + np.geomspace(1e-6, 0.25, 300), [0.5499, 0.549999]])
    _, hip_i, hip_j = body_over_feet(PAIR, 0.0, 0.5, 0.3, 0.3, middle=wanted)
    assert (hip_i + hip_j).real / 2.0 == pytest.approx(wanted, abs=1e-11)
    assert (hip_i.imag > 0.0).all()


def test_what_the_legs_do_not_carry_is_said_with_the_range():
    with pytest.raises(BodyOutOfReach) as caught:
        body_over_feet(PAIR, 0.0, 0.5, 0.3, 0.3, middle=[0.25, 3.0])
    assert str(caught.value) == (
        'posture 1: the middle of the body would be at x = 3.000 m; the legs carry it from '
        '-0.050 to 0.550 m'
    )
    with pytest.raises(PairCannotClose, match=r'1\.200 m apart; .* 0\.000 to 1\.100 m'):
        body_over_feet(PAIR, 0.0, 1.2, 0.3, 0.3)
    with pytest.raises(PairCannotClose, match=r'0\.500 m apart; .* 1\.400 to 2\.600 m'):
        body_over_feet(PAIR, 0.0, 0.5, 0.1, 2.0)
    with pytest.raises(ParameterError, match='length_j'):
        body_over_feet(PAIR, 0.0, 0.5, 0.3, 0.0)
    with pytest.raises(PairCannotClose):
        body_over_feet(PAIR, 0.0, math.nan, 0.3, 0.3)
    with pytest.raises(BodyOutOfReach):
        body_over_feet(PAIR, 0.0, 0.5, 0.3, 0.3, middle=math.nan)


@pytest.mark.parametrize('free', JOINTS)
@each_side
def test_with_one_joint_free_the_held_three_and_the_feet_give_the_pose(pair, free):
    posture = posture_of(pair, 0.1 + 0.3j, 0.05, HELD)
    feet = points_of(pair, posture)
    last_known = HELD._replace(**{free: getattr(HELD, free) + 0.1})
    found = pose_with_free_joint(pair, complex(feet.foot_i), complex(feet.foot_j), last_known, free)
    assert found.closes
    assert found.why == ''
    for name in (*JOINTS, 'theta', 'hip_i', 'hip_j'):
        expected = getattr(posture, name)
        assert complex(getattr(found.posture, name)) == pytest.approx(complex(expected), abs=1e-9)


@pytest.mark.parametrize('free', JOINTS)
def test_the_free_joint_takes_the_solution_that_is_nearer_to_its_last_angle(free):
    posture = posture_of(PAIR, 0.1 + 0.3j, 0.05, HELD)
    feet = [complex(foot) for foot in (points_of(PAIR, posture)[2], points_of(PAIR, posture)[5])]
    angles = np.linspace(-math.pi, math.pi, 60)
    found = [
        float(
            getattr(
                pose_with_free_joint(PAIR, *feet, HELD._replace(**{free: a}), free).posture, free
            )
        )
        for a in angles
    ]
    solutions = sorted({round(angle, 6) for angle in found})
    assert len(solutions) == 2
    for angle, taken in zip(angles, found):
        other = max(solutions, key=lambda s: abs(s - taken))
        assert math.cos(angle - taken) >= math.cos(angle - other) - 1e-6


def test_a_stance_that_does_not_close_says_why():
    gone = pose_with_free_joint(PAIR, 0.0, 2.5, HELD, 'u1_j')
    assert not gone.closes
    assert gone.posture is None
    assert gone.why.startswith('the feet are 2.500 m apart; the legs, as held, reach ')
    with pytest.raises(ParameterError, match="'free' is 'u3_j'"):
        pose_with_free_joint(PAIR, 0.0, 0.5, HELD, 'u3_j')
