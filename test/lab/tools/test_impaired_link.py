"""Two hosts hear one another through their link alone, later and less than was sent."""

from __future__ import annotations

import os
import socket
import time
from pathlib import Path

import pytest

from quad_lab.tools import impaired_link
from quad_lab.tools.impaired_link import (
    ImpairedLink,
    Impairment,
    NoImpairedLink,
    check_possible,
    on_host,
)

LONGEST_WAIT = 20.0

NETWORK = Path('/proc/thread-self/ns/net')


def _is_possible() -> bool:
    try:
        with ImpairedLink(f'qwtest-{os.getpid()}', Impairment(0.0, 0.0), 0):
            return True
    except NoImpairedLink:
        return False


needs_hosts = pytest.mark.skipif(not _is_possible(), reason='it needs root and TUN devices')


def connect(link):
    """Make a socket on each host."""
    sockets = []
    for number, host in enumerate(link.hosts, 1):
        with on_host(host):
            sockets.append(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        sockets[-1].bind((f'10.77.0.{number}', 5000))
        sockets[-1].settimeout(LONGEST_WAIT)
    return sockets


@needs_hosts
def test_packets_come_out_on_the_other_host_after_the_delay():
    with ImpairedLink(f'qwtest-{os.getpid()}', Impairment(0.05, 0.0), 0) as link:
        first, second = connect(link)
        sent_at = time.monotonic()
        first.sendto(b'there', ('10.77.0.2', 5000))
        assert second.recv(100) == b'there'
        second.sendto(b'back', ('10.77.0.1', 5000))
        assert first.recv(100) == b'back'
        assert time.monotonic() - sent_at >= 0.1


@needs_hosts
def test_so_many_packets_are_lost_as_were_counted():
    with ImpairedLink(f'qwtest-{os.getpid()}', Impairment(0.0, 0.3), 1) as link:
        first, second = connect(link)
        for number in range(200):
            first.sendto(bytes([number]), ('10.77.0.2', 5000))
        deadline = time.monotonic() + LONGEST_WAIT
        while link.packets < 200:
            assert time.monotonic() < deadline
            time.sleep(0.01)
        for _ in range(200 - link.lost):
            second.recv(100)
        # Binomial, 200 of 0.3: six standard deviations are 39. Others than ours may be among them.
        assert 21 < link.lost < 99


@needs_hosts
def test_hosts_are_gone_when_the_block_ends():
    with ImpairedLink(f'qwtest-{os.getpid()}', Impairment(0.0, 0.0), 0) as link:
        assert all((impaired_link._NAMESPACES / host).exists() for host in link.hosts)
        before = NETWORK.readlink()
        with on_host(link.hosts[0]):
            assert NETWORK.readlink() != before
        assert NETWORK.readlink() == before
    assert not any((impaired_link._NAMESPACES / host).exists() for host in link.hosts)


@pytest.mark.parametrize(
    ('packet', 'is_to_one'),
    [
        (bytes([0x45]) + bytes(15) + bytes([10, 77, 0, 2]), True),
        (bytes([0x45]) + bytes(15) + bytes([239, 255, 0, 1]), False),
        (bytes([0x60]) + bytes(39), False),
        (b'', False),
    ],
)
def test_multicast_is_told_by_the_address(packet, is_to_one):
    assert impaired_link._is_to_one(packet) is is_to_one


@pytest.mark.parametrize(
    ('name', 'value', 'words'),
    [('platform', 'darwin', 'no Linux'), ('geteuid', lambda: 1000, 'no root')],
)
def test_what_is_missing_is_said(monkeypatch, name, value, words):
    module = impaired_link.sys if name == 'platform' else impaired_link.os
    monkeypatch.setattr(module, name, value)
    with pytest.raises(NoImpairedLink, match=words):
        check_possible()
