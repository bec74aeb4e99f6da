"""All nodes in one process, in step: a walk is the same every time, to the last bit."""

import json
import subprocess
import sys

import pytest

from quad_cli.main import main
from quad_sim.engines.registry import ENGINES

WALK = ('--start', '1.2,1.2,0', '--goal', '1.5,2.0,1.0', '--seed', '3', '--json')
OF_THE_CLOCK = ('wall_time', 'real_time_factor', 'picture', 'recording')


def composed(folder, backend):
    """Walk in a process of its own, and record it."""
    command = [sys.executable, '-m', 'quad_cli', *demo(folder, backend)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=600.0, check=False)
    assert run.returncode == 0, run.stderr
    return of_the_walk(run.stdout)


def demo(folder, backend):
    where = ('--backend', backend, '--output', str(folder))
    return 'demo', '--composed', '--gait', 'trot', *WALK, *where


def of_the_walk(output):
    return {key: value for key, value in json.loads(output).items() if key not in OF_THE_CLOCK}


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('backend', ['kinematic', 'mujoco'])
@pytest.mark.usefixtures('domain')
def test_a_composed_walk_arrives_and_repeats_bit_for_bit(tmp_path, capfd, backend):
    if ENGINES[backend].package:
        pytest.importorskip(ENGINES[backend].package)
    first = composed(tmp_path, backend)
    assert (tmp_path / 'recording' / 'metadata.yaml').is_file()
    # Neither who listens changes anything, nor what this process has done before.
    assert main([*demo(tmp_path / 'again', backend), '--no-recording']) == 0
    second = of_the_walk(capfd.readouterr().out)
    assert first['arrived']
    assert first['late_trajectories'] == 0
    assert first['cycles'] > 4
    assert first == second
