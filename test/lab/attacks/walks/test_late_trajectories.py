"""Trajectories that come late or never stop no walk over uneven ground, and fell no robot."""

from __future__ import annotations

import math

import pytest

pytest.importorskip('pybullet')

from quad_lab.attacks.walks.late_trajectories import (
    QUICK_CASES,
    LateCase,
    all_cases,
    walk_with_lateness,
)
from quad_lab.closed_loop.disturbed_walk import Disturbance


def test_the_last_gate_lets_pass_what_follows_on_a_late_trajectory():
    outcome = walk_with_lateness(QUICK_CASES[0])
    assert outcome.late > 10
    assert outcome.duration >= 32.0, outcome.said
    assert not outcome.refused
    assert not outcome.has_fallen


def test_a_robot_whose_trajectories_are_lost_stays_upright():
    """It fell when it took a motion for done that had never begun."""
    pytest.importorskip('mujoco')
    often = Disturbance(lateness=0.2, lost=0.01, staleness=0.2, jitter=0.15)
    outcome = walk_with_lateness(
        LateCase('genibo', 'kerb', often, seed=1, backend='mujoco', timeout=38.0)
    )
    assert outcome.lost > 1
    assert outcome.duration >= 38.0, outcome.said
    assert not outcome.refused
    assert outcome.tilt < math.radians(6.0)


def test_walks_differ_with_the_seed_alone():
    first, other = all_cases(0), all_cases(10)
    assert first == all_cases(0)
    assert {case.seed for case in first}.isdisjoint(case.seed for case in other)
    assert {case.course for case in first} == {'kerb', 'boxes'}
