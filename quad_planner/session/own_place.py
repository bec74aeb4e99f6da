"""
What a height map shows where the robot itself stands: its own body and legs, for all one knows.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import StartOccupied
from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.grid.traversability import Ground

Array = NDArray[np.float64]

OWN_PLACE = 'what the height map shows where the robot itself stands is left out'
"""Remark on a plan whose start would have been refused for it."""


@dataclass(frozen=True, eq=False)
class OwnPlace:
    """Where the robot stands on the ground that was measured: no start is refused for it."""

    ground: Ground | None
    """Ground that was measured, if there is any."""
    outline: Array | None
    """Convex outline of the robot in the body frame, shape (n, 2), where it is known [m]."""
    robot: Pose2D | None
    """Pose of the robot in the map, where it is known."""

    def plan(self, search: Callable[[], Plan], search_on: Callable[[Ground], Plan]) -> Plan:
        """
        Plan, and where the start is refused once more, over ground without the robot itself.

        Parameters
        ----------
        search : callable
            Search on the map as it is.
        search_on : callable
            The same search over other ground.

        Returns
        -------
        Plan
            Its remark says so if the robot itself was left out.

        Raises
        ------
        PlannerError
            That of the search on the map as it is, if the start is refused either way.
        """
        try:
            return search()
        except StartOccupied as error:
            ground = self._without_robot()
            if ground is None:
                raise
            try:
                plan = search_on(ground)
            except StartOccupied:
                # Something else stands there.
                raise error from None
        remark = f'{plan.remark}; {OWN_PLACE}' if plan.remark else OWN_PLACE
        return replace(plan, remark=remark)

    def _without_robot(self) -> Ground | None:
        if self.ground is None or self.outline is None or self.robot is None:
            return None
        heights = without_robot(self.ground.heights, self.outline, self.robot)
        return None if heights is None else Ground(heights, self.ground.limits)


def without_robot(heights: HeightMap, outline: Array, pose: Pose2D) -> HeightMap | None:
    """
    Leave out what was measured where a robot stands.

    Parameters
    ----------
    heights : HeightMap
        Of the ground, and perhaps of the robot.
    outline : ndarray, shape (n, 2)
        Convex outline of the robot in the body frame, counter-clockwise [m].
    pose : Pose2D
        Where it stands, in the frame of the height map.

    Returns
    -------
    HeightMap or None
        With unknown heights in all cells that the outline touches, and in those around them, for
        what stands at the border of a cell is measured in the next one too. None if nothing is
        known there anyway.
    """
    margin = math.sqrt(2.0) * heights.resolution
    corners = pose.transform(outline)
    limits = heights.columns, heights.rows
    first, last = (
        np.clip(np.floor((corner - heights.origin) / heights.resolution).astype(int), 0, limits)
        for corner in (corners.min(axis=0) - margin, corners.max(axis=0) + margin)
    )
    window = np.s_[first[1] : last[1] + 1, first[0] : last[0] + 1]
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack((sides[:, 1], -sides[:, 0])) / np.hypot(*sides.T)[:, None]
    centers = heights.centers[window]
    beyond = (centers @ normals.T - (normals * corners).sum(axis=1)).max(axis=-1)
    is_own = beyond <= margin
    if not np.isfinite(heights.heights[window][is_own]).any():
        return None
    cleared = heights.heights.copy()
    cleared[window][is_own] = np.nan
    return heights.with_heights(cleared)
