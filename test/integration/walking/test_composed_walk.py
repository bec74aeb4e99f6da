"""All nodes in one process, in step: a walk is the same every time, to the last bit."""

import json
import subprocess
import sys

import pytest

from quad_sim.engines.registry import ENGINES

WALK = ('--start', '1.2,1.2,0', '--goal', '1.5,2.0,1.0', '--seed', '3', '--json')
OF_THE_CLOCK = ('wall_time', 'real_time_factor', 'picture', 'recording')


def composed(folder, backend, *options):
    command = [sys.executable, '-m', 'quad_cli', 'demo', '--composed', '--backend', backend]
    run = subprocess.run(
        [*command, *WALK, *options, '--output', str(folder)],
        capture_output=True,
        text=True,
        timeout=120.0,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    result = json.loads(run.stdout)
    return {key: value for key, value in result.items() if key not in OF_THE_CLOCK}


@pytest.mark.parametrize('backend', ['kinematic', 'mujoco'])
def test_a_composed_walk_arrives_and_repeats_bit_for_bit(tmp_path, backend):
    if ENGINES[backend].package:
        pytest.importorskip(ENGINES[backend].package)
    first = composed(tmp_path, backend, '--gait', 'trot', '--no-recording')
    # Who listens changes nothing.
    second = composed(tmp_path, backend, '--gait', 'trot')
    assert (tmp_path / 'recording' / 'metadata.yaml').is_file()
    assert first['arrived']
    assert first['late_trajectories'] == 0
    assert first['cycles'] > 4
    assert first == second
