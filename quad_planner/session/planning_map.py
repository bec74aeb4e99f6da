"""
What is planned on: the map that was received, with the ground of the height map added to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import InvalidMessage, NoMap, QuadError, WrongFrame
from quad_common.errors.quoting import quoted
from quad_common.frames.frame_names import check_frame
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_parts import thinned
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.grid.grid_update import GridUpdate
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.keepout_mask import KeepoutMask
from quad_planner.grid.traversability import Ground
from quad_planner.methods.planner import Planner
from quad_planner.session.known_footing import KnownFooting
from quad_planner.session.map_additions import MapAdditions
from quad_planner.session.own_place import OwnPlace

_PER_STEP = 20.0
"""Number of cells of a height map in the length within which a rise is a step, at most."""

_BEYOND = 2.0
"""Cells beyond the clearance at which an obstacle ahead of the robot leaves the robot free."""

_MOST_CLOSED = 4
"""Places at which the robot found no footing that are closed, on its path to one goal."""


class PlanningMap:
    """
    Hands maps to a planning method; an error leaves those before in force.

    Parameters
    ----------
    planner : Planner
        The planning method.
    frame : MapFrame
        Relation of frames to the map's; its name becomes that of the map that is received.
    limits : GroundLimits
        Limits of the ground that the robot walks on.
    occupied_threshold : int
        Least occupancy of an obstacle [%].
    steps_over_low : bool
        Whether obstacles that the height map shows to be low are none.
    warn : callable
        Is told what a user should know.
    """

    def __init__(
        self,
        planner: Planner[Any],
        frame: MapFrame,
        limits: GroundLimits,
        occupied_threshold: int = 65,
        steps_over_low: bool = False,
        warn: Callable[[str], object] = lambda sentence: None,
    ) -> None:
        self.planner = planner
        """The planning method."""
        self.frame = frame
        """Relation of frames to the map's."""
        self.outline: NDArray[np.float64] | None = None
        """Outline of the robot in the body frame, shape (n, 2), where it is known [m]."""
        self._limits, self._warn = limits, warn
        self._occupied_threshold, self._steps_over_low = occupied_threshold, steps_over_low
        self._grid: OccupancyGrid | None = None
        self._ground: Ground | None = None
        self._footing = KnownFooting()
        self._waiting: tuple[HeightMap, str] | None = None
        self._added = MapAdditions()

    @property
    def is_ready(self) -> bool:
        """Whether there is a map to plan on."""
        return self.planner.prepared is not None

    def pose_on_map(self, frame: str, pose: Pose2D, what: str) -> Pose2D:
        """Bring a pose into the map; WrongFrame if nothing relates its frame to the map's."""
        placed = self.frame.on_map(frame, pose)
        if placed is None:
            raise WrongFrame(what, frame, self.frame.name)
        return placed

    def search(self, start: Pose2D, goal: Pose2D, robot: Pose2D | None) -> Callable[[], Plan]:
        """
        Return a search between poses in the map; the robot's own place (if known) refuses no start.

        It may be called in another thread, and raises `PlannerError` if there is no plan.
        """
        own = OwnPlace(self._ground, self.outline, robot)
        plan_on = self._plan_on(start, goal, self._added)
        return lambda: own.plan(lambda: self.planner.plan(start, goal), plan_on)

    def search_without_bodies(self, start: Pose2D, goal: Pose2D) -> Callable[[], Plan]:
        """Return a search from the robot, as :meth:`search`, as if there were no other robots."""
        ground, added = self._ground, replace(self._added, bodies=())
        plan_on = self._plan_on(start, goal, added)
        return lambda: OwnPlace(ground, self.outline, start).plan(lambda: plan_on(ground), plan_on)

    def _plan_on(
        self, start: Pose2D, goal: Pose2D, added: MapAdditions
    ) -> Callable[[Ground | None], Plan]:
        """Return a search on the map, as it is now, over some ground."""
        grid, planner = self._grid, self.planner

        def plan_on(ground: Ground | None) -> Plan:
            if grid is None:
                raise NoMap()
            return planner.plan_on(self._combined(grid, ground, planner, added), start, goal)

        return plan_on

    def use(self, planner: Planner[Any], occupied_threshold: int) -> None:
        """
        Plan with another planner on the map that is known.

        Parameters
        ----------
        planner : Planner
            The planning method.
        occupied_threshold : int
            Least occupancy of an obstacle [%].

        Raises
        ------
        QuadError
            If the map cannot be planned on with it; all stays as it was.
        """
        threshold, self._occupied_threshold = self._occupied_threshold, occupied_threshold
        try:
            if self._grid is not None:
                planner.set_map(self._combined(self._grid, self._ground, planner))
        except QuadError:
            self._occupied_threshold = threshold
            raise
        self.planner = planner

    def warm_up(self, clock: Callable[[], float]) -> float:
        """Get the searches ready; return how long that took by a clock [s]."""
        began = clock()
        self.planner.warm_up()
        return clock() - began

    def take_grid(self, grid: OccupancyGrid, frame: str) -> bool:
        """
        Take a map. In another frame than the one before, no height map and mask of that stays.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.
        frame : str
            Of the map.

        Returns
        -------
        bool
            Whether anything has changed.

        Raises
        ------
        QuadError
            If it cannot be planned on; all stays as it was.
        """
        added = self._added.in_frame(frame, self.frame.pose_in(frame))
        is_mask_lost = added.mask is not self._added.mask
        is_moved = self._ground is not None and frame != self.frame.name
        has_changed = self._take(grid, frame, None if is_moved else self._ground, added)
        if is_mask_lost:
            self._warn(f'the map is in frame {quoted(frame)}: the keepout mask is left out')
        if is_moved:
            self._warn(
                f'the map is in frame {quoted(frame)} now: the height map is left out until one is'
            )
        return has_changed

    def take_update(self, update: GridUpdate, frame: str) -> bool:
        """
        Take new values of some cells of the map.

        Parameters
        ----------
        update : GridUpdate
            The cells.
        frame : str
            Of the map that they belong to.

        Returns
        -------
        bool
            Whether anything has changed.

        Raises
        ------
        InvalidMessage
            If there is no such map, or they are not on it.
        """
        if self._grid is None or frame != self.frame.name:
            known = 'there is none' if self._grid is None else f'it is in {quoted(self.frame.name)}'
            raise InvalidMessage(
                'map update', f'it is for a map in frame {quoted(frame)}, and {known}'
            )
        return self._take(update.applied_to(self._grid), frame, self._ground, self._added)

    def take_mask(self, mask: OccupancyGrid, frame: str) -> bool:
        """
        Keep out of the zones of a mask from now on; without a map it waits for one.

        What is returned and raised is as of :meth:`take_heights`.
        """
        added = replace(self._added, mask=KeepoutMask(mask), mask_frame=frame)
        if self._grid is None:
            self._added = added
            return False
        check_frame('keepout mask', frame, self.frame.name)
        return self._take(self._grid, frame, self._ground, added)

    def take_heights(self, heights: HeightMap, frame: str) -> bool:
        """
        Take a height map; without a map it waits for one, which tells what frame it has to be in.

        Parameters
        ----------
        heights : HeightMap
            Of the ground.
        frame : str
            Of the height map.

        Returns
        -------
        bool
            Whether anything has changed.

        Raises
        ------
        InvalidMessage
            If it is in another frame than the map.
        """
        if self._grid is None:
            self._waiting = heights, frame
            return False
        check_frame('height map', frame, self.frame.name)
        heights = thinned(heights, self._limits.step_length / _PER_STEP)
        if self._ground is not None and self._ground.is_like(heights):
            return False
        return self._take(self._grid, frame, Ground(heights, self._limits), self._added)

    def take_waiting_heights(self) -> bool:
        """Take the height map that came before the map, if any; see :meth:`take_heights`."""
        waiting, self._waiting = self._waiting, None
        return waiting is not None and self.take_heights(*waiting)

    def _take(
        self, grid: OccupancyGrid, frame: str, ground: Ground | None, added: MapAdditions
    ) -> bool:
        before = self.planner.prepared
        self._prepare(grid, ground, added)
        if self.planner.prepared is before and frame == self.frame.name:
            # The same map again: what was planned on it stands.
            return False
        self.frame.rename(frame)
        return True

    def close_ahead(self, frame: str, place: Pose2D) -> bool:
        """
        Let no path lead on from a pose, straight ahead: the robot found no footing there.

        What is closed is just as far ahead that the robot itself stays free.

        Parameters
        ----------
        frame : str
            Frame of the pose.
        place : Pose2D
            Pose of the robot, heading to where it cannot go.

        Returns
        -------
        bool
            False if so much is closed already that no more is.
        """
        if self._grid is None or len(self._added.closed) == _MOST_CLOSED:
            return False
        place = self.pose_on_map(frame, place, 'pose')
        distance = self.planner.clearance_radius + _BEYOND * self._grid.resolution
        ahead = place @ Pose2D(distance, 0.0, 0.0)
        return self._add(closed=(*self._added.closed, (ahead.x, ahead.y)))

    def open_all(self) -> None:
        """Forget where there was no going on."""
        if self._added.closed and self._grid is not None:
            self._add(closed=())

    def put_bodies(self, bodies: tuple[tuple[float, float, float], ...]) -> bool:
        """Lead paths around bodies, x, y and radius of each [m]; return whether there is news."""
        return self._grid is not None and bodies != self._added.bodies and self._add(bodies=bodies)

    def _add(self, **changes: Any) -> bool:
        assert self._grid is not None
        self._prepare(self._grid, self._ground, replace(self._added, **changes))
        return True

    def _prepare(self, grid: OccupancyGrid, ground: Ground | None, added: MapAdditions) -> None:
        """Plan on a map with its ground and what is added to it: on all of that, or as before."""
        before, self._added = self._added, added
        try:
            self.planner.set_map(self._combined(grid, ground))
        except BaseException:
            self._added = before
            raise
        self._grid, self._ground = grid, ground

    def _combined(
        self,
        grid: OccupancyGrid,
        ground: Ground | None,
        planner: Planner[Any] | None = None,
        added: MapAdditions | None = None,
    ) -> OccupancyGrid:
        """Return what a planner plans on, this map's and with what is added to it if not given."""
        how = self._occupied_threshold, self._steps_over_low
        whole = (added or self._added).combined(grid, ground, *how)
        is_kept = ground is self._ground or added is None
        return self._footing.laid_over(whole, ground, planner or self.planner, is_kept)
