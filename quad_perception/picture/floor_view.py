"""
The floor as seen from above: pictures straightened to a plan of the floor, by tables.

The plan is finer than the map by a whole number: each cell of the map is a square of
`parts` x `parts` points. It lies as the map does, its row 0 at the bottom, and holds it. On
the plan a camera's perspective is simple: what is at height h above the floor point p is seen at

    p' = N + (p - N) / u,   u = 1 - h/H

with N the floor point below the camera and H the camera's height. Upright edges lie along
rays from N.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_common.vision.camera import CameraModel

Array = NDArray[np.float64]
Mask = NDArray[np.uint8]

Box = tuple[float, float, float, float]
"""x_min, y_min, x_max, y_max [m]."""

_MOST_CELLS = 2**20
"""Largest number of cells of a plan's extent: tables of more would take gigabytes."""
_MOST_POINTS = 2**23
"""Largest number of points of a plan. A camera of 2048 x 2048 needs fewer."""
_BORDER = 60
"""Points along each side of the picture that are taken to find the floor's extent."""
_TOO_FAR = 5.0
"""The visible floor may reach this many camera heights from below the camera."""


class FloorView:
    """
    What is computed once for a camera and a map's cells.

    Parameters
    ----------
    camera : CameraModel
        It must be above the floor.
    resolution : float
        Side of a cell of the map [m].
    bounds : tuple of float, optional
        x_min, y_min, x_max, y_max of the map in the world [m]; by default what the camera
        sees of the floor. Both are brought to whole cells outward.
    largest_height : float
        Largest height of obstacles [m]. The plan reaches beyond the map to where tops are seen.

    Raises
    ------
    ParameterError
        If an argument is not valid, or if the camera sees the horizon and no bounds are given.
    """

    def __init__(
        self,
        camera: CameraModel,
        resolution: float = 0.05,
        bounds: Box | None = None,
        largest_height: float = 1.2,
    ) -> None:
        _check(camera, resolution, largest_height)
        self.camera = camera
        self.resolution = resolution
        self.largest_height = largest_height
        visible = _visible_floor(camera)
        if bounds is None and visible is None:
            raise ParameterError(
                'bounds', None, 'given where the horizon is seen: x_min, y_min, x_max, y_max'
            )
        box = visible if bounds is None else _checked(bounds)
        assert box is not None
        first, last = _whole_cells(box, resolution)
        columns, rows = last - first
        self.shape = (int(rows), int(columns))
        """Rows and columns of the map."""
        self.origin = Pose2D(float(first[0] * resolution), float(first[1] * resolution), 0.0)
        """Pose of the map, at its lower left corner."""
        box = _with_tops(resolution * np.array([first, last]), camera, largest_height)
        plan_first, plan_last = _whole_cells(
            box if visible is None else _overlap(box, visible), resolution
        )
        plan_first, plan_last = np.minimum(plan_first, first), np.maximum(plan_last, last)
        if not (plan_last - plan_first).prod() <= _MOST_CELLS:
            raise ParameterError('resolution', resolution, 'one with fewer cells on this floor')
        self._window = np.array([first - plan_first, last - plan_first])
        self.parts = max(2, round(resolution / _pixel_on_floor(camera) + 0.1))
        """Points of the plan along a cell."""
        points = int((plan_last - plan_first).prod()) * self.parts**2
        if points > _MOST_POINTS:
            raise ParameterError(
                'camera',
                f'{points} points on its plan of the floor',
                f'one with {_MOST_POINTS} at most',
            )
        self.step = resolution / self.parts
        """Distance between points of the plan [m]."""
        self.corner = plan_first * resolution
        """Lower left corner of the plan in the world, shape (2,) [m]."""
        self.nadir: Array = (camera.position[:2] - self.corner) / self.step
        """The floor point below the camera: column and row on the plan, shape (2,)."""
        columns, rows = (plan_last - plan_first) * self.parts
        self.seen, self._table = self._looked_up(int(columns), int(rows))
        """Points of the plan that are in the picture, shape (rows, columns)."""

    def _looked_up(self, columns: int, rows: int) -> tuple[NDArray[np.bool_], tuple[Any, Any]]:
        """Find which points of the plan are in the picture, and where; a table for OpenCV."""
        camera = self.camera
        at = np.indices((rows, columns)).reshape(2, -1)[::-1].T + 0.5
        places = at * self.step + self.corner
        pixels = camera.project(np.column_stack((places, np.zeros(len(places)))))
        with np.errstate(invalid='ignore'):
            inside = (
                (pixels >= 0.0).all(axis=1)
                & (pixels[:, 0] <= camera.width)
                & (pixels[:, 1] <= camera.height)
            )
        if camera.distortion.any():
            # Far outside the picture the lens's polynomial turns back into it.
            back = camera.on_plane(pixels[inside])
            inside[inside] = np.linalg.norm(back - places[inside], axis=1) < self.step
        pixels[~inside] = -9.0
        table = (pixels - 0.5).astype(np.float32).reshape(rows, columns, 2)
        first, second = cv2.convertMaps(table, None, cv2.CV_16SC2)
        return inside.reshape(rows, columns), (first, second)

    def straighten(self, *layers: Mask) -> tuple[Mask, ...]:
        """
        Bring layers of a picture to the plan, all at once: that takes less time.

        Parameters
        ----------
        *layers : ndarray of uint8, shape (camera.height, camera.width)
            For example masks.

        Returns
        -------
        tuple of ndarray of uint8, shape of the plan
            One for each layer; 0 where nothing is seen.
        """
        together = cv2.merge(layers) if len(layers) > 1 else layers[0]
        plan = cv2.remap(together, *self._table, cv2.INTER_LINEAR)
        return tuple(cv2.split(plan))

    def to_plan(self, points: Array) -> Array:
        """Bring points of the world [m], shape (n, 2), to columns and rows of the plan."""
        on_plan: Array = (points - self.corner) / self.step
        return on_plan

    def fraction_of_cells(self, mask: Mask) -> NDArray[np.float32]:
        """
        Find which fraction of each cell of the map is set on the plan.

        Parameters
        ----------
        mask : ndarray of uint8, shape of the plan
            0 or 255.

        Returns
        -------
        ndarray of float32, shape of the map
            From 0 to 1.
        """
        (left, low), (right, high) = self._window * self.parts
        height, width = self.shape
        fractions: NDArray[np.float32] = cv2.resize(
            mask[low:high, left:right].astype(np.float32),
            (width, height),
            interpolation=cv2.INTER_AREA,
        )
        return fractions / np.float32(255.0)


