"""
Where obstacles stand: from their silhouettes on the floor to their footprints.

An obstacle of height h with the footprint F covers on the plan of the floor
(:mod:`quad_perception.picture.floor_view`) its sides and its top. The top is F, displaced away from
the point N below the camera and enlarged:

    T = N + (F - N) / u,   u = 1 - h/H

Nothing hides the top's far edge, and the light from above makes the top brighter than the
sides. So tops are split from sides by brightness, u is what the side measures along rays
from N,

    u = |p - N| / |t - N|,   t on the top's near edge, p on the floor's edge below it,

and F is the top brought back by u. What the silhouette covers besides F is hidden floor,
of which nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from quad_perception.picture.floor_view import FloorView

Array = NDArray[np.float64]
Mask = NDArray[np.uint8]

_SIDE, _TOP = 1, 3
"""What is seen of an obstacle."""
_BRIGHT = 0.9
"""Least brightness of tops, as a fraction of the brightest part of a blob."""
_LEVEL = 92.0
"""The percentile of a blob's values that is the brightness of its top."""
_SAME_LIGHT = 0.75
"""Least brightness of a blob that shows a top, as a fraction of the brightest one."""
_RAYS = 40
"""Largest number of rays that measure a side."""
_STEP = 0.5
"""Distance between samples along a ray [points of the plan]."""
_INSIDE = 2.5
"""Rays begin so far inside the top [points of the plan]."""
_LEAST_BLOB = 0.05
"""Blobs of a smaller area than the square of this are noise [m]."""
_LEAST_RADIUS = 8.0
"""Sides nearer to below the camera are too short to be measured [points of the plan]."""
_SAME_HEIGHT = 0.08
"""Rays whose heights differ by more are of different obstacles [m]."""
_LEAST_GROUP = 0.2
"""Least fraction of a top's rays that makes an obstacle of its own."""
_GRAZING = 3.0
"""A side that is shorter is no proof of a second obstacle [points of the plan]."""
_LEAST_RAYS = 4
"""Fewer rays than this that end on the floor do not make a height."""


@dataclass(frozen=True, eq=False)
class Footprint:
    """An obstacle on the floor."""

    mask: Mask
    """255 where it stands, of a part of the plan."""
    corner: tuple[int, int]
    """Column and row on the plan of the part's first point."""
    height: float | None
    """Height of the obstacle [m]; None if no side of it is seen down to the floor."""


