"""Rectangles cover what is free, once, and know what they touch; dead ends are left out."""

import numpy as np
import pytest
from random_floors import random_floor

from quad_planner.any_angle.blocks import between, blocks_of
from quad_planner.any_angle.rectangles import corners_of, rectangles_of
from quad_planner.grid.bit_grid import BitMask


def touching(bounds, one, other):
    """Return whether the upper side of one rectangle and the lower one of another meet."""
    overlap = min(bounds[one, 2], bounds[other, 2]) - max(bounds[one, 0], bounds[other, 0])
    return bounds[one, 3] == bounds[other, 1] and overlap >= 0


@pytest.mark.parametrize('seed', range(8))
def test_every_free_cell_is_in_one_rectangle_and_neighbours_touch(seed):
    rng = np.random.default_rng(seed)
    for _ in range(15):
        free = random_floor(rng, 80)
        rectangles = rectangles_of(BitMask.of(~free))
        bounds, count = rectangles.bounds, len(rectangles.bounds)
        covered = np.zeros(free.shape, dtype=int)
        for left, bottom, right, top in bounds:
            covered[bottom:top, left:right] += 1
        assert (covered == free).all()
        for here in rng.permutation(count)[:10]:
            above = [k for k in range(count) if touching(bounds, here, k)]
            assert above == list(range(*rectangles.above[here]))
            below = [k for k in range(count) if touching(bounds, k, here)]
            places = slice(*rectangles.below[here])
            assert below == sorted(rectangles.by_top[places].tolist())


def convex_corners(free):
    """List corners inside the map with one forbidden cell of four, or two across."""
    corners = []
    for y in range(1, len(free)):
        for x in range(1, free.shape[1]):
            block = free[y - 1 : y + 1, x - 1 : x + 1]
            across = block[0, 0] == block[1, 1] and block[0, 1] == block[1, 0]
            if block.sum() == 3 or (block.sum() == 2 and across):
                corners.append((x, y))
    return corners


@pytest.mark.parametrize('seed', range(8))
def test_openings_end_at_the_convex_corners(seed):
    free = random_floor(np.random.default_rng(seed), 80)
    corners = corners_of(rectangles_of(BitMask.of(~free)))
    assert sorted(set(map(tuple, corners.tolist()))) == sorted(convex_corners(free))


def test_rows_that_are_alike_are_one_rectangle():
    free = np.ones((300, 200), dtype=bool)
    free[100:200, 70:130] = False
    bounds = rectangles_of(BitMask.of(~free)).bounds.tolist()
    assert bounds == [[0, 0, 200, 100], [0, 100, 70, 200], [130, 100, 200, 200], [0, 200, 200, 300]]
    assert rectangles_of(BitMask.of(np.ones((5, 70), dtype=bool))).bounds.shape == (0, 4)


def reached(joined, start, without):
    """Return all that is reached from a place, without another."""
    found, waiting = {start}, [start]
    while waiting:
        for there in joined[waiting.pop()] - found - {without}:
            found.add(there)
            waiting.append(there)
    return found


@pytest.mark.parametrize('seed', range(8))
def test_left_out_is_what_no_path_passes_without_coming_back(seed):
    rng = np.random.default_rng(seed)
    for _ in range(4):
        rectangles = rectangles_of(BitMask.of(~random_floor(rng, 16)))
        count = len(rectangles.bounds)
        if count < 2:
            continue
        blocks = blocks_of(rectangles)
        joined = [set() for _ in range(count)]
        for here in range(count):
            for there in range(*rectangles.above[here]):
                joined[here].add(there)
                joined[there].add(here)
        for start, goal in rng.integers(0, count, (4, 2)).tolist():
            is_open = between(blocks, start, goal)
            if goal not in reached(joined, start, -1):
                assert is_open is None
                continue
            # Menger: two paths that share nothing, unless one place parts it from both.
            expected = [
                start != goal
                and start in reached(joined, here, -1)
                and all(
                    reached(joined, here, cut) & {start, goal}
                    for cut in range(count)
                    if cut != here
                )
                for here in range(count)
            ]
            assert is_open.tolist() == expected