def _check(camera: CameraModel, resolution: float, largest_height: float) -> None:
    """Raise ParameterError if a camera cannot be used, or a number is not valid."""
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise ParameterError('resolution', resolution, 'above 0')
    if not camera.position[2] > 0.0:
        raise ParameterError('position', camera.position.tolist(), 'above the floor')
    if not 0.0 < largest_height < camera.position[2]:
        raise ParameterError(
            'largest_height', largest_height, f'between 0 and {camera.position[2]:g}'
        )


def _checked(bounds: Box) -> Box:
    x_min, y_min, x_max, y_max = bounds
    if not (all(map(math.isfinite, bounds)) and x_min < x_max and y_min < y_max):
        raise ParameterError('bounds', bounds, 'x_min, y_min, x_max, y_max in this order of size')
    return bounds


def _whole_cells(box: Box, resolution: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the columns and rows of the first cells of a box, and after the last ones."""
    x_min, y_min, x_max, y_max = (value / resolution for value in box)
    if not max(map(abs, (x_min, y_min, x_max, y_max))) < 1e9:
        raise ParameterError('resolution', resolution, 'one with fewer cells on this floor')
    first = np.floor(np.array([x_min, y_min]) + 1e-6).astype(np.int64)
    last = np.ceil(np.array([x_max, y_max]) - 1e-6).astype(np.int64)
    return first, np.maximum(last, first + 1)


def _with_tops(corners: Array, camera: CameraModel, height: float) -> Box:
    """Return the box on whose floor all is seen that stands in another one."""
    nadir = camera.position[:2]
    enlarged = 1.0 / (1.0 - height / float(camera.position[2]))
    seen = np.vstack((corners, nadir + (corners - nadir) * enlarged))
    (x_min, y_min), (x_max, y_max) = seen.min(axis=0), seen.max(axis=0)
    return float(x_min), float(y_min), float(x_max), float(y_max)


def _overlap(a: Box, b: Box) -> Box:
    return max(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3])


def _visible_floor(camera: CameraModel) -> Box | None:
    """Return the box that the floor in the picture just fits in; None if it has no end."""
    along = np.linspace(0.0, 1.0, _BORDER)
    zero, one = np.zeros(_BORDER), np.ones(_BORDER)
    sides = [(along, zero), (along, one), (zero, along), (one, along)]
    border = np.concatenate([np.column_stack(side) for side in sides])
    places = camera.on_plane(border * (camera.width, camera.height))
    reach = np.linalg.norm(places - camera.position[:2], axis=1)
    if not (reach <= _TOO_FAR * camera.position[2]).all():
        return None
    (x_min, y_min), (x_max, y_max) = places.min(axis=0), places.max(axis=0)
    return float(x_min), float(y_min), float(x_max), float(y_max)


def _pixel_on_floor(camera: CameraModel) -> float:
    """Return the side of a pixel on the floor, in the middle of the picture [m]."""
    middle = np.array([camera.width / 2.0, camera.height / 2.0])
    places = camera.on_plane(middle + [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    side = float(np.linalg.norm(places[1:] - places[0], axis=1).mean())
    if not math.isfinite(side):
        raise ParameterError('rotation', camera.rotation.tolist(), 'one that looks at the floor')
    return side
