"""
Where a robot can wait for others to pass.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_planner.grid.array_types import Mask
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.grid.keepout_mask import with_discs
from quad_planner.search.distance_field import distance_field
from quad_planner.traffic.right_of_way import Distances, is_clear_of
from quad_planner.traffic.robot_on_map import RobotOnMap

Array = NDArray[np.float64]

_BLOCK = 4096
"""Number of places that are looked at together, the nearest first."""

_GAP = 0.05
"""Distance that is left to bodies on the way to the place [m]."""


def waiting_place(
    prepared: InflatedMap,
    own: RobotOnMap,
    bodies: Sequence[RobotOnMap],
    before: Sequence[RobotOnMap],
    room: Distances,
    goal: Pose2D | None = None,
) -> Pose2D | None:
    """
    Find the nearest place, along a path past all bodies, that is off the paths of other robots.

    If there is one from which the goal can be reached when the others are where they want to go,
    it is the nearest of those: in a corner behind another one's goal a robot would be shut in.

    Parameters
    ----------
    prepared : InflatedMap
        Where the robot's center may be.
    own : RobotOnMap
        The robot.
    bodies : sequence of RobotOnMap
        Robots that it cannot pass through.
    before : sequence of RobotOnMap
        Robots that are to pass.
    room : Distances
        How much room they leave each other.
    goal : Pose2D, optional
        Where the robot wants to go afterwards.

    Returns
    -------
    Pose2D or None
        The place, with the heading in which it lies from here; None if there is none.
    """
    grid = prepared.grid
    rows, columns = np.nonzero(prepared.allowed)
    centers = grid.map_to_world(np.column_stack([columns, rows]).astype(float) + 0.5)
    taken = _taken(centers, own, bodies, grid.resolution)
    allowed = prepared.allowed.copy()
    allowed[rows[taken], columns[taken]] = False
    joints = prepared.joints(grid.world_to_map(own.position), 0.0)
    start = next((cell for cell in joints if allowed[cell[1], cell[0]]), None)
    if start is None:
        return None
    lengths = distance_field(allowed, start)[rows, columns]
    order = np.argsort(lengths, kind='stable')
    order = order[lengths[order] >= 0]
    if goal is not None:
        is_open = _leads_to(prepared, goal, before)[rows, columns]
        # A stable sort: the nearest first, and those from which the goal is reached before others.
        order = np.concatenate([order[is_open[order]], order[~is_open[order]]])
    for begin in range(0, len(order), _BLOCK):
        places = centers[order[begin : begin + _BLOCK]]
        clear = np.all([is_clear_of(places, own.radius, other, room) for other in before], axis=0)
        if np.any(clear):
            x, y = places[int(np.argmax(clear))].tolist()
            return Pose2D(x, y, own.pose.heading_to(Pose2D(x, y, 0.0)))
    return None


def _taken(centers: Array, own: RobotOnMap, bodies: Sequence[RobotOnMap], cell: float) -> Mask:
    """Return which places, shape (n, 2), other robots leave no room at."""
    taken = np.zeros(len(centers), dtype=bool)
    for other in bodies:
        # Bodies that are nearer than that already must not lock the robot in.
        here = float(np.linalg.norm(own.position - other.position))
        apart = np.linalg.norm(centers - other.position, axis=1)
        taken |= apart < min(own.radius + other.radius + _GAP, here - cell)
    return taken


def _leads_to(prepared: InflatedMap, goal: Pose2D, before: Sequence[RobotOnMap]) -> Mask:
    """Return from which cells a goal can be reached past robots that are at their own goals."""
    grid = prepared.grid
    reach = prepared.clearance_radius
    ends = [(*robot.destination.tolist(), robot.radius + reach) for robot in before]
    taken = with_discs(grid, ends).cells != grid.cells
    x, y = np.floor(grid.world_to_map(np.array([goal.x, goal.y]))).astype(int).tolist()
    free: Mask = prepared.allowed & ~taken
    if not (0 <= y < grid.height and 0 <= x < grid.width):
        return free
    lengths = distance_field(free, (x, y))
    leads: Mask = lengths >= 0
    return leads
