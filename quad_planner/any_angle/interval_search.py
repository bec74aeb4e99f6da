"""
Shortest paths at any angle, by a search over intervals of openings.

Cui, Harabor and Grastien: Compromise-free Pathfinding on a Navigation Mesh (IJCAI 2017), the
algorithm Polyanya, on the rectangles of :mod:`quad_planner.any_angle.rectangles`. A node is an
interval of an opening and the root from which all of it is seen; A* goes on through the
rectangle beyond. At the interval's ends, where they are corners, the path may turn: they become
roots of what was not seen. The least length through an interval is known exactly, so no point is
looked at that is not on a path which could be the shortest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, inlined_part
from quad_planner.any_angle.free_space import FreeSpace
from quad_planner.any_angle.intervals import (
    INTERVAL,
    TINY,
    crossing,
    distance,
    holds,
    least_through,
    neighbour,
    neighbours,
    opening_part,
    place_of,
)
from quad_planner.any_angle.rectangles import (
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    Rectangles,
    corner_places,
)
from quad_planner.grid.array_types import Mask, Points
from quad_planner.search.jump_tree import pop_node, push_node
from quad_planner.search.search_loop import DONE, FULL, PAUSED, path_back

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Records = NDArray[np.void]

_OPEN = np.dtype([('key', np.float64), ('node', np.int64)])

_NODES_AT_FIRST = 4096

_AT_A_TIME = 4096
"""Number of expansions between two calls of `check`."""

_AT_THE_GOAL = -1
"""Node of a path that is complete."""

_USED, _WAITING, _ROOT_OF_GOAL = range(3)
"""Places in `counts`: nodes, entries of the heap, and the last root of the shortest path."""


class _Search(NamedTuple):
    """The arrays of a search; they are changed."""

    nodes: Records
    """Intervals, in the order in which they were found."""
    heap: Records
    """Nodes and the least length of a path through them, the least first."""
    counts: Integers
    """Numbers, see `_USED`."""
    lengths: Floats
    """Length of the shortest known path to each root, and to the goal at the end [cells]."""
    before: Integers
    """Root before each on that path."""
    ends: Floats
    """
    Start and goal, x and y [cells]; the bound; whether the search goes on behind the goal.
    """
    is_open: Mask
    """Rectangles that may be on the path, see `Blocks`."""
    beyond: Floats
    """Least length from each corner to the goal, 0 where nothing is known [cells]."""
    views: Floats
    """
    Notes of one expansion: root, whether the upper side is seen, from where to where, and whether
    the goal is; shape (5, 5).
    """


def any_angle_path(
    space: FreeSpace,
    start: Points,
    goal: Points,
    bound: float = np.inf,
    check: Callable[[], None] = lambda: None,
) -> Points | None:
    """
    Find a shortest path at any angle.

    Parameters
    ----------
    space : FreeSpace
        The free cells; their edges are allowed.
    start, goal : ndarray, shape (2,)
        Points in free cells [cells].
    bound : float
        Length of a path that is known: longer ones are not looked at [cells].
    check : callable
        Called again and again; raises to end the search.

    Returns
    -------
    ndarray, shape (m, 2) or None
        The start, the corners where it turns, and the goal; None if there is none
        within the bound.
    """
    is_open = space.between(start, goal)
    if is_open is None:
        return None
    corners = 4 * len(space.rectangles.bounds)
    search = _found(space, _search_of(space, start, goal, (bound, 0.0), is_open), check)
    last = int(search.counts[_ROOT_OF_GOAL])
    if last < 0:
        return None
    roots = np.array(path_back(search.before.__getitem__, last, corners))
    return np.vstack((start, corner_places(space.rectangles, roots[1:]), goal))


def lengths_from(
    space: FreeSpace,
    start: Points,
    goal: Points,
    bound: float,
    beyond: Floats | None = None,
    check: Callable[[], None] = lambda: None,
) -> Floats:
    """
    Measure the shortest paths from a point to corners.

    Parameters
    ----------
    space, start, goal, check
        As for :func:`any_angle_path`.
    bound : float
        Length of a path from the start over a corner to the goal, at most [cells].
    beyond : ndarray, shape (4 n,) or None
        Least length from each corner to the goal, where it is known [cells].

    Returns
    -------
    ndarray, shape (4 n,)
        Length to each corner of a rectangle that is on a path within the bound, as far as the line
        from it to the goal tells; infinite for others, or too long [cells].
    """
    is_open = np.ones(len(space.rectangles.bounds), dtype=np.bool_)
    search = _search_of(space, start, goal, (bound, 1.0), is_open)
    if beyond is not None:
        search.beyond[:-2] = beyond
    return _found(space, search, check).lengths[:-2]


def _search_of(
    space: FreeSpace, start: Points, goal: Points, limits: tuple[float, float], is_open: Mask
) -> _Search:
    """Begin a search, with its bound, and whether it goes on behind the goal."""
    corners = 4 * len(space.rectangles.bounds)
    room = _NODES_AT_FIRST + 4 * space.width
    search = _Search(
        np.empty(room, dtype=INTERVAL),
        np.empty(room, dtype=_OPEN),
        np.array([0, 0, -1]),
        np.full(corners + 2, np.inf),
        np.empty(corners + 2, dtype=np.int64),
        np.array([*start, *goal, limits[0] * (1.0 + TINY) + TINY, limits[1]]),
        is_open,
        np.zeros(corners + 2),
        np.empty((5, 5)),
    )
    search.lengths[corners] = 0.0
    _begin(space.rectangles, search)
    return search


def _found(space: FreeSpace, search: _Search, check: Callable[[], None]) -> _Search:
    """Go on with a search until it is done."""
    outcome = PAUSED
    while outcome != DONE:
        if outcome == FULL:
            search = _larger(search)
        check()
        outcome = _go_on(space.rectangles, search, _AT_A_TIME)
    return search


def _larger(search: _Search) -> _Search:
    """Return the same search with twice the room."""
    nodes, heap = (
        np.concatenate((array, np.empty_like(array))) for array in (search.nodes, search.heap)
    )
    return search._replace(nodes=nodes, heap=heap)


def _begin(rectangles: Rectangles, search: _Search) -> None:
    """Let the rectangles wait that hold the start: all of them is seen, through no interval."""
    start = search.ends[:2]
    low, high = rectangles.bounds[:, [LEFT, BOTTOM]], rectangles.bounds[:, [RIGHT, TOP]]
    holding = ((low <= start + TINY) & (start - TINY <= high)).all(axis=1)
    for node, here in enumerate(np.flatnonzero(holding).tolist()):
        # An interval whose ends are in the wrong order.
        search.nodes[node] = (1.0, 0.0, 0.0, len(search.lengths) - 2, -1, -1, here, 0)
        search.heap[node] = (0.0, node)
        search.counts[[_USED, _WAITING]] += 1


@inlined_part
def _turn(rectangles: Rectangles, search: _Search, root: int, corner: int) -> bool:
    """
    Let a path turn at a corner that a root sees; return whether it is as short as any known.

    No corner, -1, is none to turn at.
    """
    if corner < 0:
        return False
    lengths, ends = search.lengths, search.ends
    x0, y0 = place_of(rectangles, root, ends[0], ends[1])
    x, y = place_of(rectangles, corner, ends[0], ends[1])
    length = lengths[root] + distance(x0, y0, x, y)
    if length + search.beyond[corner] > ends[4]:
        return False
    if length < lengths[corner] - TINY:
        lengths[corner] = length
        search.before[corner] = root
    return bool(length <= lengths[corner] + TINY)


@inlined_part
def _arrive(rectangles: Rectangles, search: _Search, root: int) -> None:
    """Note a path that goes straight from a root to the goal."""
    lengths, ends, counts = search.lengths, search.ends, search.counts
    if ends[5] != 0.0:
        return
    x, y = place_of(rectangles, root, ends[0], ends[1])
    length = lengths[root] + distance(x, y, ends[2], ends[3])
    if length < lengths[-1] and length <= ends[4]:
        lengths[-1] = length
        counts[_ROOT_OF_GOAL] = root
        push_node(search.heap, counts, length, _AT_THE_GOAL)


@inlined_part
def _pass_on(
    rectangles: Rectangles,
    search: _Search,
    here: int,
    is_up: bool,
    low: float,
    high: float,
    root: int,
) -> None:
    """Let the openings of a rectangle's side wait, as far as they lie between two places."""
    nodes, counts, ends = search.nodes, search.counts, search.ends
    x, y = place_of(rectangles, root, ends[0], ends[1])
    line = float(rectangles.bounds[here, TOP if is_up else BOTTOM])
    length = search.lengths[root]
    first, last = neighbours(rectangles, here, is_up)
    for at in range(first, last):
        there = neighbour(rectangles, at, is_up)
        if not search.is_open[there]:
            continue
        left, right, left_corner, right_corner = opening_part(
            rectangles, here, there, is_up, low, high
        )
        if left > right:
            continue
        key = length + least_through(x, y, left, right, line, is_up, ends[2], ends[3])
        if key > ends[4] or key >= search.lengths[-1]:
            continue
        node = counts[_USED]
        counts[_USED] += 1
        nodes[node].left, nodes[node].right = left, right
        nodes[node].left_corner, nodes[node].right_corner = left_corner, right_corner
        nodes[node].length, nodes[node].root = length, root
        nodes[node].rectangle, nodes[node].is_up = there, is_up
        push_node(search.heap, counts, key, node)


