"""
Checks of ROS: packages, settings, and whether a message comes through to another process.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator

from quad_common.errors import QuadError
from quad_common.errors.quoting import quoted
from quad_lab.doctor.finding import Finding, good, missing, wrong

_PACKAGES = (
    'geometry_msgs', 'nav_msgs', 'sensor_msgs', 'std_msgs', 'std_srvs', 'trajectory_msgs',
    'visualization_msgs', 'diagnostic_msgs', 'rosgraph_msgs',
)  # fmt: skip
"""Packages of messages that the nodes need."""

_OPTIONAL = (
    (
        'tf2_msgs',
        'make tf',
        'nodes publish no tf; recordings have it all the same',
        'nodes publish tf',
    ),
    (
        'nav2_msgs',
        'make nav2',
        "nodes serve none of Nav2's actions; goals go by topic",
        "nodes serve Nav2's actions",
    ),
    (
        'simulation_interfaces',
        'make simulation',
        "no service spawns robots; the parameter 'robots' does",
        'sim_node serves what spawns robots',
    ),
    (
        'control_msgs',
        'make control',
        'trajectories go to controllers by topic alone',
        'trajectories can go to a controller by its action',
    ),
)
"""Packages of messages that nodes do without: who builds each, what is without it and with it."""

_INSTALL = "pip install 'quadwalk[ros]', or source a ROS 2 installation"

_PATIENCE = 15.0
"""Time in which another process must have been found [s]."""

_MESSAGES = 50

_LAST_DOMAIN = 232
"""Last one for which there are ports."""


def check_ros() -> Iterator[Finding]:
    """Look whether nodes can run, and talk to each other."""
    if importlib.util.find_spec('rclpy') is None:
        yield wrong('rclpy', 'absent: the library works, nodes and walks do not', _INSTALL)
        return
    absent = [name for name in _PACKAGES if importlib.util.find_spec(name) is None]
    if absent:
        yield wrong('messages', f'absent: {", ".join(absent)}', _INSTALL)
        return
    try:
        # Where a library of ROS does not load, that is what is raised.
        from quad_common.network.reach import reach_of
        from quad_common.ros.run_node import check_middleware

        check_middleware()
    except (ImportError, QuadError) as error:
        yield wrong('rclpy', str(error), 'see docs/troubleshooting.md')
        return
    domain = os.environ.get('ROS_DOMAIN_ID') or '0'
    if not (domain.isdecimal() and int(domain) <= _LAST_DOMAIN):
        # Beyond it Fast DDS ends the process.
        said = f'ROS_DOMAIN_ID is {quoted(domain)}; valid is a number from 0 to {_LAST_DOMAIN}'
        yield wrong('network', said, 'unset ROS_DOMAIN_ID')
        return
    distribution = os.environ.get('ROS_DISTRO', 'from PyPI')
    middleware = os.environ.get('RMW_IMPLEMENTATION', 'rmw_fastrtps_cpp')
    yield good('rclpy', f'{distribution}, {middleware}')
    yield good('network', reach_of(os.environ).rstrip('.'))
    for package, target, without, effect in _OPTIONAL:
        if importlib.util.find_spec(package) is None:
            yield missing(package, f'absent: {without}', f'{target}, or a ROS 2 installation')
        else:
            yield good(package, effect)
    yield _round_trip()


def _end(echo: subprocess.Popen[bytes]) -> None:
    """Let the other process end, as it does when nobody holds the other end of its stdin."""
    try:
        echo.communicate(timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        echo.kill()
        echo.communicate()


def _round_trip() -> Finding:
    """Send messages to another process, which sends them back."""
    from quad_lab.doctor.echo import Caller

    # Another doctor may be at work on the same network.
    trip = f'trip_{uuid.uuid4().hex}'
    command = [sys.executable, '-m', 'quad_lab.doctor.echo', trip]
    echo = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
    mend = 'allow UDP and multicast on the loopback; see docs/network.md'
    try:
        began = time.monotonic()
        with Caller(trip) as caller:
            if not caller.find(_PATIENCE):
                said = f'another process was not found within {_PATIENCE:.0f} s'
                return wrong('round trip', said, mend)
            found = time.monotonic() - began
            times = caller.call(_MESSAGES)
    # A domain that is none, a profile that cannot be read: the middleware's own kinds of errors.
    except Exception as error:
        return wrong('round trip', str(error), 'see docs/network.md, and ROS_DOMAIN_ID')
    finally:
        _end(echo)
    if len(times) < _MESSAGES:
        said = f'{len(times)} of {_MESSAGES} messages came back from another process'
        return wrong('round trip', said, mend)
    middle = 1e3 * sorted(times)[len(times) // 2]
    return good(
        'round trip', f'another process is found in {found:.1f} s, and answers in {middle:.2f} ms'
    )
