"""
How a body has moved over feet that stood meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class FootStep(NamedTuple):
    """A foot that stood at both of two instants, in the level frame of each [m]."""

    x0: float
    """Place along x beside the body at the first [m]."""
    y0: float
    """The same along y [m]."""
    x1: float
    """Place along x beside the body at the second [m]."""
    y1: float
    """The same along y [m]."""
    rolled_x: float
    """Displacement of its center by rolling, along x in the axes halfway [m]."""
    rolled_y: float
    """The same along y [m]."""


def displacement(steps: Sequence[FootStep], turn: float) -> tuple[float, float]:
    """
    Find the displacement of the body that best explains standing feet.

    Parameters
    ----------
    steps : sequence of FootStep
        The feet, at least one.
    turn : float
        Turn of the body meanwhile [rad].

    Returns
    -------
    tuple of float
        Displacement x and y, in the axes halfway [m].
    """
    c, s = math.cos(turn / 2.0), math.sin(turn / 2.0)
    x = y = 0.0
    for step in steps:
        x += c * (step.x0 - step.x1) + s * (step.y0 + step.y1) + step.rolled_x
        y += c * (step.y0 - step.y1) - s * (step.x0 + step.x1) + step.rolled_y
    return x / len(steps), y / len(steps)


def turn_of_feet(steps: Sequence[FootStep]) -> float:
    """
    Find the turn of the body that best explains standing feet.

    Parameters
    ----------
    steps : sequence of FootStep
        The feet, two or more.

    Returns
    -------
    float
        Turn, counter-clockwise [rad].
    """
    before = np.array([(step.x0 + step.rolled_x, step.y0 + step.rolled_y) for step in steps])
    now = np.array([(step.x1, step.y1) for step in steps])
    a, b = before - before.mean(axis=0), now - now.mean(axis=0)
    cross = float(np.sum(b[:, 0] * a[:, 1] - b[:, 1] * a[:, 0]))
    return math.atan2(cross, float(np.sum(a * b)))