@compiled_loop
def _go_on(rectangles: Rectangles, search: _Search, at_a_time: int) -> int:
    """
    Go on with a search, for so many expansions at a time.

    Returns ``DONE``, ``PAUSED``, or ``FULL`` if the arrays must grow.
    """
    nodes, heap, counts = search.nodes, search.heap, search.counts
    for _ in range(at_a_time):
        if counts[_WAITING] == 0:
            return DONE
        node = int(heap[0].node)
        if node == _AT_THE_GOAL:
            return DONE
        here = int(nodes[node].rectangle)
        up, down = neighbours(rectangles, here, True), neighbours(rectangles, here, False)
        room = 3 * (up[1] - up[0] + down[1] - down[0]) + 3
        if max(counts[_USED], counts[_WAITING]) + room > len(nodes):
            return FULL
        pop_node(heap, counts)
        # A shorter path to the root may have been found since.
        if nodes[node].length <= search.lengths[nodes[node].root] + TINY:
            _expand(rectangles, search, node)
    return PAUSED


@inlined_part
def _expand(rectangles: Rectangles, search: _Search, node: int) -> None:
    """Go on through the rectangle beyond an interval."""
    count = _look(rectangles, search, node)
    here = search.nodes[node].rectangle
    # One place from which each is called: they are compiled into it.
    for k in range(count):
        view = search.views[k]
        if view[4] != 0.0:
            _arrive(rectangles, search, int(view[0]))
        _pass_on(rectangles, search, here, view[1] != 0.0, view[2], view[3], int(view[0]))


