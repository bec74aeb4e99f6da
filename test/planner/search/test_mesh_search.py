"""Shortest paths over a mesh are those of Dijkstra's algorithm on the whole graph."""

import heapq
from itertools import count

import numpy as np
import pytest

from quad_planner.grid.bit_grid import BitMask
from quad_planner.methods.mesh_moves import MOVES, mesh_moves
from quad_planner.search.mesh_search import CIRCLE, Ends, Legs, Mesh, mesh_path

STRAIGHT, DIAGONAL = 500_000, 707_107


def whole_search(mesh, ends):
    """Search crossings and bearings by length, then turns; of equal costs the first to wait."""
    columns = mesh.exits.shape[1]
    order = count()
    first = ((-1, ends.bearings[0]), (0, 0))
    least, before, visited = {first[0]: first[1]}, {}, set()
    waiting = [(first[1], next(order), first[0])]

    def turned(bearing, arrived):
        return (arrived, 0) if bearing < 0 else (bearing, int(bearing != arrived))

    def neighbours(state):
        here, arrived = state
        if here == -1:
            for there, length, bearing in zip(*ends.starts):
                bearing, turns = turned(bearing, arrived)
                yield (int(there), int(bearing)), (int(length), turns)
            if ends.direct >= 0:
                bearing, turns = turned(ends.direct_bearing, arrived)
                yield (-2, 0), (ends.direct, turns + (bearing != ends.bearings[1]))
            return
        for k, (dc, dr) in enumerate(MOVES):
            if mesh.exits.flat[here] >> k & 1:
                bearing = k * CIRCLE // 8
                length = mesh.diagonal if k & 1 else mesh.straight
                yield (here + dr * columns + dc, bearing), (length, int(bearing != arrived))
        for there, length, bearing in zip(*ends.goals):
            if there == here:
                bearing, turns = turned(bearing, arrived)
                yield (-2, 0), (int(length), turns + (bearing != ends.bearings[1]))

    while waiting:
        cost, _, state = heapq.heappop(waiting)
        if state in visited:
            continue
        visited.add(state)
        if state[0] == -2:
            path = []
            while state in before:
                state = before[state]
                path.append(state[0])
            return path[-2::-1]
        for other, (length, turns) in neighbours(state):
            onward = cost[0] + length, cost[1] + turns
            if other not in least or onward < least[other]:
                least[other], before[other] = onward, state
                heapq.heappush(waiting, (onward, next(order), other))
    return None


def random_legs(rng, crossings):
    """Join some crossings, now and then at no length, and along the mesh or not."""
    picked = np.sort(rng.choice(crossings, min(len(crossings), 4), replace=False))
    lengths = rng.integers(0, 3, len(picked)) * STRAIGHT // 2
    bearings = rng.choice([0, 800, 1600, 4000, 123, 5600], len(picked))
    return Legs(picked, lengths, np.where(lengths == 0, -1, bearings))


@pytest.mark.parametrize('seed', range(10))
def test_the_path_is_that_of_a_search_of_the_whole_mesh(seed):
    rng = np.random.default_rng(seed)
    for _ in range(12):
        free = rng.random(tuple(rng.integers(4, 40, 2))) >= rng.choice([0.0, 0.03, 0.1])
        spacing = float(rng.choice([1.0, 2.5, 3.3]))
        columns, rows = (int(n / spacing) + 1 for n in free.shape[::-1])
        candidates, exits = mesh_moves(BitMask.of(~free), spacing, (0, rows), columns)
        crossings = np.flatnonzero(candidates)
        if len(crossings) < 2:
            continue
        mesh = Mesh(exits, STRAIGHT, DIAGONAL)
        direct = int(rng.choice([-1, -1, 2 * STRAIGHT, 0]))
        ends = Ends(
            random_legs(rng, crossings),
            random_legs(rng, crossings),
            direct,
            1600 if direct > 0 else -1,
            tuple(rng.choice([0, 800, 77, 1600], 2).tolist()),
        )
        assert mesh_path(mesh, ends) == whole_search(mesh, ends)


def test_without_a_segment_to_the_mesh_there_is_no_path():
    mesh = Mesh(np.zeros((3, 3), dtype=np.uint8), STRAIGHT, DIAGONAL)
    none = Legs(*np.empty((3, 0), dtype=np.int64))
    one = Legs(np.array([4]), np.array([STRAIGHT]), np.array([0]))
    assert mesh_path(mesh, Ends(none, one, -1, -1, (0, 0))) is None
    assert mesh_path(mesh, Ends(one, none, 7, 0, (0, 0))) == []
    assert mesh_path(mesh, Ends(one, one, -1, -1, (0, 0))) == [4]
