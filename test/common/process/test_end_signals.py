"""A signal ends a process at any moment: in time, with its code, and with all given back."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from quad_common.process.early_signals import SIGNALS
from quad_common.process.end_signals import ended_by

ROOT = Path(__file__).resolve().parents[3]

NODE = """
from quad_common.process.entry import start_node
start_node('node_of_test')
"""

COMMAND = """
import sys, time
from pathlib import Path
from quad_common.process.end_signals import *
from quad_common.process.end_signals import Raises
signals = EndSignals(Raises(), lambda number: 128 + number, 2.0)
signals.install()
def say(text):
    print(text, flush=True)
"""


def start(code: str, folder: Path, **settings) -> subprocess.Popen:
    """Start Python on some code, with modules of the test's own."""
    path = os.pathsep.join((str(ROOT), str(folder)))
    environment = {**os.environ, 'PYTHONPATH': path, **settings.pop('env', {})}
    return subprocess.Popen(
        [sys.executable, '-c', code], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, cwd=ROOT, env=environment, **settings,
    )  # fmt: skip


def send(
    process: subprocess.Popen, *numbers: int, gap: float = 0.05, sent: Path | None = None
) -> str:
    """
    Send signals once the process has said a line, and make a file when they are sent.

    Return what the process says from then on; a signal has ended it in time.
    """
    said = process.stdout.readline()
    if said != 'begun\n':
        process.kill()
    assert said == 'begun\n'
    # Only now: how long Python takes to begin is up to what else the machine does.
    began = time.monotonic()
    for number in numbers:
        process.send_signal(number)
        time.sleep(gap)
    if sent is not None:
        sent.touch()
    # Not by communicate, which does not know what readline has read ahead.
    said = process.stdout.read()
    process.wait(60.0)
    # Well before what it sleeps, however busy the machine is.
    assert not numbers or time.monotonic() - began < 20.0
    return said


def node(folder: Path, text: str) -> None:
    (folder / 'node_of_test.py').write_text(text)


@pytest.mark.parametrize('number', SIGNALS)
def test_a_node_that_is_still_importing_ends_at_once_with_0(tmp_path, number):
    node(tmp_path, "print('begun', flush=True)\nimport time\ntime.sleep(60)\n")
    process = start(NODE, tmp_path)
    assert send(process, number) == ''
    assert process.returncode == 0


def test_a_signal_that_another_thread_has_taken_wakes_the_main_thread(tmp_path):
    # The main thread sleeps in the kernel, and Python does not look for signals there.
    node(
        tmp_path,
        'import signal, threading, time\n'
        'def take():\n    time.sleep(0.3)\n'
        "    print('begun', flush=True)\n"
        '    signal.pthread_kill(threading.get_ident(), signal.SIGTERM)\n'
        'threading.Thread(target=take, daemon=True).start()\ntime.sleep(60)\n',
    )
    process = start(NODE, tmp_path)
    assert send(process) == ''
    assert process.returncode == 0


@pytest.mark.parametrize('number', SIGNALS)
def test_a_node_that_looks_whether_it_is_to_end_ends_in_good_order(tmp_path, number):
    node(
        tmp_path,
        'from quad_common.process.entry import node_end\nimport time\n'
        'def main(args):\n    end = node_end()\n    end.is_wanted()\n'
        "    print('begun', flush=True)\n"
        '    while not end.is_wanted():\n        time.sleep(0.02)\n'
        "    print('given back')\n    return 0\n",
    )
    process = start(NODE, tmp_path)
    assert send(process, number, number) == 'given back\n'
    assert process.returncode == 0


