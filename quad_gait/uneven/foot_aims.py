"""
Where a foot goes, how high it passes over the ground, and how deep it feels for it.

None of that depends on the body's posture, of which many are tried: it is found once for them all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_gait.uneven.ground_model import FootholdChoice, GroundModel
from quad_gait.uneven.uneven_options import UnevenOptions

Array = NDArray[np.float64]


class FootAim(NamedTuple):
    """Where a foot goes, and what it passes."""

    target: Array
    """Place where the foot is to stand, its center, shape (3,) [m]."""
    top: float
    """Height to which it is lifted [m]."""
    above: float
    """Height above its place at which it begins to feel for the ground [m]."""
    depth: float
    """Depth below its place down to which it feels [m]."""
    is_certain: bool
    """Whether the ground is at one height by the map, and not somewhere between two."""


class FootAims:
    """
    Finds places for feet, and how they get there over the ground.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    swing_height : float
        Of the gait on even ground [m].
    """

    def __init__(self, robot: Robot, options: UnevenOptions, swing_height: float) -> None:
        self._robot, self._scale = robot, robot.relative_size
        self._options, self._swing_height = options, swing_height

    def foot_on(self, ground: GroundModel, place: Array) -> Array:
        """Return the center of a foot on the ground at a place (2,), shape (3,) [m]."""
        return np.array([*place, float(ground.height(place)) + self._robot.foot_radius])

    def target(
        self, ground: GroundModel, start: Array, place: Array, fraction: float, shin: Array
    ) -> Array:
        """
        Choose where a foot goes.

        Parameters
        ----------
        ground : GroundModel
            What is known of the ground.
        start : ndarray, shape (3,)
            Center of the foot where it stands [m].
        place : ndarray, shape (2,)
            Where it should stand after the whole step [m].
        fraction : float
            Of the step; 0 puts it down where it stood.
        shin : ndarray, shape (n, 3)
            Points on foot and shin from the point below the foot [m].

        Returns
        -------
        ndarray, shape (3,)
            Center of the foot where it is to stand [m].
        """
        options, scale = self._options, self._scale
        wanted = start[:2] + fraction * (place - start[:2])
        if fraction > 0.0:
            choice = FootholdChoice(
                scale * options.foothold_reach,
                max(scale * options.foothold_radius, self._robot.foot_radius),
                scale * options.largest_step,
                self._robot.roughness + scale * self._swing_height,
                shin,
                self._robot.foot_radius + scale * options.shin_clearance,
            )
            wanted = ground.best_foothold(wanted, choice)
        return self.foot_on(ground, wanted)

    def aim(
        self, ground: GroundModel, start: Array, target: Array, feels: bool, clearance: float
    ) -> FootAim:
        """
        Find how a foot gets to its place.

        Parameters
        ----------
        ground : GroundModel
            What is known of the ground.
        start, target : ndarray, shape (3,)
            Centers of the foot where it stands, and is to stand [m].
        feels : bool
            Whether motors tell when it meets the ground.
        clearance : float
            Fraction of its usual height at which the foot passes over the ground.

        Returns
        -------
        FootAim
        """
        options, robot, scale = self._options, self._robot, self._scale
        radius = robot.foot_radius
        highest, is_known = ground.passage(start[:2], target[:2], radius + scale * 0.01)
        highest = max(highest + radius, float(start[2]), float(target[2]))
        # Where no map shows the ground it may be anywhere on the way down: all of it is slow.
        top = highest + max(1.2 * self._swing_height, 1.5 * robot.roughness)
        if is_known:
            top = highest + scale * clearance * options.clearance
        height = float(ground.height(target[:2]))
        lowest, uppermost = ground.range_at(target[:2])
        above, depth = 0.0, 0.0
        if feels:
            above = min(scale * options.search_above + (uppermost - height), top - float(target[2]))
            depth = min(0.5 * robot.roughness + (height - lowest), 1.1 * robot.step_height)
        return FootAim(target, top, above, depth, lowest == uppermost)
