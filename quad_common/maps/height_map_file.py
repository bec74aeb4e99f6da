"""
Height map files: a YAML beside a gray image of 16 bits, in the manner of Nav2's map files.

    image: hills.png          # 16-bit gray PNG; its first row is the top
    resolution: 0.02          # [m]
    origin: [-1.0, -1.0]      # lower left corner, x and y [m]
    lowest: -0.03             # the height of pixels of 1 [m]
    height_step: 1.0e-06      # from one shade to the next [m]

The height of a pixel g is lowest + height_step (g - 1); a pixel of 0 is unknown.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from quad_common.errors import (
    FileUnusable,
    HeightImageNotGray,
    HeightImageTooLarge,
    MapFileUnusable,
    QuadError,
)
from quad_common.files.bounded_file import check_target, user_path
from quad_common.files.whole_file import whole_file, write_text
from quad_common.maps.height_map import HEIGHT, MAX_CELLS, HeightMap
from quad_common.maps.map_document import image_of, in_map_file, number_of, read_document, value_of
from quad_common.maps.map_image import decode_image
from quad_common.quantity import CELL_SIZE, COORDINATE, Quantity

QUANTITIES = {
    'resolution': CELL_SIZE,
    'origin': COORDINATE,
    'lowest': HEIGHT,
    'height_step': Quantity(1e-9, 1.0, 'm'),
}
"""Ranges of what a height map file says."""

KEYS = ('image', *QUANTITIES)
"""Keys that a height map file has."""

_WHAT = 'height map file'
_UNKNOWN = 0
_MOST = 65535
_FINEST = 1e-6
"""Least step between shades that is written: one micrometre [m]."""


def load_height_map(path: str | Path) -> HeightMap:
    """
    Read a height map.

    Parameters
    ----------
    path : str or Path
        The YAML file; its ``image`` is relative to it, or absolute.

    Returns
    -------
    HeightMap
        With the last image row as row 0.

    Raises
    ------
    MapError
        If the file or its image is missing, unreadable, or says what it cannot.
    """
    path, document = read_document(path, KEYS, _WHAT)
    try:
        resolution, lowest, step = (
            number_of(document, key, QUANTITIES[key])
            for key in ('resolution', 'lowest', 'height_step')
        )
        x, y = QUANTITIES['origin'].check_each('origin', value_of(document, 'origin'), ('x', 'y'))
        shades = decode_image(path.parent / image_of(document), ('PNG',), _shades)
        heights = np.where(shades == _UNKNOWN, np.nan, lowest + step * (shades - 1.0))
        return HeightMap(np.ascontiguousarray(heights[::-1]), resolution, (x, y))
    except QuadError as error:
        raise in_map_file(error, _WHAT, path) from error


def save_height_map(terrain: HeightMap, path: str | Path) -> None:
    """
    Write a height map as a PNG and its YAML.

    Parameters
    ----------
    terrain : HeightMap
        The height map; heights are rounded to 1/65534 of their span, or to 1e-6 m if that is more.
    path : str or Path
        The YAML file; the image goes beside it under the same name.

    Raises
    ------
    MapError
        If a file cannot be written.
    """
    is_known = ~np.isnan(terrain.heights)
    known = terrain.heights[is_known]
    lowest, highest = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    step = max((highest - lowest) / (_MOST - 1), _FINEST)
    shades = np.full(terrain.heights.shape, _UNKNOWN, dtype=np.uint16)
    shades[is_known] = np.rint((known - lowest) / step).astype(np.uint16) + 1
    try:
        path = user_path(path, _WHAT)
        image = path.with_suffix('.png')
        check_target(path, _WHAT)
        check_target(image, 'image')
        # The image takes its place only when the file that describes it has.
        with whole_file(image, 'image') as beside:
            Image.fromarray(np.ascontiguousarray(shades[::-1])).save(beside)
            write_text(
                path,
                f'image: {path.stem}.png\n'
                f'resolution: {terrain.resolution!r}\n'
                f'origin: [{terrain.origin[0]!r}, {terrain.origin[1]!r}]\n'
                f'lowest: {lowest!r}\n'
                f'height_step: {step!r}\n',
                _WHAT,
            )
    except FileUnusable as error:
        raise error.of_kind(MapFileUnusable) from error
    except (OSError, ValueError) as error:
        raise MapFileUnusable(_WHAT, path, f'cannot be written: {error}') from error


def _shades(image: Image.Image) -> NDArray[np.uint16]:
    """Return the shades of a gray image of 16 bits."""
    if not image.mode.startswith('I'):
        raise HeightImageNotGray(image.mode)
    if image.width * image.height > MAX_CELLS:
        raise HeightImageTooLarge(image.width, image.height, MAX_CELLS)
    return np.asarray(image).astype(np.uint16)
