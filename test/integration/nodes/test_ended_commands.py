"""Whatever ends ``quadwalk demo`` or ``bench``, nothing stays behind and the next run works."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('rosbags')

from rosbags.rosbag2 import Reader

from quad_common.process.temporary_folder import ownerless_folders

pytestmark = pytest.mark.ros

WALL_TIMEOUT = 100.0
"""For whatever a test waits for [s]."""

ENDS_WITHIN = 20.0
"""Three seconds and a half on a quiet machine, on one that does ten other things more [s]."""


@pytest.fixture(autouse=True)
def place(domain, tmp_path, monkeypatch) -> Path:
    """Have temporary folders made where no other test makes them."""
    place = tmp_path / 'temporary'
    place.mkdir()
    monkeypatch.setenv('TMPDIR', str(place))
    return place


def start(*arguments: str) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, '-m', 'quad_cli', *arguments],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


FAR = ('--start', '1.2,1.2,0', '--goal', '6.8,4.8,0')
"""A walk that takes longer than a test needs to end it."""

NEAR = ('--start', '1.2,1.2,0', '--goal', '1.6,1.2,0')


PACED = ('--backend', 'kinematic', '--real-time-factor', '10')
"""A walk of its own pace is recorded as it goes, and not when it is over."""


def demo(output: Path, way: tuple[str, ...]) -> subprocess.Popen:
    return start('demo', *PACED, '--json', *way, '--output', str(output))


def wait_until(condition) -> None:
    deadline = time.monotonic() + WALL_TIMEOUT
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def below(pid: int) -> list[int]:
    """List the children of a process, and theirs."""
    path = Path(f'/proc/{pid}/task/{pid}/children')
    children = [int(child) for child in path.read_text().split()] if path.exists() else []
    return children + [each for child in children for each in below(child)]


def is_running(pid: int) -> bool:
    """Whether a process lives; one that nobody waits for may stay behind as a zombie."""
    try:
        return Path(f'/proc/{pid}/cmdline').read_bytes() != b''
    except (FileNotFoundError, ProcessLookupError):
        return False


def recorded(folder: Path) -> bool:
    """Whether something was written into a recording."""
    return any(path.stat().st_size > 20_000 for path in folder.glob('*.mcap'))


@pytest.mark.skipif(sys.platform != 'linux', reason='looks into /proc')
@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGKILL])
def test_a_demo_that_is_ended_leaves_nothing_and_the_next_one_walks(tmp_path, place, number):
    recording = tmp_path / 'recording'
    first = demo(tmp_path, FAR)
    wait_until(lambda: recorded(recording))
    nodes = below(first.pid)
    assert len(nodes) >= 3
    began = time.monotonic()
    first.send_signal(number)
    said = first.communicate(timeout=WALL_TIMEOUT)[1]
    assert time.monotonic() - began < ENDS_WITHIN
    wait_until(lambda: not any(map(is_running, nodes)))
    assert time.monotonic() - began < ENDS_WITHIN
    assert 'Traceback' not in said
    if number == signal.SIGKILL:
        assert first.returncode == -number
        assert not (recording / 'metadata.yaml').exists()
    else:
        assert first.returncode == 128 + number
        assert said.splitlines()[-1] == f'ended by {signal.Signals(number).name}'
        with Reader(recording) as reader:
            assert reader.message_count > 0
            assert reader.duration > 0
        assert list(place.iterdir()) == []
        assert ownerless_folders() == []
        # There is nothing that the next one could find.
        return

    second = demo(tmp_path, NEAR)
    output, said = second.communicate(timeout=2.0 * WALL_TIMEOUT)
    assert second.returncode == 0, said
    assert json.loads(output)['arrived'] is True
    with Reader(recording) as reader:
        assert reader.message_count > 0
    assert list(place.iterdir()) == []
    assert ownerless_folders() == []


def test_a_second_interrupt_leaves_no_node_behind(tmp_path, place):
    command = demo(tmp_path, FAR)
    wait_until(lambda: len(below(command.pid)) >= 3)
    nodes = below(command.pid)
    for _ in range(3):
        command.send_signal(signal.SIGINT)
        time.sleep(0.02)
    said = command.communicate(timeout=WALL_TIMEOUT)[1]
    assert command.returncode == 130
    assert said.splitlines()[-1] == 'interrupted'
    assert 'Traceback' not in said
    assert not any(map(is_running, nodes))
    assert list(place.iterdir()) == []


def test_a_demo_whose_terminal_is_closed_ends_with_its_nodes(tmp_path, place):
    pid, terminal = pty.fork()
    if pid == 0:
        command = ('quad_cli', 'demo', *PACED, *FAR, '--output', str(tmp_path))
        os.execv(sys.executable, [sys.executable, '-m', *command])
    wait_until(lambda: recorded(tmp_path / 'recording'))
    nodes = below(pid)
    os.close(terminal)
    began = time.monotonic()
    _, status = os.waitpid(pid, 0)
    assert time.monotonic() - began < ENDS_WITHIN
    assert os.waitstatus_to_exitcode(status) == 128 + signal.SIGHUP
    assert len(nodes) >= 3
    assert not any(map(is_running, nodes))
    assert list(place.iterdir()) == []
    with Reader(tmp_path / 'recording') as reader:
        assert reader.message_count > 0


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_bench_with_worker_processes_ends_with_them(place, number):
    pytest.importorskip('pybullet')
    command = start('bench', 'terrain', '--quick')
    wait_until(lambda: len(below(command.pid)) >= os.cpu_count())
    workers = below(command.pid)
    began = time.monotonic()
    command.send_signal(number)
    said = command.communicate(timeout=WALL_TIMEOUT)[1]
    wait_until(lambda: not any(map(is_running, workers)))
    assert time.monotonic() - began < ENDS_WITHIN
    assert command.returncode == (-number if number == signal.SIGKILL else 128 + number)
    assert 'Traceback' not in said
    assert list(place.iterdir()) == []
