"""
How hard robots that keep their balance are pushed.
"""

from __future__ import annotations

import numpy as np

from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import AUTO, resolved

LEVELS = {
    ('a1', 0.447): 0.9,
    ('a1', 0.3): 1.2,
    ('mini_cheetah', None): 0.8,
    ('genibo', None): 0.8,
    ('cuhk', None): 0.8,
    ('titan_viii', None): 1.1,
}
"""Impulse over m sqrt(g h) that nine of ten pushes are to survive, by robot and period [s]."""

_IN_MUJOCO = 0.8
"""Fraction of it in MuJoCo."""

HARDEST = 0.7
"""Fraction of it with everything that makes it harder together."""


def push_level(robot: str, period: float | None) -> float:
    """Return the impulse over m sqrt(g h) that is to be survived in the engine that runs."""
    return LEVELS[robot, period] * (_IN_MUJOCO if resolved(AUTO) == 'mujoco' else 1.0)


def own_push_level(robot: str) -> float:
    """Return that of a robot with its own period: between those of other ones, in proportion."""
    known = {period: push_level(name, period) for name, period in LEVELS if name == robot}
    if None in known:
        return known[None]
    by_period = sorted((period, level) for period, level in known.items() if period is not None)
    own = load_robot(robot).gaits['trot'].cycle_period or by_period[0][0]
    periods, levels = np.array(by_period).T
    return float(np.interp(own, periods, levels))
