"""A ball thrown at a robot gives its body what momentum says, in both engines."""

import math
from functools import partial

import pytest

from quad_lab.balance.balance_case import BalanceCase, BalanceWalk
from quad_lab.balance.pushes import apart
from quad_lab.balance.thrown_ball import BALL_MASS, hit
from quad_sim.engines.registry import preferred


@pytest.mark.parametrize('engine', ['bullet', 'mujoco'])
def test_a_body_gains_the_momentum_of_a_ball_that_does_not_rebound(engine):
    pytest.importorskip({'bullet': 'pybullet'}.get(engine, engine))
    with preferred(engine):
        walk = BalanceWalk(BalanceCase('a1', speed=0.0))
    try:
        for angle in (0.0, math.pi / 2.0):
            survives, gained = apart(partial(hit, walk, 0.5, angle))
            assert survives
            # Robot and ball go on together, but for what the feet hold back meanwhile.
            assert 0.5 * 0.5 < gained < 1.4 * 0.5 / (1.0 + BALL_MASS)
        assert walk.loop.record.last_seen.contacts == ()
    finally:
        walk.close()
