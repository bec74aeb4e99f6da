"""A command whose output cannot be written says so, and nothing else."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('rich')

ROOT = Path(__file__).parents[2]
FULL = Path('/dev/full')

COMMANDS = {
    'help': ['--help'],
    'version': ['--version'],
    'help of a command': ['gait', '--help'],
    'help of a part': ['robot', 'list', '--help'],
    'table': ['gait', 'list'],
    'json': ['robot', 'list', '--json'],
    'text': ['parameters', 'gait_node'],
}


def run(arguments, stdout, **environment):
    kept = {key: value for key, value in os.environ.items() if key != 'PYTHONUNBUFFERED'}
    return subprocess.run(
        [sys.executable, '-m', 'quad_cli', *arguments],
        stdout=stdout,
        stderr=subprocess.PIPE,
        text=True,
        env={**kept, 'PYTHONPATH': str(ROOT), **environment},
        timeout=120.0,
        check=False,
    )


@pytest.mark.skipif(not FULL.exists(), reason='only Linux has /dev/full')
@pytest.mark.parametrize('environment', [{}, {'PYTHONUNBUFFERED': '1'}], ids=['', 'unbuffered'])
@pytest.mark.parametrize('arguments', COMMANDS.values(), ids=COMMANDS)
def test_a_full_output_is_told_in_one_sentence(arguments, environment):
    with FULL.open('w') as full:
        done = run(arguments, full, **environment)
    assert done.returncode == 2
    assert done.stderr == 'error: [Errno 28] No space left on device\n'


@pytest.mark.parametrize('arguments', [['--help'], ['gait', 'list']])
def test_a_reader_that_has_gone_is_no_fault_to_speak_of(arguments):
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = run(arguments, writer)
    finally:
        os.close(writer)
    assert (done.returncode, done.stderr) == (1, '')
