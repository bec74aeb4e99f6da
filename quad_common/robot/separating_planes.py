"""
A quick test that the robot's parts are apart: by planes that stand between them.

Two parts are at least a distance apart if their extents along some direction are. Along a few
fixed directions that is one matrix product for all samples of a motion, and settles nearly all
of them. A fan of directions settles nearly all of the rest. What remains is named, and has to be
measured.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.folding import FoldingLimits
from quad_common.robot.robot_shape import Chain, PairGroup, RobotShape

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_BEYOND_THIGH, _BEYOND_CALF, _ASIDE, _ALONG = range(4)
"""Directions of each leg: away from the body, for its thigh and for the rest; away from the
robot's middle, to its side and to its end."""

_DIRECTIONS = 4

_SLOPES = np.radians([0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0])
"""Angles of planes between body and leg, from upright to level: the best one is taken."""

_FAN = np.radians([0.0, -20.0, 20.0, -40.0, 40.0, -60.0, 60.0])
"""Directions of planes between two legs, about the line between their hips."""

_TINY = 1e-12
"""Least length of a thigh that is seen end on [m]."""


class SeparatingPlanes:
    """
    Finds the samples of a motion in which parts may be too near to one another.

    Parameters
    ----------
    shape : RobotShape
        The robot's parts.
    posture : ndarray, shape (4, 3)
        Joint angles in whose neighbourhood the robot moves [rad].
    folding : FoldingLimits
        How far each leg folds before it touches itself.
    least : float
        Distance that is too near if it is not kept [m].
    """

    def __init__(
        self, shape: RobotShape, posture: Array, folding: FoldingLimits, least: float
    ) -> None:
        self._shape = shape
        self._folding = folding
        self._least = least
        hips = np.asarray(shape.legs.hip)
        self._count = len(hips)
        side, end = (np.where(hips[:, axis] < 0.0, -1.0, 1.0) for axis in (1, 0))
        pairs = [group.legs for group in shape.groups if len(group.legs) == 2]
        first, second = np.array(pairs).T
        self._two_legs = (first, second)
        ends = np.stack([side, end], axis=1)
        # The robot's middle lies between legs of different sides or ends only.
        self._opposite = ends[first] != ends[second]
        r = shape.radii
        foot = max(r['calf'], r['foot'])
        # Of what meets at pitch axis, knee and foot; and of thigh, knee and foot alone.
        self._radii = (max(r['hip'], r['thigh']), max(r['thigh'], r['calf']), foot)
        self._beyond_radii = (r['thigh'], r['calf'], foot)
        # Hips do not move: how far each is from the middle, to its side and to its end.
        self._hips = ends * hips[:, [1, 0]] - r['hip']
        self._slopes = np.zeros((len(_SLOPES), self._count, 3))
        self._slopes[..., 1] = np.cos(_SLOPES)[:, None] * side
        self._slopes[..., 2] = -np.sin(_SLOPES)[:, None]
        self._body_beyond = self._body_extent(self._slopes)
        directions = np.zeros((self._count, _DIRECTIONS, 3))
        directions[:, _ASIDE, 1], directions[:, _ALONG, 0] = side, end
        points = np.stack(shape.legs.chain(posture))
        for column, ends in ((_BEYOND_THIGH, points[:2]), (_BEYOND_CALF, points[1:])):
            gaps = np.einsum('pki,aki->apk', ends, self._slopes).min(axis=1) - self._body_beyond
            directions[:, column] = self._slopes[gaps.argmax(axis=0), np.arange(self._count)]
        self._body = self._body_extent(directions)
        # Rows are coordinates of all legs, columns are (leg, direction).
        blocks = np.zeros((self._count, 3, self._count, _DIRECTIONS))
        for leg in range(self._count):
            blocks[leg, :, leg] = directions[leg].T
        self._matrix = blocks.reshape(3 * self._count, -1)

    def doubts(self, chain: Chain, joint_angles: Array) -> list[tuple[PairGroup, Mask]]:
        """
        Say which parts may be too near, and when.

        Parameters
        ----------
        chain : tuple of ndarray
            Pitch axes, knees and feet, each of shape (n, 4, 3) [m].
        joint_angles : ndarray, shape (n, 4, 3)
            [rad]

        Returns
        -------
        list of (PairGroup, ndarray of bool of shape (n,))
            All other parts, and these at all other samples, are as far apart as is wanted.
        """
        extents = [points.reshape(len(points), -1) @ self._matrix for points in chain]
        lowest = self._reduced([extent.min(axis=0)[None] for extent in extents])
        may_fold = self._folding.may_touch_at_all(joint_angles)
        ever = self._in_doubt(lowest, may_fold[None])[0]
        if not ever.any():
            return []
        doubtful = self._in_doubt(self._reduced(extents), self._folding.may_touch(joint_angles))
        found = []
        for k in np.flatnonzero(ever):
            group, mask = self._shape.groups[k], doubtful[:, k].copy()
            mask[mask] = self._in_doubt_by_fan(group, [points[mask] for points in chain])
            if mask.any():
                found.append((group, mask))
        return found

    def _body_extent(self, normals: Array) -> Array:
        """Return how far the body extends along directions (..., 3) [m]."""
        extent: Array = normals @ self._shape.body_center + np.abs(normals) @ self._shape.half_size
        return extent

    def _reduced(self, extents: list[Array]) -> tuple[Array, Array]:
        """
        Reduce the extents of pitch axes, knees and feet to what each leg has of room.

        Returns the room between each leg and the body, shape (n, 4), and how far the leg's
        parts are from the robot's middle at least, to its side and to its end, (n, 4, 2).
        """
        pitch, knee, foot = (e.reshape(len(e), self._count, _DIRECTIONS) for e in extents)
        thigh_radius, calf_radius, foot_radius = self._beyond_radii
        thigh = np.minimum(pitch[..., _BEYOND_THIGH], knee[..., _BEYOND_THIGH]) - thigh_radius
        rest = np.minimum(
            knee[..., _BEYOND_CALF] - calf_radius, foot[..., _BEYOND_CALF] - foot_radius
        )
        room = np.minimum(thigh - self._body[:, _BEYOND_THIGH], rest - self._body[:, _BEYOND_CALF])
        apart = np.minimum(
            np.minimum(pitch[..., _ASIDE:] - self._radii[0], knee[..., _ASIDE:] - self._radii[1]),
            np.minimum(foot[..., _ASIDE:] - self._radii[2], self._hips),
        )
        return room, apart

    def _in_doubt(self, reduced: tuple[Array, Array], folded: Mask) -> Mask:
        """Return at which samples parts may be too near, a column for each group, (n, m)."""
        room, apart = reduced
        first, second = self._two_legs
        clear = (apart[:, first] + apart[:, second] >= self._least) & self._opposite
        return np.concatenate([room < self._least, folded, ~clear.any(axis=-1)], axis=1)

    def _in_doubt_by_fan(self, group: PairGroup, points: list[Array]) -> Mask:
        """Return at which of the given samples no plane of a fan is between a group's parts."""
        if group.with_body:
            return self._near_body(group.legs[0], points)
        if len(group.legs) == 1:
            return np.ones(len(points[0]), dtype=bool)
        a, b = group.legs
        hips = np.asarray(self._shape.legs.hip)
        line = hips[a] - hips[b]
        angles = math.atan2(line[1], line[0]) + _FAN
        normals = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(_FAN))])
        gap = self._leg_extent(a, points, normals) + self._leg_extent(b, points, -normals)
        near: Mask = gap.max(axis=1) < self._least
        return near

    def _leg_extent(self, leg: int, points: list[Array], normals: Array) -> Array:
        """Return how far a leg is at least along directions (3, k), shape (n, k) [m]."""
        hip = np.asarray(self._shape.legs.hip)[leg]
        extent: Array = (hip @ normals - self._shape.radii['hip'])[None]
        for place, radius in zip(points, self._radii):
            extent = np.minimum(extent, place[:, leg] @ normals - radius)
        return extent

    def _near_body(self, leg: int, points: list[Array]) -> Mask:
        """Return at which samples a leg's thigh or the rest of it may be near the body, (n,)."""
        normals, body = self._slopes[:, leg].T, self._body_beyond[:, leg]
        pitch, knee, foot = (place[:, leg] @ normals - body for place in points)
        thigh_radius, calf_radius, foot_radius = self._beyond_radii
        thigh = np.minimum(pitch, knee).max(axis=1)
        thigh = np.maximum(thigh, self._beyond_plane_of(points[0][:, leg], points[1][:, leg]))
        rest = np.minimum(knee - calf_radius, foot - foot_radius).max(axis=1)
        near: Mask = np.minimum(thigh - thigh_radius, rest) < self._least
        return near

    def _beyond_plane_of(self, pitch: Array, knee: Array) -> Array:
        """Return how far the body is from planes through thighs, level fore and aft, (n,) [m]."""
        normals = np.zeros_like(pitch)
        side = np.where(pitch[:, 1] < 0.0, -1.0, 1.0)
        normals[:, 1] = side * (pitch[:, 2] - knee[:, 2])
        normals[:, 2] = side * (knee[:, 1] - pitch[:, 1])
        normals /= np.maximum(np.linalg.norm(normals, axis=1), _TINY)[:, None]
        beyond: Array = (normals * pitch).sum(axis=1) - self._body_extent(normals)
        return beyond
