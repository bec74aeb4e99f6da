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

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, compiled_part, inlined_part
from quad_gait.footsteps.search_values import Body, Goal, Lattice, Tree
from quad_gait.footsteps.stance_check import find_room, may_step, place_body, take_feet

Array = NDArray[np.float64]

_KEY_BITS = 15
_HASH = np.uint64(0x9E3779B97F4A7C15)
_ROOM = 4096
"""Steps from one stance, more than there ever are."""

_DISCOMFORT = 0.3
"""Cost of a foot one longest step away from its initial posture; a step costs 1."""


_DEVIATION = 4.0
"""Cost of a step after which the body is off the heading of the goal, for 1 rad, squared."""


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
        take_feet(lattice, tree, tree.cells[0])
        place_body(body, tree)
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
        take_feet(lattice, tree, cells)
        for leg in range(4):
            for axis in range(3):
                feet[leg, axis] = tree.scratch[leg, axis]
        place_body(body, tree)
        x, y, c, s = tree.pose[0], tree.pose[1], tree.pose[3], tree.pose[4]
        for leg in range(4):
            if not find_room(body, tree, feet, leg):
                continue
            ahead, aside = body.neutral[leg, 0], body.neutral[leg, 1]
            column = round((x + c * ahead - s * aside - lattice.x) / lattice.side)
            row = round((y + s * ahead + c * aside - lattice.y) / lattice.side)
            for i in range(max(0, row - around), min(rows, row + around + 1)):
                for j in range(max(0, column - around), min(columns, column + around + 1)):
                    if lattice.fit[leg, i, j] == 0:
                        continue
                    cell = i * columns + j
                    if may_step(lattice, body, tree, feet, leg, cell):
                        _add(lattice, body, goal, tree, node, cells, leg, cell)
    end: int = state[3]
    return end


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
    place_body(body, tree)
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
