"""
Anytime weighted A* over stances: four footholds each, of which a step changes one.

A stance is possible if the robot can stand on it: its body level over the middle of the feet, as
it walks over uneven ground, every foot in reach. A step is possible if the center of mass has room
inside the three feet that stand, and legs reach from there both where the foot is and where it
goes. Any foot may go next.

The first path found is not the shortest. The search goes on as long as it may, and leaves out what
cannot lead to a shorter one (Hansen and Zhou, 2007).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, compiled_part, inlined_part

Array = NDArray[np.float64]

MOST_CELLS = 32000
"""Cells of a lattice, at most: four of them make the key of a stance."""

_KEY_BITS = 15
_HASH = np.uint64(0x9E3779B97F4A7C15)
_EMPTY = -1

_ROOM = 4096
"""Steps from one stance, more than there ever are."""

_DISCOMFORT = 0.3
"""Cost of a foot one longest step away from its initial posture; a step costs 1."""


_DEVIATION = 4.0
"""Cost of a step after which the body is off the heading of the goal, for 1 rad, squared."""


class Lattice(NamedTuple):
    """Where feet may stand: cells in rows, and behind them the four feet at the start."""

    places: Array
    """Centers of feet on the cells, and where they stand at the start, shape (n + 4, 3) [m]."""
    fit: NDArray[np.uint8]
    """Whether a leg's foot may stand on a cell, shape (4, rows, columns)."""
    x: float
    """x of the first cell [m]."""
    y: float
    """y of the first cell [m]."""
    side: float
    """Distance between cells [m]."""


class Body(NamedTuple):
    """What is known of a robot; tables as :class:`~quad_gait.footsteps.leg_room.LegRoom`'s."""

    neutral: Array
    """Feet in the initial posture, body frame, shape (4, 3) [m]."""
    lowest: Array
    """Lowest heights of feet, shape (4, n, n) [m]."""
    highest: Array
    """Highest heights of feet, shape (4, n, n) [m]."""
    side: float
    """Side of a cell of the tables [m]."""
    lowerings: Array
    """Distances by which the body may be lower than in its initial posture, shape (k,) [m]."""
    center_x: float
    """Center of mass in the initial posture, body frame, x [m]."""
    center_y: float
    """Center of mass in the initial posture, body frame, y [m]."""
    longest_step: float
    """Largest horizontal distance of a step [m]."""
    margin: float
    """Least distance of the center of mass from the sides of the feet that stand [m]."""
    separation: float
    """Least distance between feet [m]."""


class Goal(NamedTuple):
    """Where the body is to be over its feet, and how exactly."""

    x: float
    """x [m]."""
    y: float
    """y [m]."""
    yaw: float
    """Heading [rad]."""
    distance: float
    """Distance from there that will do [m]."""
    angle: float
    """Angle that will do [rad]."""
    weight: float
    """Factor of the cost that is expected, 1 or more: the larger, the sooner a path is found."""
    strain: float
    """Factor of how far feet are off their initial posture, by which such stances come later."""


class Tree(NamedTuple):
    """What the search has found; the first node is the start."""

    cells: NDArray[np.int32]
    """Where the feet stand, shape (n, 4)."""
    costs: Array
    """Cost from the start, shape (n,)."""
    ahead: Array
    """Cost to the goal at least, shape (n,)."""
    strain: Array
    """How far all feet are off their initial posture, squared, shape (n,) [longest steps^2]."""
    parents: NDArray[np.int32]
    """Node before; -1 at the start, shape (n,)."""
    keys: NDArray[np.int64]
    """Keys of the stances, shape (n,)."""
    table: NDArray[np.int32]
    """Hash table of nodes by key; -1 where empty, shape (2^k,)."""
    heap: NDArray[np.int32]
    """Nodes to be expanded, shape (m,)."""
    order: Array
    """What the heap is ordered by, shape (m,)."""
    paid: Array
    """Cost of the node when it was pushed, shape (m,)."""
    state: NDArray[np.int64]
    """Numbers of nodes, of entries of the heap, of expansions; and the best end, -1 for none."""
    scratch: Array
    """Feet of a stance, shape (5, 3) [m]."""
    pose: Array
    """Where the body is over them: x, y, z, cosine and sine of its heading, shape (5,)."""
    triangle: Array
    """Room for the center of mass, shape (3, 2) [m]."""


