"""Physics settles a planar pair of legs where S3 says."""

import math

import numpy as np
import pytest

pytest.importorskip('pybullet')

from quad_common.errors import ParameterError
from quad_common.planar_pair.active_pair import with_knee_held
from quad_common.planar_pair.planar_pair import (
    ActivePair,
    JointAngles,
    PlanarLeg,
    points_of,
    posture_of,
)
from quad_lab.benchmarks.ground.bench_active_pair import settle_errors
from quad_sim.engines.bullet_pair import difference, settle
from quad_sim.engines.bullet_simulator import headless_client

PAIR = ActivePair(PlanarLeg(0.2, 0.17), PlanarLeg(0.21, 0.19), -0.2, 0.3)
START = posture_of(PAIR, 0.1 + 0.3j, 0.1, JointAngles(0.7, -1.9, 0.8, -2.0))
FEET = points_of(PAIR, START)


@pytest.fixture
def client():
    client = headless_client()
    yield client
    client.disconnect()


def goal(u1=1.0, hip=0.12 + 0.29j):
    return with_knee_held(PAIR, hip, FEET.foot_i, FEET.foot_j, u1, previous=START)


def test_every_causality_and_every_joint_free_alone_settle_where_predicted(client):
    errors = settle_errors(client, np.random.default_rng(3), 1)
    assert len(errors) == 8
    assert max(math.degrees(angle) for angle, _ in errors) < 0.5
    assert max(1e3 * place for _, place in errors) < 1.0


def test_the_pair_goes_a_way_before_it_settles_and_its_feet_stay(client):
    end = goal()
    held = {'hip_x': 0.12, 'hip_z': 0.29, 'u1_j': 1.0}
    settled = settle(client, PAIR, START, held)
    angle, place = difference(PAIR, settled.posture, end)
    assert math.degrees(angle) < 0.5
    assert 1e3 * place < 1.0
    assert settled.foot_error < 1e-4
    assert settled.time >= 0.5
    # What is compared is no standing still: it went much farther than the bar.
    angle, place = difference(PAIR, settled.posture, START)
    assert math.degrees(angle) > 5.0
    assert 1e3 * place > 10.0


def test_free_joints_have_no_motor(client):
    # Nothing held: gravity takes the body down, as far as the pinned feet let it.
    settled = settle(client, PAIR, START, {})
    assert settled.posture.hip_i.imag < START.hip_i.imag - 0.1
    assert settled.foot_error < 5e-3


def test_a_prediction_with_the_printed_formula_would_be_told_apart(client):
    # S3 eq. 44 as printed has g, not g squared.
    W = 0.21 + 0.19 * np.exp(1.0j)
    Q, g = PAIR.span / W, abs((FEET.foot_j - (0.12 + 0.29j)) / W)
    cosine = (g - 1.0 - abs(Q) ** 2) / (2.0 * abs(Q))
    printed = np.angle(Q) - math.acos(cosine)
    settled = settle(client, PAIR, START, {'hip_x': 0.12, 'hip_z': 0.29, 'u1_j': 1.0})
    assert abs(math.degrees(printed - float(settled.posture.u2_j))) > 0.5


def test_what_cannot_be_held_is_named(client):
    with pytest.raises(ParameterError, match="'held' is 'u3_j'; it must be one of hip_x, hip_z"):
        settle(client, PAIR, START, {'u3_j': 0.0})
