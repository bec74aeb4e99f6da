"""
Starts viewer_node, and waits until its page is there.
"""

from __future__ import annotations

import socket
import time
import urllib.request
from dataclasses import dataclass

from quad_common.errors import QuadError
from quad_lab.topic_walk.node_processes import NodeProcesses

_TIMEOUT = 60.0
"""For the page to be there [s]."""

_SHORT_WAIT = 0.05
"""Between two looks [s]."""

_PORTS = 100
"""Ports that are tried, from the wanted one on."""

_EVERYWHERE = ('0.0.0.0', '::')
"""Addresses that stand for all of a machine's."""


@dataclass(eq=False, repr=False)
class PageNotReady(QuadError):
    """The viewer's page did not come up in time."""

    address: str
    """Address of the page."""
    limit: float
    """Time that it had [s]."""

    def sentence(self) -> str:
        """Say where it was waited for."""
        return f'the page at {self.address} was not there within {self.limit:.0f} s'


@dataclass(eq=False, repr=False)
class NoFreePort(QuadError):
    """No port is left to listen on, or the address is none of this machine's."""

    host: str
    """Address to listen on."""
    port: int
    """First port that was tried."""
    reason: str
    """Reason for which the last one could not be had."""

    def sentence(self) -> str:
        """Say which ports were tried."""
        last = self.port + _PORTS - 1
        return f'no port from {self.port} to {last} is free on {self.host}: {self.reason}'


@dataclass(frozen=True)
class PagePlace:
    """Where a page is to be."""

    host: str = '127.0.0.1'
    """Address to listen on."""
    port: int = 8080
    """Port to listen on, or the next free one."""


def start_viewer(nodes: NodeProcesses, place: PagePlace, **parameters: object) -> str:
    """
    Start viewer_node and wait for its page.

    Parameters
    ----------
    nodes : NodeProcesses
        They end it.
    place : PagePlace
        Where the page is to be.
    **parameters
        Others of the node's.

    Returns
    -------
    str
        Address of the page, as a browser on this machine takes it.

    Raises
    ------
    NoFreePort
        If there is no port to listen on.
    PageNotReady
        If the page does not come up in time.
    NodeDied
        If the node ends on its own.
    """
    port = free_port(place)
    host = '127.0.0.1' if place.host in _EVERYWHERE else place.host
    address = f'http://{"localhost" if host == "127.0.0.1" else host}:{port}'
    nodes.start('viewer_node', host=place.host, port=port, **parameters)
    deadline = time.monotonic() + _TIMEOUT
    while time.monotonic() < deadline:
        try:
            with urllib.request.urlopen(f'http://{host}:{port}', timeout=5.0):
                return address
        except OSError:
            nodes.check()
            time.sleep(_SHORT_WAIT)
    raise PageNotReady(address, _TIMEOUT)


def free_port(place: PagePlace) -> int:
    """Return the first port that is free, from the wanted one on; NoFreePort if none is."""
    reason = ''
    for port in range(place.port, min(place.port + _PORTS, 65536)):
        try:
            with socket.socket() as probe:
                # As the server will: ports of connections that have just ended count as free.
                probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                probe.bind((place.host, port))
                return int(probe.getsockname()[1])
        except OSError as error:
            reason = error.strerror or str(error)
    raise NoFreePort(place.host, place.port, reason)


def invitation(address: str, place: PagePlace) -> str:
    """Say how to open a page, from this machine and from others."""
    port = address.rpartition(':')[2]
    if place.host in ('127.0.0.1', 'localhost', '::1'):
        return (
            f'open {address}   (from another machine: ssh -L {port}:localhost:{port} '
            f'<this machine>, then the same address)'
        )
    return f'open {address}   (whoever reaches this address can steer the robot)'
