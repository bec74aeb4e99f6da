"""
Files of points by which a camera is calibrated: places in the world, and pixels.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    CameraFileUnusable,
    CameraValueOutOfRange,
    FileUnusable,
    OutOfRange,
    PointLineMalformed,
    TooManyPointsInFile,
)
from quad_common.files.bounded_file import read_text
from quad_common.quantity import COORDINATE, Quantity

_PIXEL = Quantity(-1e5, 1e5, 'pixels')
_POINT = {'x': COORDINATE, 'y': COORDINATE, 'column': _PIXEL, 'row': _PIXEL}
"""What a line of a file of points holds."""

_MOST_POINTS = 1000


def read_points(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Read points for calibrating a camera.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    places : ndarray, shape (n, 2)
        x and y in the world [m].
    pixels : ndarray, shape (n, 2)
        Column and row in the picture, as an image viewer counts them.

    Raises
    ------
    CameraError
        If the file cannot be read, or a line is no point.
    """
    what = 'file of points'
    try:
        lines = read_text(path, what).splitlines()
    except FileUnusable as error:
        raise error.of_kind(CameraFileUnusable) from error
    rows = []
    for number, line in enumerate(lines, 1):
        text = line.partition('#')[0].replace(',', ' ').split()
        if not text:
            continue
        if len(text) != len(_POINT):
            raise PointLineMalformed(what, path, number)
        try:
            rows.append([_POINT[name].check(name, part) for name, part in zip(_POINT, text)])
        except OutOfRange as error:
            raise error.at(f'{what} {path}, line {number}: ', CameraValueOutOfRange) from error
        if len(rows) > _MOST_POINTS:
            raise TooManyPointsInFile(what, path, _MOST_POINTS)
    values = np.array(rows, dtype=float).reshape(-1, len(_POINT))
    return values[:, :2], values[:, 2:]