@inlined_part
def _look(rectangles: Rectangles, search: _Search, node: int) -> int:
    """Note the views through the rectangle beyond an interval; return how many there are."""
    interval, ends, views = search.nodes[node], search.ends, search.views
    here, is_up, root = interval.rectangle, interval.is_up != 0, interval.root
    left, right = interval.left, interval.right
    bounds = rectangles.bounds
    near = float(bounds[here, BOTTOM if is_up else TOP])
    far = float(bounds[here, TOP if is_up else BOTTOM])
    x, y = place_of(rectangles, root, ends[0], ends[1])
    has_goal = holds(rectangles, here, ends[2], ends[3])
    if left > right:
        _note(views, 0, root, True, (-np.inf, np.inf), has_goal)
        _note(views, 1, root, False, (-np.inf, np.inf), False)
        return 2
    if y == near:
        # Along the side, to the opening: from its end all of the rectangle is seen.
        if x < left or x > right:
            corner = interval.left_corner if x < left else interval.right_corner
            if not _turn(rectangles, search, root, corner):
                return 0
            root = corner
        if ends[5] != 0.0:
            # No shortest path turns there, but others may: the lengths are noted.
            for end in (interval.left_corner, interval.right_corner):
                _turn(rectangles, search, root, end)
        _note(views, 0, root, is_up, (-np.inf, np.inf), has_goal)
        _note(views, 1, root, not is_up, (-np.inf, left - 0.5), False)
        _note(views, 2, root, not is_up, (right + 0.5, np.inf), False)
        return 3
    # What is seen through the opening ends at the lines from the root through its ends.
    low, high = crossing(x, y, left, near, far), crossing(x, y, right, near, far)
    goal_low = goal_high = ends[2]
    if has_goal:
        goal_low = crossing(x, y, left, near, ends[3]) - TINY
        goal_high = crossing(x, y, right, near, ends[3]) + TINY
    _note(views, 0, root, is_up, (low, high), has_goal and goal_low <= ends[2] <= goal_high)
    count = 1
    for is_left in (True, False):
        corner = interval.left_corner if is_left else interval.right_corner
        if _turn(rectangles, search, root, corner):
            is_seen = ends[2] < goal_low if is_left else ends[2] > goal_high
            far_part = (-np.inf, low) if is_left else (high, np.inf)
            near_part = (-np.inf, left - 0.5) if is_left else (right + 0.5, np.inf)
            _note(views, count, corner, is_up, far_part, has_goal and is_seen)
            _note(views, count + 1, corner, not is_up, near_part, False)
            count += 2
    return count


@inlined_part
def _note(
    views: Floats, at: int, root: int, is_up: bool, span: tuple[float, float], arrives: bool
) -> None:
    """Note what a root sees of a side, and whether it sees the goal."""
    views[at, 0], views[at, 1] = float(root), 1.0 if is_up else 0.0
    views[at, 2], views[at, 3] = span[0], span[1]
    views[at, 4] = 1.0 if arrives else 0.0
