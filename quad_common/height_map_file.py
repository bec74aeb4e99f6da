"""
Height map files: a YAML beside a grey image of 16 bits, in the manner of Nav2's map files.

    image: hills.png          # 16-bit grey PNG; its first row is the top
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

from quad_common.errors import MapError
from quad_common.height_map import HeightMap
from quad_common.map_document import InvalidEntry, image_of, number_of, numbers_of, read_document

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
    path = Path(path).expanduser()
    document = read_document(path, 'height map file')
    try:
        resolution = number_of(document, 'resolution')
        x, y = numbers_of(document, 'origin', ('x', 'y'))
        lowest, step = number_of(document, 'lowest'), number_of(document, 'height_step')
        if not step > 0.0:
            raise InvalidEntry(f"'height_step' is {step:g}; it must be above zero")
        shades = _read_image(path.parent / image_of(document))
        heights = np.where(shades == _UNKNOWN, np.nan, lowest + step * (shades - 1.0))
        return HeightMap(np.ascontiguousarray(heights[::-1]), resolution, (x, y))
    except (InvalidEntry, MapError) as error:
        raise MapError(f'height map file {path}: {error}') from error


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
    path = Path(path).expanduser()
    is_known = ~np.isnan(terrain.heights)
    known = terrain.heights[is_known]
    lowest, highest = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    step = max((highest - lowest) / (_MOST - 1), _FINEST)
    shades = np.full(terrain.heights.shape, _UNKNOWN, dtype=np.uint16)
    shades[is_known] = np.rint((known - lowest) / step).astype(np.uint16) + 1
    try:
        Image.fromarray(np.ascontiguousarray(shades[::-1])).save(path.with_suffix('.png'))
        path.write_text(
            f'image: {path.stem}.png\n'
            f'resolution: {terrain.resolution!r}\n'
            f'origin: [{terrain.origin[0]!r}, {terrain.origin[1]!r}]\n'
            f'lowest: {lowest!r}\n'
            f'height_step: {step!r}\n',
            encoding='utf-8',
        )
    except OSError as error:
        raise MapError(f'height map file {path} cannot be written: {error}') from error


def _read_image(path: Path) -> NDArray[np.int64]:
    """Return the shades of a grey image of 16 bits."""
    try:
        with Image.open(path, formats=('PNG',)) as image:
            if not image.mode.startswith('I'):
                raise InvalidEntry(
                    f"the image '{path}' is of mode {image.mode}; it must be grey with 16 bits"
                )
            return np.asarray(image).astype(np.int64)
    except FileNotFoundError as error:
        raise InvalidEntry(f"the image '{path}' does not exist") from error
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise InvalidEntry(f"the image '{path}' cannot be read as PNG: {error}") from error
