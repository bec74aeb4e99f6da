"""
Where two paths are too near to each other, and what a robot without the right of way does there.

The rule. Of two robots one has the right of way (:func:`~.robot_on_map.precedes`). The other one
may not be on a stretch of its path that is nearer to the path of the first than both bodies need,
unless it leaves it long before the first can be there. Before such a stretch it waits; if it is on
one already, it goes to the nearest place off the path of the first. The robot with the right of
way stops for a body on its path, and for nothing else.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import distances_to_polyline
from quad_planner.grid.array_types import Points
from quad_planner.traffic.robot_on_map import RobotOnMap

_STEP = 0.05
"""Distance between the places of a path that are looked at [m]."""

_REST = 0.9
"""Time until a robot that is to stop has come to rest: it hears, decides, and ends a stride [s]."""

_AHEAD = 1.0
"""A stretch is left while the other robot is farther from it than this, at least [m]."""


_CELL = 0.05
"""By which a path around a body may be nearer to it than both radii: it is drawn in cells [m]."""


class Duty(enum.IntEnum):
    """What a robot has to do because of another one."""

    NONE = 0
    WAIT = 1
    """Stand until the other one has passed, or has moved away."""
    LEAVE = 2
    """Go off the path of the other one."""


@dataclass(frozen=True)
class Distances:
    """How much room robots leave each other."""

    margin: float = 0.2
    """Between the path of one and the body of another, beyond both radii [m]."""
    touching: float = 0.1
    """Beyond both radii, nearer than which a body on the path is stopped for [m]."""
    stop: float = 0.45
    """Distance before a stretch at which a robot waits: it needs some to come to rest [m]."""
    look: float = 0.8
    """Distance along the path within which bodies on it are stopped for [m]."""

    def at(self, speed: float) -> Distances:
        """Return them for a robot of a speed [m/s], which comes to rest within a second or so."""
        return replace(self, stop=self.stop + _REST * speed, look=self.look + 1.5 * _REST * speed)


def sampled(line: Points) -> tuple[Points, Points]:
    """
    Take places along a line, about 5 cm apart.

    Parameters
    ----------
    line : ndarray, shape (n, 2), n >= 1
        Corners of the line [m].

    Returns
    -------
    places : ndarray, shape (m, 2)
        With the first and the last corner [m].
    along : ndarray, shape (m,)
        Distance of each from the first, along the line [m].
    """
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    corners = np.concatenate([[0.0], np.cumsum(lengths)])
    count = int(np.ceil(corners[-1] / _STEP)) + 1
    along = np.linspace(0.0, corners[-1], count)
    places = np.column_stack([np.interp(along, corners, line[:, k]) for k in (0, 1)])
    return places, along


def duty_towards(
    own: RobotOnMap, other: RobotOnMap, room: Distances, waits: bool = False, faster: float = 2.0
) -> Duty:
    """
    Return what a robot has to do because of one that has the right of way.

    Parameters
    ----------
    own, other : RobotOnMap
        The two robots.
    room : Distances
        How much room they leave each other.
    waits : bool
        Whether the robot waits already: then it goes on a little later.
    faster : float
        How many times as fast the other one may be.

    Returns
    -------
    Duty
    """
    needed = own.radius + other.radius + room.margin
    places, along = sampled(own.line)
    near = distances_to_polyline(places, other.line) < needed
    theirs, their_along = sampled(other.line)
    for first, last in _runs(near):
        on_stretch = places[first : last + 1]
        reached = distances_to_polyline(theirs, on_stretch) < needed
        other_comes = float(their_along[reached].min()) if reached.any() else 0.0
        if faster * along[last] + _AHEAD < other_comes:
            continue
        if first == 0:
            return Duty.LEAVE
        stop = room.stop * (1.5 if waits else 1.0)
        return Duty.WAIT if along[first] < stop else Duty.NONE
    return Duty.NONE


def is_body_ahead(
    own: RobotOnMap, other: RobotOnMap, room: Distances, is_obstacle: bool = False
) -> bool:
    """
    Return whether another robot's body is on the next part of a robot's path.

    Parameters
    ----------
    own, other : RobotOnMap
        The two robots.
    room : Distances
        How much room they leave each other.
    is_obstacle : bool
        Whether paths lead around the body, as around a wall. Then the path itself keeps the
        safety distance from it, and only one from before runs into it.
    """
    places, along = sampled(own.line)
    ahead = places[along <= room.look]
    apart = np.linalg.norm(ahead - other.position, axis=1)
    # Where it only gets farther away, it may go.
    nearest = int(np.argmin(apart))
    needed = own.radius + other.radius + room.touching
    if is_obstacle:
        needed = min(needed - room.touching - _CELL, apart[0] - 2.0 * _CELL)
    return nearest > 0 and bool(apart[nearest] < needed)


def is_clear_of(
    places: Points, radius: float, other: RobotOnMap, room: Distances
) -> NDArray[np.bool_]:
    """Return, shape (m,), which places a robot of a radius may wait at for another to pass."""
    needed = radius + other.radius + room.margin
    clear: NDArray[np.bool_] = distances_to_polyline(places, other.line) > needed
    return clear


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return first and last index of each run of true values."""
    edges = np.diff(np.concatenate([[0], mask.astype(np.int8), [0]]))
    return list(
        zip(np.flatnonzero(edges == 1).tolist(), (np.flatnonzero(edges == -1) - 1).tolist())
    )
