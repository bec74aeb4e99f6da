"""
What is added to a map before it is planned on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.grid.keepout_mask import KeepoutMask, with_discs
from quad_planner.grid.traversability import Ground


@dataclass(frozen=True)
class MapAdditions:
    """What no map shows: zones to keep out of, places without footing, and other robots."""

    mask: KeepoutMask | None = None
    """Zones to keep out of."""
    mask_frame: str = ''
    """Frame of the zones; all else is in the map's."""
    closed: tuple[tuple[float, float], ...] = ()
    """Places at which the robot found no footing, x and y in the map [m]."""
    bodies: tuple[tuple[float, float, float], ...] = ()
    """Other robots: x, y and radius of each in the map [m]."""

    def in_frame(self, frame: str, before: Pose2D | None) -> MapAdditions:
        """
        Return what goes with a map in any frame.

        Parameters
        ----------
        frame : str
            Frame of that map. Zones that are given in another one are left out.
        before : Pose2D or None
            Pose of the frame of the map before in it. If that is not known, places and robots are
            left out.

        Returns
        -------
        MapAdditions
            Places and robots are in that frame.
        """
        mask = self.mask if self.mask_frame == frame else None
        if before is None:
            return MapAdditions(mask, self.mask_frame)
        places = [before @ Pose2D(x, y, 0.0) for x, y in self.closed]
        robots = [(before @ Pose2D(x, y, 0.0), radius) for x, y, radius in self.bodies]
        return MapAdditions(
            mask,
            self.mask_frame,
            tuple((place.x, place.y) for place in places),
            tuple((robot.x, robot.y, radius) for robot, radius in robots),
        )

    def combined(
        self, grid: OccupancyGrid, ground: Ground | None, least: int, steps_over_low: bool
    ) -> OccupancyGrid:
        """
        Return the map with all of it, and with the ground.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.
        ground : Ground, optional
            The ground that the robot walks on.
        least : int
            Least occupancy of an obstacle [%].
        steps_over_low : bool
            Whether obstacles that the ground shows to be low are none.

        Returns
        -------
        OccupancyGrid
            What is planned on.
        """
        grid = self.with_zones(grid)
        if ground is not None:
            grid = ground.added_to(grid, least, steps_over_low)
        return self.with_obstacles(grid)

    def with_zones(self, grid: OccupancyGrid) -> OccupancyGrid:
        """Return the map with zones to keep out of."""
        return grid if self.mask is None else self.mask.added_to(grid)

    def with_obstacles(self, grid: OccupancyGrid) -> OccupancyGrid:
        """Return the map with other robots, and places without footing."""
        if self.bodies:
            grid = with_discs(grid, self.bodies)
        if not self.closed:
            return grid
        cells = grid.cells.copy()
        columns, rows = np.floor(grid.world_to_map(np.array(self.closed))).astype(int).T
        inside = (columns >= 0) & (columns < grid.width) & (rows >= 0) & (rows < grid.height)
        cells[rows[inside], columns[inside]] = OCCUPIED
        return OccupancyGrid(cells, grid.resolution, grid.origin)
