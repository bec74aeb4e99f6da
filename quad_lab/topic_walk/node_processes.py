"""
Starts nodes as processes of their own, keeps their logs and ends them by their ids.
"""

from __future__ import annotations

import contextlib
import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from quad_common.errors import QuadError
from quad_common.network.transport import DISCOVERY_SERVER, RANGE, local_settings
from quad_common.process.end_signals import blocked_signals, released_at_last, shielded
from quad_common.process.entry import PARENT
from quad_common.process.temporary_folder import temporary_folder

NODES = {
    'planner_node': 'quad_planner',
    'gait_node': 'quad_gait',
    'sim_node': 'quad_sim',
    'ceiling_camera_node': 'quad_perception',
    'viewer_node': 'quad_view',
}
"""What Python runs for each node's executable."""

_OF_OWN_TIME = ('sim_node', 'viewer_node')
"""Nodes that make simulated time, or show whatever comes."""

_LAST_WAIT = 3.0
"""For all nodes together to end; each sees to it that it takes less [s]."""

_SHORT_WAIT = 0.05
"""Between two looks whether a node has ended [s]."""

_ABORT_WAIT = 0.5
"""For a node that hangs to say where [s]."""

_FIRST_LOCK_PORT = 32768

_PARTICIPANTS = 32
"""The most that find one another on one machine."""


@dataclass(eq=False, repr=False)
class NodeDied(QuadError):
    """A node ended without being asked to."""

    name: str
    """Name of the node."""
    code: int
    """Exit code."""
    log: str
    """Last lines of its log."""

    def sentence(self) -> str:
        """Say which node ended, and its last words."""
        return f'{self.name} ended with code {self.code}; its last words:\n{self.log}'


@dataclass(eq=False, repr=False)
class NoFreeDomain(QuadError):
    """Every ROS domain of this machine is in use."""

    count: int
    """Number of domains that were tried."""

    def sentence(self) -> str:
        """Say how many are in use."""
        return f'all {self.count} ROS domains of this machine are in use'


@contextlib.contextmanager
def isolated_domain() -> Iterator[int]:
    """
    Claim a ROS domain of this machine, so that nothing else disturbs or observes the nodes.

    Yields
    ------
    int
        The domain, from 1 to 100; ``ROS_DOMAIN_ID`` and the other settings stand in
        ``os.environ`` meanwhile. A domain that the user has set is taken as it is.
    """
    if os.environ.get('ROS_SECURITY_ENABLE'):
        # Only here, because it needs rclpy.
        from quad_common.ros.run_node import check_middleware

        check_middleware()
    changed = local_settings(os.environ)
    with contextlib.ExitStack() as stack:
        if 'ROS_DOMAIN_ID' not in os.environ:
            changed['ROS_DOMAIN_ID'] = str(_claim_domain(stack))
        before = {name: os.environ.get(name) for name in changed}
        os.environ.update(changed)
        try:
            yield int(os.environ['ROS_DOMAIN_ID'])
        finally:
            _restore(before)


@contextlib.contextmanager
def subnet_domain() -> Iterator[None]:
    """Let nodes meet across the hosts of the subnet, as they do where nothing is set."""
    changed = dict.fromkeys(('ROS_STATIC_PEERS', 'ROS_LOCALHOST_ONLY', DISCOVERY_SERVER), '')
    changed[RANGE] = 'SUBNET'
    before = {name: os.environ.get(name) for name in changed}
    os.environ.update(changed)
    try:
        yield
    finally:
        _restore(before)


def _restore(variables: Mapping[str, str | None]) -> None:
    """Set environment variables as they were; None: unset."""
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value


def _claim_domain(stack: contextlib.ExitStack) -> int:
    """Hold a TCP port that stands for the domain as long as the stack lives."""
    domains = list(range(1, 101))
    random.SystemRandom().shuffle(domains)
    for domain in domains:
        lock = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            lock.bind(('127.0.0.1', _FIRST_LOCK_PORT + domain))
        except OSError:
            lock.close()
            continue
        # Only now: to look takes the ports for a moment, which nodes that begin may be about to.
        if not _is_quiet(domain):
            lock.close()
            continue
        stack.enter_context(contextlib.closing(lock))
        return domain
    raise NoFreeDomain(100)


def _is_quiet(domain: int) -> bool:
    """Return whether no process on this machine holds a discovery port of a domain."""
    # RTPS 2.2 sec. 9.6.1.1: one port for all participants, and one for each of them.
    first = 7400 + 250 * domain
    for port in (first, *(first + 10 + 2 * k for k in range(_PARTICIPANTS))):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(('', port))
            except OSError:
                return False
    return True