def make_tree(nodes: int, feet: int) -> Tree:
    """Make an empty tree for so many nodes whose first one stands on the cells from `feet` on."""
    size = 1 << (2 * nodes - 1).bit_length()
    tree = Tree(
        cells=np.empty((nodes, 4), dtype=np.int32),
        costs=np.empty(nodes),
        ahead=np.empty(nodes),
        strain=np.zeros(nodes),
        parents=np.empty(nodes, dtype=np.int32),
        keys=np.empty(nodes, dtype=np.int64),
        table=np.full(size, _EMPTY, dtype=np.int32),
        heap=np.empty(2 * nodes, dtype=np.int32),
        order=np.empty(2 * nodes),
        paid=np.empty(2 * nodes),
        state=np.array([0, 0, 0, -1], dtype=np.int64),
        scratch=np.empty((5, 3)),
        pose=np.empty(5),
        triangle=np.empty((3, 2)),
    )
    tree.cells[0] = feet + np.arange(4)
    return tree


@compiled
def search(lattice: Lattice, body: Body, goal: Goal, tree: Tree, expansions: int) -> int:
    """
    Search on, until nothing better can be found or so many stances were expanded.

    Returns
    -------
    int
        Last node of the best path; -1 if there is none yet.
    """
    state = tree.state
    if state[0] == 0:
        _take_feet(lattice, tree, tree.cells[0])
        _place_body(body, tree)
        tree.costs[0] = 0.0
        tree.ahead[0] = _cost_ahead(body, goal, tree.pose)
        tree.parents[0] = -1
        tree.keys[0] = _key(tree.cells[0])
        tree.table[_slot(tree, tree.keys[0])] = 0
        state[0] = 1
        if _is_there(goal, tree.pose):
            state[3] = 0
        _push(tree, 0, goal)
    feet = np.empty((4, 3))
    cells = np.empty(4, dtype=np.int32)
    rows, columns = lattice.fit.shape[1:]
    around = math.ceil(0.5 * body.lowest.shape[1] * body.side / lattice.side)
    for _ in range(expansions):
        if state[0] + _ROOM > len(tree.costs) or state[1] + _ROOM > len(tree.heap):
            break
        node = _pop(tree)
        if node < 0:
            break
        best = state[3]
        if best >= 0 and tree.costs[node] + tree.ahead[node] >= tree.costs[best]:
            continue
        if node == best:
            continue
        state[2] += 1
        for leg in range(4):
            cells[leg] = tree.cells[node, leg]
        _take_feet(lattice, tree, cells)
        for leg in range(4):
            for axis in range(3):
                feet[leg, axis] = tree.scratch[leg, axis]
        _place_body(body, tree)
        x, y, c, s = tree.pose[0], tree.pose[1], tree.pose[3], tree.pose[4]
        for leg in range(4):
            if not _find_room(body, tree, feet, leg):
                continue
            ahead, aside = body.neutral[leg, 0], body.neutral[leg, 1]
            column = round((x + c * ahead - s * aside - lattice.x) / lattice.side)
            row = round((y + s * ahead + c * aside - lattice.y) / lattice.side)
            for i in range(max(0, row - around), min(rows, row + around + 1)):
                for j in range(max(0, column - around), min(columns, column + around + 1)):
                    if lattice.fit[leg, i, j] == 0:
                        continue
                    cell = i * columns + j
                    if _may_step(lattice, body, tree, feet, leg, cell):
                        _add(lattice, body, goal, tree, node, cells, leg, cell)
    end: int = state[3]
    return end


@inlined_part
def _take_feet(lattice: Lattice, tree: Tree, cells: NDArray[np.int32]) -> None:
    """Note where the feet of a stance are."""
    for leg in range(4):
        for axis in range(3):
            tree.scratch[leg, axis] = lattice.places[cells[leg], axis]


