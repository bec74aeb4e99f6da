"""
The planner of S0 section 3: Dijkstra's algorithm over a mesh of possible turning points.

A mesh of width delta = 2n + S_max (S0 eq. 5: the robot's length and its longest step) is
laid over the map, its first crossing on the map's origin and its lines along the map's
axes. Crossings outside the safety boundary are the candidates for turning points; from
each the robot may walk along the horizontal, the vertical and the diagonals to the next,
where it fits throughout. Start and goal join the mesh by straight segments.

Among the shortest paths, of which a mesh has many, one with the fewest turns is taken:
every turn on the spot costs gait cycles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import NoPathFound, ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.cell_request import CellRequest
from quad_planner.methods.mesh_moves import MOVES, mesh_moves
from quad_planner.methods.planner_options import PlannerOptions
from quad_planner.search.mesh_search import CIRCLE, Ends, Legs, Mesh, mesh_path

MAX_CROSSINGS = 2**20
"""The finest mesh that is laid over a map."""


def _bearing(angle: float) -> int:
    return round(angle / math.tau * CIRCLE) % CIRCLE


def _micrometres(length: float) -> int:
    """Return a length in whole micrometres, so that equal lengths are equal."""
    return round(length * 1e6)


@dataclass(frozen=True, eq=False)
class PreparedMesh(InflatedMap):
    """A map made ready for any number of searches; `MeshPlanner.prepare` makes it."""

    spacing: float
    """Width of the mesh [cells]."""
    candidates: Mask
    """Crossings that the robot may stand on, by row and column, shape (n, m)."""
    exits: NDArray[np.uint8]
    """Free moves of each crossing: bit k is set if move k of the eight is free, shape (n, m)."""

    @cached_property
    def lines(self) -> Mesh:
        """Return the moves, and their lengths, as the search wants them."""
        width = self.spacing * self.grid.resolution
        straight, diagonal = (_micrometres(width * math.hypot(dc, dr)) for dc, dr in MOVES[:2])
        return Mesh(self.exits, straight, diagonal)

    def crossing(self, number: int) -> Points:
        """Return where a crossing is, in cell coordinates, shape (2,)."""
        row, column = divmod(number, self.candidates.shape[1])
        return np.array([column, row]) * self.spacing

    def candidates_near(self, point: Points, reach: float) -> list[int]:
        """Return the numbers of the candidates within `reach` [cells] of a point."""
        size = np.array(self.candidates.shape[::-1])
        low = np.clip(np.ceil((point - reach) / self.spacing), 0, size).astype(int)
        high = np.clip(np.floor((point + reach) / self.spacing) + 1, 0, size).astype(int)
        rows, columns = np.nonzero(self.candidates[low[1] : high[1], low[0] : high[0]])
        rows, columns = rows + low[1], columns + low[0]
        apart = np.column_stack((columns, rows)) * self.spacing - point
        near = np.linalg.norm(apart, axis=1) <= reach
        return [int(number) for number in (rows * size[0] + columns)[near]]


@dataclass(frozen=True)
class MeshPlanner(PlannerOptions):
    """
    Plan over a mesh of turning points.

    Raises
    ------
    ParameterError
        If a length is not finite, or not above zero where it must be.
    """

    mesh_size: float
    """Width of the mesh, delta = 2n + S_max (S0 eq. 5), > 0 [m]; 0.628 for TITAN-VIII."""
    connection_radius: float | None = None
    """
    Longest segment that joins start or goal to the mesh, or to each other [m]; twice the
    mesh size if None.
    """

    def __post_init__(self) -> None:
        """Check the lengths."""
        for name in ('mesh_size', 'connection_radius'):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, 'a finite length above 0 m')
        super().__post_init__()

    def prepare(self, grid: OccupancyGrid) -> PreparedMesh:
        """
        Inflate a map and find the moves that are free on its mesh.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.

        Returns
        -------
        PreparedMesh
            What `plan` needs of the map, for any number of plans.

        Raises
        ------
        ParameterError
            If the mesh would have more than `MAX_CROSSINGS` crossings.
        """
        spacing = self.mesh_size / grid.resolution
        size = np.array([grid.width, grid.height])
        columns, rows = (int(n) for n in np.floor(size / spacing + 1e-9) + 1)
        if columns * rows > MAX_CROSSINGS:
            least = grid.resolution * math.sqrt(grid.width * grid.height / MAX_CROSSINGS)
            raise ParameterError(
                'mesh_size', self.mesh_size, f'above {least:.3f} m on a map of this size'
            )
        safety = self.inflated_map(grid)
        candidates, exits = mesh_moves(safety.forbidden_bits, spacing, (0, rows), columns)
        return PreparedMesh(
            grid,
            self.clearance_radius,
            safety.blocked_bits,
            safety.forbidden_bits,
            spacing,
            candidates,
            exits,
        )

    def update(
        self, prepared: PreparedMesh, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> PreparedMesh:
        """Make a map ready of which only some rows have changed: `PlanningMethod.update`."""
        blocked, forbidden, (low, high) = self.zones_changed_to(prepared, grid, changed)
        spacing, candidates = prepared.spacing, prepared.candidates.copy()
        rows, columns = candidates.shape
        exits = prepared.exits.copy()
        # Crossings from which a move leads into the rows that changed, or along their edge.
        first = max(math.floor(low / spacing) - 1, 0)
        last = min(math.ceil(high / spacing) + 2, rows)
        # One row more to either side, for their moves; its own moves are not all seen.
        below, above = max(first - 1, 0), min(last + 1, rows)
        band = mesh_moves(forbidden, spacing, (below, above), columns)
        candidates[first:last], exits[first:last] = (
            part[first - below : last - below] for part in band
        )
        return PreparedMesh(
            grid,
            self.clearance_radius,
            blocked,
            forbidden,
            spacing,
            candidates,
            exits,
        )

    def plan(self, prepared: PreparedMesh | OccupancyGrid, start: Pose2D, goal: Pose2D) -> Plan:
        """
        Find the shortest plan over the mesh, and among those one with the fewest turns.

        A start that is inside the safety boundary by no more than `start_tolerance` may
        be left on a segment that comes no nearer to an obstacle than the start is.

        Parameters
        ----------
        prepared : PreparedMesh or OccupancyGrid
            The map, from `prepare`; a bare grid is prepared for this plan only.
        start, goal : Pose2D
            In the world [m, m, rad].

        Returns
        -------
        Plan
            The turning points; a single pose, the goal's, where start and goal are less
            than `SAME_PLACE` apart.

        Raises
        ------
        InvalidPose
            If a pose holds a number that is not finite.
        StartOutsideMap, GoalOutsideMap
            If a pose is not on the map.
        StartOccupied, GoalOccupied
            If a pose is too near to a blocked cell.
        NoPathFound
            If no path over the mesh connects them.
        PlannerTimedOut, PlanSuperseded
            As :meth:`PlannerOptions.timer`.
        """
        mesh = prepared if isinstance(prepared, PreparedMesh) else self.prepare(prepared)
        grid = mesh.grid
        request = CellRequest.of(mesh, start, goal, self.start_tolerance, self.timer())
        if request.is_turn:
            return Plan((goal,))

        s, g, leave_at = request.s, request.g, request.leave_at
        reach = (self.connection_radius or 2.0 * self.mesh_size) / grid.resolution
        starts = self._connections(mesh, s, reach, leave_at)
        goals = self._connections(mesh, g, reach, request.arrive_at)
        direct = np.linalg.norm(g - s) <= reach and mesh.fits(s, g, leave_at)

        yaw = grid.origin.yaw
        ends = Ends(
            _legs([(u, p - s) for u, p in starts.items()], grid.resolution),
            _legs([(u, g - p) for u, p in goals.items()], grid.resolution),
            *(_leg(g - s, grid.resolution) if direct else (-1, -1)),
            (_bearing(start.yaw - yaw), _bearing(goal.yaw - yaw)),
        )
        crossings = mesh_path(mesh.lines, ends, request.check)
        if crossings is None:
            why = self._why_not(mesh, s, g, bool(starts), bool(goals))
            raise NoPathFound((start.x, start.y), (goal.x, goal.y), why)
        return request.plan(np.array([s, *map(mesh.crossing, crossings), g]))

    def _connections(
        self, mesh: PreparedMesh, point: Points, reach: float, keep: float
    ) -> dict[int, Points]:
        """Return the candidates that are straight ahead of a point, and where they are."""
        near = {u: mesh.crossing(u) for u in mesh.candidates_near(point, reach)}
        return {u: p for u, p in near.items() if mesh.fits(point, p, keep)}

    def _why_not(
        self, mesh: PreparedMesh, s: Points, g: Points, leaves: bool, arrives: bool
    ) -> str:
        apart = mesh.not_connected(s, g)
        if apart is not None:
            return apart
        coarse = f'the mesh of {self.mesh_size:.2f} m may be too coarse for this passage'
        if not leaves:
            return f'no mesh crossing is reachable from the start; {coarse}'
        if not arrives:
            return f'the goal is reachable from no mesh crossing; {coarse}'
        return f'both are in one free area, but no path over the mesh connects them; {coarse}'


def _leg(step: Points, resolution: float) -> tuple[int, int]:
    """Return the length of a segment [um] and its bearing, -1 if it has no length."""
    length = _micrometres(float(np.linalg.norm(step)) * resolution)
    return length, _bearing(math.atan2(step[1], step[0])) if length else -1


def _legs(steps: list[tuple[int, Points]], resolution: float) -> Legs:
    """Return segments by the numbers of their crossings, each with its vector [cells]."""
    legs = [(number, *_leg(step, resolution)) for number, step in steps]
    return Legs(*np.array(legs, dtype=np.int64).reshape(-1, 3).T.copy())
