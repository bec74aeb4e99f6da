"""
Where a robot can stand on the ground under a map, as far as it is known.
"""

from __future__ import annotations

from typing import Any

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_planner.costs.ground_difficulty import GridOverGround
from quad_planner.footing.footing import FootedRobot, Footing
from quad_planner.grid.traversability import Ground
from quad_planner.methods.planner import Planner


class KnownFooting:
    """Keeps what was found on the ground before, so that only changes are looked at again."""

    def __init__(self) -> None:
        self._last: tuple[Ground | None, FootedRobot | None, Footing | None] = None, None, None

    def laid_over(
        self,
        grid: OccupancyGrid,
        ground: Ground | None,
        planner: Planner[Any],
        is_kept: bool = True,
    ) -> OccupancyGrid:
        """
        Lay a map over the ground, if a planner has any use for that.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.
        ground : Ground, optional
            The ground that the robot walks on.
        planner : Planner
            What is to plan on it.
        is_kept : bool
            Whether maps that follow are likely to lie over this ground.

        Returns
        -------
        OccupancyGrid
            A :class:`GridOverGround`, or the map itself.
        """
        if ground is None or not (planner.weighs_ground or planner.footed):
            return grid
        return GridOverGround.of(grid, ground, self._on(ground, planner.footed, is_kept))

    def _on(self, ground: Ground, footed: FootedRobot | None, is_kept: bool) -> Footing | None:
        if footed is None:
            return None
        on, by, footing = self._last
        if on is not ground or by is not footed or footing is None:
            footing = footed.on(ground.heights, footing)
            if is_kept:
                self._last = ground, footed, footing
        return footing
