"""A gait that is not given the processor again and again makes no robot fall."""

from __future__ import annotations

import math

import pytest

pytest.importorskip('pybullet')

from quad_lab.attacks.walks.pauses import FLAT, QUICK_CASES, all_cases, walk_with_pauses


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('case', QUICK_CASES, ids=lambda case: case.ground)
def test_a_robot_that_feels_for_the_ground_stays_upright(case):
    outcome = walk_with_pauses(case)
    assert outcome.pauses > 5
    assert not outcome.has_fallen
    assert outcome.tilt < math.radians(6.0)


def test_all_walks_are_the_same_for_a_seed_and_others_for_another():
    first, again, other = (list(all_cases(seed)) for seed in (0, 0, 10))
    assert first == again
    assert not {(c.robot, c.gait, c.ground, c.seed) for c in first} & {
        (c.robot, c.gait, c.ground, c.seed) for c in other
    }
    assert {case.ground for case in first} > {FLAT, 'kerb', 'boxes'}
