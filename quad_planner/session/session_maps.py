"""
Maps of a planning session, as they come in parts.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_planner.grid.grid_update import GridUpdate
from quad_planner.session.session_state import SessionState


class SessionMaps(SessionState, ABC):
    """Takes maps, and plans again on what has changed; parameters as of SessionState."""

    @abstractmethod
    def plan_on_new_map(self) -> None:
        """Show the map, and plan on it to the goal in force."""

    def take_grid(self, grid: OccupancyGrid, frame: str) -> None:
        """
        Plan on this map from now on.

        Raises
        ------
        QuadError
            If it cannot be planned on, or a height map that waited for it does not go with it.
        """
        if self.map.take_grid(grid, frame):
            self.plan_on_new_map()
        if self.map.take_waiting_heights():
            self.plan_on_new_map()

    def take_update(self, update: GridUpdate, frame: str) -> None:
        """Plan on the map with some cells changed; see :meth:`PlanningMap.take_update`."""
        if self.map.take_update(update, frame):
            self.plan_on_new_map()

    def take_mask(self, mask: OccupancyGrid, frame: str) -> None:
        """Keep out of the zones of a mask; see :meth:`PlanningMap.take_mask`."""
        if self.map.take_mask(mask, frame):
            self.plan_on_new_map()

    def take_heights(self, heights: HeightMap, frame: str) -> None:
        """Plan over this ground from now on; see :meth:`PlanningMap.take_heights`."""
        if self.map.take_heights(heights, frame):
            self.plan_on_new_map()
