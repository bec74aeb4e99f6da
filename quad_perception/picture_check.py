"""
Pictures that show nothing: black, overexposed, or the same one again and again.
"""

from __future__ import annotations

import numpy as np

from quad_common.errors import ParameterError, PictureUnusable
from quad_perception.color_segmentation import Picture

_DARK = 20
"""Pixels of at most this value are black."""
_BRIGHT = 252
"""Pixels whose least number is at least this are overexposed."""
_MOST = 0.98
"""This share of such pixels is too much."""
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


class PictureWatch:
    """
    Notices a camera that sends the same picture again and again.

    A real camera's pictures differ by their noise. A simulated one without noise sends equal
    pictures while nothing moves: give it a longer patience, or none.

    Parameters
    ----------
    patience : float
        For how long pictures may be equal, > 0 [s]; infinite for always.
    """

    def __init__(self, patience: float = 2.0) -> None:
        if not patience > 0.0:
            raise ParameterError('patience', patience, 'above 0')
        self._patience = patience
        self._last: Picture | None = None
        self._since = 0.0

    def check(self, rgb: Picture, t: float) -> None:
        """
        Take notice of a picture.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (height, width, 3)
            The picture.
        t : float
            When it was taken [s].

        Raises
        ------
        PictureUnusable
            If all pictures have been equal for longer than the patience.
        """
        # A clock that went back is a new start.
        if self._last is None or t < self._since or not np.array_equal(self._last, rgb):
            self._last, self._since = rgb.copy(), t
        elif t - self._since > self._patience:
            raise PictureUnusable(f'has not changed for {t - self._since:.1f} s: the camera hangs')
