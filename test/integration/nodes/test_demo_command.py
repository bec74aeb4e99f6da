"""``quadwalk demo`` walks, says how well, and leaves a picture and the figures."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('matplotlib')

from quad_cli.main import main

pytestmark = pytest.mark.ros


def demo(folder, *arguments: str) -> subprocess.CompletedProcess:
    """Run the demo with one JSON object on its standard output."""
    command = [sys.executable, '-m', 'quad_cli.main', 'demo', '--backend', 'kinematic', '--json']
    return subprocess.run(
        [*command, '--output', str(folder), *arguments],
        capture_output=True, text=True, check=False, timeout=200,
    )  # fmt: skip


@pytest.mark.usefixtures('domain')
def test_the_demo_walks_to_its_goal_and_shows_how(tmp_path):
    result = demo(tmp_path, '--start', '1.2,1.2,0', '--goal', '1.7,1.2,0deg', '--seed', '3')
    assert result.returncode == 0, result.stderr
    summary = json.loads(result.stdout)
    assert summary == json.loads((tmp_path / 'walk.json').read_text())
    assert summary['arrived'] is True
    assert summary['problem'] == ''
    assert summary['fallen'] is False
    assert summary['contacts'] == ''
    assert summary['goal'] == [1.7, 1.2, 0.0]
    assert 0.0 <= summary['position_error'] < 0.05
    assert 0.0 <= summary['heading_error'] < 5.0
    assert summary['path_length'] == pytest.approx(0.5, abs=0.01)
    assert 0.4 < summary['walked_distance'] < 1.5
    assert summary['turning_points'] == 2
    assert summary['cycles'] >= 3
    assert 0.0 < summary['least_stability_margin'] < 0.3
    # Three cycles of five seconds, begun and ended in the initial posture.
    assert 10.0 < summary['walking_time'] < 100.0
    assert summary['real_time_factor'] > 0.0
    picture = tmp_path / 'walk.png'
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert picture.stat().st_size > 5_000
    if summary['recording'] is not None:
        [recording] = (tmp_path / 'recording').glob('*.mcap')
        assert recording.stat().st_size > 10_000


@pytest.mark.usefixtures('domain')
def test_a_demo_with_an_impossible_goal_says_why(tmp_path, capfd):
    options = ('--goal', '0,0,0', '--no-recording', '--output', str(tmp_path))
    code = main(['demo', '--composed', '--backend', 'kinematic', '--json', *options])
    assert code == 1
    summary = json.loads(capfd.readouterr().out)
    assert summary['arrived'] is False
    assert 'the goal (0.00, 0.00) m is 0.00 m from the nearest occupied' in summary['problem']
    assert summary['recording'] is None
    assert (tmp_path / 'walk.png').is_file()
