"""
Where on a height map a trotting robot is, by the heights at which its feet stand.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.ground.footholds import Footholds

Array = NDArray[np.float64]

_DRIFT = 0.07
"""Standard deviation of odometry after the first metre [m]; it grows with the root."""

_SCALE, _SCALE_DRIFT = 0.05, 0.03
"""Standard deviations of the part of its way by which odometry is off all the time, at first and
of its change after the first metre."""

_RISING = 0.06
"""The same of the body's height after the first second, over the hips' height."""

_FELT = 0.01
"""Standard deviation of a height at which a foot stands, over the hips' height: one for the
duration of its stance, however often it is measured."""

_OUTLIER = 0.1
"""Difference from the map, over the hips' height, from which on heights count less: feet stand on
edges."""

_MISFIT = 0.15
"""Mean difference from the map, over the hips' height, from which on it is not believed."""

_FAIR = 0.025
"""The same, up to which it is, even where level ground would fit better."""

_FINE = 0.004
"""Mean difference up to which a map that is believed stays so, however small the robot: feet and
cells are no finer [m]."""

_SURE_AGAIN = 0.5
"""Fraction of both that a map must keep to be believed again."""

_ASTRAY = 3.0
"""Standard deviations of odometry's drift from which on a robot is not where it seems to be."""

_ENOUGH = 4
"""Number of footholds that a map must know to be believed."""

_AT_FIRST = 0.01
"""Standard deviation of the place at the beginning [m]."""

_FARTHEST = 0.3
"""Standard deviation of the place, over the hips' height, at most: after a long way over level
ground one foot on a gentle rise is not to move it by more."""

_LOST_HEIGHT = 0.1
"""The same of the height after no foot told of it, over the hips' height."""


