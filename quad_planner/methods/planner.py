"""
One door to every planning method, which keeps the map between plans.

A method has two halves: `prepare` does once a map what does not depend on start and
goal, or `update` where only a part of the map has changed; `plan` does the rest. To add a
method, add its class to `METHODS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import fields
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from quad_common.errors import InvalidPlanner, NoMap, PlannerError, QuadError
from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.costs.cell_costs import CostLayer
from quad_planner.costs.ground_difficulty import ground_of
from quad_planner.footing.footing import FootedRobot
from quad_planner.footing.warm_up import warm_up as warm_up_footing
from quad_planner.grid.bit_grid import changed_rows
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.footed_planner import FootedPlanner, FootingOptions
from quad_planner.methods.mesh_planner import MeshPlanner
from quad_planner.methods.outline_planner import OutlineOptions, OutlinePlanner
from quad_planner.methods.potential_planner import PotentialPlanner
from quad_planner.methods.quickest_planner import QuickestPlanner
from quad_planner.methods.shortest_planner import ShortestPlanner

Prepared = TypeVar('Prepared', bound=InflatedMap)


class PlanningMethod(Protocol[Prepared]):
    """A planning method, as the planner uses it."""

    @property
    def clearance_radius(self) -> float:
        """Distance that the robot's center keeps from every obstacle [m]."""

    @property
    def costs(self) -> tuple[CostLayer, ...]:
        """Reasons why paths through some cells cost more."""

    def prepare(self, grid: OccupancyGrid) -> Prepared:
        """Make a map ready for any number of plans."""

    def update(self, prepared: Prepared, grid: OccupancyGrid, changed: tuple[int, int]) -> Prepared:
        """
        Make a map ready of which only some rows have changed.

        Parameters
        ----------
        prepared : Prepared
            The map as it was, from `prepare` or `update`.
        grid : OccupancyGrid
            The map as it is, of the same size and in the same place.
        changed : tuple of int
            The rows, from the first up to, but without, the second.

        Returns
        -------
        Prepared
            What `prepare` would return.
        """

    def plan(self, prepared: Prepared, start: Pose2D, goal: Pose2D) -> Plan:
        """Plan on a prepared map; raise `PlannerError` if there is no plan."""


METHODS: Mapping[str, Callable[..., PlanningMethod[Any]]] = {
    'mesh': MeshPlanner,
    'shortest': ShortestPlanner,
    'quickest': QuickestPlanner,
    'potential': PotentialPlanner,
}
"""The planning methods by name."""


_MOST = 0.5
"""Fraction of changed rows above which a map is prepared as a new one."""


class Planner(Generic[Prepared]):
    """
    A planning method and the map it works on.

    Parameters
    ----------
    method : PlanningMethod
        Method by which to plan.
    """

    def __init__(self, method: PlanningMethod[Prepared]) -> None:
        self._method = method
        self._prepared: Prepared | None = None

    @property
    def prepared(self) -> Prepared | None:
        """Return the prepared map, or None before the first one."""
        return self._prepared

    def set_map(self, grid: OccupancyGrid) -> None:
        """
        Take a map for the plans that follow.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.

        Raises
        ------
        QuadError
            If the method cannot use the map; the one before it stays.
        """
        self._prepared = self._updated(grid) or self._method.prepare(grid)

    def _updated(self, grid: OccupancyGrid) -> Prepared | None:
        """Return the map made ready from the one before, None if they are too different."""
        before = self._prepared
        if before is None or not grid.is_aligned_with(before.grid):
            return None
        if ground_of(grid) is not ground_of(before.grid):
            return None
        changed = changed_rows(before.grid.cells, grid.cells)
        if changed is None:
            return before
        if changed[1] - changed[0] > _MOST * grid.height:
            return None
        return self._method.update(before, grid, changed)

    @property
    def clearance_radius(self) -> float:
        """Distance that the robot's center keeps from every obstacle [m]."""
        return self._method.clearance_radius

    @property
    def footed(self) -> FootedRobot | None:
        """Robot for which footholds are looked for along plans; None if they are not."""
        return getattr(self._method, 'footed', None)

    @property
    def weighs_ground(self) -> bool:
        """Whether costs are taken of the ground under the map."""
        return any(getattr(layer, 'needs_ground', False) for layer in self._method.costs)

    def warm_up(self) -> None:
        """
        Plan on a small map of its own, around a wall and not, so that the compiled code is ready.

        It takes half a second, and after an installation that of compiling: ten, or more.
        """
        cells = np.zeros((48, 48), dtype=np.int8)
        cells[16:32, 22:26] = OCCUPIED
        side = self._method.clearance_radius / 2.0
        grid = OccupancyGrid(cells, side, Pose2D(0.0, 0.0, 0.0))
        start, behind, before = (Pose2D(x * side, 24.3 * side, 0.3) for x in (8.6, 40.2, 15.4))
        # Far enough from the wall, in a cell that is not as a whole.
        corner = Pose2D(27.9 * side, 33.9 * side, 0.3)
        # Whether there is a plan does not matter, nor whether the method can use this map.
        with suppress(QuadError):
            prepared = self._method.prepare(grid)
            for goal in (behind, before, corner):
                with suppress(PlannerError):
                    self._method.plan(prepared, start, goal)
        if self.footed is not None:
            warm_up_footing(self.footed)

    def plan(self, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Plan on the map that was set last.

        Parameters
        ----------
        start, goal : Pose2D
            In the world [m, m, rad].

        Returns
        -------
        Plan
            The turning points.

        Raises
        ------
        PlannerError
            If there is no map, or no plan; the map stays.
        """
        if self._prepared is None:
            raise NoMap()
        return self._method.plan(self._prepared, start, goal)

    def plan_on(self, grid: OccupancyGrid, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Plan once on another map; the one that was set last stays.

        Parameters
        ----------
        grid : OccupancyGrid
            The other map.
        start, goal : Pose2D
            In the world [m, m, rad].

        Returns
        -------
        Plan
            The turning points.

        Raises
        ------
        PlannerError
            If there is no plan.
        """
        prepared = self._updated(grid) or self._method.prepare(grid)
        return self._method.plan(prepared, start, goal)


def make_planner(
    method: str,
    outline: OutlineOptions | None = None,
    footing: FootingOptions | None = None,
    **options: Any,
) -> Planner[Any]:
    """
    Make a planner by its method's name.

    Parameters
    ----------
    method : str
        A key of `METHODS`.
    outline : OutlineOptions, optional
        The robot's outline, to plan by it where that is of use.
    footing : FootingOptions, optional
        The robot, to look for its footholds along plans where the ground is known.
    **options
        The fields of the methods' classes, for example `mesh_size` of `MeshPlanner`; those
        of other methods are left aside.

    Returns
    -------
    Planner
        A planner that has no map yet.

    Raises
    ------
    InvalidPlanner
        If there is no such method.
    ParameterError
        If an option's value is not valid.
    """
    if method not in METHODS:
        raise InvalidPlanner(method, METHODS)
    taken = {name: value for name, value in options.items() if name in _options(METHODS[method])}
    unknown = set(options) - set().union(*map(_options, METHODS.values()))
    if unknown:
        raise TypeError(f'no planning method has the options {sorted(unknown)}')
    made: Any = METHODS[method](**taken)
    if outline is not None:
        made = OutlinePlanner(made, outline)
    return Planner(made if footing is None else FootedPlanner(made, footing))


def _options(method: Any) -> set[str]:
    return {field.name for field in fields(method)}