class NodeProcess:
    """
    One node, running.

    Parameters
    ----------
    name : str
        Key of :data:`NODES`.
    parameters : mapping of str to object
        Its ROS parameters.
    log : Path
        Where its output goes.
    namespace : str
        Of its topics and services.
    host : str
        Network namespace of Linux that it runs in; empty for that of this process.
    """

    def __init__(
        self,
        name: str,
        parameters: Mapping[str, object],
        log: Path,
        namespace: str = '',
        host: str = '',
    ) -> None:
        self.name = name
        self._log = log
        self._is_interrupted = False
        arguments = [part for key, value in parameters.items() for part in ('-p', _set(key, value))]
        if namespace:
            arguments += ['-r', f'__ns:=/{namespace.strip("/")}']
        environment = dict(
            os.environ,
            PYTHONUNBUFFERED='1',
            PYTHONFAULTHANDLER='1',
            **{PARENT: str(os.getpid())},
        )
        # The wheels of rclpy leave it behind to start each python once more only.
        environment.pop('_ROS_WHEELS_BOOTSTRAP_COMPLETE', None)
        # ip becomes the node: it has the same process id.
        prefix = ['ip', 'netns', 'exec', host] if host else []
        command = [*prefix, sys.executable, '-m', NODES[name], '--ros-args', *arguments]
        with shielded(), log.open('ab') as output, blocked_signals():
            self._process = subprocess.Popen(
                command,
                stdout=output,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
            )

    @property
    def pid(self) -> int:
        """The process id."""
        return self._process.pid

    def check(self) -> None:
        """Raise NodeDied if it has ended."""
        code = self._process.poll()
        if code is not None:
            raise NodeDied(self.name, code, self.log_tail())

    def log_tail(self, lines: int = 12) -> str:
        """Return the last lines of its output."""
        return '\n'.join(self._log.read_text(errors='replace').splitlines()[-lines:])

    def kill(self) -> None:
        """End it at once, as a crash would."""
        self._process.kill()
        self._process.wait()

    def wait(self, timeout: float = 5.0) -> int:
        """Wait for its end; return its exit code."""
        # In short waits: the time for which the whole machine stood still does not count.
        for _ in range(max(1, round(timeout / _SHORT_WAIT))):
            try:
                return self._process.wait(_SHORT_WAIT)
            except subprocess.TimeoutExpired:
                continue
        return self._end_by_force()

    def end_by(self, deadline: float) -> None:
        """Interrupt it, and see to it that it has ended at a time of the monotonic clock."""
        self.interrupt()
        while self._process.poll() is None and time.monotonic() < deadline:
            time.sleep(_SHORT_WAIT)
        if self._process.poll() is None:
            self._end_by_force()

    def _end_by_force(self) -> int:
        """End it though it hangs."""
        # Python writes into the log where it hangs, and ends.
        self._process.send_signal(signal.SIGABRT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_ABORT_WAIT)
        self.kill()
        return self._process.returncode

    def stop(self, timeout: float = 5.0) -> int:
        """Interrupt it, as Ctrl-C would, and wait; return its exit code."""
        self.interrupt()
        return self.wait(timeout)

    def interrupt(self) -> None:
        """Interrupt it, as Ctrl-C would, once: a second time would disturb its end."""
        if not self._is_interrupted and self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)
        self._is_interrupted = True


class NodeProcesses:
    """
    Nodes that are ended together when the block ends.

    Parameters
    ----------
    namespace : str
        Of their topics and services.
    hosts : mapping of str to str, optional
        Network namespaces of Linux that nodes run in, by their names; the others run in that of
        this process.
    """

    def __init__(self, namespace: str = '', hosts: Mapping[str, str] | None = None) -> None:
        self._namespace = namespace
        self._hosts = dict(hosts or {})
        self._running: dict[str, NodeProcess] = {}
        self._stack = contextlib.ExitStack()
        self._folder = self._stack.enter_context(temporary_folder())
        self._stack.enter_context(released_at_last(self._kill))

    def __enter__(self) -> NodeProcesses:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with shielded(), self._stack:
            # All at once, so that they end beside one another.
            for process in self._running.values():
                process.interrupt()
            deadline = time.monotonic() + _LAST_WAIT
            for process in self._running.values():
                process.end_by(deadline)

    def start(self, name: str, **parameters: object) -> NodeProcess:
        """Start a node, or start it again; it takes its time from the simulator."""
        log = self._folder / f'{name}.log'
        with shielded():
            given = in_simulated_time(name, parameters)
            self._running[name] = NodeProcess(
                name, given, log, self._namespace, self._hosts.get(name, '')
            )
        return self._running[name]

    def check(self) -> None:
        """Raise NodeDied if one has ended."""
        for process in self._running.values():
            process.check()

    def _kill(self) -> None:
        for process in self._running.values():
            process.kill()


def in_simulated_time(name: str, parameters: Mapping[str, object]) -> dict[str, object]:
    """Return the parameters of a node that walks with a simulator, unless they say otherwise."""
    return {'use_sim_time': name not in _OF_OWN_TIME, **parameters}


def _set(name: str, value: object) -> str:
    if isinstance(value, bool):
        return f'{name}:={str(value).lower()}'
    if isinstance(value, str):
        # Quoted, so that a text that looks like a number or a list stays a text.
        return f"{name}:='{value}'"
    return f'{name}:={value}'
