"""
The ground ahead of a trotting robot's feet, by a height map.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import UNKNOWN, GroundAhead, Landings
from quad_gait.ground.ground_match import GroundMatch

Array = NDArray[np.float64]

_ON_THE_WAY = np.linspace(0.0, 1.0, 7)
"""Where the ground is looked at on a foot's way, from its liftoff to its touchdown, and between a
hind foot and the fore foot on its side."""

_HIGHEST_STEP = 0.25
"""Height of a step there, over the hips' height, from which on ground counts as unknown: no trot
steps so high or so low."""

_STEEPEST = 0.45
"""Height off the plane of the feet, over the distance from the body, from which on ground without
such a step does, too."""


class KnownGround:
    """
    What a height map tells of the ground ahead.

    Parameters
    ----------
    heights : HeightMap
        The map.
    robot : Robot
        The robot.
    """

    def __init__(self, heights: HeightMap, robot: Robot) -> None:
        self._map = heights
        self._match = GroundMatch(heights, robot)
        self._pose = Pose2D(0.0, 0.0, 0.0)
        self._highest_step = _HIGHEST_STEP * robot.hip_height

    def take(self, heights: HeightMap) -> None:
        """Go on by another map."""
        self._map = heights
        self._match.take(heights)

    @property
    def match(self) -> GroundMatch:
        """Where on the map the robot is."""
        return self._match

    def locate(
        self,
        time: float,
        poses: tuple[Pose2D, Pose2D],
        feet: Array,
        bears: NDArray[np.bool_],
        stance: float,
    ) -> None:
        """Find out where on the map the robot is, as :meth:`GroundMatch.update` says."""
        self._match.update(time, poses, feet, bears, stance)
        x, y = self._match.shift
        self._pose = Pose2D(poses[0].x + x, poses[0].y + y, poses[0].yaw)

    def ahead(self, time: float, body: BodyEstimate, landings: Landings) -> GroundAhead:
        """
        Tell of the ground under feet.

        Parameters
        ----------
        time : float
            Time from the measurement to the knot at which they are planned [s].
        body : BodyEstimate
            How the body moves.
        landings : Landings
            The feet.

        Returns
        -------
        GroundAhead
            Unknown where the map does not tell, or does not fit what the feet have met.
        """
        if not self._match.is_sure:
            return UNKNOWN
        here = self._places(landings.feet, np.full(4, time), body)
        there = self._places(landings.targets, time + landings.times, body)
        # The body goes over the ground on which its feet will stand in the middle of a stance.
        middle = landings.stance / 2.0
        under = self._places(landings.neutral, np.full(4, time + middle), body)
        fore, hind = there[:2], there[2:]
        begins, ends = np.concatenate([here, hind]), np.concatenate([there, fore])
        lines = begins[:, None] + _ON_THE_WAY[:, None] * (ends - begins)[:, None]
        places = np.concatenate([here, there, under, lines.reshape(-1, 2)])
        heights = self._map.height_at(places)
        if not np.isfinite(heights).all() or not landings.stand.any():
            return UNKNOWN
        slope = np.array(landings.slope[:2])
        at_feet = heights[:4] - landings.rises - landings.feet @ slope
        plane = float(at_feet[landings.stand].mean())
        on_lines = heights[12:].reshape(len(lines), -1)
        begin, end = heights[:4, None], heights[4:8, None]
        straight = begin + _ON_THE_WAY * (end - begin)
        bumps = np.maximum((on_lines[:4] - straight).max(axis=1), 0.0)
        step = max(float(np.abs(np.diff(on_lines, axis=1)).max()), float(bumps.max()))
        # A body that goes along a slope takes the plane with it.
        climbing = float(slope @ body.velocity)
        rises = heights[4:8] - plane - landings.targets @ slope - climbing * landings.times
        body_rise = (heights[8:12] - landings.neutral @ slope).mean() - plane - climbing * middle
        if max(step, abs(body_rise)) > self._highest_step:
            return UNKNOWN
        distances = np.linalg.norm(landings.targets, axis=1)
        if (np.abs(rises) > np.maximum(_STEEPEST * distances, self._highest_step)).any():
            return UNKNOWN
        a, b, c, d = rises.tolist()
        e, f, g, h = bumps.tolist()
        return GroundAhead(True, (a, b, c, d), (e, f, g, h), float(body_rise))

    def _places(self, places: Array, times: Array, body: BodyEstimate) -> Array:
        """Return where on the map places beside the body are after times, (4, 2) [m]."""
        points = []
        for place, time in zip(places, times.tolist()):
            moved = Pose2D(body.velocity[0] * time, body.velocity[1] * time, body.turn * time)
            points.append((self._pose @ moved).transform(place))
        return np.array(points)
