"""
What every planning method can be told, and what follows from it for a map and a search.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from contextvars import ContextVar
from dataclasses import dataclass
from typing import ClassVar

from quad_common.compiled import compilation_count
from quad_common.errors import ParameterError, PlannerTimedOut, PlanSuperseded
from quad_common.maps.occupancy_grid import OCCUPIED_THRESHOLD, OccupancyGrid
from quad_planner.costs.cell_costs import CostLayer
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.inflated_map import InflatedMap


def _never() -> bool:
    return False


_LONGEST: ContextVar[float] = ContextVar('longest', default=math.inf)


@contextlib.contextmanager
def within(longest: float) -> Iterator[None]:
    """Let no search that this thread begins meanwhile take longer than so long [s]."""
    token = _LONGEST.set(longest)
    try:
        yield
    finally:
        _LONGEST.reset(token)


def is_hurried() -> bool:
    """Return whether this thread searches :func:`within` a time."""
    return _LONGEST.get() < math.inf


@dataclass(frozen=True, kw_only=True)
class PlannerOptions:
    """
    The options that planning methods share.

    Raises
    ------
    ParameterError
        If a length is not finite, or not above zero where it must be.
    """

    clearance_radius: float
    """Distance that the robot's center keeps from every obstacle, > 0 [m]."""
    start_tolerance: float = 0.10
    """
    Distance by which the start may be inside the safety boundary, for a robot that strayed [m].
    """
    occupied_threshold: int = OCCUPIED_THRESHOLD
    """Cells of at least this value are obstacles."""
    unknown_is_free: bool = False
    """Whether cells of which nothing is known are free."""
    time_limit: float | None = None
    """Time that a search may take; needs a clock [s]."""
    clock: Callable[[], float] | None = None
    """Returns the time, for example `time.monotonic` [s]."""

    costs: tuple[CostLayer, ...] = ()
    """Layers by which paths through some cells cost more, for methods that take costs."""
    is_superseded: Callable[[], bool] = _never
    """Asked again and again during a search, which ends where it returns true."""

    knows_costs: ClassVar[bool] = False
    """Whether the method looks at `costs`."""

    def __post_init__(self) -> None:
        """Check the lengths, and whether the method can do what is asked of it."""
        radius, tolerance = self.clearance_radius, self.start_tolerance
        if not (math.isfinite(radius) and radius > 0.0):
            raise ParameterError('clearance_radius', radius, 'a finite length above 0 m')
        if not (math.isfinite(tolerance) and tolerance >= 0.0):
            raise ParameterError('start_tolerance', tolerance, 'a finite length of at least 0 m')
        if self.costs and not self.knows_costs:
            layers = ', '.join(type(layer).__name__ for layer in self.costs)
            raise ParameterError('costs', layers, 'left out: this method compares other things')

    def inflated_map(self, grid: OccupancyGrid) -> InflatedMap:
        """Return a map with the zone that the robot's center must keep out of."""
        return InflatedMap.of(
            grid, self.clearance_radius, self.occupied_threshold, self.unknown_is_free
        )

    def zones_changed_to(
        self, before: InflatedMap, grid: OccupancyGrid, changed: tuple[int, int]
    ) -> tuple[BitMask, BitMask, tuple[int, int]]:
        """Return the zones of a map whose rows changed: :meth:`InflatedMap.zones_changed_to`."""
        return before.zones_changed_to(grid, self.occupied_threshold, self.unknown_is_free, changed)

    def timer(self) -> Callable[[], None]:
        """
        Begin to measure the time of a search.

        Where code is compiled meanwhile, after an installation, the time between two calls counts
        for nothing: that may take longer than any search.

        Returns
        -------
        callable
            To be called again and again. It raises PlannerTimedOut when the time is over,
            and PlanSuperseded when the plan is no longer wanted.
        """
        clock, limit = self.clock, min(self.time_limit or math.inf, _LONGEST.get())
        began = last = 0.0 if clock is None else clock()
        compilations = compilation_count()

        def check() -> None:
            nonlocal began, last, compilations
            if self.is_superseded():
                raise PlanSuperseded
            if clock is None:
                return
            now = clock()
            if compilation_count() != compilations:
                began += now - last
                compilations = compilation_count()
            last = now
            if now - began > limit:
                raise PlannerTimedOut(limit)

        return check
