"""
Which pixels each range of colors catches, for people to look at.
"""

from __future__ import annotations

import colorsys
from collections.abc import Sequence

import cv2
import numpy as np

from quad_perception.picture.color_segmentation import ColorRange, Picture, Segmentation

_DIM = 0.35
"""Brightness of the picture where no range catches it, as a fraction."""
_LINE = 22
"""Height of a line of the legend [pixels]."""


def draw_masks(rgb: Picture, seen: Segmentation, ranges: Sequence[ColorRange]) -> Picture:
    """
    Draw what each range catches.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (height, width, 3)
        The picture.
    seen : Segmentation
        The same picture by colors.
    ranges : sequence of ColorRange
        Those to draw.

    Returns
    -------
    ndarray of uint8, shape (height + 22 n, width, 3)
        The picture, gray and dim, with what n ranges catch in the middle of their colors;
        below it their names and fractions of the picture. White: caught by several.
    """
    gray = cv2.cvtColor(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), cv2.COLOR_GRAY2RGB)
    drawn = (_DIM * gray).astype(np.uint8)
    caught = np.zeros(rgb.shape[:2], np.uint8)
    legend = np.zeros((_LINE * len(ranges), rgb.shape[1], 3), np.uint8)
    for k, color in enumerate(ranges):
        middle = _middle(color)
        mask = seen.masks[color.name] > 0
        drawn[mask] = middle
        drawn[mask & (caught > 0)] = 255
        caught[mask] = 1
        top = k * _LINE
        cv2.rectangle(legend, (4, top + 4), (30, top + _LINE - 4), middle, cv2.FILLED)
        text = f'{color.name}: {100.0 * mask.mean():.2f} %'
        place = (38, top + _LINE - 6)
        cv2.putText(
            legend, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1, cv2.LINE_AA
        )
    return np.vstack((drawn, legend))


def _middle(color: ColorRange) -> tuple[int, int, int]:
    """Return the color in the middle of a range, bright, as red, green and blue."""
    span = (color.upper[0] - color.lower[0]) % 360.0 or color.upper[0] - color.lower[0]
    hue = (color.lower[0] + span / 2.0) % 360.0 / 360.0
    saturation = 0.0 if span >= 360.0 else color.upper[1]
    r, g, b = colorsys.hsv_to_rgb(hue, saturation, 0.85 * color.upper[2])
    return round(255.0 * r), round(255.0 * g), round(255.0 * b)
