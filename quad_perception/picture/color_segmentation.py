"""
Tell things apart by their colors.

A color is a range of hue, saturation and value (HSV). Light that is brighter or darker
scales red, green and blue alike, which leaves hue and saturation as they are: a range is
narrow in hue, and wide in value. Noise is taken out by a median over 3 x 3 pixels before,
which leaves edges where they are.
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    CameraEntryInvalid,
    CameraFileUnusable,
    CameraValueOutOfRange,
    FileUnusable,
    ParameterError,
)
from quad_common.files.bounded_file import user_path
from quad_common.files.yaml_document import in_file, read_yaml
from quad_common.quantity import Quantity, list_of

Picture = NDArray[np.uint8]
Mask = NDArray[np.uint8]

QUANTITIES = {
    'hue': Quantity(0.0, 360.0, 'deg'),
    'saturation': Quantity(0.0, 1.0),
    'value': Quantity(0.0, 1.0),
}
"""Ranges of a color in a file."""

_WHAT = 'color file'


@dataclass(frozen=True)
class ColorRange:
    """
    The colors of one kind of thing.

    Raises
    ------
    ParameterError
        If a number is outside its range, or a lower one above the upper one, but for hue.
    """

    name: str
    """What has this color, for example ``obstacle``."""
    lower: tuple[float, float, float]
    """Hue [deg], 0 to 360, saturation and value, 0 to 1."""
    upper: tuple[float, float, float]
    """Their upper ends. If the lower hue is above the upper one the range goes through 0: red."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, color in (('lower', self.lower), ('upper', self.upper)):
            hue, *others = color if len(color) == 3 else (math.nan,)
            if not (0.0 <= hue <= 360.0 and all(0.0 <= value <= 1.0 for value in others)):
                raise ParameterError(
                    f'{self.name}.{name}',
                    color,
                    'a hue of 0 to 360 degrees, a saturation and a value of 0 to 1',
                )
        for k, quantity in ((1, 'saturation'), (2, 'value')):
            if self.lower[k] > self.upper[k]:
                raise ParameterError(
                    f'{self.name}.lower', self.lower, f'at most {self.upper[k]:g} in {quantity}'
                )

    @classmethod
    def around(
        cls,
        name: str,
        rgb: Sequence[int],
        hue: float = 20.0,
        saturation: float = 0.5,
        value: float = 0.12,
    ) -> ColorRange:
        """
        Make the range of a strong color in any light.

        Parameters
        ----------
        name : str
            What has this color.
        rgb : sequence of int
            Red, green and blue, 0 to 255.
        hue : float
            How far hues may be from the color's, below 90 [deg].
        saturation : float
            The least saturation, as a fraction of the color's.
        value : float
            The least value.

        Returns
        -------
        ColorRange
            The range.
        """
        if not (len(rgb) == 3 and all(0 <= part <= 255 for part in rgb)):
            raise ParameterError(name, tuple(rgb), 'red, green and blue of 0 to 255')
        if not 0.0 < hue < 90.0:
            raise ParameterError('hue', hue, 'above 0 and below 90 degrees')
        h, s, _ = colorsys.rgb_to_hsv(*(part / 255.0 for part in rgb))
        if s < 0.2:
            raise ParameterError(name, tuple(rgb), 'a strong color: gray has no hue')
        return cls(
            name,
            ((360.0 * h - hue) % 360.0, saturation * s, value),
            ((360.0 * h + hue) % 360.0, 1.0, 1.0),
        )

    def mask(self, hsv: Picture) -> Mask:
        """
        Find the pixels of these colors.

        Parameters
        ----------
        hsv : ndarray of uint8, shape (height, width, 3)
            Hue in steps of 360/256 degrees, saturation and value of 255, as from
            ``cv2.COLOR_RGB2HSV_FULL``.

        Returns
        -------
        ndarray of uint8, shape (height, width)
            255 where the color is in the range, 0 elsewhere.
        """
        lower = [self.lower[0] * 256.0 / 360.0, 255.0 * self.lower[1], 255.0 * self.lower[2]]
        upper = [self.upper[0] * 256.0 / 360.0, 255.0 * self.upper[1], 255.0 * self.upper[2]]
        if lower[0] <= upper[0]:
            return np.asarray(cv2.inRange(hsv, np.array(lower), np.array(upper)), np.uint8)
        below = cv2.inRange(hsv, np.array([0.0, *lower[1:]]), np.array(upper))
        above = cv2.inRange(hsv, np.array(lower), np.array([255.0, *upper[1:]]))
        return np.asarray(cv2.bitwise_or(below, above), np.uint8)


