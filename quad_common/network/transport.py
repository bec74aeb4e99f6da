"""
What Fast DDS sends by: UDP alone, never its shared memory.

Shared memory is guarded by locks that do not survive their owner: a process that is killed while it
holds one makes every other wait for ever, in the middle of publishing. A killed planner must not
stop a robot's driver. UDP is no slower here, and a container needs no room for segments.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, MutableMapping
from xml.etree import ElementTree

from quad_common.resources import share_directory

RANGE = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
"""Environment variable: who may discover a participant."""

PROFILES = 'FASTRTPS_DEFAULT_PROFILES_FILE'
"""Environment variable: the file of Fast DDS's settings."""

QOS_FROM_PROFILES = 'RMW_FASTRTPS_USE_QOS_FROM_XML'
"""Environment variable: whether readers and writers are as that file says, too."""

_TRANSPORTS = 'FASTDDS_BUILTIN_TRANSPORTS'
"""Environment variable: what Fast DDS sends by where no file says it."""

DISCOVERY_SERVER = 'ROS_DISCOVERY_SERVER'
"""Environment variable: addresses of servers by which Fast DDS's participants find one another."""

_LOOPBACK = '127.0.0.1'


def local_settings(environment: Mapping[str, str]) -> dict[str, str]:
    """
    Return the environment variables of a participant that this machine alone can reach.

    With the range LOCALHOST ROS adds shared memory to whatever a file says; with SYSTEM_DEFAULT the
    file is in force, and its sockets are bound to the loopback.

    Parameters
    ----------
    environment : mapping of str to str
        The environment variables that there are.

    Returns
    -------
    dict of str to str
        Those to be set.
    """
    # Peers are reached beyond any range, and with a server nobody is found without it.
    beyond = {'ROS_STATIC_PEERS': '', DISCOVERY_SERVER: ''}
    local = {RANGE: 'LOCALHOST', 'ROS_LOCALHOST_ONLY': ''} | beyond
    if not _is_fast_dds(environment):
        return local
    return local | {
        RANGE: 'SYSTEM_DEFAULT',
        PROFILES: str(share_directory() / 'config' / 'fastdds.xml'),
        # Of that file, what it says of readers and writers too.
        QOS_FROM_PROFILES: '1',
    }


def leave_shared_memory(environment: MutableMapping[str, str]) -> None:
    """
    Have Fast DDS send by UDP alone, unless a file says what it is to send by.

    Parameters
    ----------
    environment : mutable mapping of str to str
        The environment variables. Who is in reach stays the same.
    """
    if not _is_fast_dds(environment) or PROFILES in environment:
        return
    others = environment.get('ROS_STATIC_PEERS', '') + environment.get(DISCOVERY_SERVER, '')
    is_alone = not others.strip('; ')
    if environment.get(RANGE) == 'LOCALHOST' and is_alone:
        environment.update(local_settings(environment))
    else:
        environment.setdefault(_TRANSPORTS, 'UDPv4')


def is_bound_to_this_machine(environment: Mapping[str, str]) -> bool:
    """
    Return whether Fast DDS's settings let nobody but this machine reach a participant.

    Parameters
    ----------
    environment : mapping of str to str
        The environment variables.

    Returns
    -------
    bool
        Whether every transport of the file of settings is bound to the loopback, and none is left
        that the file does not say.
    """
    with contextlib.suppress(OSError, ElementTree.ParseError):
        texts: dict[str, list[str]] = {}
        for element in ElementTree.parse(environment.get(PROFILES, '')).iter():
            text = ''.join(element.itertext()).strip()
            texts.setdefault(element.tag.rpartition('}')[2], []).append(text)
        interfaces = texts.get('interfaceWhiteList', [])
        return (
            texts.get('useBuiltinTransports') == ['false']
            and len(interfaces) == len(texts.get('transport_descriptor', []))
            and set(interfaces) == {_LOOPBACK}
        )
    return False


def _is_fast_dds(environment: Mapping[str, str]) -> bool:
    """Return whether ROS uses Fast DDS, as it does unless it is told otherwise."""
    return environment.get('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp').startswith('rmw_fastrtps')
