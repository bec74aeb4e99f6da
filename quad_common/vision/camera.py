"""
A pinhole camera with lens distortion: from points in the world to pixels and back.

The frame of the camera is ROS's optical one (REP-103): x to the right of the picture, y
down, z along the view. Lens distortion is OpenCV's model of five numbers, ``plumb_bob``
in sensor_msgs/CameraInfo.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import ParameterError
from quad_common.quantity import COORDINATE, Quantity

Array = NDArray[np.float64]

QUANTITIES = {
    'side': Quantity(1, 32768, 'pixels'),
    'focal_length': Quantity(1.0, 1e6, 'pixels'),
    'principal_point': Quantity(-1e5, 1e5, 'pixels'),
    'position': COORDINATE,
    'distortion': Quantity(-1e3, 1e3),
}
"""Ranges of a camera's numbers."""

MOST_PIXELS = 2**26
"""Largest number of pixels of a picture: 8192 x 8192."""

_ROUNDS = 50
"""Largest number of steps by which light is traced back through a lens."""

_EXACT = 1e-6
"""Error within which light is traced back [pixels]."""

_SLOW = 0.5
"""A step that leaves so much of the error is made shorter, or longer, from then on."""

_LOOK_EVERY = 6
"""Rounds after which a pixel is given up that is hardly nearer."""