@dataclass(frozen=True, eq=False)
class Segmentation:
    """What a picture shows, by color."""

    masks: Mapping[str, Mask]
    """Masks by the name of the range, 255 where pixels have its color; shape (height, width)."""
    value: Picture
    """The largest of red, green and blue, less noise; shape (height, width)."""


def segment(rgb: Picture, ranges: Sequence[ColorRange]) -> Segmentation:
    """
    Find the pixels of each range of colors.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (height, width, 3)
        The picture: red, green, blue.
    ranges : sequence of ColorRange
        What is looked for. Names must differ.

    Returns
    -------
    Segmentation
        A mask for each range.
    """
    check_picture(rgb)
    names = [color.name for color in ranges]
    if len(set(names)) < len(names):
        raise ParameterError('ranges', names, 'of different names')
    hsv = cv2.cvtColor(cv2.medianBlur(rgb, 3), cv2.COLOR_RGB2HSV_FULL)
    masks = {color.name: color.mask(hsv) for color in ranges}
    return Segmentation(masks, cv2.extractChannel(hsv, 2))


def load_ranges(path: str | Path) -> tuple[ColorRange, ...]:
    """
    Read ranges of colors.

    Parameters
    ----------
    path : str or Path
        A YAML file: under each name ``lower`` and ``upper``, three numbers each.

    Returns
    -------
    tuple of ColorRange
        Ranges in the order of the file.

    Raises
    ------
    CameraError
        If the file is missing, unreadable, or says what it cannot.
    """
    try:
        path = user_path(path, _WHAT)
        document = read_yaml(path, _WHAT, 'names with lower and upper each')
    except FileUnusable as error:
        raise error.of_kind(CameraFileUnusable) from error
    try:
        return tuple(_range(name, entry) for name, entry in document.items())
    except ParameterError as error:
        raise in_file(error, _WHAT, path, CameraEntryInvalid, CameraValueOutOfRange) from error


def _range(name: str, entry: object) -> ColorRange:
    """Read one range of colors."""
    if not isinstance(entry, dict) or set(entry) != {'lower', 'upper'}:
        raise ParameterError(name, entry, 'given by lower and upper')
    colors = {}
    for key in ('lower', 'upper'):
        parts = list_of(f'{name}.{key}', entry[key], tuple(QUANTITIES))
        colors[key] = tuple(
            quantity.check(f'{name}.{key}.{part}', value)
            for (part, quantity), value in zip(QUANTITIES.items(), parts)
        )
    (lower_hue, *lower), (upper_hue, *upper) = colors['lower'], colors['upper']
    return ColorRange(name, (lower_hue, lower[0], lower[1]), (upper_hue, upper[0], upper[1]))


def check_picture(rgb: Picture, size: tuple[int, int] | None = None) -> None:
    """
    Refuse what is not a picture.

    Parameters
    ----------
    rgb : ndarray
        What should be a picture.
    size : tuple of int, optional
        The width and height it should have [pixels].

    Raises
    ------
    ParameterError
        If it is not of uint8 and shape (height, width, 3), or of another size.
    """
    if not isinstance(rgb, np.ndarray) or rgb.dtype != np.uint8 or rgb.ndim != 3:
        found = getattr(rgb, 'dtype', type(rgb).__name__), getattr(rgb, 'shape', ())
        raise ParameterError('rgb', found, 'an array of uint8 of shape (height, width, 3)')
    if rgb.shape[2] != 3 or rgb.size == 0:
        raise ParameterError('rgb', rgb.shape, 'of shape (height, width, 3)')
    if size is not None and (rgb.shape[1], rgb.shape[0]) != size:
        raise ParameterError(
            'rgb',
            f'{rgb.shape[1]} x {rgb.shape[0]} pixels',
            f"{size[0]} x {size[1]} pixels, as in the camera's file",
        )
