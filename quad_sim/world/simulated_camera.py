"""
The simulated camera: pictures as a given camera model takes them.

The renderer knows perfect lenses only. Distortion is made from a picture that is wide enough
to hold all that the distorted one shows.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.vision.camera import CameraModel

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]
"""Red, green and blue, shape (height, width, 3)."""

NEAR, FAR = 0.1, 100.0
"""What the camera sees, along its view [m]."""

_LARGEST = 4096
"""Side of the picture that is rendered, at most [pixels]."""

_EXACT = 0.05
"""Error that the distortion's inverse may have [pixels]."""


class Scene(Protocol):
    """What can be looked at."""

    def render(self, view: Array, projection: Array, width: int, height: int) -> Picture:
        """
        Draw a picture as it is now.

        Parameters
        ----------
        view : ndarray, shape (4, 4)
            From the world to the eye: x to the right, y up, z against the view (OpenGL's).
        projection : ndarray, shape (4, 4)
            From the eye to clip coordinates; see :func:`projection_matrix`.
        width, height : int
            Of the picture [pixels].

        Returns
        -------
        ndarray of uint8, shape (height, width, 3)
            Red, green and blue; the first row is the top.
        """


class SimulatedCamera:
    """
    Takes pictures of a scene.

    Parameters
    ----------
    model : CameraModel
        Place and lens of the camera.
    noise : float
        Standard deviation of the normal noise of each number in a picture [of 255].
    brightness : float
        Factor of each number in a picture, before the noise. Numbers end at 255,
        as those of a real camera that is exposed too long.

    Raises
    ------
    ParameterError
        If noise or brightness are not valid, or the lens shows no true picture: its distortion
        folds the picture over, or a picture that holds all it shows would be too large.
    """

    def __init__(self, model: CameraModel, noise: float = 0.0, brightness: float = 1.0) -> None:
        for name, value in (('noise', noise), ('brightness', brightness)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ParameterError(name, value, 'a finite number of at least 0')
        self.model = model
        self._noise = noise
        self._brightness = brightness
        self._rendered = model.without_distortion()
        self._from: tuple[NDArray[np.float32], NDArray[np.float32]] | None = None
        if np.any(model.distortion):
            self._rendered, pixels = _wide_enough(model)
            # OpenCV counts from the center of the first pixel.
            columns, rows = (pixels.astype(np.float32) - np.float32(0.5)).transpose(2, 0, 1)
            self._from = columns, rows
        self._view = view_matrix(model)
        self._projection = projection_matrix(self._rendered)

    def take(self, scene: Scene, rng: np.random.Generator) -> Picture:
        """
        Take a picture.

        Parameters
        ----------
        scene : Scene
            What is looked at; it stays as it is.
        rng : Generator
            For the noise; nothing is drawn from it if there is none.

        Returns
        -------
        ndarray of uint8, shape (height, width, 3)
            Red, green and blue; the first row is the top.
        """
        wide = self._rendered
        picture: Picture = scene.render(self._view, self._projection, wide.width, wide.height)
        if self._from is not None:
            # Imported late: few simulations have a camera.
            import cv2

            picture = cv2.remap(picture, *self._from, cv2.INTER_LINEAR).astype(np.uint8, copy=False)
        if self._brightness == 1.0 and self._noise == 0.0:
            return picture
        light = picture.astype(np.float32) * np.float32(self._brightness)
        if self._noise > 0.0:
            light += np.float32(self._noise) * rng.standard_normal(light.shape, dtype=np.float32)
        seen: Picture = np.clip(np.rint(light), 0.0, 255.0).astype(np.uint8)
        return seen


def view_matrix(model: CameraModel) -> Array:
    """
    Return what brings the world to a camera's eye.

    Parameters
    ----------
    model : CameraModel
        The camera: y down and z along the view.

    Returns
    -------
    ndarray, shape (4, 4)
        To OpenGL's eye: y up and z against the view.
    """
    view = np.eye(4)
    view[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ model.rotation.T
    view[:3, 3] = -view[:3, :3] @ model.position
    return view


def projection_matrix(model: CameraModel) -> Array:
    """
    Return what brings a camera's eye to clip coordinates.

    Parameters
    ----------
    model : CameraModel
        The camera; its distortion is left out.

    Returns
    -------
    ndarray, shape (4, 4)
        -1 to 1 over the picture's width from left to right, over its height from bottom to
        top, and from :data:`NEAR` to :data:`FAR`.
    """
    (fx, _, cx), (_, fy, cy), _ = model.matrix
    w, h = model.width, model.height
    depth = FAR - NEAR
    return np.array(
        [
            [2.0 * fx / w, 0.0, 1.0 - 2.0 * cx / w, 0.0],
            [0.0, 2.0 * fy / h, 2.0 * cy / h - 1.0, 0.0],
            [0.0, 0.0, -(FAR + NEAR) / depth, -2.0 * FAR * NEAR / depth],
            [0.0, 0.0, -1.0, 0.0],
        ]
    )


def _wide_enough(model: CameraModel) -> tuple[CameraModel, Array]:
    """
    Find a camera without distortion that sees all that one with distortion sees.

    Parameters
    ----------
    model : CameraModel
        The camera with distortion.

    Returns
    -------
    CameraModel
        One without, at the same place, with the same focal lengths.
    ndarray, shape (height, width, 2)
        Where in its picture each pixel of the first camera's is.
    """
    shape = (model.height, model.width)
    rows, columns = np.indices(shape) + 0.5
    wanted = np.column_stack([columns.ravel(), rows.ravel()])
    points = model.position + model.directions(wanted)
    missed = np.abs(model.project(points) - wanted).max()
    if not missed < _EXACT:
        raise ParameterError(
            'distortion',
            model.distortion.tolist(),
            f'smaller: light cannot be traced back through this lens (missed by {missed:.2g} '
            'pixels)',
        )
    straight = model.without_distortion()
    pixels = straight.project(points)
    low = np.floor(pixels.min(axis=0)) - 1.0
    width, height = (int(v) for v in np.ceil(pixels.max(axis=0)) + 1.0 - low)
    if max(width, height) > _LARGEST:
        raise ParameterError(
            'distortion',
            model.distortion.tolist(),
            f'smaller: without it the picture would have {width} x {height} pixels, and '
            f'{_LARGEST} x {_LARGEST} are the most',
        )
    matrix = model.matrix.copy()
    matrix[:2, 2] -= low
    wide = CameraModel(width, height, matrix, model.rotation, model.position, np.zeros(5))
    return wide, (pixels - low).reshape(*shape, 2)
