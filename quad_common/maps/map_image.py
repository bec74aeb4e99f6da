"""
Images of maps: decoded by Pillow, within a stated size.

A file of some kilobytes may say that it has a picture of gigabytes: the size is looked at
before anything is decoded.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from PIL import Image, UnidentifiedImageError

from quad_common.errors import (
    FileUnusable,
    ImageTooLarge,
    ImageUnreadable,
    MapError,
    MapFileUnusable,
)
from quad_common.errors.quoting import clipped
from quad_common.files.bounded_file import LARGEST_IMAGE, read_bytes

MOST_PIXELS = 2**27
"""Number of pixels of the largest image that is decoded: 579 m square with cells of 0.05 m."""

_MOST_VALUES = 2**28
"""Pixels times color bands."""

_NAMES = {'PPM': 'PGM'}
"""What users call Pillow's formats."""

Decoded = TypeVar('Decoded')


def decode_image(
    path: Path, formats: tuple[str, ...], decode: Callable[[Image.Image], Decoded]
) -> Decoded:
    """
    Decode an image.

    Parameters
    ----------
    path : Path
        The file.
    formats : tuple of str
        Pillow's names of the formats that it may have.
    decode : callable
        Makes arrays of the opened image; it is called with the size checked.

    Returns
    -------
    object
        What `decode` returned.

    Raises
    ------
    MapError
        If the file cannot be read, or is no such image, or too large.
    """
    try:
        content = read_bytes(path, 'image', LARGEST_IMAGE)
    except FileUnusable as error:
        raise MapFileUnusable(f'the {error.what}', error.path, error.reason) from error
    names = [_NAMES.get(name, name) for name in formats]
    kinds = ' or '.join([', '.join(names[:-1]), names[-1]] if names[1:] else names)
    try:
        with warnings.catch_warnings():
            # Pillow warns of large images; what is too large is refused below.
            warnings.simplefilter('ignore', Image.DecompressionBombWarning)
            with Image.open(io.BytesIO(content), formats=formats) as image:
                _check_size(image, path)
                return decode(image)
    except MapError:
        raise
    except Exception as error:
        # Decoders raise whatever a damaged file makes them meet: IndexError, struct.error, ...
        is_other = isinstance(error, UnidentifiedImageError)
        reason = 'it is none' if is_other else clipped(str(error)) or type(error).__name__
        raise ImageUnreadable(path, kinds, reason) from error


def _check_size(image: Image.Image, path: Path) -> None:
    width, height = image.size
    pixels = width * height
    if not 0 < pixels <= MOST_PIXELS or pixels * len(image.getbands()) > _MOST_VALUES:
        raise ImageTooLarge(path, width, height, image.mode, MOST_PIXELS)
