"""Floors to draw for tests of searches at any angle."""

import numpy as np


def random_floor(rng, largest=24):
    """Draw boxes on a floor, or cells at random, which often touch in a corner only."""
    shape = tuple(rng.integers(2, largest, 2))
    if rng.random() < 0.4:
        return rng.random(shape) >= rng.choice([0.05, 0.15, 0.3, 0.5])
    free = np.ones(shape, dtype=bool)
    for _ in range(rng.integers(1, 9)):
        x, y = rng.integers(0, shape[1]), rng.integers(0, shape[0])
        free[y : y + rng.integers(1, 8), x : x + rng.integers(1, 8)] = False
    return free


def random_place(rng, free):
    """Draw a point in a free cell, now and then on its edge or in its corner."""
    cells = np.argwhere(free)[:, ::-1]
    within = rng.random(2) if rng.random() < 0.6 else rng.choice([0.0, 0.5, 1.0], 2)
    return cells[rng.integers(len(cells))] + within
