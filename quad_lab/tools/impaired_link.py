"""
Two hosts on one machine, and a link between them that delays packets and loses some.

The hosts are network namespaces of Linux. Each has one interface, a TUN device; what goes into one
is read here and comes out of the other later, or never.
"""

from __future__ import annotations

import contextlib
import ctypes
import heapq
import os
import select
import shutil
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from types import TracebackType

from quad_common.errors import QuadError
from quad_common.process.end_signals import released_at_last, shielded

_TUN = Path('/dev/net/tun')

_NAMESPACES = Path('/var/run/netns')

_DEVICE = 'quadwalk0'

_SET_DEVICE = 0x400454CA
"""The request TUNSETIFF."""

_WITHOUT_ETHERNET = 0x0001 | 0x1000
"""The flags IFF_TUN and IFF_NO_PI: packets of IP, and nothing before them."""

_NEW_NETWORK = 0x40000000
"""The flag CLONE_NEWNET."""

_FIRST_MULTICAST = 224
"""First byte of the addresses of many hosts at once."""

_LARGEST = 65536
"""Bytes of a packet."""

_LONGEST_WAIT = 0.1
"""Between two looks whether it is over [s]."""


@dataclass(eq=False, repr=False)
class NoImpairedLink(QuadError):
    """Two hosts cannot be made on this machine."""

    missing: str
    """What is missing, as the end of the sentence "there is no ..."."""

    def sentence(self) -> str:
        """Say what it needs."""
        return (
            'a network between two hosts is made of network namespaces and TUN devices, which '
            f'needs Linux, root, iproute2 and /dev/net/tun; here there is no {self.missing}'
        )


@dataclass(frozen=True)
class Impairment:
    """What happens to packets, each way."""

    delay: float
    """Time that a packet takes [s]."""
    loss: float
    """Fraction of the packets that are lost, each by itself."""
    has_multicast: bool = True
    """Whether packets to many hosts at once are handed on; across routers they are not."""


class ImpairedLink:
    """
    Two hosts and the link between them; use it in a ``with`` block.

    Parameters
    ----------
    name : str
        Beginning of the names of the hosts' network namespaces.
    impairment : Impairment
        What happens to packets.
    seed : int
        Of what is lost.

    Raises
    ------
    NoImpairedLink
        If this machine, or this user, cannot have it.
    """

    def __init__(self, name: str, impairment: Impairment, seed: int) -> None:
        check_possible()
        self.hosts = (f'{name}-a', f'{name}-b')
        """Names of the network namespaces."""
        self.packets = self.lost = 0
        """Number of packets that were sent, and of those that were lost."""
        self._impairment = impairment
        self._random = Random(seed)
        self._stack = contextlib.ExitStack()
        self._is_over = threading.Event()

    def __enter__(self) -> ImpairedLink:
        with contextlib.ExitStack() as stack:
            devices = []
            for number, host in enumerate(self.hosts, 1):
                remove = partial(_remove, host)
                stack.enter_context(released_at_last(remove))
                stack.callback(remove)
                _ip('netns', 'add', host)
                devices.append(_open_device(host))
                stack.callback(os.close, devices[-1])
                for command in (
                    f'addr add 10.77.0.{number}/24 dev {_DEVICE}',
                    'link set lo up',
                    f'link set {_DEVICE} up multicast on txqueuelen 5000',
                    f'route add 224.0.0.0/4 dev {_DEVICE}',
                ):
                    _ip('-n', host, *command.split())
            thread = threading.Thread(target=self._forward, args=devices, name='link', daemon=True)
            thread.start()
            stack.callback(thread.join)
            stack.callback(self._is_over.set)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with shielded():
            self._stack.close()

    def _forward(self, first: int, second: int) -> None:
        """Hand packets from one device to the other until it is over."""
        others = {first: second, second: first}
        waiting: list[tuple[float, int, int, bytes]] = []
        while not self._is_over.is_set():
            now = time.monotonic()
            while waiting and waiting[0][0] <= now:
                _, _, device, packet = heapq.heappop(waiting)
                # A host that is busy loses packets, as on any network.
                with contextlib.suppress(OSError):
                    os.write(device, packet)
            wait = min(_LONGEST_WAIT, max(0.0, waiting[0][0] - now)) if waiting else _LONGEST_WAIT
            for device in select.select(list(others), [], [], wait)[0]:
                with contextlib.suppress(BlockingIOError):
                    packet = os.read(device, _LARGEST)
                    if not (self._impairment.has_multicast or _is_to_one(packet)):
                        continue
                    self.packets += 1
                    if self._random.random() < self._impairment.loss:
                        self.lost += 1
                        continue
                    due = time.monotonic() + self._impairment.delay
                    heapq.heappush(waiting, (due, self.packets, others[device], packet))


@contextlib.contextmanager
def on_host(host: str) -> Iterator[None]:
    """Have this thread, and what it starts meanwhile, on a host while the block runs."""
    here = os.open('/proc/thread-self/ns/net', os.O_RDONLY)
    there = os.open(_NAMESPACES / host, os.O_RDONLY)
    try:
        _set_namespace(there)
        yield
    finally:
        _set_namespace(here)
        os.close(there)
        os.close(here)


def _is_to_one(packet: bytes) -> bool:
    """Return whether a packet is of IPv4, to a single host."""
    return len(packet) >= 20 and packet[0] >> 4 == 4 and packet[16] < _FIRST_MULTICAST


def check_possible() -> None:
    """Raise NoImpairedLink if two hosts cannot be made."""
    if sys.platform != 'linux':
        raise NoImpairedLink('Linux')
    if os.geteuid() != 0:
        raise NoImpairedLink('root')
    if shutil.which('ip') is None:
        raise NoImpairedLink('command ip (apt install iproute2)')
    if not _TUN.exists():
        raise NoImpairedLink(str(_TUN))


def _open_device(host: str) -> int:
    """Make the device of a host; return its file descriptor."""
    import fcntl

    try:
        with on_host(host):
            device = os.open(_TUN, os.O_RDWR | os.O_NONBLOCK)
        request = struct.pack('16sH', _DEVICE.encode(), _WITHOUT_ETHERNET)
        fcntl.ioctl(device, _SET_DEVICE, request)
    except OSError as error:
        raise NoImpairedLink(f'TUN device to be had ({error.strerror})') from error
    return device


def _set_namespace(descriptor: int) -> None:
    library = ctypes.CDLL(None, use_errno=True)
    if library.setns(descriptor, _NEW_NETWORK) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def _ip(*arguments: str) -> None:
    done = subprocess.run(['ip', *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise NoImpairedLink(f'permission to make hosts ({done.stderr.strip()[:200]})')


def _remove(host: str) -> None:
    """Remove a host, if it is there."""
    subprocess.run(['ip', 'netns', 'delete', host], capture_output=True, check=False)