@dataclass(frozen=True)
class FootprintFinder:
    """
    Finds the footprints of obstacles.

    Parameters
    ----------
    view : FloorView
        Camera and plan.
    assumed_height : float
        Height of obstacles whose sides are not seen [m]: below the camera, or behind others.
    least_size : float
        What is smaller in both directions is no obstacle but a speck [m].
    """

    view: FloorView
    assumed_height: float = 0.6
    least_size: float = 0.08

    def find(self, obstacles: Mask, value: Mask) -> list[Footprint]:
        """
        Find where obstacles stand.

        Parameters
        ----------
        obstacles : ndarray of uint8, shape of the plan
            255 where an obstacle is seen.
        value : ndarray of uint8, shape of the plan
            Brightness.

        Returns
        -------
        list of Footprint
            One for each top that is seen.
        """
        tops = self._tops(obstacles, value)
        # Nothing, a side, or a top.
        surfaces = cv2.bitwise_or(cv2.bitwise_and(obstacles, _SIDE), cv2.bitwise_and(tops, _TOP))
        return [
            self._brought_back(part, corner, u, height)
            for top, corner in self._components(tops)
            for part, u, height in self._scaled(top, corner, surfaces)
        ]

    def _tops(self, obstacles: Mask, value: Mask) -> Mask:
        """Return 255 where an obstacle's top is seen."""
        tops = np.zeros_like(obstacles)
        parts = []
        for label, part in _parts(obstacles, (_LEAST_BLOB / self.view.step) ** 2):
            values = value[part][label]
            parts.append((label, part, float(np.percentile(values, _LEVEL))))
        brightest = max((level for _, _, level in parts), default=0.0)
        for label, part, level in parts:
            threshold = _BRIGHT * max(level, _SAME_LIGHT * brightest)
            tops[part][label & (value[part] >= threshold)] = 255
        # What noise has made is smaller than a top.
        return np.asarray(cv2.bitwise_and(cv2.medianBlur(tops, 5), obstacles), np.uint8)

    def _components(self, tops: Mask) -> Iterator[tuple[Mask, tuple[int, int]]]:
        """Yield the mask of each top, with a margin of two, and its corner on the plan."""
        for label, (rows, columns) in _parts(tops, (self.least_size / self.view.step) ** 2):
            own = label.astype(np.uint8) * np.uint8(255)
            bordered = cv2.copyMakeBorder(own, 2, 2, 2, 2, cv2.BORDER_CONSTANT)
            yield bordered, (columns.start - 2, rows.start - 2)

    def _scaled(
        self, top: Mask, corner: tuple[int, int], surfaces: Mask
    ) -> Iterator[tuple[Mask, float, float | None]]:
        """Yield the parts of a top that have one height each: mask, u, and height if measured."""
        camera_height = float(self.view.camera.position[2])
        assumed = 1.0 - self.assumed_height / camera_height
        points, inward, radii = self._near_edge(top, corner)
        if len(points) < _LEAST_RAYS:
            yield top, assumed, None
            return
        reach = radii.max() * self.view.largest_height / camera_height
        along = np.arange(-_INSIDE, reach + 2.0, _STEP) + _STEP / 2.0
        surface = _looked_up(surfaces, points[:, None] + along[:, None] * inward[:, None])
        # The ray: own top, own side, then the floor or the top of a nearer obstacle.
        left_top = np.maximum.accumulate(surface != _TOP, axis=1)
        left_side = np.maximum.accumulate(left_top & (surface != _SIDE), axis=1)
        first_side, last_side = (np.argmax(state, axis=1) for state in (left_top, left_side))
        has_ended = left_side[:, -1]
        ends_on_floor = has_ended & (surface[np.arange(len(points)), last_side] == 0)
        edge_radii = radii + _INSIDE - _STEP * first_side
        ratios = _STEP * (last_side - first_side) / edge_radii
        measured, weights = ratios[ends_on_floor], edge_radii[ends_on_floor]
        groups = _groups(measured, np.maximum(2.0 / weights, _SAME_HEIGHT / camera_height))
        # Rays that graze an obstacle along its edge see nothing of its side.
        if len(groups) > 1:
            lengths = measured * weights
            sides = [group for group in groups if np.median(lengths[group]) > _GRAZING]
            groups = sides or [max(groups, key=len)]
        if not groups:
            longest = float(ratios[has_ended].max()) if has_ended.any() else 0.0
            yield top, min(assumed, 1.0 - longest), None
            return
        parts = [top]
        if len(groups) > 1:
            rays = [inward[ends_on_floor][group] for group in groups]
            parts = self._split(top, corner, rays)
        for part, group in zip(parts, groups):
            ratio = float(np.average(measured[group], weights=weights[group]))
            yield part, 1.0 - ratio, camera_height * ratio

    def _split(self, top: Mask, corner: tuple[int, int], rays: list[Array]) -> list[Mask]:
        """Split a top of two obstacles: each point belongs to the group with the nearest ray."""
        rows, columns = np.nonzero(top)
        outward = np.column_stack((columns, rows)) + 0.5 + corner - self.view.nadir
        outward /= np.maximum(np.hypot(outward[:, 0], outward[:, 1]), 1e-9)[:, None]
        nearest = np.argmax([(-outward @ group.T).max(axis=1) for group in rays], axis=0)
        parts = []
        for k in range(len(rays)):
            part = np.zeros_like(top)
            part[rows[nearest == k], columns[nearest == k]] = 255
            parts.append(part)
        return parts

    def _near_edge(self, top: Mask, corner: tuple[int, int]) -> tuple[Array, Array, Array]:
        """
        Find the points of a top's edge that rays to below the camera leave it at.

        Returns
        -------
        points : ndarray, shape (n, 2)
            Columns and rows on the plan.
        inward : ndarray, shape (n, 2)
            Unit vectors to below the camera.
        radii : ndarray, shape (n,)
            Distances to there [points of the plan].
        """
        edge = cv2.subtract(top, cv2.erode(top, None))
        rows, columns = np.nonzero(edge)
        points: Array = np.column_stack((columns, rows)).astype(np.float64) + 0.5 + corner
        inward: Array = self.view.nadir - points
        radii: Array = np.hypot(inward[:, 0], inward[:, 1])
        inward /= np.maximum(radii, 1e-9)[:, None]
        leaves = _looked_up(top, points + 1.5 * inward - corner) == 0
        is_below = _looked_up(top, (self.view.nadir - corner)[None])[0] > 0
        near = np.flatnonzero(leaves & (radii > _LEAST_RADIUS) & ~is_below)
        if len(near) > _RAYS:
            near = near[np.linspace(0, len(near) - 1, _RAYS).astype(int)]
        return points[near], inward[near], radii[near]

    def _brought_back(
        self, top: Mask, corner: tuple[int, int], u: float, height: float | None
    ) -> Footprint:
        """Return the footprint whose top this is."""
        nadir = self.view.nadir
        first = np.floor(nadir + u * (np.array(corner) - nadir)).astype(int)
        last = np.ceil(nadir + u * (np.array(corner) + top.shape[::-1] - nadir)).astype(int)
        first = np.clip(first, 0, self.view.seen.shape[::-1])
        last = np.clip(last, first, self.view.seen.shape[::-1])
        size = last - first
        if not size.all():
            return Footprint(np.zeros((0, 0), np.uint8), (int(first[0]), int(first[1])), height)
        # Point q of the part was seen at t: t - N = (q - N)/u, with centers at halves.
        shift = nadir + (first + 0.5 - nadir) / u - corner - 0.5
        matrix = np.array([[1.0 / u, 0.0, shift[0]], [0.0, 1.0 / u, shift[1]]])
        mask = cv2.warpAffine(
            top, matrix, (int(size[0]), int(size[1])), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        )
        _, mask = cv2.threshold(mask, 127, 255, cv2.THRESH_BINARY)
        return Footprint(mask, (int(first[0]), int(first[1])), height)


