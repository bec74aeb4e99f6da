"""
Opens the page: viser's server, on one address, for pages of its own only.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import ipaddress
import logging
import socket
from collections.abc import Mapping
from typing import Any
from urllib.parse import urlsplit

from quad_common.errors import MissingOptionalDependency, ParameterError

try:
    import viser
except ImportError as error:
    raise MissingOptionalDependency('viser', "pip install 'quadwalk[view]'") from error

_LOOPBACK_NAMES = ('localhost', '127.0.0.1', '::1')

_POLICY_VIOLATION = 1008
"""Code of a connection that is closed for what it is [RFC 6455]."""


def open_server(host: str, port: int, title: str) -> viser.ViserServer:
    """
    Open the page.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        Port to listen on, or the next free one.
    title : str
        What stands at its top.

    Returns
    -------
    viser.ViserServer
        The server; it runs in a thread of its own.

    Raises
    ------
    ParameterError
        If the address is none of this machine's.
    """
    check_address(host)
    # It would log the stack of whoever connects and says nothing.
    logging.getLogger('websockets.server').setLevel(logging.CRITICAL)
    # It prints its address, in a frame: the node's own words say more.
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host, port, label=title, verbose=False)
    # viser can publish a page by way of a host of its own on the internet; not the page of a robot.
    server.gui.configure_theme(show_logo=False, show_share_button=False, control_width='large')
    setattr(server, 'request_share_url', lambda *_, **__: None)  # noqa: B010
    refuse_strangers(server, host)
    return server


def check_address(host: str) -> None:
    """Raise ParameterError unless this machine can listen on an address."""
    try:
        # viser would try a thousand ports, and then wait for ever.
        with socket.create_server((host, 0), family=_family(host)):
            pass
    except OSError as error:
        raise ParameterError('host', host, 'an address of this machine') from error


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ':' in host else socket.AF_INET


def refuse_strangers(server: viser.ViserServer, host: str) -> None:
    """
    Close connections that another page has opened.

    Every page that a browser shows may open a connection to this machine, and a robot must not
    follow any page. A browser says with a connection whose page it is.

    Parameters
    ----------
    server : viser.ViserServer
        The server.
    host : str
        Address that it listens on.
    """
    sockets = server._websock_server

    async def check(client: Any) -> None:
        connection = sockets._live_connections[client.client_id]
        request = connection.request
        if request is None or not is_own_page(request.headers, host):
            await connection.close(_POLICY_VIOLATION, 'a page of another origin')
            sockets._live_connections.pop(client.client_id, None)
            sockets._client_state_from_id.pop(client.client_id, None)
            # Ends the handler before it takes what the page has sent meanwhile.
            raise asyncio.CancelledError

    # Before viser's own, which would take the page for a reader.
    sockets._client_connect_cb.insert(0, check)


def is_own_page(headers: Mapping[str, str], host: str) -> bool:
    """
    Return whether a connection comes from the viewer's own page.

    Parameters
    ----------
    headers : mapping of str to str
        Of the request that opens it.
    host : str
        Address that the server listens on.

    Returns
    -------
    bool
        Whether its page was loaded from where the connection leads to, and, if the server listens
        to this machine only, by one of this machine's own names: any other could have been given
        to this address for the purpose. A program that is no browser sends no origin, and may
        come.
    """
    origin, target = headers.get('Origin'), headers.get('Host', '')
    if origin is not None and urlsplit(origin).netloc.lower() != target.lower():
        return False
    name = (urlsplit(f'//{target}').hostname or '').lower()
    return not is_loopback(host) or name in _LOOPBACK_NAMES


def is_loopback(host: str) -> bool:
    """Return whether an address is reached from this machine only."""
    if host == 'localhost':
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
