"""The page gets a port that is free, and people are told how to reach it."""

from __future__ import annotations

import socket

import pytest

from quad_lab.topic_walk.viewer_process import NoFreePort, PagePlace, free_port, invitation


def test_a_port_in_use_is_passed_over():
    with socket.socket() as taken:
        taken.bind(('127.0.0.1', 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert free_port(PagePlace(port=port)) > port


def test_an_address_of_another_machine_cannot_be_listened_on():
    with pytest.raises(NoFreePort, match=r'from 8080 to 8179 is free on 192\.0\.2\.1'):
        free_port(PagePlace('192.0.2.1', 8080))


def test_the_invitation_says_how_to_come_by_ssh_or_who_may_come():
    told = invitation('http://localhost:8081', PagePlace(port=8080))
    assert 'open http://localhost:8081' in told
    assert 'ssh -L 8081:localhost:8081' in told
    assert 'whoever reaches' in invitation('http://localhost:8080', PagePlace('0.0.0.0'))
