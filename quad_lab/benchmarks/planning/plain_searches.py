"""
Searches that look at everything, and share nothing with those that they are compared with.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator
from itertools import count

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import wrap_angle
from quad_common.robot_files.walking_time import LENGTH_SLACK
from quad_lab.benchmarks.planning.small_requests import RESOLUTION, WalkRequest
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.line_of_sight import sees
from quad_planner.methods.mesh_moves import MOVES
from quad_planner.search.mesh_search import CIRCLE, Ends, Mesh

_STEPS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def least_cycles_over_cells(
    request: WalkRequest, factors: NDArray[np.float64] | None = None
) -> int | None:
    """
    Search over whole stretches: each from a turn to wherever it may end; None without a path.

    Walking through a cell takes longer by its factor, shape (height, width).
    """
    free, start, goal, start_yaw, goal_yaw, pace = request
    height, width = free.shape
    waiting = [
        (pace.turn_cycles(math.radians(45 * k) - start_yaw), *start, k, False) for k in range(8)
    ]
    heapq.heapify(waiting)
    done: set[tuple[int, int, int, bool]] = set()
    best: int | None = None
    while waiting:
        cycles, x, y, k, has_walked = heapq.heappop(waiting)
        if best is not None and cycles >= best:
            break
        if (x, y, k, has_walked) in done:
            continue
        done.add((x, y, k, has_walked))
        if (x, y) == goal and has_walked:
            total = cycles + pace.last_turn_cycles(goal_yaw - math.radians(45 * k))
            best = total if best is None else min(best, total)
        if has_walked:
            for j in range(8):
                turn = pace.turn_cycles(math.radians(45 * (j - k)))
                if j != k:
                    heapq.heappush(waiting, (cycles + turn, x, y, j, False))
            continue
        dx, dy = _STEPS[k]
        length = 0.0
        while True:
            to_x, to_y = x + dx, y + dy
            if not (0 <= to_x < width and 0 <= to_y < height and free[to_y, to_x]):
                break
            if dx and dy and not (free[y, to_x] and free[to_y, x]):
                break
            factor = 1.0 if factors is None else (factors[y, x] + factors[to_y, to_x]) / 2.0
            x, y = to_x, to_y
            length += factor * math.hypot(dx, dy) * RESOLUTION
            heapq.heappush(waiting, (cycles + pace.straight_cycles(length), x, y, k, True))
    return best


def least_cycles_over_points(
    forbidden: BitMask, points: NDArray[np.float64], request: WalkRequest
) -> float:
    """
    Search over all pairs of points that see each other, without a bound.

    The first two are start and goal [cells]; infinite without a path.
    """
    start_yaw, goal_yaw, pace = request.start_yaw, request.goal_yaw, request.pace
    number = len(points)
    views = [
        [
            j
            for j in range(number)
            if (points[i] != points[j]).any()
            and sees(forbidden.words, forbidden.width, *points[i], *points[j])
        ]
        for i in range(number)
    ]

    def angle(i: int, j: int) -> float:
        return math.atan2(*(points[j] - points[i])[::-1])

    def length(i: int, j: int) -> float:
        return float(np.hypot(*(points[j] - points[i]))) * RESOLUTION

    def entry(base: float, stretch: float, i: int, j: int) -> tuple[float, float, float, int, int]:
        # Of two stretches to one place, the one that is farther on is never worse.
        strides = stretch / (pace.stride * (1.0 + LENGTH_SLACK))
        return base + pace.stopping + strides, base, stretch, i, j

    waiting = [
        entry(pace.turn_cycles(angle(0, j) - start_yaw), length(0, j), 0, j) for j in views[0]
    ]
    heapq.heapify(waiting)
    done: set[tuple[int, int]] = set()
    best = math.inf
    while waiting:
        cost, base, stretch, i, j = heapq.heappop(waiting)
        if cost > best:
            break
        if (i, j) in done:
            continue
        done.add((i, j))
        rest = base + pace.straight_cycles(stretch)
        if j == 1:
            best = min(best, rest + pace.last_turn_cycles(goal_yaw - angle(i, j)))
            continue
        for k in views[j]:
            turn = abs(wrap_angle(angle(j, k) - angle(i, j)))
            if turn <= pace.bend:
                heapq.heappush(waiting, entry(base, stretch + length(j, k), j, k))
            else:
                turned = rest + pace.turn_cycles(turn)
                heapq.heappush(waiting, entry(turned, length(j, k), j, k))
    return best


def least_length_over_points(forbidden: BitMask, points: NDArray[np.float64]) -> float:
    """
    Measure the shortest path over all pairs of points that see each other.

    The first two are start and goal [cells]; infinite without a path.
    """
    waiting = [(0.0, 0)]
    least = np.full(len(points), math.inf)
    least[0] = 0.0
    done = np.zeros(len(points), dtype=np.bool_)
    while waiting:
        length, here = heapq.heappop(waiting)
        if here == 1:
            return length
        if done[here]:
            continue
        done[here] = True
        onward = length + np.hypot(*(points - points[here]).T)
        # Only those to which it would be shorter are looked at.
        for there in np.flatnonzero(onward < least).tolist():
            if sees(forbidden.words, forbidden.width, *points[here], *points[there]):
                least[there] = onward[there]
                heapq.heappush(waiting, (float(onward[there]), there))
    return math.inf


def path_over_whole_mesh(mesh: Mesh, ends: Ends) -> list[int] | None:
    """Search crossings and bearings by length, then turns; of equal costs the first to wait."""
    columns = mesh.exits.shape[1]
    order = count()
    first = ((-1, ends.bearings[0]), (0, 0))
    least = {first[0]: first[1]}
    before: dict[tuple[int, int], tuple[int, int]] = {}
    visited: set[tuple[int, int]] = set()
    waiting = [(first[1], next(order), first[0])]

    def turned(bearing: int, arrived: int) -> tuple[int, int]:
        return (arrived, 0) if bearing < 0 else (bearing, int(bearing != arrived))

    def neighbours(state: tuple[int, int]) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
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