@inlined_part
def _place_body(body: Body, tree: Tree) -> None:
    """
    Place the body, level, where the feet are nearest to their initial posture on average.

    As :func:`quad_gait.state.body_placement.body_over`, without a tilt.
    """
    feet, neutral, pose = tree.scratch, body.neutral, tree.pose
    x = y = z = nx = ny = nz = 0.0
    for leg in range(4):
        x += 0.25 * feet[leg, 0]
        y += 0.25 * feet[leg, 1]
        z += 0.25 * feet[leg, 2]
        nx += 0.25 * neutral[leg, 0]
        ny += 0.25 * neutral[leg, 1]
        nz += 0.25 * neutral[leg, 2]
    across = along = 0.0
    for leg in range(4):
        a, b = neutral[leg, 0] - nx, neutral[leg, 1] - ny
        u, v = feet[leg, 0] - x, feet[leg, 1] - y
        across += a * v - b * u
        along += a * u + b * v
    length = math.hypot(across, along)
    c, s = 1.0, 0.0
    if length > 0.0:
        c, s = along / length, across / length
    pose[0] = x - c * nx + s * ny
    pose[1] = y - s * nx - c * ny
    pose[2] = z - nz
    pose[3] = c
    pose[4] = s


@inlined_part
def _is_reached(body: Body, tree: Tree, leg: int, count: int) -> bool:
    """Tell whether legs reach all feet, the fifth being one of `leg`, at some of the heights."""
    pose, feet = tree.pose, tree.scratch
    c, s, size = pose[3], pose[4], body.lowest.shape[1]
    half = 0.5 * size
    low, high = -math.inf, math.inf
    for index in range(count):
        number = leg if index == 4 else index
        u, v = feet[index, 0] - pose[0], feet[index, 1] - pose[1]
        i = math.floor((c * u + s * v - body.neutral[number, 0]) / body.side + half)
        j = math.floor((c * v - s * u - body.neutral[number, 1]) / body.side + half)
        if i < 0 or j < 0 or i >= size or j >= size:
            return False
        low = max(low, feet[index, 2] - body.highest[number, i, j])
        high = min(high, feet[index, 2] - body.lowest[number, i, j])
        if not low <= high:
            return False
    is_possible = False
    for k in range(len(body.lowerings)):
        is_possible |= low <= pose[2] - body.lowerings[k] <= high
    return is_possible


@inlined_part
def _find_room(body: Body, tree: Tree, feet: Array, leg: int) -> bool:
    """Find where the center of mass may be while a foot is in the air; tell if there is room."""
    inner = tree.triangle
    k = 0
    for other in range(4):
        if other != leg:
            inner[k, 0] = feet[other, 0]
            inner[k, 1] = feet[other, 1]
            k += 1
    a = math.hypot(inner[2, 0] - inner[1, 0], inner[2, 1] - inner[1, 1])
    b = math.hypot(inner[0, 0] - inner[2, 0], inner[0, 1] - inner[2, 1])
    c = math.hypot(inner[1, 0] - inner[0, 0], inner[1, 1] - inner[0, 1])
    around = a + b + c
    x = (a * inner[0, 0] + b * inner[1, 0] + c * inner[2, 0]) / around
    y = (a * inner[0, 1] + b * inner[1, 1] + c * inner[2, 1]) / around
    double = (inner[1, 0] - inner[0, 0]) * (inner[2, 1] - inner[0, 1])
    double -= (inner[1, 1] - inner[0, 1]) * (inner[2, 0] - inner[0, 0])
    radius = abs(double) / around
    if radius < body.margin:
        return False
    part = 1.0 - body.margin / radius
    for k in range(3):
        inner[k, 0] = x + part * (inner[k, 0] - x)
        inner[k, 1] = y + part * (inner[k, 1] - y)
    return True


