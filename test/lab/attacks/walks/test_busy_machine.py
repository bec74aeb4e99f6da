"""Sound robots on a busy machine are called sound, and what is drawn follows from its seed."""

from itertools import islice

import pytest
from rich.console import Console

pytest.importorskip('pybullet')

from quad_common.robot_files.robot_file import available_robots
from quad_lab.attacks.walks.busy_machine import (
    QUICK_WALK,
    attack_by_load,
    drawn_walks,
    walk_watched,
)
from quad_lab.tools.criterion import Criterion
from quad_sim.engines.registry import ENGINES, engines_with


def test_the_same_seed_draws_the_same_walks_and_another_one_others():
    first, again, other = (list(islice(drawn_walks(seed, 60.0), 30)) for seed in (3, 3, 4))
    assert first == again
    assert first != other


def test_every_robot_gait_turning_and_kind_of_walk_is_drawn():
    walks = list(islice(drawn_walks(0, 60.0), 400))
    assert {walk.robot for walk in walks} == set(available_robots())
    assert {walk.gait for walk in walks} == {'crawl', 'crab', 'wave', 'trot'}
    assert {walk.turning for walk in walks} == {'in_place', 'crab', 'arc'}
    kinds = {'steered', 'circle', 'plan', 'bumps', 'slope', 'cross_slope', 'kerb', 'boxes'}
    assert {walk.kind for walk in walks} == kinds
    assert {walk.is_disturbed for walk in walks} == {True, False}
    engines = [name for name in engines_with('has_world') if ENGINES[name].is_installed]
    for robot in available_robots():
        assert {walk.backend for walk in walks if walk.robot == robot} == set(engines)


def test_a_walk_is_the_same_whoever_walks_it():
    walk = next(drawn_walks(5, 6.0))
    assert walk_watched(walk) == walk_watched(walk)


@pytest.mark.slow
def test_a_quick_campaign_has_late_and_lost_trajectories_and_no_false_alarm():
    measured, _ = attack_by_load(Console(quiet=True), quick=True, seed=2)
    bars: dict[str, Criterion] = {bar.name: bar for bar in measured}
    assert bars['sound robots walk, simulated'].value > 3.0 * QUICK_WALK / 3600.0
    assert bars['sound robots: trajectories that came late'].value > 0
    assert all(bar.holds is not False for bar in bars.values()), bars
