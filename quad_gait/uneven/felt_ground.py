"""
What feet have met of the ground, and how far a height map may be off by that.

A map is compared with each place where a foot met the ground. Where it shows another height, it
may show the right one a little aside. If one shift along the ground makes it fit the last strides,
the map is moved by that: odometry has drifted. Else the least distance at which it shows the height
is how far it is off there, if it is a map of this ground at all. The largest of these distances
over the last strides is what a robot should reckon with. If no place near explains what a foot met,
the map is wrong by more than that, and feet find their ground better without it.
"""

from __future__ import annotations

import math
import statistics
from collections import deque

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_parts import part_within, thinned
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.state.stance import Stance
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.map_registration import MOST_STEPS, registered

Array = NDArray[np.float64]

_TOLERANCE = 0.012
"""Difference of heights that is no reason to doubt a map [m, of TITAN-VIII]."""

_FARTHEST = 0.12
"""Distance aside within which a map may be right [m, of TITAN-VIII]."""

_NEGLIGIBLE = 1.6
"""A map is not off where it is right within so many cells: feet stand on edges, and slip [1]."""

_LANDINGS = 40
"""Number of landings for which a map is not believed as before: ten strides."""

_RECENT = 24
"""Number of landings by which a map is moved: six strides, in which odometry hardly drifts."""

_NOWHERE = HeightMap(np.zeros((1, 1)), 1.0, (0.0, 0.0))
"""A map of no use."""

_WINDOW, _MOVED = 1.2, 0.3
"""Half the side of the part of a map that is looked at around a robot, and distance after which
it is another one [m, of TITAN-VIII]."""

