"""
Quickest paths at any angle, from corner to corner, in whole gait cycles (S0 sec. 3).

A state is a point and the direction in which the robot comes to it; the points are the
start, the goal, the convex corners of the forbidden zone, and any others that are given.
Costs are those of a `WalkingTimeModel`: a stretch ends where the robot has to
turn on the spot, and goes on through a bend. A* over the states is exact for these
points: the bound on what is left is the length of the shortest path, without turns.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, inlined_part
from quad_common.robot_files.walking_time import LENGTH_SLACK
from quad_planner.any_angle.free_space import FreeSpace
from quad_planner.any_angle.interval_search import lengths_from
from quad_planner.any_angle.rectangles import corner_places
from quad_planner.any_angle.sight import Sight
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.bit_grid import BitMask
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
from quad_planner.grid.line_of_sight import sees
from quad_planner.search.search_loop import DONE, FULL, PAUSED, run_search
from quad_planner.search.walk_terms import WalkTerms

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

_AT_A_TIME = 50_000
"""Number of expansions between two calls of `check`."""

_TINY = 1e-9
"""Fraction of a cycle that is rounding."""


class _Edges(NamedTuple):
    """Points that see one another: point v has the edges from firsts[v] to firsts[v + 1]."""

    firsts: Indices
    """Number of the first edge of each point."""
    ends: Indices
    """Point to which each edge leads."""
    starts: Indices
    """Point from which each edge comes."""
    strides: Floats
    """Length of each edge, in strides."""
    angles: Floats
    """Direction of each edge [rad]."""
    left: Floats
    """Length of the shortest path from each point to the goal, in strides."""


class _Cycles(NamedTuple):
    """The numbers of a pace."""

    turn: float
    """Turn of one cycle [rad]."""
    stopping: float
    """Cycles that a stop costs."""
    bend: float
    """Turn that costs no stop [rad]."""
    goal_yaw: float
    """Heading at the goal [rad]."""
    heading_tolerance: float
    """Angle within which the robot has that heading [rad]."""


def quickest_corners(
    space: FreeSpace,
    forbidden: BitMask,
    points: Points,
    terms: WalkTerms,
    check: Callable[[], None] = lambda: None,
) -> Points | None:
    """
    Find a path over corners, and points that are given, that takes the fewest gait cycles.

    Parameters
    ----------
    space : FreeSpace
        The free cells.
    forbidden : BitMask
        The other cells; their edges are allowed.
    points : ndarray, shape (n, 2)
        The start, the goal, and points besides the corners where the path may turn [cells].
    terms : WalkTerms
        Times by which its gait cycles are counted.
    check : callable
        Called now and then; raises to end the search.

    Returns
    -------
    ndarray, shape (m, 2) or None
        The start, the points where it turns, and the goal; None if there is none
        within the bound.
    """
    pace, bound = terms.pace, terms.bound
    stride = pace.stride * (1.0 + LENGTH_SLACK) / terms.resolution
    # In `bound - 1` cycles the robot gets no farther than this, even without a turn.
    longest = (bound - 1 - pace.stopping) * stride + _TINY
    if not float(np.hypot(*(points[1] - points[0]))) <= longest:
        return None
    points, edges = _edges(space, forbidden, points, longest, stride, check)
    turn = pace.turn * (1.0 + LENGTH_SLACK)
    cycles = _Cycles(turn, pace.stopping, pace.bend, terms.goal_yaw, pace.heading_tolerance)
    costs = np.full(len(edges.ends), np.inf)
    parents = np.full(len(edges.ends), -1)
    is_done = np.zeros(len(edges.ends), dtype=np.bool_)
    # Of each point, a state that is good for all directions: its cost and direction.
    best = np.column_stack((np.full(len(points), np.inf), np.zeros(len(points))))
    goal = np.array([float(bound), -1.0])
    queue = with_room(bucket_queue(bound), len(points))
    _begin(edges, terms.start_yaw, cycles, bound, costs, queue)

    def expand(queue: BucketQueue) -> int:
        return _search(edges, cycles, costs, parents, is_done, best, goal, queue, bound, _AT_A_TIME)

    run_search(expand, queue, len(points), check)
    return _path_to(int(goal[1]), points, edges, parents)


def _path_to(edge: int, points: Points, edges: _Edges, parents: Indices) -> Points | None:
    """Go back from the edge that ends at the goal; None if there is none."""
    if edge < 0:
        return None
    places = [1]
    while edge >= 0:
        places.append(int(edges.starts[edge]))
        edge = int(parents[edge])
    return points[places[::-1]]


def _edges(
    space: FreeSpace,
    forbidden: BitMask,
    given: Points,
    longest: float,
    stride: float,
    check: Callable[[], None],
) -> tuple[Points, _Edges]:
    """
    Find out which points see which, as far as they may be on a short enough path.

    A corner may be if the shortest paths to it from the start and from the goal are short
    enough together. Returns the points, the given ones first, and their edges.
    """
    from_start = lengths_from(space, given[0], given[1], longest, check=check)
    to_goal = lengths_from(space, given[1], given[0], longest, from_start, check)
    kept = np.flatnonzero(from_start + to_goal <= longest + _TINY)
    count = len(given)
    points = np.vstack((given, corner_places(space.rectangles, kept)))
    numbers = np.full(len(from_start), -1)
    numbers[kept] = np.arange(count, count + len(kept))
    sight = Sight(space.rectangles, numbers)
    # Of given points the straight line is known only.
    start_lengths = np.concatenate((np.hypot(*(given - given[0]).T), from_start[kept]))
    left = np.concatenate((np.hypot(*(given - given[1]).T), to_goal[kept]))
    places = np.array([space.rectangle_at(point) for point in given] + (kept >> 2).tolist())
    # A given point is looked at from the others by the same look: all of it counts.
    limits = np.where(np.arange(len(points)) < count, np.inf, longest - start_lengths + _TINY)
    goal = np.broadcast_to(points[1], points.shape)
    start, end = sight.seen_from(places, np.column_stack((points, goal, limits)), check)
    # What a given point sees sees that point.
    by_given = start < count
    views = [_view(forbidden, given, at) for at in range(count)]
    start, end = (
        np.concatenate((start, end[by_given], np.repeat(np.arange(count), list(map(len, views))))),
        np.concatenate((end, start[by_given], *views)),
    )
    steps = points[end] - points[start]
    lengths = np.hypot(*steps.T)
    short = (lengths > 0.0) & (start_lengths[start] + lengths + left[end] <= longest + _TINY)
    order = np.flatnonzero(short)[np.lexsort((end[short], start[short]))]
    start, end, steps, lengths = start[order], end[order], steps[order], lengths[order]
    firsts = np.searchsorted(start, np.arange(len(points) + 1))
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    return points, _Edges(firsts, end, start, lengths / stride, angles, left / stride)


def _view(forbidden: BitMask, points: Points, at: int) -> Indices:
    """Return which of a few points one of them sees, other than those in the same place."""
    place = points[at]
    seen = [
        other
        for other, point in enumerate(points)
        if (point != place).any() and sees(forbidden.words, forbidden.width, *place, *point)
    ]
    return np.array(seen, dtype=np.int64)


@inlined_part
def _apart(a: float, b: float) -> float:
    """Return the angle between two directions, 0 to pi [rad]."""
    return float(abs((a - b + np.pi) % (2.0 * np.pi) - np.pi))


@inlined_part
def _turn_cycles(angle: float, cycles: _Cycles) -> float:
    """Return how many cycles a change of heading takes (`WalkingTimeModel.turn_cycles`)."""
    if angle <= cycles.bend:
        return 0.0
    return float(max(1, math.ceil(angle / cycles.turn + cycles.stopping)))


@inlined_part
def _rest(cost: float) -> float:
    """Return what a state costs when the robot has come to rest there."""
    return float(math.ceil(cost - _TINY))


@inlined_part
def _leaving(cost: float, direction: float, onward: float, cycles: _Cycles) -> float:
    """Return what a state costs when the robot leaves it in another direction."""
    angle = _apart(direction, onward)
    if angle <= cycles.bend:
        return cost
    return _rest(cost) + _turn_cycles(angle, cycles) + cycles.stopping


@inlined_part
def _bucket(cost: float, left: float, least: int) -> int:
    """Return how many whole cycles a state will cost at least, no less than before."""
    return max(least, int(_rest(cost + left)))


def _begin(
    edges: _Edges,
    start_yaw: float,
    cycles: _Cycles,
    bound: int,
    costs: Floats,
    queue: BucketQueue,
) -> None:
    """Let the edges from the start wait; there must be room."""
    for edge in range(int(edges.firsts[0]), int(edges.firsts[1])):
        turns = _turn_cycles(_apart(start_yaw, edges.angles[edge]), cycles)
        cost = turns + cycles.stopping + edges.strides[edge]
        bucket = _bucket(cost, edges.left[edges.ends[edge]], 0)
        if bucket < bound:
            costs[edge] = cost
            push(queue.heads, queue.entries, queue.state, edge, 0, bucket)


@compiled_loop
def _search(
    edges: _Edges,
    cycles: _Cycles,
    costs: Floats,
    parents: Indices,
    is_done: Mask,
    best: Floats,
    goal: Floats,
    queue: BucketQueue,
    bound: int,
    at_a_time: int,
) -> int:
    """
    Go on with a search, for so many expansions at a time.

    A state is an edge: the robot at its end, in its direction. Returns ``DONE``,
    ``PAUSED``, or ``FULL`` if the queue must grow.
    """
    for _ in range(at_a_time):
        if is_empty(queue.state):
            return DONE
        bucket = next_bucket(queue.heads, queue.state)
        if goal[0] <= bucket:
            return DONE
        if not has_room(queue.entries, queue.state, len(edges.left)):
            return FULL
        state, _ = pop(queue.heads, queue.entries, queue.state)
        if is_done[state]:
            continue
        is_done[state] = True
        at, cost, direction = edges.ends[state], costs[state], edges.angles[state]
        if at == 1:
            angle = _apart(direction, cycles.goal_yaw)
            total = _rest(cost)
            if angle > cycles.heading_tolerance:
                total += max(1.0, _turn_cycles(angle, cycles))
            if total < goal[0]:
                goal[0], goal[1] = total, state
            continue
        if _is_no_better(cost, direction, best[at, 0], best[at, 1], cycles):
            continue
        if cost < best[at, 0]:
            best[at, 0], best[at, 1] = cost, direction
        for edge in range(edges.firsts[at], edges.firsts[at + 1]):
            onward = _leaving(cost, direction, edges.angles[edge], cycles) + edges.strides[edge]
            if onward < costs[edge] - _TINY:
                further = _bucket(onward, edges.left[edges.ends[edge]], bucket)
                if further < bound:
                    costs[edge] = onward
                    parents[edge] = state
                    is_done[edge] = False
                    push(queue.heads, queue.entries, queue.state, edge, 0, further)
    return PAUSED


@inlined_part
def _is_no_better(
    cost: float, direction: float, best: float, best_direction: float, cycles: _Cycles
) -> bool:
    """
    Return whether the robot would do as well to turn from another state in the same place.

    Turning by that much more never costs more cycles than a turn through both angles and
    a bend.
    """
    if not best < np.inf:
        return False
    between = _apart(direction, best_direction) + cycles.bend
    turned = math.ceil(between / cycles.turn + cycles.stopping) + cycles.stopping
    return bool(_rest(best) + turned <= cost)
