"""
What a search for footsteps knows, and what it remembers.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOST_CELLS = 32000
"""Cells of a lattice, at most: four of them make the key of a stance."""

_EMPTY = -1


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
    """What is known of a robot; tables as :class:`~quad_common.footing.leg_room.LegRoom`'s."""

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
    breadth: float
    """Least distance to the side from a right foot to the left one beside it [m]."""


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

    @property
    def is_exhausted(self) -> bool:
        """Whether nothing is left to be expanded."""
        return bool(self.state[1] == 0)


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
