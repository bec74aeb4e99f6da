"""
What feet have met of the ground, and how far a height map may be off by that.

A map is compared with each place where a foot met the ground. Where it shows another height, it
may show the right one a little aside: the least distance at which it does is how far it is off
there, if it is a map of this ground at all. The largest of these distances over the last strides
is what a robot should reckon with. Where no place near explains what a foot met, the map is wrong
by more than that, and feet find their ground better without it.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.state.stance import Stance
from quad_gait.uneven.ground_model import GroundModel

Array = NDArray[np.float64]

_TOLERANCE = 0.012
"""Difference of heights that is no reason to doubt a map [m, of TITAN-VIII]."""

_FARTHEST = 0.12
"""Distance aside within which a map may be right [m, of TITAN-VIII]."""

_NEGLIGIBLE = 1.6
"""A map is not off where it is right within so many cells: feet stand on edges, and slip [1]."""

_LANDINGS = 40
"""Number of landings for which a map is not believed as before: ten strides."""

_WINDOW, _MOVED = 1.2, 0.3
"""Half the side of the part of a map that is looked at around a robot, and distance after which
it is another one [m, of TITAN-VIII]."""

_MOST_POINTS = 1000
"""Number of places that are remembered."""


class FeltGround:
    """
    Remembers where feet met the ground, and judges a height map by it.

    Parameters
    ----------
    robot : Robot
        The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._scale = robot.relative_size
        self._points: deque[tuple[float, float, float]] = deque(maxlen=_MOST_POINTS)
        self._stood = np.full(len(LEGS), math.nan)
        self._off: deque[float] = deque(maxlen=_LANDINGS)
        self._window: HeightMap | None = None
        self._seen: tuple[HeightMap | None, Array] = (None, np.zeros(2))
        self.count = 0
        """Number of places that were felt so far."""

    @property
    def points(self) -> Array:
        """
        Places where feet met the ground, in the plan's frame, the newest last, shape (n, 3) [m].

        Their heights are the height map's: on the average those where the other feet stood, by the
        map; without one they are relative to where the robot began.
        """
        return np.array(self._points, dtype=float).reshape(-1, 3)

    @property
    def map_error(self) -> float:
        """Distance by which the map seems to be off; infinite if no distance explains it [m]."""
        return max(self._off, default=0.0)

    @property
    def remark(self) -> str:
        """What feet say of the map, as a sentence; empty as long as they agree with it."""
        error = self.map_error
        if error == 0.0:
            return ''
        if math.isinf(error):
            return 'the height map does not show what the feet met: they feel their way without it'
        return f'the height map is off by up to {error:.2f} m where the feet met the ground'

    def forget_map(self) -> None:
        """Believe the map again: it is another one."""
        self._off.clear()
        self._window = None

    def model(self, under: Array, height_map: HeightMap | None) -> GroundModel:
        """
        Return what is known of the ground, with the map as far as it is to be believed.

        Parameters
        ----------
        under : ndarray, shape (n, 3)
            Where feet that stand touch the ground [m].
        height_map : HeightMap or None
            Map of the ground.

        Returns
        -------
        GroundModel
        """
        error = self.map_error
        if height_map is None or error == 0.0:
            return GroundModel.through(under, height_map)
        if math.isinf(error):
            return GroundModel.through(under)
        return GroundModel.through(under, self._part(under, height_map), error)

    def note_contact(self, leg: int, now: Stance, height_map: HeightMap | None) -> None:
        """
        Take where a foot met the ground.

        Parameters
        ----------
        leg : int
            Index of its leg.
        now : Stance
            The robot as it stood then.
        height_map : HeightMap or None
            Map of the ground.
        """
        under = self._under(now)
        others = np.arange(len(LEGS)) != leg
        believed = GroundModel.through(under[others], height_map)
        if believed.height_map is None:
            known = others & np.isfinite(self._stood)
            if not known.any():
                self._stood[others] = under[others, 2] - under[others, 2].mean()
                known = others
            level = float(np.median(self._stood[known] - under[known, 2]))
        else:
            level = -believed.shift
            self._off.append(self._distance_off(believed, under[leg], is_floor=True))
        self._stood[others] = under[others, 2] + level
        self._stood[leg] = under[leg, 2] + level
        self._points.append((float(under[leg, 0]), float(under[leg, 1]), float(self._stood[leg])))
        self.count += 1

    def note_gap(self, leg: int, now: Stance, height_map: HeightMap | None) -> None:
        """Take that a foot has met no ground as deep as it is now."""
        under = self._under(now)
        believed = GroundModel.through(np.delete(under, leg, axis=0), height_map)
        if believed.height_map is not None:
            self._off.append(self._distance_off(believed, under[leg], is_floor=False))

    def _under(self, now: Stance) -> Array:
        below: Array = now.feet - np.array([0.0, 0.0, self._robot.foot_radius])
        return below

    def _distance_off(self, ground: GroundModel, met: Array, is_floor: bool) -> float:
        """
        Return how far aside a map shows what a foot met, or that there is nothing so high [m].

        0 where it is right; infinite where no place near is.
        """
        heights = ground.height_map
        assert heights is not None
        side, tolerance = heights.resolution, self._scale * _TOLERANCE
        own = float(heights.height_at(met[:2])) + ground.shift - met[2]
        if math.isnan(own) or (own < tolerance and (own > -tolerance or not is_floor)):
            return 0.0
        reach = math.ceil(self._scale * _FARTHEST / side)
        steps = np.arange(-reach, reach + 1) * side
        around = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
        away = np.hypot(*around.T)
        around, away = around[away <= reach * side], away[away <= reach * side]
        beside = heights.height_at(met[:2] + around) + ground.shift - met[2]
        order = np.argsort(away, kind='stable')
        lowest = np.fmin.accumulate(beside[order])
        highest = np.fmax.accumulate(beside[order])
        is_possible = lowest < tolerance
        if is_floor:
            is_possible &= highest > -tolerance
        if not is_possible.any():
            return math.inf
        distance = float(away[order][int(np.argmax(is_possible))])
        return 0.0 if distance <= _NEGLIGIBLE * side else math.ceil(distance / side) * side

    def _part(self, under: Array, height_map: HeightMap) -> HeightMap:
        """Return the map around the feet: to look far around in all of it takes too long."""
        center = under[:, :2].mean(axis=0)
        whole, at = self._seen
        if (
            self._window is None
            or whole is not height_map
            or (math.dist(center, at) > self._scale * _MOVED)
        ):
            half = self._scale * _WINDOW
            self._window = height_map.part_within((*(center - half), *(center + half)))
            self._seen = height_map, center
        return self._window
