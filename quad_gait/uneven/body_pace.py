"""
How long the body takes from one posture to another over feet that stand.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_moments import GRAVITY
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.stance import CenterOfMass, Stance
from quad_gait.uneven.path_motion import turned_by
from quad_gait.uneven.uneven_options import UnevenOptions

_SWAY = 0.13
"""Distance of the zero moment point from the center of mass while the body goes elsewhere, as a
fraction of the distance between left and right feet: what is gone faster rocks a tall robot."""

_PEAK = 10.0 / math.sqrt(3.0)
"""Largest acceleration of a motion with minimum jerk, times its duration squared, over its
distance."""

_SHARE = 0.5
"""Distance by which the zero moment point may go beyond both ends of a motion, as a fraction of
that from there to the end of the support."""

_LONGEST = 1.5
"""Duration from which on a motion gets no longer for that [s]: it is all but at rest."""

_NEGLIGIBLE = 1e-6
"""Distance that is none [m]."""

Array = NDArray[np.float64]


def _excursions(sways: Array) -> Array:
    """Return how far the zero moment point goes beyond the end, over a motion's distance."""
    times: Array = np.linspace(0.0, 1.0, 401).astype(np.float64)
    progress, speed = minimum_jerk(0.0, 1.0, times)
    beyond = progress - 1.0 - sways[:, None] * np.gradient(speed, times)
    farthest: Array = beyond.max(axis=1)
    return farthest


_SWAYS: Array = np.geomspace(1e-3, 10.0, 81).astype(np.float64)
"""Heights of the center of mass, over gravity times the square of a motion's duration."""

_EXCURSIONS = _excursions(_SWAYS)
"""Distances by which the zero moment point then goes beyond the end, over the motion's."""


class BodyPace:
    """
    Says how long shifts of the body take.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    """

    def __init__(self, robot: Robot, options: UnevenOptions) -> None:
        self._radius, self._center = robot.footprint_radius, CenterOfMass(robot)
        self._least = options.shift_time
        self._speed = robot.relative_size * options.shift_speed
        height = robot.center_height
        width = float((robot.neutral_feet[::2, 1] - robot.neutral_feet[1::2, 1]).min())
        # The square of the least time of a motion, over its distance [s^2/m].
        self._sway = _PEAK * height / (GRAVITY * _SWAY * width)
        self._fall_time = math.sqrt(height / GRAVITY)

    def duration(self, now: Stance, end: BodyPose) -> float:
        """
        Return how long the body takes, so that it goes at its speed and does not rock.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        end : BodyPose
            Where the body is to be.

        Returns
        -------
        float
            [s]
        """
        start = now.body
        moved = end.position - start.position
        distance = float(np.linalg.norm(moved))
        turned = np.abs(
            [end.roll - start.roll, end.pitch - start.pitch, turned_by(start, end)]
        ).max()
        distance = max(distance, self._radius * float(turned))
        least = max(self._least, math.sqrt(self._sway * math.hypot(*moved[:2])))
        usual = max(least, distance / self._speed)
        return max(usual, self._balanced(now.feet, self._center.over(now), moved, usual))

    def _balanced(self, feet: Array, center: Array, moved: Array, usual: float) -> float:
        """
        Return how long it takes where feet leave little room before or behind the motion.

        While it sets out the zero moment point is behind the center of mass, and ahead of it while
        the body comes to rest: beyond the feet that stand it would tip over.
        """
        (x, y), (dx, dy) = center.tolist(), moved[:2].tolist()
        length = math.hypot(dx, dy)
        if length < _NEGLIGIBLE:
            return usual
        ux, uy = dx / length, dy / length
        room = min(
            _room(feet, (x + dx, y + dy), (ux, uy)),
            _room(feet, (x, y), (-ux, -uy)),
        )
        sway = np.interp(_SHARE * room / length, _EXCURSIONS, _SWAYS)
        return min(max(usual, _LONGEST), self._fall_time / math.sqrt(sway))


def _room(feet: Array, place: tuple[float, float], towards: tuple[float, float]) -> float:
    """
    Return how far it is from a place in a direction to the end of the area between feet [m].

    That is where the way crosses the farthest line from one foot to another; 0 if it crosses none.
    """
    (x, y), (ux, uy) = place, towards
    across = [
        (ux * (fy - y) - uy * (fx - x), ux * (fx - x) + uy * (fy - y))
        for fx, fy, _ in feet.tolist()
    ]
    farthest = 0.0
    for (a, along_a), (b, along_b) in combinations(across, 2):
        if (a > 0.0) != (b > 0.0):
            farthest = max(farthest, along_a + (along_b - along_a) * a / (a - b))
    return farthest
