"""A trot whose plans change in mid-turn does not fall."""

import math

import pytest

from quad_lab.seeded_walks.changing_plans import walk_changing_plans
from quad_sim.engines.registry import ENGINES, engines_with

BACKENDS = engines_with('has_world')


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize(
    ('seed', 'backend'),
    [(13, BACKENDS[0]), (13, BACKENDS[-1]), (17, BACKENDS[0]), (20, BACKENDS[-1])],
)
def test_a_small_robot_stays_upright_whatever_the_turns(backend, seed):
    pytest.importorskip(ENGINES[backend].package)
    walk = walk_changing_plans('cuhk', seed, backend)
    assert walk.fell_at is None
    assert walk.largest_tilt < math.radians(12.0)


@pytest.mark.parametrize('robot', ['genibo', 'pukyong', 'titan_viii'])
def test_other_robots_do_too(robot):
    pytest.importorskip(ENGINES[BACKENDS[-1]].package)
    walk = walk_changing_plans(robot, 3, BACKENDS[-1], duration=8.0)
    assert walk.fell_at is None
    assert walk.largest_tilt < math.radians(12.0)
