"""
Pictures that show nothing: black, or overexposed.
"""

from __future__ import annotations

from quad_common.errors import PictureUnusable
from quad_perception.picture.color_segmentation import Picture

_DARK = 20
"""Pixels of at most this value are black."""
_BRIGHT = 252
"""Pixels whose least number is at least this are overexposed."""
_MOST = 0.98
"""Fraction of such pixels that is too much."""
_EVERY = 8
"""Every so many rows and columns are looked at."""


def check_exposure(rgb: Picture) -> None:
    """
    Refuse pictures that are black or overexposed.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (height, width, 3)
        The picture.

    Raises
    ------
    PictureUnusable
        If nearly all of it is the one or the other.
    """
    sample = rgb[::_EVERY, ::_EVERY]
    dark = float((sample.max(axis=2) <= _DARK).mean())
    if dark >= _MOST:
        raise PictureUnusable(f'is black: {100.0 * dark:.0f} % of it is darker than {_DARK} of 255')
    bright = float((sample.min(axis=2) >= _BRIGHT).mean())
    if bright >= _MOST:
        raise PictureUnusable(
            f'is overexposed: {100.0 * bright:.0f} % of it is white; make it darker'
        )