def _parts(
    mask: Mask, least_area: float
) -> Iterator[tuple[NDArray[np.bool_], tuple[slice, slice]]]:
    """Yield each connected part of a mask with at least an area: where in which rows, columns."""
    # Contours take a fifth of the time that cv2.connectedComponents takes.
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for outline in outlines:
        x, y, w, h = cv2.boundingRect(outline)
        if w * h < least_area:
            continue
        part = (slice(y, y + h), slice(x, x + w))
        filled = np.zeros((h, w), np.uint8)
        cv2.drawContours(filled, [outline], -1, 255, cv2.FILLED, offset=(-x, -y))
        label = cv2.bitwise_and(filled, mask[part]) > 0
        if np.count_nonzero(label) >= least_area:
            yield label, part


def _groups(values: Array, tolerances: Array) -> list[NDArray[np.int64]]:
    """
    Put values that agree into groups.

    Parameters
    ----------
    values : ndarray, shape (n,)
        What was measured.
    tolerances : ndarray, shape (n,)
        Amount by which a value may differ from the next one of its group.

    Returns
    -------
    list of ndarray of int
        Indices of the values of each group that has enough of them.
    """
    if len(values) < _LEAST_RAYS:
        return []
    order = np.argsort(values)
    ends = np.flatnonzero(np.diff(values[order]) > tolerances[order][1:]) + 1
    groups = np.split(order, ends)
    least = max(_LEAST_RAYS, _LEAST_GROUP * len(values))
    large = [group for group in groups if len(group) >= least]
    if not large:
        return [max(groups, key=len)]
    kept = []
    for group in large:
        # Where a ray grazes the obstacle, its edge lies anywhere.
        middle = values[group[len(group) // 2]]
        kept.append(group[np.abs(values[group] - middle) <= 2.0 * tolerances[group]])
    return kept


def _looked_up(mask: Mask, places: Array) -> Mask:
    """Return a mask's values at places, columns and rows with fractions; 0 outside."""
    height, width = mask.shape
    at = np.floor(places).astype(np.int32)
    columns, rows = at[..., 0], at[..., 1]
    # Below zero counts as far above it.
    inside = (columns.view(np.uint32) < width) & (rows.view(np.uint32) < height)
    values = mask.ravel()[np.where(inside, rows * width + columns, 0)]
    found: Mask = values * inside.view(np.uint8)
    return found