def executable(module: str, imports: str) -> str:
    """Write code that starts an executable, and does something in place of its next import."""
    name = 'entry' if module == 'quad_gait' else 'end_signals'
    return (
        'import runpy, signal, sys, threading, time\n'
        'class Slow:\n    def find_spec(self, name, path=None, target=None):\n'
        f"        if name == 'quad_common.process.{name}':\n"
        f'            {imports}\n            time.sleep(60)\n'
        'def take(number):\n    time.sleep(0.3)\n'
        "    print('begun', flush=True)\n"
        '    signal.pthread_kill(threading.get_ident(), number)\n'
        'sys.meta_path.insert(0, Slow())\n'
        f"runpy.run_module('{module}', run_name='__main__')\n"
    )


@pytest.mark.parametrize('module', ['quad_gait', 'quad_cli'])
@pytest.mark.parametrize('number', SIGNALS)
def test_an_executable_hears_signals_before_it_imports_anything(tmp_path, module, number):
    # Whatever it imports next is made to take forever.
    process = start(executable(module, "print('begun', flush=True)"), tmp_path)
    assert send(process, number) == ''
    assert process.returncode == (0 if module == 'quad_gait' else 128 + number)


@pytest.mark.parametrize('module', ['quad_gait', 'quad_cli'])
@pytest.mark.parametrize('number', SIGNALS)
def test_an_executable_hears_signals_while_an_import_waits_in_the_kernel(tmp_path, module, number):
    # A signal just before the wait, or one that another thread takes, does not end the wait.
    taken = f'threading.Thread(target=take, args=({number:d},)).start()'
    process = start(executable(module, taken), tmp_path)
    began = time.monotonic()
    assert send(process) == ''
    assert process.returncode == (0 if module == 'quad_gait' else 128 + number)
    assert time.monotonic() - began < 40.0


def test_a_node_that_hangs_is_ended_with_0_and_says_where_it_hung(tmp_path):
    node(
        tmp_path,
        'from quad_common.process.entry import node_end\n'
        'from quad_common.process.end_signals import released_at_last\nimport time\n'
        'def hang():\n    time.sleep(60)\n'
        'def main(args):\n    node_end().is_wanted()\n'
        f"    with released_at_last(lambda: open(r'{tmp_path}/released', 'w').close()):\n"
        "        print('begun', flush=True)\n        hang()\n",
    )
    process = start(NODE, tmp_path)
    said = send(process, signal.SIGTERM)
    assert process.returncode == 0
    assert said.startswith('did not end within 1.0 s of SIGTERM: it was in hang (')
    assert len(said.splitlines()) == 1
    assert (tmp_path / 'released').exists()


def test_a_thread_that_works_on_does_not_keep_a_node(tmp_path):
    node(
        tmp_path,
        'import threading, time\n'
        'def main(args):\n    threading.Thread(target=time.sleep, args=(60,)).start()\n'
        "    print('begun', flush=True)\n    return 2\n",
    )
    process = start(NODE, tmp_path)
    assert send(process) == ''
    assert process.returncode == 2


def test_signals_that_were_blocked_by_whom_started_a_node_wait_for_it(tmp_path):
    node(tmp_path, 'raise RuntimeError\n')
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        process = start(NODE, tmp_path)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0] == ''
    assert process.returncode == 0


def test_a_node_ends_with_the_process_that_started_it_and_not_with_its_thread(tmp_path):
    node(
        tmp_path,
        'import os, time\nfrom quad_common.process.entry import node_end\n'
        'def main(args):\n    end = node_end()\n    end.is_wanted()\n'
        "    print('begun', os.getpid(), flush=True)\n"
        '    while not end.is_wanted():\n        time.sleep(0.02)\n'
        "    print('given back', flush=True)\n    return 0\n",
    )
    starter = (
        'import os, subprocess, sys, threading, time\n'
        'def start():\n'
        f'    subprocess.Popen([sys.executable, "-c", {NODE!r}],\n'
        '        env={**os.environ, "QUADWALK_PARENT": str(os.getpid())})\n'
        'thread = threading.Thread(target=start)\nthread.start()\nthread.join()\n'
        'time.sleep(60)\n'
    )
    process = start(starter, tmp_path)
    pid = int(process.stdout.readline().split()[1])
    time.sleep(1.0)
    os.kill(pid, 0)
    process.kill()
    # The node has the pipe open as long as it lives.
    assert process.stdout.read() == 'given back\n'
    process.wait(10.0)


