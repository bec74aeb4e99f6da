"""The attack on processes sees what they leave behind, and only that."""

from __future__ import annotations

import fcntl
import os
import subprocess
import sys
import time
from dataclasses import replace

import pytest

pytest.importorskip('rclpy')
if sys.platform != 'linux':
    pytest.skip('looks into /proc', allow_module_level=True)

from quad_lab.attacks.processes.endings import Ending, ending_bars, is_bad
from quad_lab.attacks.processes.traces import Traces

GOOD = Ending('planner_node', 'SIGINT', 0.5, 0.2, 0, True, False, ())

FAMILY = """
import subprocess, sys
child = subprocess.Popen([sys.executable, '-c', 'print("begun", flush=True); input()'])
child.wait()
"""


def test_what_a_process_starts_belongs_to_it_even_when_it_has_ended():
    parent = subprocess.Popen(
        [sys.executable, '-c', FAMILY], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert parent.stdout.readline() == 'begun\n'
    traces = Traces(parent.pid)
    traces.look()
    assert len(traces.running()) == 2
    parent.kill()
    parent.wait()
    [child] = traces.running()
    parent.communicate('\n')
    deadline = time.monotonic() + 20.0
    while traces.running():
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert child != parent.pid


def test_shared_memory_counts_as_long_as_it_is_there(tmp_path, monkeypatch):
    monkeypatch.setattr('quad_lab.attacks.processes.traces.FOLDER', tmp_path)
    path = tmp_path / 'fastrtps_0123_el'
    path.write_text('')
    (tmp_path / 'fastrtps_theirs_el').write_text('')
    traces = Traces(os.getpid())
    with path.open() as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        traces.look()
    assert traces.shared_memory() == ['fastrtps_0123_el']
    path.unlink()
    assert traces.shared_memory() == []


@pytest.mark.parametrize(
    'change',
    [
        {'duration': 5.1},
        {'is_code_right': False},
        {'has_traceback': True},
        {'left': ('quadwalk_x',)},
        {'next_run': False},
    ],
)
def test_each_thing_that_goes_wrong_has_a_bar_that_does_not_hold(change):
    good, bad = replace(GOOD, next_run=True), replace(GOOD, **{'next_run': True, **change})
    assert not is_bad(good)
    assert is_bad(bad)
    assert all(bar.holds is not False for bar in ending_bars('node', [good] * 3))
    failed = [bar for bar in ending_bars('node', [good, bad]) if bar.holds is False]
    assert len(failed) == 1