@dataclass(frozen=True, eq=False)
class CameraModel:
    """
    What maps the world to a picture.

    Raises
    ------
    ParameterError
        If a field is not what its description says.
    """

    width: int
    """Width of the picture [pixels]."""
    height: int
    """Height of the picture [pixels]."""
    matrix: Array
    """Focal lengths and principal point, K of sensor_msgs/CameraInfo, shape (3, 3) [pixels]."""
    rotation: Array
    """Rotation from the camera's frame to the world, shape (3, 3)."""
    position: Array
    """Position of the camera in the world, shape (3,) [m]."""
    distortion: Array
    """k1, k2, p1, p2, k3, shape (5,)."""

    def __post_init__(self) -> None:
        """Check shapes, and whether the rotation is one."""
        self._check_size()
        for name, shape in (
            ('matrix', (3, 3)),
            ('rotation', (3, 3)),
            ('position', (3,)),
            ('distortion', (5,)),
        ):
            value = getattr(self, name)
            if value.shape != shape or not np.isfinite(value).all():
                raise ParameterError(name, value.tolist(), f'finite numbers of shape {shape}')
        for name, values in (
            ('focal_length', np.diag(self.matrix)[:2]),
            ('principal_point', self.matrix[:2, 2]),
            ('position', self.position),
            ('distortion', self.distortion),
        ):
            for value in values:
                QUANTITIES[name].check(name, float(value))
        (fx, _, cx), (_, fy, cy), _ = self.matrix
        if not np.array_equal(self.matrix, [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]):
            # OpenCV takes no notice of what else a matrix may hold.
            raise ParameterError(
                'matrix', self.matrix.tolist(), '[[fx, 0, cx], [0, fy, cy], [0, 0, 1]], no skew'
            )
        if not np.allclose(self.rotation @ self.rotation.T, np.eye(3), atol=1e-6):
            raise ParameterError('rotation', self.rotation.tolist(), 'a rotation matrix')

    def _check_size(self) -> None:
        """Refuse pictures without pixels, and those that no memory holds."""
        for name, side in (('width', self.width), ('height', self.height)):
            QUANTITIES['side'].check(name, side)
        if self.width * self.height > MOST_PIXELS:
            size = f'{self.width} x {self.height}'
            raise ParameterError('size', size, f'at most {MOST_PIXELS} pixels')

    @classmethod
    def looking_down(
        cls,
        position: ArrayLike,
        yaw: float,
        field_of_view: float,
        size: tuple[int, int] = (640, 640),
        distortion: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> CameraModel:
        """
        Make a camera under the ceiling.

        Parameters
        ----------
        position : array_like, shape (3,)
            In the world [m].
        yaw : float
            Direction in the world of the picture's right side [rad].
        field_of_view : float
            Angle that the picture's width spans, without distortion [rad].
        size : tuple of int
            Width and height of the picture [pixels].
        distortion : array_like, shape (5,)
            k1, k2, p1, p2, k3.

        Returns
        -------
        CameraModel
            It looks straight down.
        """
        c, s = math.cos(yaw), math.sin(yaw)
        # Right, down in the picture, and straight down, as columns.
        rotation = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])
        numbers = (np.asarray(value, dtype=float) for value in (position, distortion))
        return cls(*size, _lens(field_of_view, size), rotation, *numbers)

    @classmethod
    def looking_at(
        cls,
        position: ArrayLike,
        target: ArrayLike,
        field_of_view: float,
        size: tuple[int, int] = (1280, 720),
    ) -> CameraModel:
        """
        Make a camera that looks at a point, its picture upright.

        Parameters
        ----------
        position, target : array_like, shape (3,)
            In the world [m], not above each other.
        field_of_view : float
            Angle that the picture's width spans [rad].
        size : tuple of int
            Width and height of the picture [pixels].
        """
        place = np.asarray(position, dtype=float)
        ahead = np.asarray(target, dtype=float) - place
        ahead /= np.linalg.norm(ahead)
        right = np.cross(ahead, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(ahead, right), ahead], axis=1)
        return cls(*size, _lens(field_of_view, size), rotation, place, np.zeros(5))

    def project(self, points: ArrayLike) -> Array:
        """
        Find where points of the world are in the picture.

        Parameters
        ----------
        points : array_like, shape (n, 3)
            In front of the camera, in the world [m].

        Returns
        -------
        ndarray, shape (n, 2)
            Column and row; (0, 0) is the outer corner of the first pixel, whose center is
            at (0.5, 0.5). NaN for points that are not in front of the camera.
        """
        seen = (
            np.reshape(np.asarray(points, dtype=float), (-1, 3)) - self.position
        ) @ self.rotation
        pixels = np.full((len(seen), 2), np.nan)
        ahead = seen[:, 2] > 1e-9
        if ahead.any():
            pixels[ahead] = self._through_lens(seen[ahead, :2] / seen[ahead, 2:])
        return pixels

    def on_plane(self, pixels: ArrayLike, height: float = 0.0) -> Array:
        """
        Find the points at a height that are seen in pixels.

        Parameters
        ----------
        pixels : array_like, shape (n, 2)
            Columns and rows, as from :meth:`project`.
        height : float
            Of the horizontal plane in the world [m].

        Returns
        -------
        ndarray, shape (n, 2)
            x and y in the world [m]; NaN where the view does not meet the plane.
        """
        directions = self.directions(pixels)
        down = directions[:, 2]
        with np.errstate(divide='ignore', invalid='ignore'):
            along = (height - self.position[2]) / down
        points: Array = self.position[:2] + along[:, None] * directions[:, :2]
        points[~(along > 0.0)] = np.nan
        return points

    def directions(self, pixels: ArrayLike) -> Array:
        """
        Find where pixels look.

        Parameters
        ----------
        pixels : array_like, shape (n, 2)
            Columns and rows.

        Returns
        -------
        ndarray, shape (n, 3)
            Unit vectors in the world.
        """
        # Imported late: every node knows of cameras, and few have one.
        import cv2

        given = np.reshape(np.asarray(pixels, dtype=float), (-1, 2))
        straight = cv2.undistortPoints(given[:, None], self.matrix, self.distortion).reshape(-1, 2)
        if self.distortion.any():
            straight = self._refined(given, straight)
        # What a lens shows nowhere may have run off to anywhere.
        with np.errstate(over='ignore', invalid='ignore'):
            rays = np.column_stack((straight, np.ones(len(straight)))) @ self.rotation.T
            unit: Array = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        return unit

    def _refined(self, given: Array, straight: Array) -> Array:
        """Let undistorted places fit pixels: OpenCV leaves tenths of a pixel for wide lenses."""
        focal = np.array((self.matrix[0, 0], self.matrix[1, 1]))
        left = np.arange(len(given))
        before = np.zeros_like(given)
        looked = np.full(len(given), np.inf)
        step = np.ones(len(given))
        with np.errstate(over='ignore', invalid='ignore'):
            for number in range(_ROUNDS):
                if not len(left):
                    break
                missed = given[left] - self._through_lens(straight[left])
                size = (missed**2).sum(axis=1)
                along = (missed * before[left]).sum(axis=1)
                bound = _SLOW * (before[left] ** 2).sum(axis=1)
                # Where a lens spreads directions to more than double, whole steps overshoot
                # for ever; where it crowds them they are short.
                step[left[along < -bound]] *= 0.5
                step[left[along > bound]] *= 1.5
                before[left] = missed
                is_left = np.abs(missed).max(axis=1) > _EXACT
                if number % _LOOK_EVERY == 0:
                    # Into the corners of a lens that folds the picture over nothing is seen.
                    is_left &= size < _SLOW * looked[left]
                    looked[left] = size
                left, missed = left[is_left], missed[is_left]
                straight[left] += step[left, None] * missed / focal
        return straight

    def _through_lens(self, straight: Array) -> Array:
        """
        Find the pixels of undistorted places at unit depth, shape (n, 2).

        OpenCV's ``projectPoints`` gives the same, and spends nine tenths of its time on
        derivatives that nothing here asks for.
        """
        if self.distortion.any():
            x, y = straight.T
            k1, k2, p1, p2, k3 = self.distortion
            square = x * x + y * y
            radial = 1.0 + square * (k1 + square * (k2 + square * k3))
            straight = np.column_stack(
                (
                    x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
                    y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
                )
            )
        pixels: Array = straight * np.diag(self.matrix)[:2] + self.matrix[:2, 2]
        return pixels

    def without_distortion(self) -> CameraModel:
        """Return the same camera with a perfect lens."""
        return CameraModel(
            self.width, self.height, self.matrix, self.rotation, self.position, np.zeros(5)
        )


def _lens(field_of_view: float, size: tuple[int, int]) -> Array:
    """Return the matrix of a lens without distortion; raise ParameterError if there is none."""
    if not 0.0 < field_of_view < math.pi:
        raise ParameterError('field_of_view', field_of_view, 'between 0 and pi')
    width, height = size
    focal = width / 2.0 / math.tan(field_of_view / 2.0)
    return np.array([[focal, 0.0, width / 2.0], [0.0, focal, height / 2.0], [0.0, 0.0, 1.0]])
