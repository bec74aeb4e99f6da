"""
Where a leg of any three axes has one posture for each place: the part of its aspect it walks in.

The postures of such a leg fall apart into aspects, parts of the joint space in which the Jacobian
is regular (Borrel and Liegeois 1986). Within wide ranges an aspect may still hold two postures of
one place (Parenti-Castelli and Innocenti 1988; such legs are cuspidal, Wenger 1992), and pockets
that join it only around a singularity. The leg therefore keeps to postures that a straight line of
regular ones joins to the nominal one, in a window of angles around it that is narrowed until no
two of them have their feet in one place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.serial_legs.compiled_leg import CompiledLeg

Array = NDArray[np.float64]

_NODES = 15
"""Number of angles of each joint on the grid at which iteration begins."""

_NEAREST = 4
"""Number of nodes near a place of which the one nearest to the nominal posture comes first."""

_WIDEST = math.pi - 0.05
"""Largest angle of a joint from the nominal posture: a whole turn does not fit in [rad]."""

_FINE = 61
"""Number of angles of joints two and three on the grid that is searched for double postures."""

_AROUND = 128
"""Number of nodes near a place among which its other postures are looked for."""

_TRIED = 3
"""Number of these, the nearest of other postures, from which iteration looks for one."""

_OTHER, _SAME = 0.4, 0.02
"""Angles from a posture beyond which a node may lead to another, and below which it is the same
[rad]."""

_NARROWER = 0.95
"""Factor by which the window is narrowed in a step, and once more for what lies between nodes."""

_NEAR = 1e-12
"""Distance of a foot from where it is wanted that ends the iteration, as a fraction of the leg's
length."""

FOUND = 1e-9
"""The same of a foot that is found: in places singular to rounding it gets no nearer."""


@dataclass(frozen=True, eq=False)
class Window:
    """Ranges of joints around a nominal posture."""

    lower: Array
    """Lower ends, shape (3,) [rad]."""
    upper: Array
    """Upper ends, shape (3,) [rad]."""
    nominal: Array
    """Posture between them, shape (3,) [rad]."""

    def within(self, widest: float) -> Window:
        """Return the part that is no farther from the nominal posture than an angle [rad]."""
        lower = np.maximum(self.lower, self.nominal - widest)
        return Window(lower, np.minimum(self.upper, self.nominal + widest), self.nominal)

    def holds(self, postures: Array, first: int = 0) -> NDArray[np.bool_]:
        """Return which postures (n, 3 - first) are in it, without the joints before ``first``."""
        is_in = (postures >= self.lower[first:]) & (postures <= self.upper[first:])
        return np.asarray(is_in.all(axis=-1))


@dataclass(frozen=True, eq=False)
class Aspect:
    """Postures of a leg, of which no two have their feet in one place."""

    leg: CompiledLeg
    """The leg."""
    window: Window
    """Ranges of its joints."""
    postures: Array
    """Joint angles on a grid, shape (n, 3) [rad]."""
    tree: Any
    """Places of their feet from the first joint, for a search by distance."""
    strangeness: Array
    """Distances of the postures from the nominal one, shape (n,) [rad]."""

    def solve(self, feet: Array, length: float) -> tuple[Array, Array]:
        """
        Find the postures of places.

        Parameters
        ----------
        feet : ndarray, shape (n, 3)
            Feet from the first joint [m].
        length : float
            Length of the leg [m].

        Returns
        -------
        tuple of ndarray, shapes (n, 3) and (n,)
            Joint angles [rad], and how far their feet are from where they are wanted; infinite
            where the only posture that was found is not one of the aspect [m].
        """
        count = min(_NEAREST, len(self.postures))
        nodes = np.reshape(self.tree.query(feet, k=count)[1], (len(feet), count))
        usual = np.argmin(self.strangeness[nodes], axis=1)
        begins = nodes[np.arange(len(feet)), usual]
        angles, left = self._tried(feet, begins, length)
        # The nearest node may lead there where the most usual one does not.
        again = np.flatnonzero(~(left <= FOUND * length) & (begins != nodes[:, 0]))
        if len(again):
            others, rest = self._tried(feet[again], nodes[again, 0], length)
            is_found = rest <= FOUND * length
            angles[again[is_found]], left[again[is_found]] = others[is_found], rest[is_found]
        return angles, left

    def holds(self, postures: Array) -> NDArray[np.bool_]:
        """Return which postures (n, 3) [rad] belong to it."""
        is_in = self.window.holds(postures)
        is_in[is_in] = self.leg.stays_regular(self.window.nominal, postures[is_in])
        return is_in

    def _tried(self, feet: Array, begins: NDArray[np.intp], length: float) -> tuple[Array, Array]:
        angles, left = self.leg.solve(feet, self.postures[begins], _NEAR * length)
        reached = np.flatnonzero(left <= FOUND * length)
        # What ran off into another aspect, or around, is not found.
        left[reached[~self.holds(angles[reached])]] = np.inf
        return angles, left


def posture_grid(lower: Array, upper: Array, count: int = _NODES) -> Array:
    """Return postures over ranges (3,), shape (count, count, count, 3) [rad]."""
    angles = [np.linspace(low, high, count) for low, high in zip(lower, upper)]
    return np.stack(np.meshgrid(*angles, indexing='ij'), axis=-1)


def aspect_around(leg: CompiledLeg, ranges: Window, length: float) -> Aspect:
    """
    Find the postures around a regular one of which no two have their feet in one place.

    Parameters
    ----------
    leg : CompiledLeg
        The leg.
    ranges : Window
        Ranges of its joints and the nominal posture.
    length : float
        Length of the leg [m].
    """
    window = one_to_one(leg, ranges.within(_WIDEST), length)
    nodes = posture_grid(window.lower, window.upper).reshape(-1, 3)
    grid: Array = np.vstack([window.nominal, nodes])
    grid = grid[leg.stays_regular(window.nominal, grid)]
    strangeness = np.linalg.norm(grid - window.nominal, axis=-1)
    return Aspect(leg, window, grid, _tree(leg.feet(grid)), strangeness)


def one_to_one(leg: CompiledLeg, window: Window, length: float) -> Window:
    """
    Narrow a window until no two regular postures in it have their feet in one place.

    The first joint turns the foot about its axis and changes nothing else: places are compared by
    their distances from the axis and along it, and the turn between two postures by whether it
    fits into the first joint's range.
    """
    first, second, turns = _double_postures(leg, window, length)
    widest, narrow = _WIDEST, window
    while len(turns):
        span = float(narrow.upper[0] - narrow.lower[0])
        both = narrow.holds(first[:, 1:], 1) & narrow.holds(second[:, 1:], 1) & (turns <= span)
        if not both.any():
            return window.within(widest * _NARROWER) if widest < _WIDEST else narrow
        widest *= _NARROWER
        narrow = window.within(widest)
    return narrow


def _tree(places: Array) -> Any:
    """Return places (n, k) for a search by distance."""
    # Not above: a third of what a node imports, and few legs need it.
    from scipy.spatial import cKDTree

    return cKDTree(places)


def _double_postures(leg: CompiledLeg, window: Window, length: float) -> tuple[Array, Array, Array]:
    """Return two postures of one place each, (m, 3), and their first joints' turn, (m,) [rad]."""
    ends = [np.linspace(window.lower[k], window.upper[k], _FINE) for k in (1, 2)]
    pitches, knees = (angles.ravel() for angles in np.meshgrid(*ends, indexing='ij'))
    nodes = np.column_stack([np.full(len(knees), window.nominal[0]), pitches, knees])
    nodes = nodes[leg.stays_regular(window.nominal, nodes)]
    feet = leg.feet(nodes)
    along = feet @ leg.axes[0]
    around = feet - along[:, None] * leg.axes[0]
    start = np.eye(3)[int(np.argmin(np.abs(leg.axes[0])))]
    ahead = np.cross(leg.axes[0], start)
    ahead /= np.linalg.norm(ahead)
    azimuths = np.arctan2(around @ np.cross(leg.axes[0], ahead), around @ ahead)
    places = np.column_stack([along, np.linalg.norm(around, axis=1)])
    count = min(_AROUND, len(nodes))
    near = np.reshape(_tree(places).query(places, k=count)[1], (len(nodes), count))
    is_other = np.abs(nodes[near, 1:] - nodes[:, None, 1:]).max(axis=-1) > _OTHER
    # The nearest of other postures first, for the order of neighbors is by distance.
    order = np.argsort(~is_other, axis=1, kind='stable')[:, :_TRIED]
    rows = np.repeat(np.arange(len(nodes)), order.shape[1])
    others = np.take_along_axis(near, order, axis=1).ravel()
    is_tried = np.take_along_axis(is_other, order, axis=1).ravel()
    rows, others = rows[is_tried], others[is_tried]
    begins = nodes[others]
    begins[:, 0] += azimuths[rows] - azimuths[others]
    found, left = leg.solve(feet[rows], begins, _NEAR * length)
    is_double = (left <= FOUND * length) & window.holds(found[:, 1:], 1)
    is_double &= np.abs(found[:, 1:] - nodes[rows, 1:]).max(axis=-1) > _SAME
    rows, found = rows[is_double], found[is_double]
    is_regular = leg.stays_regular(window.nominal, found)
    rows, found = rows[is_regular], found[is_regular]
    turns = np.abs(np.remainder(found[:, 0] - nodes[rows, 0] + math.pi, 2.0 * math.pi) - math.pi)
    return nodes[rows], found, turns