@pytest.mark.parametrize('number', SIGNALS)
def test_a_command_unwinds_once_however_many_signals_come(tmp_path, number):
    sent = tmp_path / 'sent'
    process = start(
        COMMAND + 'try:\n    try:\n        say("begun")\n        time.sleep(60)\n'
        f'    finally:\n        while not Path({str(sent)!r}).exists():\n'
        '            time.sleep(0.02)\n        say("given back")\n'
        'except Interrupted as error:\n    say(str(error))\n    end_process(128 + error.number)\n',
        tmp_path,
    )
    said = send(process, number, signal.SIGINT, signal.SIGTERM, sent=sent)
    assert said == f'given back\n{ended_by(number)}\n'
    assert process.returncode == 128 + number


def test_what_is_shielded_is_finished_before_a_signal_is_raised(tmp_path):
    sent = tmp_path / 'sent'
    process = start(
        COMMAND + 'try:\n    with shielded():\n        with shielded():\n            say("begun")\n'
        f'            while not Path({str(sent)!r}).exists():\n                time.sleep(0.02)\n'
        '        say("whole")\n    say("never")\n'
        'except Interrupted as error:\n    say(str(error))\n',
        tmp_path,
    )
    assert send(process, signal.SIGTERM, sent=sent) == 'whole\nended by SIGTERM\n'


def test_what_another_thread_shields_keeps_no_signal_from_the_main_thread(tmp_path):
    process = start(
        COMMAND + 'import threading\n'
        'def work():\n    with shielded():\n        say("begun")\n        time.sleep(1.0)\n'
        'try:\n    threading.Thread(target=work, daemon=True).start()\n'
        '    time.sleep(60)\nexcept Interrupted as error:\n    say(str(error))\n',
        tmp_path,
    )
    assert send(process, signal.SIGTERM) == 'ended by SIGTERM\n'


def test_a_signal_that_python_swallows_in_a_destructor_is_raised_anew(tmp_path):
    process = start(
        COMMAND
        + 'class Slow:\n    def __del__(self):\n        say("begun")\n        time.sleep(60)\n'
        'try:\n    Slow()\n    time.sleep(60)\nexcept Interrupted as error:\n    say(str(error))\n',
        tmp_path,
    )
    assert send(process, signal.SIGINT) == 'interrupted\n'


def test_a_command_that_does_not_unwind_is_ended_with_the_code_of_its_signal(tmp_path):
    process = start(
        COMMAND
        + 'try:\n    say("begun")\n    time.sleep(60)\nexcept Interrupted:\n    time.sleep(60)\n',
        tmp_path,
    )
    assert send(process, signal.SIGHUP).startswith('did not end within 2.0 s of SIGHUP: it was in ')
    assert process.returncode == 128 + signal.SIGHUP


def test_what_nohup_started_does_not_hear_of_its_terminal(tmp_path):
    process = start(
        COMMAND + 'say("begun")\ntime.sleep(0.5)\nsay("went on")\n',
        tmp_path,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN),
    )
    assert send(process, signal.SIGHUP) == 'went on\n'
    assert process.returncode == 0


def test_a_forked_process_is_not_its_parents_to_clean_up(tmp_path):
    process = start(
        COMMAND + 'import os, signal\n'
        f"with released_at_last(lambda: open(r'{tmp_path}/released', 'w').close()):\n"
        '    child = os.fork()\n'
        '    if not child:\n        end_process(7)\n'
        '    say("begun")\n    say(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n',
        tmp_path,
    )
    assert send(process) == '7\n'
    assert not (tmp_path / 'released').exists()
