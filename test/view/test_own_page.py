"""Only the viewer's own page may steer: connections that other pages open are closed."""

from __future__ import annotations

import contextlib
import time

import pytest

pytest.importorskip('viser', reason='the viewer needs viser: pip install quadwalk[view]')

import msgspec
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from quad_lab.tools.page_reader import FIRST_WORD, PageReader
from quad_lab.topic_walk.viewer_process import PagePlace, free_port
from quad_view.page.server import is_loopback, is_own_page, open_server

HERE = '127.0.0.1'


def closing_code(connection):
    """Read until a connection is closed; return the code."""
    try:
        while True:
            connection.recv(timeout=60.0)
    except ConnectionClosed as closed:
        return None if closed.rcvd is None else closed.rcvd.code


@pytest.mark.parametrize(
    ('origin', 'target', 'host', 'may'),
    [
        ('http://localhost:8080', 'localhost:8080', HERE, True),
        ('http://127.0.0.1:8080', '127.0.0.1:8080', HERE, True),
        # Through ssh's other port.
        ('http://localhost:9999', 'localhost:9999', HERE, True),
        (None, 'localhost:8080', HERE, True),
        ('http://evil.example', 'localhost:8080', HERE, False),
        ('null', 'localhost:8080', HERE, False),
        # A name that leads here, made for the purpose.
        ('http://evil.example:8080', 'evil.example:8080', HERE, False),
        ('http://robot.local:8080', 'robot.local:8080', '0.0.0.0', True),
        ('http://evil.example', 'robot.local:8080', '0.0.0.0', False),
    ],
)
def test_a_connection_must_come_from_the_page_that_it_leads_to(origin, target, host, may):
    headers = {'Host': target} | ({} if origin is None else {'Origin': origin})
    assert is_own_page(headers, host) is may


@pytest.mark.parametrize(
    ('host', 'is_own'),
    [('127.0.0.1', True), ('::1', True), ('localhost', True), ('0.0.0.0', False)],
)
def test_addresses_of_this_machine_alone_are_known(host, is_own):
    assert is_loopback(host) is is_own


def test_a_foreign_page_is_not_listened_to_and_the_own_page_is():
    server = open_server(HERE, free_port(PagePlace(port=8900)), 'test')
    try:
        address = f'http://localhost:{server.get_port()}'
        heard = []
        server.on_client_connect(heard.append)
        stranger = connect(
            address.replace('http', 'ws'),
            origin='http://evil.example',
            subprotocols=[f'viser-v{viser.__version__}'],
        )
        # A page counts from its first word on: this one speaks at once.
        with contextlib.suppress(ConnectionClosed):
            stranger.send(msgspec.msgpack.encode(FIRST_WORD))
        assert closing_code(stranger) == 1008
        assert heard == []
        with PageReader(address) as reader:
            deadline = time.monotonic() + 20.0
            while not heard and time.monotonic() < deadline:
                reader.count(0.1)
        assert len(heard) == 1
    finally:
        server.stop()


def test_the_page_cannot_be_published_over_the_internet():
    server = open_server(HERE, free_port(PagePlace(port=8900)), 'test')
    try:
        assert server.request_share_url() is None
    finally:
        server.stop()
