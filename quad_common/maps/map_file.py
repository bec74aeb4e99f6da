"""
Map files: Nav2's YAML beside an image, read as ``nav2_map_server`` of Jazzy reads them.

The rules are those of its ``map_io.cpp``. The image is brought to 8-bit gray, g; the
occupancy of a pixel is p = 1 - g/255, or g/255 with ``negate``. Then, by ``mode``:

    trinary   p >= occupied_thresh: 100;  p <= free_thresh: 0;  between: unknown
    scale     the same, but between them 100 (p - free) / (occupied - free), rounded
    raw       g itself where it is at most 100, unknown elsewhere; ``negate`` has no say

In trinary and scale a pixel that is not wholly opaque is unknown. These are the rules
since release 1.3.7 of May 2025; before it, comparisons were strict, colors were averaged
evenly, and trinary averaged alpha among them. What ``map_saver`` wrote reads the same.

Images are read by Pillow, not OpenCV: OpenCV leaves a PGM whose white is not 255
unscaled, and does not say so.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from quad_common.errors import (
    FileUnusable,
    MapFileUnusable,
    ParameterError,
    QuadError,
    ThresholdsCrossed,
)
from quad_common.files.bounded_file import check_target, user_path
from quad_common.files.whole_file import whole_file, write_text
from quad_common.maps.map_document import (
    image_of,
    in_map_file,
    number_of,
    read_document,
    value_of,
)
from quad_common.maps.map_image import decode_image
from quad_common.maps.occupancy_grid import (
    FREE,
    OCCUPIED,
    OCCUPIED_THRESHOLD,
    UNKNOWN,
    OccupancyGrid,
)
from quad_common.planar_pose import Pose2D
from quad_common.quantity import ANGLE, CELL_SIZE, COORDINATE, Quantity, list_of

MODES = ('trinary', 'scale', 'raw')

QUANTITIES = {
    'resolution': CELL_SIZE,
    'origin': COORDINATE,
    'free_thresh': Quantity(0.0, 1.0),
    'occupied_thresh': Quantity(0.0, 1.0),
}
"""Ranges of what a map file says; of the origin's yaw it is :data:`quantity.ANGLE`."""

KEYS = ('image', 'mode', *QUANTITIES, 'negate')
"""Keys that a map file may have."""

_FORMATS = ('PPM', 'PNG', 'BMP')


def load_map(path: str | Path) -> OccupancyGrid:
    """
    Read a map.

    Parameters
    ----------
    path : str or Path
        The YAML file; its ``image`` is relative to it, or absolute.

    Returns
    -------
    OccupancyGrid
        The map, its last image row as row 0.

    Raises
    ------
    MapError
        If the file or its image is missing, unreadable, or says what it cannot.
    """
    path, document = read_document(path, KEYS)
    try:
        mode = str(document.get('mode', 'trinary')).lower()
        if mode not in MODES:
            raise ParameterError('mode', document['mode'], f'one of {", ".join(MODES)}')
        resolution = number_of(document, 'resolution', QUANTITIES['resolution'])
        origin = _origin(value_of(document, 'origin'))
        free, occupied = (
            number_of(document, key, QUANTITIES[key]) for key in ('free_thresh', 'occupied_thresh')
        )
        if not free <= occupied:
            raise ThresholdsCrossed(free, occupied)
        negate = _flag(document, 'negate')
        image = path.parent / image_of(document)
        gray, alpha = decode_image(image, _FORMATS, _gray_and_alpha)
        cells = _raw(gray) if mode == 'raw' else _graded(gray, alpha, negate, free, occupied, mode)
        # The image's first row is the top of the map, the grid's first row its bottom.
        return OccupancyGrid(np.ascontiguousarray(cells[::-1]), resolution, origin)
    except QuadError as error:
        raise in_map_file(error, 'map file', path) from error


