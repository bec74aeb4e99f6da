"""Nodes share no memory with others, which may be killed, and reach no farther than was wanted."""

from __future__ import annotations

from pathlib import Path

import pytest

from quad_common.network.reach import reach_of
from quad_common.network.transport import (
    PROFILES,
    RANGE,
    is_bound_to_this_machine,
    leave_shared_memory,
    local_settings,
)

UDP = {'FASTDDS_BUILTIN_TRANSPORTS': 'UDPv4'}


def changes(**environment: str) -> dict[str, str]:
    """Return what is changed in an environment."""
    after = dict(environment)
    leave_shared_memory(after)
    return {name: value for name, value in after.items() if environment.get(name) != value}


@pytest.mark.parametrize(
    'environment',
    [
        {},
        {RANGE: 'SUBNET'},
        {RANGE: 'LOCALHOST', 'ROS_STATIC_PEERS': '10.0.0.2'},
        {RANGE: 'LOCALHOST', 'ROS_DISCOVERY_SERVER': '127.0.0.1:11811'},
    ],
)
def test_nodes_send_by_udp_alone(environment):
    assert changes(**environment) == UDP


def test_nodes_of_one_machine_stay_on_it():
    after = {RANGE: 'LOCALHOST'}
    leave_shared_memory(after)
    assert after == local_settings({})
    assert 'to this machine only' in reach_of(after)


@pytest.mark.parametrize(
    'environment',
    [
        {'RMW_IMPLEMENTATION': 'rmw_cyclonedds_cpp', RANGE: 'LOCALHOST'},
        {PROFILES: 'mine.xml', RANGE: 'LOCALHOST'},
        {'FASTDDS_BUILTIN_TRANSPORTS': 'LARGE_DATA'},
    ],
)
def test_what_somebody_has_chosen_stays(environment):
    assert changes(**environment) == {}


@pytest.mark.parametrize('middleware', ['rmw_cyclonedds_cpp', 'rmw_fastrtps_cpp'])
def test_what_is_local_is_so_with_every_middleware(middleware):
    beyond = {'ROS_STATIC_PEERS': '10.0.0.2', 'ROS_DISCOVERY_SERVER': '10.0.0.3:11811'}
    environment = {'RMW_IMPLEMENTATION': middleware} | beyond
    environment.update(local_settings(environment))
    assert 'to this machine only (' in reach_of(environment)


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        ('127.0.0.1</address></interface', '10.0.0.2</address></interface'),
        ('<interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>', ''),
        ('<useBuiltinTransports>false', '<useBuiltinTransports>true'),
        ('<profiles', '<profiles<'),
    ],
)
def test_settings_that_let_others_in_are_not_taken_for_local(tmp_path, old, new):
    environment = local_settings({})
    assert is_bound_to_this_machine(environment)
    text = Path(environment[PROFILES]).read_text()
    assert old in text
    changed = tmp_path / 'settings.xml'
    changed.write_text(text.replace(old, new))
    environment[PROFILES] = str(changed)
    assert not is_bound_to_this_machine(environment)
    assert 'every participant' in reach_of(environment)