@inlined_part
def _may_step(lattice: Lattice, body: Body, tree: Tree, feet: Array, leg: int, cell: int) -> bool:
    """Tell whether a foot can go to a cell, and the robot stand there; leave the body's pose."""
    x, y, z = lattice.places[cell, 0], lattice.places[cell, 1], lattice.places[cell, 2]
    distance = math.hypot(x - feet[leg, 0], y - feet[leg, 1])
    if distance > body.longest_step or distance < 0.5 * lattice.side:
        return False
    for other in range(4):
        if other == leg:
            continue
        if math.hypot(x - feet[other, 0], y - feet[other, 1]) < body.separation:
            return False
    scratch, pose = tree.scratch, tree.pose
    for other in range(4):
        for axis in range(3):
            scratch[other, axis] = feet[other, axis]
    scratch[leg, 0], scratch[leg, 1], scratch[leg, 2] = x, y, z
    _place_body(body, tree)
    if not _is_reached(body, tree, leg, 4):
        return False
    # While it swings the body is over the middle of its way, and over the other feet.
    scratch[leg, 0] = 0.5 * (x + feet[leg, 0])
    scratch[leg, 1] = 0.5 * (y + feet[leg, 1])
    _place_body(body, tree)
    c, s = pose[3], pose[4]
    ahead = c * body.center_x - s * body.center_y
    aside = s * body.center_x + c * body.center_y
    _balance(tree, ahead, aside)
    scratch[leg, 0], scratch[leg, 1] = x, y
    scratch[4, 0], scratch[4, 1], scratch[4, 2] = feet[leg, 0], feet[leg, 1], feet[leg, 2]
    return _is_reached(body, tree, leg, 5)


@inlined_part
def _balance(tree: Tree, ahead: float, aside: float) -> None:
    """Move the body so that its center of mass, so far ahead and aside of it, is in its room."""
    inner, pose = tree.triangle, tree.pose
    x, y = pose[0] + ahead, pose[1] + aside
    lefts = 0
    for k in range(3):
        other = (k + 1) % 3
        ex, ey = inner[other, 0] - inner[k, 0], inner[other, 1] - inner[k, 1]
        lefts += ex * (y - inner[k, 1]) - ey * (x - inner[k, 0]) > 0.0
    if lefts == 0 or lefts == 3:
        return
    nearest, best_x, best_y = math.inf, x, y
    for k in range(3):
        other = (k + 1) % 3
        ex, ey = inner[other, 0] - inner[k, 0], inner[other, 1] - inner[k, 1]
        squared = max(ex * ex + ey * ey, 1e-18)
        part = ((x - inner[k, 0]) * ex + (y - inner[k, 1]) * ey) / squared
        part = min(max(part, 0.0), 1.0)
        u, v = inner[k, 0] + part * ex, inner[k, 1] + part * ey
        distance = math.hypot(u - x, v - y)
        if distance < nearest:
            nearest, best_x, best_y = distance, u, v
    pose[0] = best_x - ahead
    pose[1] = best_y - aside


@compiled_part
def _add(
    lattice: Lattice,
    body: Body,
    goal: Goal,
    tree: Tree,
    node: int,
    cells: NDArray[np.int32],
    leg: int,
    cell: int,
) -> None:
    """Note a step; the feet are those of `scratch`, after it."""
    state, feet, pose = tree.state, tree.scratch, tree.pose
    before = cells[leg]
    cells[leg] = cell
    key = _key(cells)
    slot = _slot(tree, key)
    found = tree.table[slot]
    _place_body(body, tree)
    cost = tree.costs[node] + 1.0 + _DISCOMFORT * _squared_off(body, feet, pose, leg)
    cost += _DEVIATION * _turn(goal, pose) ** 2
    best = state[3]
    is_new = found < 0
    if is_new:
        found = state[0]
        tree.ahead[found] = _cost_ahead(body, goal, pose)
        tree.strain[found] = 0.0
        for other in range(4):
            tree.strain[found] += _squared_off(body, feet, pose, other)
    is_better = is_new or cost < tree.costs[found] - 1e-12
    if is_better and (best < 0 or cost + tree.ahead[found] < tree.costs[best]):
        if is_new:
            state[0] += 1
            tree.table[slot] = found
            tree.keys[found] = key
            for other in range(4):
                tree.cells[found, other] = cells[other]
        tree.costs[found] = cost
        tree.parents[found] = node
        if _is_there(goal, pose):
            state[3] = found
        else:
            _push(tree, found, goal)
    cells[leg] = before


