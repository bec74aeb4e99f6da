"""A walk is a function of its case and its seed, bit for bit; its key says what it follows from."""

import math
from dataclasses import replace

import pytest

from quad_lab.campaigns.replayed_walk import differing
from quad_lab.seeded_walks.walk_task import Job, code_digest, key_of, run_walk

SHORT = {'robot': 'cuhk', 'gait': 'trot', 'shortest': 0.2, 'longest': 0.4, 'map': 'random'}
STEERED = {'task': 'steer', 'robot': 'cuhk', 'gait': 'trot', 'duration': 2.0}

ENGINES = {'bullet': 'pybullet', 'mujoco': 'mujoco'}


@pytest.mark.parametrize(('engine', 'noise'), [('bullet', 0.0), ('mujoco', 0.002)])
def test_one_seed_makes_one_walk(engine, noise):
    pytest.importorskip(ENGINES[engine])
    job = Job({**SHORT, 'engine': engine, 'position_noise': noise, 'joint_noise': noise}, 5)
    first = run_walk(job).figures
    assert first.succeeded, first
    assert first.position_error < 0.03
    assert 0.2 <= first.length <= 0.4
    run_walk(replace(job, seed=6))
    assert differing(run_walk(job).figures, first) == []
    assert differing(run_walk(replace(job, seed=6)).figures, first) != []


@pytest.mark.parametrize('direction', ['forward', 'left', 'turn'])
def test_a_steered_walk_goes_as_fast_as_it_is_asked(direction):
    pytest.importorskip('mujoco')
    case = {**STEERED, 'engine': 'mujoco', 'direction': direction, 'speed': 0.1, 'duration': 3.0}
    figures = run_walk(Job(case, 1)).figures
    assert figures.succeeded, figures
    assert figures.speed == pytest.approx(0.1, rel=0.05)
    assert math.isnan(figures.transport_cost) == (direction == 'turn')


def test_changes_of_the_gait_are_walked():
    pytest.importorskip('mujoco')
    case = {**STEERED, 'engine': 'mujoco', 'speed': 0.1}
    low, high = (
        run_walk(Job({**case, 'gait.swing_height': height}, 1)).figures.transport_cost
        for height in (0.004, 0.02)
    )
    assert low < 0.8 * high


def test_whatever_goes_wrong_becomes_a_figure():
    figures = run_walk(Job({'robot': 'nobody'}, 1)).figures
    assert 'nobody' in figures.problem
    assert not figures.succeeded
    narrow = run_walk(Job({**SHORT, 'map': 'room', 'shortest': 900.0, 'longest': 999.0}, 1)).figures
    assert 'none has a plan of 900 to 999 m' in narrow.problem


def test_a_key_is_that_of_all_that_figures_follow_from(tmp_path):
    robot = tmp_path / 'robot.yaml'
    robot.write_text('a', encoding='utf-8')
    job = Job({**STEERED, 'map': 'room'}, 1)
    keys = {
        key_of(job),
        key_of(replace(job, seed=2)),
        key_of(replace(job, case={**job.case, 'friction': 0.5})),
        key_of(replace(job, case={**job.case, 'map': 'office'})),
    }
    assert len(keys) == 4
    assert key_of(Job(dict(reversed(job.case.items())), 1)) == key_of(job)
    assert all(len(key) == 24 for key in (*keys, code_digest()))


def test_a_file_that_a_case_names_belongs_to_the_key(tmp_path):
    from quad_lab.seeded_walks import walk_task

    path = tmp_path / 'gait.yaml'
    keys = []
    for text in ('one', 'two'):
        path.write_text(text, encoding='utf-8')
        walk_task._content.cache_clear()
        keys.append(key_of(Job({'gait': str(path)}, 1)))
    assert keys[0] != keys[1]
