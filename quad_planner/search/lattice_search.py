"""
The fewest turns of all shortest paths over cells, by A* over cells and eight headings.

A state is a cell and the heading in which it is entered; a turn costs so little that all turns
together cost less than the difference of two lengths. Costs are whole numbers, so equal costs
are equal. The bound on what is left (:func:`total_cost`) is the length of the shortest path to
the goal, and the least turns that a path over free ground takes. States wait in buckets of cost
and bound together; the search ends with the first bucket that can hold none cheaper than what
is found.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, inlined_part
from quad_planner.grid.bit_grid import BitGrid
from quad_planner.grid.bucket_queue import (
    BucketQueue,
    bucket_queue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    push,
    with_room,
)
from quad_planner.search.cell_steps import DIAGONAL, DX, DY, STRAIGHT
from quad_planner.search.distance_field import NOT_REACHED as NO_LENGTH
from quad_planner.search.distance_field import may_step, word_length
from quad_planner.search.lattice_costs import (
    HEADINGS,
    LARGEST,
    NOT_REACHED,
    Costs,
    excess_of,
    least_turns_of,
    total_cost,
)
from quad_planner.search.lattice_states import (
    FIRST_STATE,
    LatticeGround,
    LatticeStates,
    give_back,
    ground_between,
    has_tiles,
    lattice_states,
    make_tile,
    place_of,
    state_of,
    with_tiles,
)
from quad_planner.search.search_loop import DONE, FULL, PAUSED, run_search

Cells = NDArray[np.int64]
Numbers = NDArray[np.int64]


# How a state was reached: by a step after a turn from heading k, or as follows.
_BY_A_STEP = np.uint8(8)
_AT_THE_START = np.uint8(9)
_PREVIOUS = np.uint8(15)
_EXPANDED = np.uint8(16)

_AT_A_TIME = 50_000
"""Number of states that waited between two calls of `check`."""


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
        pause=0,
        bucket=STRAIGHT * most // 4,
        longest=length * most + most - 1,
        scale=float(most),
        turns=turns,
        first_turns=none,
        last_turns=none,
        least_turns=least_turns_of(turns, none),
        excess=excess_of(turns),
    )
    found = _find(grid, (start[0], start[1]), (goal[0], goal[1]), costs, check)
    return known if found is None else found


def _find(
    grid: BitGrid,
    start: tuple[int, int],
    goal: tuple[int, int],
    costs: Costs,
    check: Callable[[], None],
) -> Cells | None:
    """Search; return where the path begins, turns and ends."""
    ground = ground_between(grid, start, goal, costs, check)
    ends = ground.number(start), ground.number(goal)
    if word_length(int(ground.words[ends[0]])) == NO_LENGTH:
        return None
    queue = with_room(bucket_queue(costs.longest // costs.bucket + 1), HEADINGS)
    states = lattice_states(ground.width, len(ground.words) // ground.width)
    # The least cost at the goal, and the state in which it is reached.
    best = np.array([NOT_REACHED, 0])
    _begin(ground, ends, costs, states, queue)

    def expand(queue: BucketQueue) -> int:
        nonlocal states
        states = with_tiles(states, HEADINGS + 1)
        return _search(ground.words, ground.width, ends[1], costs, states, best, queue, _AT_A_TIME)

    try:
        run_search(expand, queue, 0, check)
        cost, state = best.tolist()
        return None if cost == NOT_REACHED else _turning_points(states, ground, state)
    finally:
        give_back(states)


def _begin(
    ground: LatticeGround,
    ends: tuple[int, int],
    costs: Costs,
    states: LatticeStates,
    queue: BucketQueue,
) -> None:
    """Let the first steps to the start's eight neighbours wait; ends as numbers of cells."""
    words, width = ground.words, ground.width
    (y, x), (goal_y, goal_x) = (divmod(end, width) for end in ends)
    word = int(words[ends[0]])
    for k in range(HEADINGS):
        if not may_step(word, k):
            continue
        to_x, to_y = x + int(DX[k]), y + int(DY[k])
        cell = to_y * width + to_x
        cost = costs.diagonal if k & 1 else costs.straight
        left = word_length(int(words[cell]))
        offset = (goal_x - to_x, goal_y - to_y)
        total = total_cost(cost, left, *offset, k, costs.scale, costs.least_turns)
        if total < costs.longest:
            if state_of(states.numbers, to_x, to_y, k) < FIRST_STATE:
                make_tile(*states.tiles, states.numbers, states.used, to_x, to_y)
            state = state_of(states.numbers, to_x, to_y, k)
            states.tiles.cost[state] = cost + 1
            states.tiles.by[state] = _AT_THE_START
            bucket = _bucket(total, costs.bucket)
            push(queue.heads, queue.entries, queue.state, state, 0, bucket)


