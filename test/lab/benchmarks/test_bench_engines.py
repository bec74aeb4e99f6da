"""The comparison of the engines: what it measures, and that each job is done in both."""

import math
import os
import warnings

import pytest

pytest.importorskip('pybullet')
pytest.importorskip('mujoco')

from quad_common.robot_files.robot_file import available_robots
from quad_lab.benchmarks.bench_engines import in_engine, measure, standing_creep
from quad_lab.tools.criterion import make_console
from quad_sim.engines.registry import AUTO, PREFERRED, preferred, resolved


def say(word):
    warnings.warn(word, RuntimeWarning, stacklevel=2)
    return word, resolved(AUTO)


def test_a_job_is_done_in_the_engine_and_its_warnings_are_counted():
    before = os.environ.get(PREFERRED)
    assert in_engine('mujoco', say, 'unstable') == (('unstable', 'mujoco'), 1)
    assert os.environ.get(PREFERRED) == before


def test_steps_are_timed_for_every_robot():
    bars, details = measure(make_console(stderr=True), quick=True, seed=0, only=('steps',))
    assert set(details) == {'quick', 'seed', 'steps'}
    assert set(details['steps']) == set(available_robots())
    for times in details['steps'].values():
        assert all(0.0 < time < 1e4 for time in (*times['step'], *times['observation']))
    assert len(bars) == 3 * len(available_robots())


@pytest.mark.parametrize('slope', [0.0, 0.1])
def test_a_robot_that_stands_hardly_creeps(slope):
    with preferred('mujoco'):
        speed, turning = standing_creep('titan_viii', slope, 1.0)
    assert speed < 1e-4
    assert turning < math.radians(0.1)
