"""
Whether a robot can stand on four footholds, and go from them to others by one step.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import inlined_part
from quad_gait.footsteps.search_values import Body, Lattice, Tree

Array = NDArray[np.float64]


@inlined_part
def take_feet(lattice: Lattice, tree: Tree, cells: NDArray[np.int32]) -> None:
    """Note where the feet of a stance are."""
    for leg in range(4):
        for axis in range(3):
            tree.scratch[leg, axis] = lattice.places[cells[leg], axis]


@inlined_part
def place_body(body: Body, tree: Tree) -> None:
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
def find_room(body: Body, tree: Tree, feet: Array, leg: int) -> bool:
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
def may_step(lattice: Lattice, body: Body, tree: Tree, feet: Array, leg: int, cell: int) -> bool:
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
    place_body(body, tree)
    # Legs alternate: the left one of a pair, and the right one.
    beside = leg ^ 1
    aside = pose[3] * (y - feet[beside, 1]) - pose[4] * (x - feet[beside, 0])
    if (aside if leg % 2 == 0 else -aside) < body.breadth:
        return False
    if not _is_reached(body, tree, leg, 4):
        return False
    # While it swings the body is over the middle of its way, and over the other feet.
    scratch[leg, 0] = 0.5 * (x + feet[leg, 0])
    scratch[leg, 1] = 0.5 * (y + feet[leg, 1])
    place_body(body, tree)
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