@compiled_loop
def _search(
    words: Numbers,
    width: int,
    goal: int,
    costs: Costs,
    states: LatticeStates,
    best: Numbers,
    queue: BucketQueue,
    at_a_time: int,
) -> int:
    """
    Go on with a search, for so many states that waited at a time.

    Each is followed straight on while the bound does not rise above its bucket. Returns ``DONE``,
    ``PAUSED``, or ``FULL`` if the queue or the states must grow.
    """
    # Arrays one by one, for compiled code counts references to those of a tuple at each look.
    heads, entries, waiting = queue.heads, queue.entries, queue.state
    turns, excess = costs.turns, costs.excess
    least_turns, scale = costs.least_turns, costs.scale
    width_of_bucket = costs.bucket
    straight, diagonal, longest = costs.straight, costs.diagonal, costs.longest
    reached_cost, reached_by, rests = states.tiles.cost, states.tiles.by, states.tiles.rests
    corners, numbers, used = states.tiles.corners, states.numbers, states.used
    goal_x, goal_y = goal % width, goal // width
    for _ in range(at_a_time):
        if is_empty(waiting):
            return DONE
        bucket = next_bucket(heads, waiting)
        if best[0] <= (bucket - 1) * width_of_bucket + 1:
            return DONE
        state, _ = pop(heads, entries, waiting)
        goes_on = True
        x, y = place_of(corners, state)
        while goes_on:
            goes_on = False
            by = reached_by[state]
            if by & _EXPANDED:
                break
            # A state lets those wait to which it turns, and the one ahead.
            if not (has_room(entries, waiting, HEADINGS) and has_tiles(used, corners, HEADINGS)):
                # There is room for it itself: it has just been taken, or followed one that was.
                push(heads, entries, waiting, state, 0, bucket)
                return FULL
            reached_by[state] = by | _EXPANDED
            cell, k = y * width + x, state & 7
            cost = int(reached_cost[state]) - 1
            if cell == goal:
                if cost < min(best[0], longest):
                    best[0], best[1] = cost, state
                break
            word = words[cell]
            # Another heading there from which all turns cost no more?
            other = int(rests[state >> 3])
            if other == 0 or (other >> 3) + excess[other & 7, k] > cost:
                if other == 0 or cost < other >> 3:
                    rests[state >> 3] = cost << 3 | k
                for j in range(HEADINGS):
                    if j == k or not may_step(word, j):
                        continue
                    to_x, to_y = x + int(DX[j]), y + int(DY[j])
                    onward = cost + int(turns[k, j])
                    onward += diagonal if j & 1 else straight
                    turned = state_of(numbers, to_x, to_y, j)
                    if not _is_less(turned, onward, reached_cost):
                        continue
                    left = word_length(words[to_y * width + to_x])
                    dx, dy = goal_x - to_x, goal_y - to_y
                    total = total_cost(onward, left, dx, dy, j, scale, least_turns)
                    if total < longest:
                        if turned < FIRST_STATE:
                            make_tile(
                                reached_cost, reached_by, rests, corners, numbers, used, to_x, to_y
                            )
                            turned = state_of(numbers, to_x, to_y, j)
                        reached_cost[turned] = onward + 1
                        reached_by[turned] = np.uint8(k)
                        further = bucket
                        # The bound on what is left may fall by more than a step costs: never back.
                        if total > bucket * width_of_bucket:
                            further = _bucket(total, width_of_bucket)
                        push(heads, entries, waiting, turned, 0, further)
            if not may_step(word, k):
                break
            x, y = x + int(DX[k]), y + int(DY[k])
            onward = cost + (diagonal if k & 1 else straight)
            state = state_of(numbers, x, y, k)
            if not _is_less(state, onward, reached_cost):
                break
            left = word_length(words[y * width + x])
            total = total_cost(onward, left, goal_x - x, goal_y - y, k, scale, least_turns)
            if total >= longest:
                break
            if state < FIRST_STATE:
                make_tile(reached_cost, reached_by, rests, corners, numbers, used, x, y)
                state = state_of(numbers, x, y, k)
            reached_cost[state] = onward + 1
            reached_by[state] = _BY_A_STEP
            goes_on = total <= bucket * width_of_bucket
            if not goes_on:
                push(heads, entries, waiting, state, 0, _bucket(total, width_of_bucket))
    return PAUSED


@inlined_part
def _is_less(state: int, cost: int, reached_cost: NDArray[np.int32]) -> bool:
    """Return whether a state was not reached as cheaply."""
    if state < FIRST_STATE:
        return True
    known = int(reached_cost[state])
    return known == 0 or cost + 1 < known


@inlined_part
def _bucket(total: int, width: int) -> int:
    """Return the bucket of a cost and the least that is left."""
    return (total + width - 1) // width


def _turning_points(states: LatticeStates, ground: LatticeGround, state: int) -> Cells:
    """Go back from a state at the goal to the start; list where the path begins, turns and ends."""
    step, start, previous = int(_BY_A_STEP), int(_AT_THE_START), int(_PREVIOUS)
    # Python's own numbers: quick to read one by one, and nothing to compile.
    moves, numbers = states.tiles.by.data, states.numbers.data
    steps = list(zip(DX.tolist(), DY.tolist()))
    x, y = place_of(states.tiles.corners, state)
    heading, by = state & 7, step
    places = [(x, y)]
    while by != start:
        tile = numbers[y >> 3, x >> 3]
        by = moves[tile << 9 | (y & 7) << 6 | (x & 7) << 3 | heading] & previous
        x, y = x - steps[heading][0], y - steps[heading][1]
        if by != step:
            places.append((x, y))
            heading = by
    cells: Cells = np.array(places[::-1]) + np.array((ground.left, ground.bottom))
    return cells