@inlined_part
def _squared_off(body: Body, feet: Array, pose: Array, leg: int) -> float:
    """Return how far a foot is off its initial posture, squared [longest steps^2]."""
    u, v = feet[leg, 0] - pose[0], feet[leg, 1] - pose[1]
    ahead = pose[3] * u + pose[4] * v - body.neutral[leg, 0]
    aside = pose[3] * v - pose[4] * u - body.neutral[leg, 1]
    squared: float = (ahead * ahead + aside * aside) / body.longest_step**2
    return squared


@inlined_part
def _cost_ahead(body: Body, goal: Goal, pose: Array) -> float:
    """Return how many steps it takes at least: each moves the middle of four feet."""
    away = math.hypot(goal.x - pose[0], goal.y - pose[1]) - goal.distance
    turn = _turn(goal, pose) - goal.angle
    # Half of what a foot turns the body by at most, so that it is never too much.
    arm = 0.5 * math.hypot(body.neutral[0, 0], body.neutral[0, 1])
    return 4.0 * max(0.0, away, arm * turn) / body.longest_step


@inlined_part
def _turn(goal: Goal, pose: Array) -> float:
    turn = goal.yaw - math.atan2(pose[4], pose[3])
    return abs((turn + math.pi) % (2.0 * math.pi) - math.pi)


@inlined_part
def _is_there(goal: Goal, pose: Array) -> bool:
    away = math.hypot(goal.x - pose[0], goal.y - pose[1])
    turn = _turn(goal, pose)
    return away <= goal.distance and turn <= goal.angle


@inlined_part
def _key(cells: NDArray[np.int32]) -> np.int64:
    key = np.int64(0)
    for leg in range(4):
        key = (key << _KEY_BITS) | np.int64(cells[leg])
    return key


@compiled_part
def _slot(tree: Tree, key: np.int64) -> np.int64:
    """Find where a key is in the hash table, or belongs."""
    mask = len(tree.table) - 1
    mixed = np.uint64(key) * _HASH
    slot = np.int64(mixed >> np.uint64(32)) & mask
    while tree.table[slot] >= 0 and tree.keys[tree.table[slot]] != key:
        slot = (slot + 1) & mask
    return slot


@compiled_part
def _push(tree: Tree, node: int, goal: Goal) -> None:
    heap, order, paid, state = tree.heap, tree.order, tree.paid, tree.state
    value = tree.costs[node] + goal.weight * tree.ahead[node] + goal.strain * tree.strain[node]
    hole = state[1]
    state[1] += 1
    while hole > 0:
        above = (hole - 1) >> 1
        if order[above] <= value:
            break
        heap[hole], order[hole], paid[hole] = heap[above], order[above], paid[above]
        hole = above
    heap[hole], order[hole], paid[hole] = node, value, tree.costs[node]


@compiled_part
def _pop(tree: Tree) -> int:
    """Take the node out that is first in order and was not improved since; -1 if there is none."""
    heap, order, paid, state = tree.heap, tree.order, tree.paid, tree.state
    while state[1] > 0:
        node: int = heap[0]
        cost = paid[0]
        state[1] -= 1
        last = state[1]
        if last > 0:
            moved, value, worth = heap[last], order[last], paid[last]
            hole = 0
            while True:
                below = 2 * hole + 1
                if below >= last:
                    break
                if below + 1 < last and order[below + 1] < order[below]:
                    below += 1
                if order[below] >= value:
                    break
                heap[hole], order[hole], paid[hole] = heap[below], order[below], paid[below]
                hole = below
            heap[hole], order[hole], paid[hole] = moved, value, worth
        if cost <= tree.costs[node]:
            return node
    return -1
