"""A node says whom it listens to, and does not start without the security that was asked for."""

from __future__ import annotations

import pytest

from quad_common.network.reach import (
    SecuritySettingUnknown,
    SecurityUnavailable,
    check_security,
    library_without_security,
    reach_of,
)

REACHES = [
    ({}, 'domain 0 to every machine of this subnet (ROS_AUTOMATIC_DISCOVERY_RANGE is not set)'),
    (
        {'ROS_DOMAIN_ID': '7', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'},
        'domain 7 to this machine only (ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST)',
    ),
    ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET'}, 'to every machine of this subnet'),
    (
        {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST', 'ROS_STATIC_PEERS': '10.0.0.2;robot'},
        'to this machine only, and with 10.0.0.2;robot (',
    ),
    ({'ROS_AUTOMATIC_DISCOVERY_RANGE': 'OFF', 'ROS_STATIC_PEERS': 'robot'}, 'is given (ROS'),
    (
        {
            'ROS_LOCALHOST_ONLY': '1',
            'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET',
            'ROS_STATIC_PEERS': 'robot',
        },
        'to this machine only (ROS_LOCALHOST_ONLY=1)',
    ),
    (
        {'ROS_AUTOMATIC_DISCOVERY_RANGE': 'localhost'},
        "to this machine only (ROS_AUTOMATIC_DISCOVERY_RANGE='localhost' is no range",
    ),
    (
        {'ROS_DISCOVERY_SERVER': '10.77.0.1:11811', 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'},
        'to every participant that the server 10.77.0.1:11811 knows (ROS_DISCOVERY_SERVER is set)',
    ),
    ({'ROS_DISCOVERY_SERVER': ''}, 'to every machine of this subnet'),
    ({}, 'security is off'),
    (
        {'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'Enforce'},
        'security is enforced',
    ),
    ({'ROS_SECURITY_ENABLE': 'true'}, 'security is on where there are keys for it'),
]


@pytest.mark.parametrize(('environment', 'words'), REACHES)
def test_the_reach_is_what_ros_makes_of_the_environment(environment, words):
    assert words in reach_of(environment)


@pytest.mark.parametrize('strategy', ['', 'Enforce', 'Permissive'])
def test_security_that_cannot_be_had_is_an_error_whatever_the_strategy(strategy):
    environment = {'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': strategy}
    check_security(environment, lambda: None)
    with pytest.raises(SecurityUnavailable, match='rmw_x was built without security'):
        check_security(environment, lambda: 'rmw_x')


@pytest.mark.parametrize(
    'environment',
    [
        {'ROS_SECURITY_ENABLE': '1'},
        {'ROS_SECURITY_ENABLE': 'True'},
        {'ROS_SECURITY_ENABLE': 'true', 'ROS_SECURITY_STRATEGY': 'enforce'},
    ],
)
def test_a_misspelt_setting_is_an_error_and_not_a_start_without_security(environment):
    with pytest.raises(SecuritySettingUnknown, match='without enforcing security'):
        check_security(environment, lambda: None)


def test_nothing_is_asked_of_whom_wants_no_security():
    for environment in ({}, {'ROS_SECURITY_ENABLE': 'false', 'ROS_SECURITY_STRATEGY': 'x'}):
        check_security(environment, lambda: pytest.fail('the library was looked at'))


def test_a_library_without_security_is_known_by_what_it_would_say(tmp_path):
    secure, insecure = tmp_path / 'librmw_other.so', tmp_path / 'librmw_fastrtps_shared_cpp.so'
    words = b"\0This Fast DDS version doesn't have the security libraries\0"
    secure.write_bytes(words)
    insecure.write_bytes(b'\0nothing\0')
    maps = tmp_path / 'maps'
    maps.write_text(f'0-1 r--p 0 00:1 1 {secure}\n0-1 r--p 0 00:1 1 {insecure}\n0-1 rw-p 0 0:0 0\n')
    assert library_without_security(maps) is None
    insecure.write_bytes(words)
    assert library_without_security(maps) == 'rmw_fastrtps'
    assert library_without_security(tmp_path / 'absent') is None
