"""
Corners that a robot rounds by circles: whether its outline fits all along them.

A follower rounds a corner by the circle that touches both legs, as large as its deviation and
radius allow, and takes up half a leg at most. A turning point on a leg, where nothing turns,
makes legs shorter and so circles smaller, down to a turn nearly on the spot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.compiled import compiled_loop
from quad_planner.grid.array_types import Points
from quad_planner.outline.heading_kernels import CLASSES, STEP
from quad_planner.outline.outline_zones import Zones, leg_fits

_SMALLEST = 0.5
"""Length of the smallest circle's tangents: it is as good as a turn on the spot [cells]."""

_ABOUT = math.pi - 1e-3
"""The robot turns back on the spot [rad]."""


@dataclass(frozen=True)
class ArcTurns:
    """Circles by which a follower rounds corners."""

    corner_deviation: float = 0.1
    """Distance by which a circle may pass inside its corner [m]."""
    corner_radius: float = 1.0
    """Largest radius [m]."""

    def tangent(self, turn: float) -> float:
        """Return how far before a corner its circle begins, on long legs [m]."""
        half = abs(turn) / 2.0
        if half < 1e-6 or half > _ABOUT / 2.0:
            return 0.0
        from_deviation = self.corner_deviation / (1.0 / math.cos(half) - 1.0)
        return min(self.corner_radius, from_deviation) * math.tan(half)


def with_short_arcs(zones: Zones, points: Points, arcs: ArcTurns, resolution: float) -> Points:
    """
    Add turning points so that the outline fits along all circles.

    Parameters
    ----------
    zones : Zones
        The map.
    points : ndarray, shape (n, 2)
        Turning points at which the robot may turn on the spot [cells].
    arcs : ArcTurns
        The circles.
    resolution : float
        Side of a cell [m].

    Returns
    -------
    ndarray, shape (m, 2)
        The turning points and those that make circles smaller [cells].
    """
    legs = np.diff(points, axis=0)
    lengths = np.hypot(*legs.T)
    headings = np.arctan2(legs[:, 1], legs[:, 0])
    before = np.zeros(len(lengths))
    after = np.zeros(len(lengths))
    for at in range(len(legs) - 1):
        turn = math.remainder(headings[at + 1] - headings[at], 2.0 * math.pi)
        tangent = arcs.tangent(turn) / resolution
        largest = min(tangent, lengths[at] / 2.0, lengths[at + 1] / 2.0)
        fitting = largest
        corner = points[at + 1]
        while fitting > _SMALLEST and not arc_fits(
            zones, corner[0], corner[1], headings[at], turn, fitting
        ):
            fitting = max(_SMALLEST, fitting / 2.0)
        if fitting < largest:
            after[at], before[at + 1] = 2.0 * fitting, 2.0 * fitting
    kept = [points[:1]]
    for at, (leg, length) in enumerate(zip(legs, lengths)):
        marks = [m for m in (before[at], length - after[at]) if 1e-6 < m < length - 1e-6]
        kept += [points[at : at + 1] + leg * (mark / length) for mark in sorted(marks)]
        kept.append(points[at + 1 : at + 2])
    return np.concatenate(kept)


@compiled_loop
def arc_fits(zones: Zones, x: float, y: float, heading: float, turn: float, tangent: float) -> bool:
    """
    Return whether the robot fits along a circle that rounds a corner.

    Parameters
    ----------
    zones : Zones
        The map.
    x, y : float
        The corner [cells].
    heading : float
        Heading before it [rad].
    turn : float
        Change of heading there [rad].
    tangent : float
        Length of each leg that the circle takes up [cells].
    """
    parts = max(1, math.ceil(2.0 * abs(turn) / STEP))
    radius = tangent / math.tan(abs(turn) / 2.0)
    side = 1.0 if turn > 0.0 else -1.0
    x0, y0 = x - tangent * math.cos(heading), y - tangent * math.sin(heading)
    center_x = x0 - side * radius * math.sin(heading)
    center_y = y0 + side * radius * math.cos(heading)
    for part in range(parts):
        a = heading + turn * part / parts
        b = heading + turn * (part + 1) / parts
        ax, ay = center_x + side * radius * math.sin(a), center_y - side * radius * math.cos(a)
        bx, by = center_x + side * radius * math.sin(b), center_y - side * radius * math.cos(b)
        for angle in (a, b):
            k = math.floor(angle / STEP + 0.5) % CLASSES
            if not leg_fits(zones, ax, ay, bx, by, k):
                return False
    return True
