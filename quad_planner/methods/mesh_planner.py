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
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import NoPathFound, ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.grid.inflation import points_allowed, segments_allowed
from quad_planner.methods.cell_request import CellRequest
from quad_planner.methods.planner_options import PlannerOptions
from quad_planner.search.dijkstra import shortest_path

MAX_CROSSINGS = 2**20
"""The finest mesh that is laid over a map."""

# A cost is one whole number: length in micrometres times _MICROMETRE, plus the number of
# turns. Whole numbers add without rounding, so equal lengths are equal and turns decide.
_MICROMETRE = 1 << 20
_TURN = 1

# Bearings, in the map frame, are whole numbers too: parts of a circle that 8 divides.
_CIRCLE = 6400

# Move k goes (columns, rows) to the neighbour at k times 45 degrees; k + 4 is its reverse.
_MOVES = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))

_AT_ONCE = 1 << 14
"""Segments that are checked in one go, to bound the memory."""

# A state of the search is a crossing's number and the bearing on which it was reached.
_State = tuple[int, int]
_START, _GOAL = -1, -2


def _bearing(angle: float) -> int:
    return round(angle / math.tau * _CIRCLE) % _CIRCLE


def _cost(length: float) -> int:
    return round(length * 1e6) * _MICROMETRE


@dataclass(frozen=True, eq=False)
class PreparedMesh(InflatedMap):
    """A map made ready for any number of searches; `MeshPlanner.prepare` makes it."""

    spacing: float
    """Width of the mesh [cells]."""
    candidates: Mask
    """Crossings that the robot may stand on, by row and column, shape (n, m)."""
    exits: bytes
    """Free moves of each crossing, row after row: bit k is set if move k of the eight is free."""

    @cached_property
    def moves(self) -> tuple[tuple[tuple[int, int, int], ...], ...]:
        """Return, for each value in `exits`, the moves: crossings on, bearing, cost."""
        row = self.candidates.shape[1]
        width = self.spacing * self.grid.resolution
        every = [
            (dr * row + dc, k * _CIRCLE // 8, _cost(width * math.hypot(dc, dr)))
            for k, (dc, dr) in enumerate(_MOVES)
        ]
        return tuple(
            tuple(move for k, move in enumerate(every) if exits >> k & 1) for exits in range(256)
        )

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
        candidates, exits = _lay(safety.allowed, spacing, (0, rows), columns)
        return PreparedMesh(
            grid,
            self.clearance_radius,
            safety.blocked_bits,
            safety.forbidden_bits,
            spacing,
            candidates,
            exits.tobytes(),
        )

    def update(
        self, prepared: PreparedMesh, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> PreparedMesh:
        """Make a map ready of which only some rows have changed: `PlanningMethod.update`."""
        blocked, forbidden, (low, high) = self.zones_changed_to(prepared, grid, changed)
        spacing, candidates = prepared.spacing, prepared.candidates.copy()
        rows, columns = candidates.shape
        exits = np.frombuffer(prepared.exits, dtype=np.uint8).reshape(rows, columns).copy()
        # Crossings from which a move leads into the rows that changed, or along their edge.
        first = max(math.floor(low / spacing) - 1, 0)
        last = min(math.ceil(high / spacing) + 2, rows)
        allowed = InflatedMap(grid, self.clearance_radius, blocked, forbidden).allowed
        # One row more to either side, for their moves; its own moves are not all seen.
        below, above = max(first - 1, 0), min(last + 1, rows)
        band = _lay(allowed, spacing, (below, above), columns)
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
            exits.tobytes(),
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

        heading, final = (_bearing(p.yaw - grid.origin.yaw) for p in (start, goal))
        ends = _Ends(s, g, starts, goals, bool(direct), final)
        neighbours = _neighbours(mesh, ends)
        found = shortest_path(neighbours, (_START, heading), (_GOAL, 0), request.check)
        if found is None:
            why = self._why_not(mesh, s, g, bool(starts), bool(goals))
            raise NoPathFound((start.x, start.y), (goal.x, goal.y), why)
        between = [mesh.crossing(u) for u, _ in found.path[1:-1]]
        return request.plan(np.array([s, *between, g]))

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


def _lay(
    allowed: Mask, spacing: float, between: tuple[int, int], columns: int
) -> tuple[Mask, NDArray[np.uint8]]:
    """
    Lay rows of a mesh over a map.

    Parameters
    ----------
    allowed : ndarray of bool, shape (height, width)
        The allowed cells.
    spacing : float
        Width of the mesh [cells].
    between : tuple of int
        Rows of crossings, from the first up to, but without, the second.
    columns : int
        Number of columns of crossings.

    Returns
    -------
    tuple of ndarray, both of shape (n, columns)
        Crossings that are candidates; moves, of eight, that are free between them.
    """
    first, last = between
    lines = [spacing * np.arange(*ends, dtype=np.float64) for ends in ((0, columns), between)]
    candidates = points_allowed(allowed, np.stack(np.meshgrid(*lines), axis=-1))
    exits = np.zeros((last - first, columns), dtype=np.uint8)
    for k, (dc, dr) in enumerate(_MOVES[:4]):
        ends = np.zeros_like(candidates)
        left, right = max(-dc, 0), columns - max(dc, 0)
        ends[: last - first - dr, left:right] = candidates[dr:, left + dc : right + dc]
        r, c = np.nonzero(candidates & ends)
        for part in range(0, len(r), _AT_ONCE):
            r_, c_ = r[part : part + _AT_ONCE], c[part : part + _AT_ONCE]
            starts = np.column_stack((c_, r_ + first)).astype(float) * spacing
            free = segments_allowed(allowed, starts, np.array([float(dc), float(dr)]) * spacing)
            exits[r_[free], c_[free]] |= 1 << k
            exits[r_[free] + dr, c_[free] + dc] |= 1 << (k + 4)
    return candidates, exits


class _Ends(NamedTuple):
    """Start and goal of a search, and how they join the mesh."""

    s: Points
    """Place of the start [cells]."""
    g: Points
    """Place of the goal [cells]."""
    starts: dict[int, Points]
    """Candidates straight ahead of the start, and their places."""
    goals: dict[int, Points]
    """Candidates from which the goal is straight ahead, and their places."""
    direct: bool
    """Whether the goal is straight ahead of the start."""
    final: int
    """Bearing of the goal's heading."""


def _neighbours(
    mesh: PreparedMesh, ends: _Ends
) -> Callable[[_State], Iterator[tuple[_State, int]]]:
    """Return what lists the states after a state, and what they cost."""
    moves, exits = mesh.moves, mesh.exits

    def leg(a: Points, b: Points, arrived: int) -> _State:
        """Return the cost of a segment off the mesh, and the bearing along it."""
        cost = _cost(float(np.linalg.norm(b - a)) * mesh.grid.resolution)
        if cost == 0:
            return 0, arrived
        bearing = _bearing(math.atan2(b[1] - a[1], b[0] - a[0]))
        return cost + (bearing != arrived) * _TURN, bearing

    def neighbours(state: _State) -> Iterator[tuple[_State, int]]:
        u, arrived = state
        if u == _START:
            for v, point in ends.starts.items():
                cost, bearing = leg(ends.s, point, arrived)
                yield (v, bearing), cost
        else:
            for step, bearing, cost in moves[exits[u]]:
                yield (u + step, bearing), cost + (bearing != arrived) * _TURN
        if u in ends.goals or (u == _START and ends.direct):
            cost, bearing = leg(ends.s if u == _START else ends.goals[u], ends.g, arrived)
            yield (_GOAL, 0), cost + (bearing != ends.final) * _TURN

    return neighbours