class GroundMatch:
    """
    Follows the shift s between a place as odometry has it and where it is on a height map.

    A trotting robot drifts by its own odometry, and feet that are put down for the ground beside
    them meet it too early or too late. But they tell where the robot is: a foot that bears load at
    p, its center at the height z over that of the body, which is at h, stands on the map m::

        m(p + s) = h + z - r sqrt(1 + |grad m|^2)

    with the radius r of its ball. An extended Kalman filter of s and h takes these (terrain
    contour matching; haptic localisation, R. Buchanan et al., IROS 2020, with a filter in place of
    particles). h follows the feet that stood at two instants, as leg odometry does; its error, and
    that of s, grow in between. Odometry of one robot on one ground errs the same way for a while:
    it goes too far or too little by a, and to one side by b, of its displacement d, so s follows::

        s = s + [[a, -b], [b, a]] d

    Parameters
    ----------
    heights : HeightMap
        The map.
    robot : Robot
        The robot.
    """

    def __init__(self, heights: HeightMap, robot: Robot) -> None:
        self._map = heights
        self._radius, self._size = robot.foot_radius, robot.hip_height
        self._height = 0.0
        self._last: tuple[float, Pose2D, Pose2D, Array, NDArray[np.bool_]] | None = None
        self._footholds = Footholds()
        # Variance by which odometry may have drifted in all [m^2].
        self._drifted = _AT_FIRST**2
        self._begin()

    def _begin(self) -> None:
        """Know nothing of where the robot is, but by odometry."""
        # Shift x, y and what the height by feet is off that on the map [m]; a and b.
        self._state: Array = np.zeros(5)
        self._covariance: Array = np.diag(
            np.square([_AT_FIRST, _AT_FIRST, self._size, _SCALE, _SCALE])
        )
        self._is_placed = self._is_sure = False

    def _begin_if_astray(self) -> None:
        """Begin anew where a map that does not fit has led the robot far from its odometry."""
        if float(self._state[:2] @ self._state[:2]) > _ASTRAY**2 * self._drifted:
            self._begin()
            self._footholds.forget_shifts()

    @property
    def shift(self) -> tuple[float, float]:
        """Distance from a place as odometry has it to where it is on the map, x and y [m]."""
        return float(self._state[0]), float(self._state[1])

    @property
    def is_sure(self) -> bool:
        """Whether the map fits what the feet have met lately, and no worse than a level one."""
        return self._is_sure

    def take(self, heights: HeightMap) -> None:
        """
        Go on by another map.

        Parameters
        ----------
        heights : HeightMap
            What fits the last footholds is believed at once.
        """
        self._map = heights
        if not self._is_sure:
            # What did not fit may have led astray.
            self._begin()
            self._footholds.forget_shifts()
        off, _ = self._footholds.off(heights, self._radius)
        self._is_placed = len(off) > 0
        if self._is_placed:
            # Its heights may count from elsewhere.
            self._state[2] = -float(off.mean())
        self._covariance[2, 2] += (_LOST_HEIGHT * self._size) ** 2
        self._judge()

    def update(
        self,
        time: float,
        poses: tuple[Pose2D, Pose2D],
        feet: Array,
        bears: NDArray[np.bool_],
        stance: float,
    ) -> None:
        """
        Take notice of feet.

        Parameters
        ----------
        time : float
            When they were measured [s].
        poses : tuple of Pose2D
            The body's on the map, and by odometry alone.
        feet : ndarray, shape (4, 3)
            Their centers beside the level body [m].
        bears : ndarray of bool, shape (4,)
            Which of them stand and bear load.
        stance : float
            Duration of a stance [s].
        """
        dt = self._go_on(time, poses, feet, bears)
        by_odometry = poses[0].transform(feet[:, :2])
        places = by_odometry + self.shift
        ground, slope = self._map.height_at(places), self._map.slope_at(places)
        known = bears & np.isfinite(ground) & np.isfinite(slope).all(axis=1)
        over = self._radius * np.sqrt(1.0 + (slope**2).sum(axis=1))
        felt = self._height + feet[:, 2] - over
        if not self._is_placed and known.any():
            # The map's heights may count from anywhere.
            self._state[2] = float((ground[known] - felt[known]).mean())
            self._is_placed = True
        usual = (_FELT * self._size) ** 2 * max(1.0, stance / max(dt, 1e-3))
        for k in np.flatnonzero(known).tolist():
            row = np.array([slope[k, 0], slope[k, 1], -1.0, 0.0, 0.0])
            off = float(felt[k] + self._state[2] - ground[k])
            far = max(1.0, abs(off) / (_OUTLIER * self._size))
            told = self._covariance @ row
            gain = told / (float(row @ told) + usual * far * far)
            self._state = self._state + gain * off
            self._covariance = self._covariance - np.outer(gain, told)
        self._begin_if_astray()
        if self._footholds.note(by_odometry, self._state[:2], self._height + feet[:, 2], bears):
            self._judge()

    def _judge(self) -> None:
        """Find out whether the map is to be believed."""
        off, unlevel = self._footholds.off(self._map, self._radius)
        if len(off) < _ENOUGH:
            self._is_sure = False
            return
        misfit, level = (float(np.abs(d - d.mean()).mean()) for d in (off, unlevel))
        most = min(max(level, _FAIR * self._size), _MISFIT * self._size)
        self._is_sure = misfit < (max(most, _FINE) if self._is_sure else _SURE_AGAIN * most)

    def _go_on(
        self, time: float, poses: tuple[Pose2D, Pose2D], feet: Array, bears: NDArray[np.bool_]
    ) -> float:
        """Take notice of a motion, and return the time that it took [s]."""
        last, self._last = self._last, (time, *poses, feet, bears)
        if last is None:
            return 0.0
        then, before, by_odometry, stood_at, stood = last
        dt = max(time - then, 0.0)
        moved = poses[1].distance_to(by_odometry)
        # What else moves the pose is somebody's correction of odometry: the feet find out.
        corrected = math.hypot(*_difference(poses[0], before, poses[1], by_odometry))
        self._drift(poses[0].x - before.x, poses[0].y - before.y)
        growth = _DRIFT**2 * moved + corrected**2
        self._drifted += growth
        scale = _SCALE_DRIFT**2 * moved
        self._covariance += np.diag([growth, growth, 0.0, scale, scale])
        self._bound()
        both = bears & stood
        if both.any():
            self._height -= float((feet[both, 2] - stood_at[both, 2]).mean())
            self._covariance[2, 2] += (_RISING * self._size) ** 2 * dt
        else:
            self._covariance[2, 2] += (_LOST_HEIGHT * self._size) ** 2
        return dt

    def _drift(self, x: float, y: float) -> None:
        """Let the shift go on as it did, in a displacement by odometry [m]."""
        step = np.eye(5)
        step[:2, 3:] = [[x, -y], [y, x]]
        self._state = step @ self._state
        self._covariance = step @ self._covariance @ step.T

    def _bound(self) -> None:
        """Keep what nothing has told of for long from being wholly open."""
        place = _FARTHEST * self._size
        most = np.array([place, place, math.inf, _SCALE, _SCALE])
        kept = np.minimum(1.0, most / np.sqrt(np.diag(self._covariance)))
        self._covariance *= np.outer(kept, kept)


def _difference(
    now: Pose2D, before: Pose2D, odometry: Pose2D, earlier: Pose2D
) -> tuple[float, float]:
    """Return how a pose moved otherwise than by odometry, x and y [m]."""
    expected = before @ (earlier.inverse() @ odometry)
    return now.x - expected.x, now.y - expected.y
