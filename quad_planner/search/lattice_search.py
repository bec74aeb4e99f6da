"""
Quickest paths over cells and eight headings, in whole gait cycles (S0 sec. 3).

A state is a cell and the heading in which the robot stands or walks there. Straight on it
walks stretches, which cost whole cycles by the stride; at any cell it may end a stretch
and turn, which costs whole cycles by the turn. So a state's cost grows by the length of
each step and is rounded up to a whole cycle at each turn; of two paths to one state the
cheaper is the better one for all that may follow, and A* is exact.

Costs are whole numbers, for a straight step, for a diagonal one, and the stride's worth
for a cycle, so equal costs are equal. The bound on what is left (:func:`total_cost`) is the
length of the shortest path to the goal, and the least turns that a path over free ground takes.
States wait in one bucket for each whole cycle of cost and bound together, so the first bucket
in which the goal is reached holds the least time.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, inlined_part
from quad_planner.grid.bit_grid import BitGrid, BitMask, Bits, is_set
from quad_planner.grid.bucket_queue import (
    BucketQueue,
    bucket_queue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    push,
)
from quad_planner.search.cell_steps import DIAGONAL, DX, DY, STRAIGHT
from quad_planner.search.distance_field import distance_field
from quad_planner.search.lattice_costs import (
    HEADINGS,
    LARGEST,
    NOT_REACHED,
    Costs,
    costs_of,
    least_turns_of,
    total_cost,
)
from quad_planner.search.search_loop import DONE, FULL, PAUSED, run_search
from quad_planner.search.walk_terms import WalkTerms

Cells = NDArray[np.int64]
Numbers = NDArray[np.int64]


# How a state was reached: from heading k by a turn, or as follows.
_BY_A_STEP = np.uint8(8)
_AT_THE_START = np.uint8(9)
_PREVIOUS = np.uint8(15)
_EXPANDED = np.uint8(16)

_AT_A_TIME = 200_000
"""Number of expansions between two calls of `check`."""


@dataclass(frozen=True)
class LatticePath:
    """A quickest path."""

    cells: Cells
    """Cells where it begins, turns and ends: x and y, shape (n, 2)."""
    cycles: int
    """Gait cycles, of walking and turning."""
    expansions: int
    """Number of states that were looked at."""


class _Reached(NamedTuple):
    """What the search knows; state 8 c + k is heading k in cell c."""

    cost: NDArray[np.int32]
    """Plus one, and 0 where not reached: zeros cost nothing until they are touched."""
    by: NDArray[np.uint8]
    """State from which each was reached, and whether the search went on from there."""
    best: NDArray[np.int64]
    """The least cost at the goal and the heading in which it is reached; expansions."""


def quickest_path(
    grid: BitGrid,
    start: tuple[int, int],
    goal: tuple[int, int],
    terms: WalkTerms,
    check: Callable[[], None] = lambda: None,
) -> LatticePath | None:
    """
    Find a path that takes the fewest gait cycles.

    Parameters
    ----------
    grid : BitGrid
        The free cells.
    start, goal : tuple of int
        x and y of two different cells of the map.
    terms : WalkTerms
        Times by which its gait cycles are counted.
    check : callable
        Called now and then; raises to end the search.

    Returns
    -------
    LatticePath or None
        None if there is no path, or none within the bound, or an end is not free.
    """
    if not (grid.is_free(*start) and grid.is_free(*goal)):
        return None
    costs = costs_of(terms)
    found = _find(grid, start, goal, costs, check)
    if found is None:
        return None
    cells, cost, expansions = found
    return LatticePath(cells, cost // costs.cycle, expansions)


def fewest_turns(grid: BitGrid, known: Cells, check: Callable[[], None] = lambda: None) -> Cells:
    """
    Find, of all shortest paths over the cells, one with the fewest turning points.

    A turn costs so little that all turns together cost less than the difference of two
    lengths.

    Parameters
    ----------
    grid : BitGrid
        The free cells.
    known : ndarray of int, shape (n, 2), n >= 2
        Places where a shortest path begins, turns and ends: x and y.
    check : callable
        Called now and then; raises to end the search.

    Returns
    -------
    ndarray of int, shape (m, 2)
        The same of a path that is as short, m <= n; the known one if no path turns less.
    """
    start, goal = (tuple(map(int, known[at])) for at in (0, -1))
    steps = np.abs(np.diff(known, axis=0))
    diagonal = int(steps.min(axis=1).sum())
    straight = int(steps.max(axis=1).sum()) - diagonal
    length = straight * STRAIGHT + diagonal * DIAGONAL
    # The path itself turns n - 2 times.
    most = len(known) - 1
    if most < 2 or length * most > LARGEST:
        return known
    turns = np.ones((HEADINGS, HEADINGS), dtype=np.int64) - np.eye(HEADINGS, dtype=np.int64)
    none = np.zeros(HEADINGS, dtype=np.int64)
    costs = Costs(
        straight=STRAIGHT * most,
        diagonal=DIAGONAL * most,
        cycle=1,
        bucket=STRAIGHT * most // 4,
        longest=length * most + most - 1,
        scale=float(most),
        turns=turns,
        first_turns=none,
        last_turns=none,
        least_turns=least_turns_of(turns, none),
    )
    found = _find(grid, (start[0], start[1]), (goal[0], goal[1]), costs, check)
    return known if found is None else found[0]


def _find(
    grid: BitGrid,
    start: tuple[int, int],
    goal: tuple[int, int],
    costs: Costs,
    check: Callable[[], None],
) -> tuple[Cells, int, int] | None:
    """Search; return where the path begins, turns and ends, its cost, and expansions."""
    width = grid.width + 2
    cells = width * (grid.height + 2)
    first, last = ((y + 1) * width + x + 1 for x, y in (start, goal))
    left = _lengths_left(grid, start, goal, costs, check)
    if left[first] == 0:
        return None
    queue = bucket_queue(costs.longest // costs.bucket + 1)
    reached = _Reached(
        np.zeros(HEADINGS * cells, dtype=np.int32),
        np.zeros(HEADINGS * cells, dtype=np.uint8),
        np.array([NOT_REACHED, 0, 0]),
    )
    _begin(grid.rows, width, first, last, costs, left, reached, queue)

    def expand(queue: BucketQueue) -> int:
        return _search(grid.rows, width, last, costs, left, reached, queue, _AT_A_TIME)

    run_search(expand, queue, 0, check)
    best, heading, expansions = reached.best.tolist()
    if best == NOT_REACHED:
        return None
    return _turning_points(reached.by, width, last, heading), best, expansions


def _lengths_left(
    grid: BitGrid,
    start: tuple[int, int],
    goal: tuple[int, int],
    costs: Costs,
    check: Callable[[], None],
) -> Numbers:
    """
    Measure how far it is from each cell to the goal, where a path could be short enough.

    Returns, for each cell of the grid with its wall, the length plus one, or 0.
    """
    along, across = (abs(a - b) for a, b in zip(start, goal))
    least = max(along, across) + (math.sqrt(2.0) - 1.0) * min(along, across)
    # A detour to the side costs this least where it replaces straight steps by diagonal ones.
    spare = costs.longest / costs.straight - least
    margin = math.ceil(max(spare, 0.0) / (2.0 * (math.sqrt(2.0) - 1.0))) + 2
    sizes = (grid.width + 2, grid.height + 2)
    # In the grid with its wall, cells are one farther.
    low = [max(min(a, b) + 1 - margin, 0) for a, b in zip(start, goal)]
    high = [min(max(a, b) + 2 + margin, size) for a, b, size in zip(start, goal, sizes)]
    free = BitMask(grid.rows, sizes[0]).window(low[0], low[1], high[0], high[1])
    lengths = distance_field(free, (goal[0] + 1 - low[0], goal[1] + 1 - low[1]), check)
    left = np.zeros(sizes[::-1], dtype=np.int64)
    # What is not reached has a length of -1.
    np.add(lengths, 1, out=left[low[1] : high[1], low[0] : high[0]])
    return left.reshape(-1)


@inlined_part
def _may_step(rows: Bits, x: int, y: int, heading: int) -> bool:
    """Return whether a step from a free cell is free; a diagonal needs both beside it."""
    dx, dy = int(DX[heading]), int(DY[heading])
    if not is_set(rows, y + dy, x + dx):
        return False
    if heading & 1:
        return is_set(rows, y, x + dx) and is_set(rows, y + dy, x)
    return True


@inlined_part
def _wait(queue: BucketQueue, bucket: int, state: int) -> None:
    push(queue.heads, queue.entries, queue.state, state, 0, bucket)


def _begin(
    rows: Bits,
    width: int,
    start: int,
    goal: int,
    costs: Costs,
    left: Numbers,
    reached: _Reached,
    queue: BucketQueue,
) -> None:
    """Let the start's eight headings wait."""
    x, y = start % width, start // width
    dx, dy = goal % width - x, goal // width - y
    cycle = costs.cycle
    for k in range(HEADINGS):
        cost = int(costs.first_turns[k])
        total = total_cost(cost, int(left[start]), dx, dy, k, costs)
        if total > costs.longest - cycle or not _may_step(rows, x, y, k):
            continue
        state = HEADINGS * start + k
        reached.cost[state] = cost + 1
        reached.by[state] = _AT_THE_START
        _wait(queue, (total + costs.bucket - 1) // costs.bucket, state)


@compiled
def _search(
    rows: Bits,
    width: int,
    goal: int,
    costs: Costs,
    left: Numbers,
    reached: _Reached,
    queue: BucketQueue,
    at_a_time: int,
) -> int:
    """
    Go on with a search, for so many expansions at a time.

    Returns ``DONE``, ``PAUSED``, or ``FULL`` if the queue must grow.
    """
    cycle, best = costs.cycle, reached.best
    goal_x, goal_y = goal % width, goal // width
    for _ in range(at_a_time):
        if is_empty(queue.state):
            return DONE
        bucket = next_bucket(queue.heads, queue.state)
        # The first whole cycle above all that waited in the buckets before.
        if best[0] <= ((bucket - 1) * costs.bucket // cycle + 1) * cycle:
            return DONE
        # A state lets those wait that it turns to, and the one ahead.
        if not has_room(queue.entries, queue.state, HEADINGS):
            return FULL
        state, _ = pop(queue.heads, queue.entries, queue.state)
        by = reached.by[state]
        if by & _EXPANDED:
            continue
        reached.by[state] = by | _EXPANDED
        best[2] += 1
        cell, k = state // HEADINGS, state % HEADINGS
        x, y = cell % width, cell // width
        cost = int(reached.cost[state]) - 1
        rest = (cost + cycle - 1) // cycle * cycle
        if cell == goal:
            total = rest + costs.last_turns[k]
            if total < min(best[0], costs.longest):
                best[0], best[1] = total, k
            continue
        if by & _PREVIOUS == _BY_A_STEP:
            left_here = int(left[cell])
            for j in range(HEADINGS):
                if j != k:
                    turned = rest + int(costs.turns[k, j])
                    total = total_cost(turned, left_here, goal_x - x, goal_y - y, j, costs)
                    other = HEADINGS * cell + j
                    if _is_new(other, turned, total, costs, reached) and _may_step(rows, x, y, j):
                        _reach(other, turned, np.uint8(k), total, bucket, costs, reached, queue)
        if _may_step(rows, x, y, k):
            x, y = x + int(DX[k]), y + int(DY[k])
            cost += costs.diagonal if k & 1 else costs.straight
            left_there = int(left[y * width + x])
            total = total_cost(cost, left_there, goal_x - x, goal_y - y, k, costs)
            state = HEADINGS * (y * width + x) + k
            if _is_new(state, cost, total, costs, reached):
                _reach(state, cost, _BY_A_STEP, total, bucket, costs, reached, queue)
    return PAUSED


@inlined_part
def _is_new(state: int, cost: int, total: int, costs: Costs, reached: _Reached) -> bool:
    """Return whether a state was not reached as cheaply, and may be on a path in the bound."""
    known = int(reached.cost[state])
    return total <= costs.longest - costs.cycle and (known == 0 or cost + 1 < known)


@inlined_part
def _reach(
    state: int,
    cost: int,
    by: np.uint8,
    total: int,
    bucket: int,
    costs: Costs,
    reached: _Reached,
    queue: BucketQueue,
) -> None:
    """Note how a state was reached, and let it wait."""
    reached.cost[state] = cost + 1
    reached.by[state] = by
    # The bound on what is left may fall by more than a step costs: never back.
    _wait(queue, max(bucket, (total + costs.bucket - 1) // costs.bucket), state)


def _turning_points(reached_by: NDArray[np.uint8], width: int, goal: int, heading: int) -> Cells:
    """Go back from the goal to the start; list where the path begins, turns and ends."""
    offsets = (DY * width + DX).tolist()
    step, start, previous = int(_BY_A_STEP), int(_AT_THE_START), int(_PREVIOUS)
    # Python's own numbers: quick to read one by one, and nothing to compile.
    moves = reached_by.data
    places = [goal]
    cell, by = goal, step
    while by != start:
        by = moves[HEADINGS * cell + heading] & previous
        if by == step:
            cell -= offsets[heading]
        else:
            places.append(cell)
            heading = by
    return np.array([[place % width - 1, place // width - 1] for place in reversed(places)])
