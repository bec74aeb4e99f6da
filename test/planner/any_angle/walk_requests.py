"""Walks to ask for in tests of quickest paths."""

import math

import numpy as np

from quad_common.robot_files.walking_time import WalkingTimeModel

RESOLUTION = 0.05
CRAWL = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2))


def random_requests(seed, count):
    """Draw small maps with two free cells, headings and paces."""
    rng = np.random.default_rng(seed)
    while count:
        height, width = rng.integers(4, 26, 2)
        free = rng.random((height, width)) >= rng.choice([0.0, 0.1, 0.2, 0.3, 0.4])
        cells = np.argwhere(free)[:, ::-1]
        if len(cells) < 2:
            continue
        start, goal = (tuple(map(int, cells[k])) for k in rng.choice(len(cells), 2, replace=False))
        pace = WalkingTimeModel(
            cycle_period=1.0,
            stride=float(rng.choice([0.2261, 0.07, 0.439, 0.1])),
            turn=math.radians(rng.choice([44.2, 30.0, 56.0, 91.0])),
            stopping=float(rng.choice([0.0, 0.0, 0.7])),
        )
        yield free, start, goal, *rng.uniform(-math.pi, math.pi, 2).tolist(), pace
        count -= 1
