"""Walks of a campaign have seeds of their own, which stay when the campaign grows."""

from dataclasses import replace

import pytest
from campaign_parts import GRID

from quad_lab.campaigns.campaign_spec import Span
from quad_lab.campaigns.jobs import combinations, jobs_of

RANDOM = replace(
    GRID,
    method='random',
    walks=300,
    vary={'robot': ('titan_viii', 'cuhk'), 'friction': Span(0.4, 0.8)},
)


def seeds(jobs):
    return {job.seed for job in jobs}


@pytest.mark.parametrize('spec', [GRID, RANDOM])
def test_every_walk_has_a_seed_of_its_own(spec):
    jobs = jobs_of(spec)
    assert len(seeds(jobs)) == len(jobs) == spec.walks * (6 if spec is GRID else 1)
    assert jobs_of(spec) == jobs


def test_a_grid_has_every_combination_as_often():
    cases = [job.case for job in jobs_of(GRID)]
    pairs = [(case['robot'], case['friction']) for case in cases]
    assert all(pairs.count(pair) == GRID.walks for pair in set(pairs))
    assert sorted({friction for _, friction in pairs}) == pytest.approx([0.4, 0.6, 0.8])
    # One of each comes before the second of any.
    assert len(set(pairs[:6])) == 6


@pytest.mark.parametrize('spec', [GRID, RANDOM])
def test_more_walks_leave_the_others_as_they_were(spec):
    assert jobs_of(replace(spec, walks=spec.walks + 3))[: len(jobs_of(spec))] == jobs_of(spec)


def test_another_robot_leaves_the_walks_of_the_others_as_they_were():
    more = replace(GRID, vary={**GRID.vary, 'robot': ('titan_viii', 'genibo', 'cuhk')})
    kept = [job for job in jobs_of(more) if job.case['robot'] != 'genibo']
    assert {(job.seed, job.case['robot']) for job in kept} == {
        (job.seed, job.case['robot']) for job in jobs_of(GRID)
    }


def test_another_seed_makes_other_walks():
    assert not seeds(jobs_of(GRID)) & seeds(jobs_of(replace(GRID, seed=4)))


def test_values_at_random_are_those_of_their_ranges():
    cases = [job.case for job in jobs_of(RANDOM)]
    frictions = sorted(case['friction'] for case in cases)
    assert 0.4 <= frictions[0] < 0.42
    assert 0.78 < frictions[-1] <= 0.8
    assert frictions[150] == pytest.approx(0.6, abs=0.05)
    assert 100 < sum(case['robot'] == 'cuhk' for case in cases) < 200


def test_ranges_at_random_are_checked_at_both_ends():
    assert {case['friction'] for case in combinations(RANDOM)} == {0.4, 0.8}
