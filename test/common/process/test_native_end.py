"""A process ends in time though its main thread hangs with Python's lock in its hands."""

import subprocess
import sys
import time

import pytest

SCRIPT = """
import ctypes, time
from quad_common.process.native_end import ended_natively_after
with ended_natively_after({seconds}, {code}) as is_armed:
    assert is_armed
    print('armed', flush=True)
    ctypes.PyDLL(None).sleep({hang})
time.sleep({after})
print('through')
"""

pytestmark = pytest.mark.skipif(sys.platform != 'linux', reason='a timer of Linux')


def run(**values):
    command = [sys.executable, '-c', SCRIPT.format(**values)]
    return subprocess.run(command, capture_output=True, timeout=25.0, check=False, text=True)


@pytest.mark.parametrize('code', [0, 3])
def test_a_process_that_hangs_with_the_lock_is_ended_with_its_code(code):
    began = time.monotonic()
    ended = run(seconds=0.3, code=code, hang=20, after=0)
    assert (ended.returncode, ended.stdout) == (code, 'armed\n'), ended.stderr
    assert time.monotonic() - began < 15.0


def test_a_process_whose_block_has_ended_in_time_goes_on():
    ended = run(seconds=1.0, code=3, hang=0, after=1.5)
    assert (ended.returncode, ended.stdout) == (0, 'armed\nthrough\n'), ended.stderr