def save_map(grid: OccupancyGrid, path: str | Path, *, free_threshold: int = 25) -> None:
    """
    Write a map as a trinary PGM and its YAML, as Nav2's ``map_saver`` does.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    path : str or Path
        The YAML file; the image goes beside it under the same name.
    free_threshold : int
        Cells from 0 to this value are written as free, those from 65 as occupied, the
        others as unknown.

    Raises
    ------
    MapError
        If a file cannot be written.
    """
    pixels = np.full(grid.cells.shape, 205, dtype=np.uint8)
    pixels[(grid.cells >= FREE) & (grid.cells <= free_threshold)] = 254
    pixels[grid.occupied(OCCUPIED_THRESHOLD)] = 0
    o = grid.origin
    try:
        path = user_path(path, 'map file')
        image = path.with_suffix('.pgm')
        check_target(path, 'map file')
        check_target(image, 'image')
        # Into memory: written by itself, Pillow leaves a part where the disk is full, and no word.
        content = io.BytesIO()
        Image.fromarray(np.ascontiguousarray(pixels[::-1])).save(content, 'PPM')
        # The image takes its place only when the file that describes it has.
        with whole_file(image, 'image') as beside:
            beside.write_bytes(content.getvalue())
            write_text(
                path,
                f'image: {path.stem}.pgm\n'
                'mode: trinary\n'
                f'resolution: {float(grid.resolution)!r}\n'
                f'origin: [{float(o.x)!r}, {float(o.y)!r}, {float(o.yaw)!r}]\n'
                'negate: 0\n'
                'occupied_thresh: 0.65\n'
                'free_thresh: 0.196\n',
                'map file',
            )
    except FileUnusable as error:
        raise error.of_kind(MapFileUnusable) from error
    except (OSError, ValueError) as error:
        raise MapFileUnusable('map file', path, f'cannot be written: {error}') from error


def _origin(value: Any) -> Pose2D:
    """Read the pose of the map's lower left corner."""
    x, y, yaw = list_of('origin', value, ('x', 'y', 'yaw'))
    place = QUANTITIES['origin']
    return Pose2D(
        place.check('origin.x', x), place.check('origin.y', y), ANGLE.check('origin.yaw', yaw)
    )


def _flag(document: Mapping[str, Any], key: str) -> bool:
    value = value_of(document, key)
    if value not in (0, 1) or not isinstance(value, (bool, int)):
        raise ParameterError(key, value, '0 or 1')
    return bool(value)


def _gray_and_alpha(image: Image.Image) -> tuple[NDArray[np.uint8], NDArray[np.uint8] | None]:
    """Return the 8-bit gray values of an image, and its alpha if it has one."""
    if image.mode.startswith('I'):
        # 16-bit gray: 65535 / 255 = 257, rounded. By a table, which takes no memory.
        table = ((np.arange(65536) + 128) // 257).astype(np.uint8)
        return table.take(np.asarray(image), mode='clip'), None
    # ITU-R 601 luma, 0.299 R + 0.587 G + 0.114 B, here and in GraphicsMagick.
    if 'A' in image.getbands() or 'transparency' in image.info:
        gray, alpha = np.moveaxis(np.asarray(image.convert('RGBA').convert('LA')), -1, 0)
        return gray, alpha
    return np.asarray(image.convert('L')), None


def _raw(gray: NDArray[np.uint8]) -> NDArray[np.int8]:
    return np.where(gray <= OCCUPIED, gray.astype(np.int8), np.int8(UNKNOWN))


def _graded(
    gray: NDArray[np.uint8],
    alpha: NDArray[np.uint8] | None,
    negate: bool,
    free: float,
    occupied: float,
    mode: str,
) -> NDArray[np.int8]:
    # There are only 256 shades: grade those, then look each pixel up. In single
    # precision, as in Nav2, so that a shade equal to a threshold gets the same grade.
    p = np.arange(256, dtype=np.float32) / np.float32(255.0)
    if not negate:
        p = np.float32(1.0) - p
    shades = np.full(256, UNKNOWN, dtype=np.int8)
    if mode == 'scale' and free < occupied:
        scaled = (p - np.float32(free)) / np.float32(occupied - free) * np.float32(100.0)
        between = (p > np.float32(free)) & (p < np.float32(occupied))
        shades[between] = np.floor(scaled[between] + np.float32(0.5)).astype(np.int8)
    shades[p >= np.float32(occupied)] = OCCUPIED
    shades[p <= np.float32(free)] = FREE
    cells = shades[gray]
    if alpha is not None:
        cells[alpha < 255] = UNKNOWN
    return cells
