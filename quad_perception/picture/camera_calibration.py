"""
Where a camera is: from points of the floor whose places and pixels are known.

The lens must be known. The pose is the one with the least squared distances between the
pixels and the projections of the points (perspective-n-point, refined by
Levenberg-Marquardt).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import (
    CameraPoseDoesNotFit,
    NoPoseAbovePoints,
    PointCountsDiffer,
    PointsInLine,
    PointsMalformed,
    PointsNotNumbers,
    TooFewPoints,
)
from quad_common.vision.camera import CameraModel

Array = NDArray[np.float64]

LEAST_POINTS = 4

_LEAST_SPREAD = 0.03
"""The points' extent across their longest one, as a fraction of it: below it they are in a line."""


@dataclass(frozen=True, eq=False)
class CameraCalibration:
    """A camera whose pose was found."""

    camera: CameraModel
    """The camera, with its pose."""
    errors: Array
    """Distance between each pixel and its point's projection, shape (n,) [pixels]."""
    position_deviation: Array
    """Standard deviation of the camera's position, shape (3,); what the errors make of it [m]."""

    @property
    def reprojection_error(self) -> float:
        """Root of the mean squared error [pixels]."""
        return float(np.sqrt(np.mean(self.errors**2)))


def calibrate_pose(
    lens: CameraModel, points: ArrayLike, pixels: ArrayLike, largest_error: float = 5.0
) -> CameraCalibration:
    """
    Find where a camera is.

    Parameters
    ----------
    lens : CameraModel
        Its lens; its pose does not matter.
    points : array_like, shape (n, 2) or (n, 3), n >= 4
        Places in the world, on the floor if they have no height [m].
    pixels : array_like, shape (n, 2)
        Places in the picture: column and row, as from
        :meth:`quad_common.vision.camera.CameraModel.project`.
    largest_error : float
        A larger reprojection error means that something is wrong [pixels].

    Returns
    -------
    CameraCalibration
        The camera with its pose, and how well it fits.

    Raises
    ------
    CameraError
        If there are too few points, they are in a line, some are not finite, or no pose
        above them fits.
    """
    places = _checked('points', points, (2, 3))
    if places.shape[1] == 2:
        places = np.column_stack((places, np.zeros(len(places))))
    seen = _checked('pixels', pixels, (2,))
    if len(places) != len(seen):
        raise PointCountsDiffer(len(places), len(seen))
    if len(places) < LEAST_POINTS:
        raise TooFewPoints(len(places), LEAST_POINTS)
    _refuse_lines('points', places)
    _refuse_lines('pixels', seen)
    rotation, position, deviation = _best_pose(lens, places, seen)
    camera = replace(lens, rotation=rotation, position=position)
    errors = np.linalg.norm(camera.project(places) - seen, axis=1)
    found = CameraCalibration(camera, errors, deviation)
    if not found.reprojection_error <= largest_error:
        worst = int(np.argmax(errors))
        pixel = (float(seen[worst, 0]), float(seen[worst, 1]))
        raise CameraPoseDoesNotFit(found.reprojection_error, worst + 1, pixel)
    return found


def _checked(name: str, values: ArrayLike, columns: tuple[int, ...]) -> Array:
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise PointsNotNumbers(name) from None
    if array.ndim != 2 or array.shape[1] not in columns or not np.isfinite(array).all():
        raise PointsMalformed(name, columns)
    return array


def _refuse_lines(name: str, values: Array) -> None:
    spread = np.linalg.svd(values - values.mean(axis=0), compute_uv=False)
    if not spread[1] > _LEAST_SPREAD * spread[0]:
        raise PointsInLine(name)


def _best_pose(lens: CameraModel, places: Array, seen: Array) -> tuple[Array, Array, Array]:
    """Return rotation, position and its deviation of the pose that fits best, from above."""
    best = None
    is_flat = np.ptp(places[:, 2]) < 1e-9
    methods = [cv2.SOLVEPNP_SQPNP, *([cv2.SOLVEPNP_IPPE] if is_flat else [])]
    for method in methods:
        try:
            _, turns, shifts, _ = cv2.solvePnPGeneric(
                places, seen, lens.matrix, lens.distortion, flags=method
            )
        except cv2.error:
            continue
        for turn, shift in zip(turns, shifts):
            turn, shift = cv2.solvePnPRefineLM(
                places, seen, lens.matrix, lens.distortion, turn, shift
            )
            projected, jacobian = cv2.projectPoints(
                places, turn, shift, lens.matrix, lens.distortion
            )
            squares = float(np.sum((projected.reshape(-1, 2) - seen) ** 2))
            to_world = cv2.Rodrigues(turn)[0].T
            position = -to_world @ shift.ravel()
            is_above = position[2] > places[:, 2].max()
            is_ahead = bool((((places - position) @ to_world)[:, 2] > 0.0).all())
            if is_above and is_ahead and (best is None or squares < best[0]):
                best = squares, to_world, position, jacobian[:, :6], turn, shift
    if best is None:
        raise NoPoseAbovePoints()
    squares, to_world, position, jacobian, turn, shift = best
    variance = squares / max(1, 2 * len(places) - 6)
    covariance = variance * np.linalg.pinv(jacobian.T @ jacobian)
    # How the position depends on the numbers that were fitted, by differences.
    moved = np.empty((3, 6))
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-6
        other = cv2.Rodrigues(turn + step[:3, None])[0].T
        moved[:, k] = (-other @ (shift.ravel() + step[3:]) - position) / 1e-6
    deviation = np.sqrt(np.diag(moved @ covariance @ moved.T))
    return to_world, position, deviation