_SLIP = 0.008
"""Change of the height at which a foot stands that is no give of the ground [m, of TITAN-VIII]."""

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
        self._stood: Array = np.full(len(LEGS), math.nan)
        self._off: deque[float] = deque(maxlen=_LANDINGS)
        self._recent: deque[Array] = deque(maxlen=_RECENT)
        self.map_shift: Array = np.zeros(2)
        """Distance by which the map is moved back to fit what was felt, along x and y [m]."""
        self._window: HeightMap | None = None
        self._seen: tuple[HeightMap | None, Array] = (None, np.zeros(2))
        self._shifted: tuple[HeightMap | None, Array, HeightMap] = (None, np.zeros(2), _NOWHERE)
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
        error, shift = self.map_error, float(np.hypot(*self.map_shift))
        if math.isinf(error):
            return 'the height map does not show what the feet met: they feel their way without it'
        if error > 0.0:
            return f'the height map is off by up to {error:.2f} m where the feet met the ground'
        if shift > 0.0:
            return f'the height map fits what the feet met where it is moved by {shift:.2f} m'
        return ''

    def forget_map(self) -> None:
        """Believe the map again: it is another one."""
        self._off.clear()
        self._window, self.map_shift = None, np.zeros(2)

    def forget(self) -> None:
        """Know nothing of where feet stood last: something else has moved the robot."""
        self.forget_map()
        self._recent.clear()
        self._stood = np.full(len(LEGS), math.nan)

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
        if height_map is None or (error == 0.0 and not self.map_shift.any()):
            return GroundModel.through(under, height_map)
        if math.isinf(error):
            return GroundModel.through(under)
        return GroundModel.through(under, self._part(under, self.moved(height_map)), error)

    def under(
        self, now: Stance, height_map: HeightMap | None, but: int | None = None
    ) -> GroundModel:
        """Return the :meth:`model` by all feet, or by all but one."""
        standing = [leg for leg in range(len(LEGS)) if leg != but]
        below = now.feet[standing] - np.array([0.0, 0.0, self._robot.foot_radius])
        return self.model(below, height_map)

    def moved(self, height_map: HeightMap) -> HeightMap:
        """Return the map where it fits what was felt."""
        if not self.map_shift.any():
            return height_map
        whole, shift, moved = self._shifted
        if whole is not height_map or shift is not self.map_shift:
            x, y = (np.array(height_map.origin) - self.map_shift).tolist()
            moved = HeightMap(height_map.heights, height_map.resolution, (x, y))
            self._shifted = height_map, self.map_shift, moved
        return moved

    def note_correction(self, correction: Pose2D, pose: Pose2D) -> None:
        """
        Take that a localiser has corrected where the robot is on the map.

        Where feet stood lately is known in the plan's frame, and so it is corrected, too. Where
        the map was moved to fit the feet, what the correction makes up for is taken off.

        Parameters
        ----------
        correction : Pose2D
            Transform from places in the plan's frame as they were to what they are now.
        pose : Pose2D
            Pose of the body now.
        """
        for k, place in enumerate(self._recent):
            x, y = correction.transform(place[None, :2])[0]
            self._recent[k] = np.array([x, y, place[2]])
        if self.map_shift.any():
            before = correction.inverse() @ pose
            shift = self.map_shift - (pose.x - before.x, pose.y - before.y)
            # The shift is known to a step of the search, no better.
            least = _NEGLIGIBLE * self._scale * _FARTHEST / MOST_STEPS
            self.map_shift = shift if np.hypot(*shift) > least else np.zeros(2)
            self._window = None

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
        place = self._felt_place(leg, now)
        self._stood[leg] = place[2]
        self._recent.append(place)
        self.count += 1
        ground = None if height_map is None else self._fitted(height_map)
        if ground is not None and height_map is not None:
            self._judge(ground, place, height_map)
            place = place - np.array([0.0, 0.0, ground.shift])
        self._points.append((float(place[0]), float(place[1]), float(place[2])))

    def note_gap(self, leg: int, now: Stance, height_map: HeightMap | None) -> None:
        """Take that a foot has met no ground as deep as it is now."""
        place = self._felt_place(leg, now)
        ground = None if height_map is None else self._fitted(height_map)
        if ground is not None:
            self._off.append(self._distance_off(ground, place, is_floor=False))

    def note_stance(self, now: Stance) -> None:
        """Take where the feet are while all of them stand."""
        below = self._below(now)
        known = np.isfinite(self._stood)
        if known.any():
            self._stood = below + float(np.median(self._stood[known] - below[known]))
            return
        self._stood = below - below.mean()
        self._recent.extend(np.column_stack([now.feet[:, :2], self._stood]))

    def slip(self, now: Stance, leg: int) -> float:
        """Return by how much a foot other than that leg's is off the height at which it stood."""
        # At every measurement of a swing: NumPy takes twenty times as long for three numbers.
        off: list[float] = (self._below(now) - self._stood).tolist()
        others = [off[k] for k in range(len(LEGS)) if k != leg]
        if any(map(math.isnan, others)):
            return 0.0
        middle = statistics.median(others)
        return float(max(abs(number - middle) for number in others))

    def is_slipping(self, now: Stance, leg: int) -> bool:
        """Tell whether a foot other than that leg's slides off what it stood on."""
        return self.slip(now, leg) > self._robot.relative_size * _SLIP

    def _below(self, now: Stance) -> Array:
        """Return the heights of the ground below the feet, from base_link, shape (4,) [m]."""
        heights: Array = now.feet[:, 2] - self._robot.foot_radius
        return heights

    def _felt_place(self, leg: int, now: Stance) -> Array:
        """Return where a foot is, with a height over where the robot began, shape (3,) [m]."""
        if np.isnan(self._stood).any():
            self.note_stance(now)
        below, others = self._below(now), np.arange(len(LEGS)) != leg
        level = float(np.median(self._stood[others] - below[others]))
        self._stood[others] = below[others] + level
        return np.array([*now.feet[leg, :2], below[leg] + level])

    def _fitted(self, height_map: HeightMap) -> GroundModel | None:
        """Return the map, at the height at which it fits what was felt; None if unknown there."""
        felt, moved = np.array(self._recent).reshape(-1, 3), self.moved(height_map)
        off = felt[:, 2] - moved.height_at(felt[:, :2])
        if not np.isfinite(off).any():
            return None
        return GroundModel(felt[-1], np.zeros(2), moved, float(np.nanmedian(off)))

    def _judge(self, ground: GroundModel, met: Array, height_map: HeightMap) -> None:
        """Compare the map with what a foot has met; move it where it fits better elsewhere."""
        off = self._distance_off(ground, met, is_floor=True)
        self._off.append(off)
        if off == 0.0:
            return
        felt, scale = np.array(self._recent), self._scale
        reach, tolerance = scale * _FARTHEST, scale * _TOLERANCE
        fit = registered(height_map, felt, self.map_shift, reach, tolerance)
        if fit is None:
            return
        self.map_shift, self._window = fit.shift, None
        fitted = self._fitted(height_map)
        if fitted is not None:
            self._off.clear()
            self._off.extend(self._distance_off(fitted, place, is_floor=True) for place in felt)

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
        side = max(side, self._scale * _FARTHEST / MOST_STEPS)
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
            part = part_within(height_map, (*(center - half), *(center + half)))
            # A map that is off is not known to the millimeter.
            self._window = thinned(part, self._scale * _FARTHEST / MOST_STEPS)
            self._seen = height_map, center
        return self._window
