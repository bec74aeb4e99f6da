"""Messages that are taken apart while a signal comes."""

from __future__ import annotations

import contextlib
import signal
import sys

import pytest

pytest.importorskip('rclpy')

from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

from quad_common.errors import InvalidMessage
from quad_common.process.end_signals import Interrupted, Raises
from quad_common.ros.guarded_node import taken_apart
from quad_lab.recordings.subscription import message_of

pytestmark = pytest.mark.ros

SIGNALS = 40

READS = 100_000
"""So many take a second or two; the signal comes after 3 ms."""


@pytest.fixture
def alarms(monkeypatch):
    """Let alarms raise as the signals that end a command do; return what sends the next one."""
    # Each reaction puts its own in front of the one before.
    monkeypatch.setattr('sys.unraisablehook', sys.unraisablehook)
    reactions = []

    def next_alarm() -> None:
        reactions.append(Raises())
        signal.setitimer(signal.ITIMER_REAL, 0.003)

    before = signal.signal(signal.SIGALRM, lambda number, frame: reactions[-1](number))
    yield next_alarm
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


def by_message_of(data: bytes) -> None:
    message_of(data, JointState)


def by_node(data: bytes) -> None:
    taken_apart(JointState, 'joint_states', 10_000, lambda message: None, data)


@pytest.mark.parametrize('read', [by_message_of, by_node])
def test_no_signal_is_lost_while_messages_are_taken_apart(alarms, read):
    data = serialize_message(JointState(name=['joint'] * 12, position=[0.1] * 12))

    def read_many() -> None:
        alarms()
        for _ in range(READS):
            # As whoever reads a batch, and takes what is no message for the end of it.
            with contextlib.suppress(InvalidMessage):
                read(data)

    for _ in range(SIGNALS):
        with pytest.raises(Interrupted):
            read_many()


def test_bytes_that_are_no_message_are_refused():
    with pytest.raises(InvalidMessage, match='its bytes are no JointState'):
        message_of(b'\x00\x01', JointState)
