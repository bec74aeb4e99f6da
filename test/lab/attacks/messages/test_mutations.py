"""The attack reaches every field of any message, and leaves some messages as they are."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from nav_msgs.msg import Odometry, Path
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import CameraInfo, JointState, PointCloud2
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from quad_lab.attacks.messages.mutations import (
    UNCHANGED,
    Mutator,
    leaves_of,
    random_bytes,
    replaced,
)
from quad_lab.attacks.stage.examples import example_of

pytestmark = pytest.mark.ros

KINDS = (Odometry, Path, JointState, JointTrajectory, MarkerArray, CameraInfo, PointCloud2)


def draws(kind, count):
    message, mutator = example_of(kind), Mutator(np.random.default_rng(1))
    return message, [mutator.draw(message) for _ in range(count)]


@pytest.mark.parametrize('kind', KINDS)
def test_every_field_is_reached(kind):
    message, mutations = draws(kind, 2 * len(leaves_of(example_of(kind))))
    assert {leaf.name for leaf in leaves_of(message)} <= {m.field for m in mutations}


@pytest.mark.parametrize('kind', KINDS)
def test_valid_messages_are_sent_too(kind):
    message, mutations = draws(kind, 200)
    unchanged = [m for m in mutations if m.kind == UNCHANGED]
    assert 0 < len(unchanged) < 40
    assert all(m.message is message for m in unchanged)


@pytest.mark.parametrize('kind', KINDS)
def test_what_is_changed_can_be_sent_and_the_original_stays(kind):
    message, mutations = draws(kind, 25)
    sent = [deserialize_message(serialize_message(m.message), kind) for m in mutations]
    assert message == example_of(kind)
    different = [s != message for s in sent]
    # Minus zero in place of zero, or a stamp that is the same, changes nothing that counts.
    assert np.mean(different) > 0.6


def test_fields_within_sequences_are_reached():
    names = {leaf.name for leaf in leaves_of(example_of(Path))}
    assert {'poses', 'poses[0].pose.orientation.w', 'poses[0].header.stamp'} <= names


def test_numbers_that_are_known_to_hurt_are_sent():
    _, mutations = draws(Odometry, 3000)
    values = {m.message.pose.pose.orientation.x for m in mutations}
    assert {math.inf, 1e308, 1.4e154} <= values
    assert any(math.isnan(value) for value in values)
    seconds = {m.message.header.stamp.sec for m in mutations}
    assert {-1, 2**31 - 1, -(2**31)} <= seconds


def test_a_request_without_fields_is_sent_as_it_is():
    _, mutations = draws(Trigger.Request, 5)
    assert [m.kind for m in mutations] == [UNCHANGED] * 5


def test_a_value_is_replaced_in_a_copy():
    message = example_of(JointTrajectory)
    changed = replaced(message, ('points', 0, 'positions', 0), 2.0)
    assert changed.points[0].positions[0] == 2.0
    assert message.points[0].positions[0] == 0.0


def test_random_bytes_differ_and_keep_the_encapsulation():
    data = serialize_message(example_of(JointState))
    rng = np.random.default_rng(2)
    damaged = [random_bytes(data, rng) for _ in range(50)]
    assert {kind for kind, _ in damaged} == {'cut off', 'flipped bits', 'noise', 'longer'}
    assert all(new != data and new[:4] == data[:4] for _, new in damaged)
