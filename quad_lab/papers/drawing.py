"""
How pictures of papers' figures are drawn, and made small.
"""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

Array = NDArray[np.float64]

COLORS = ('#1f4fd8', '#d62728', '#2a9d2a', '#ff8c00')
"""Colors of lines; of legs in the order lf, rf, lh, rh."""

LEG_NAMES = ('left front', 'right front', 'left hind', 'right hind')
"""Names of legs in the order of a robot's."""

LEG_NUMBERS = {'lf': '1', 'rf': '2', 'lh': '3', 'rh': '4'}
"""Numbers of the legs in S0 and S4."""

_SIZE = (6.8, 3.1)
"""Size of a picture [inches]."""

_DPI = 95

_PALETTE = 128
"""Number of colors in a picture's file."""


def picture_of(draw: Callable[[Figure], None]) -> bytes:
    """
    Draw a figure as a small PNG.

    Parameters
    ----------
    draw : callable
        Draws on an empty figure; it may change its size.

    Returns
    -------
    bytes
        The file's content, the same for the same drawing.
    """
    figure = Figure(figsize=_SIZE, layout='constrained')
    FigureCanvasAgg(figure)
    draw(figure)
    raw = io.BytesIO()
    figure.savefig(raw, format='png', dpi=_DPI, metadata={'Software': None})
    small = io.BytesIO()
    with Image.open(raw) as image:
        image.convert('RGB').quantize(_PALETTE, dither=Image.Dither.NONE).save(
            small, format='png', optimize=True
        )
    return small.getvalue()


def panels(figure: Figure, rows: int, columns: int, shared_y: bool = False) -> list[Axes]:
    """Divide a figure into equal panels, row by row, with small text and a faint grid."""
    axes = np.atleast_1d(figure.subplots(rows, columns, sharey=shared_y)).ravel().tolist()
    for one in axes:
        one.tick_params(labelsize=7)
        one.grid(color='0.9', linewidth=0.6)
        one.set_axisbelow(True)
    return list(axes)


def name_axes(axes: Axes, x: str, y: str, title: str = '') -> None:
    """Write what the axes are, and the panel's title."""
    axes.set_xlabel(x, fontsize=8)
    axes.set_ylabel(y, fontsize=8)
    if title:
        axes.set_title(title, fontsize=8)


def draw_legs(axes: Axes, times: Array, values: Array) -> None:
    """Draw a line for each leg: times (n,), values (n, 4)."""
    for k, name in enumerate(LEG_NAMES):
        style = '-' if k % 2 == 0 else '--'
        axes.plot(times, values[:, k], style, color=COLORS[k], linewidth=1.3, label=name)


def draw_stance(axes: Axes, feet: Array, in_contact: NDArray[np.bool_], corners: Array) -> None:
    """Draw feet (4, 2) on the ground full and lifted ones hollow, and the support polygon."""
    axes.fill(corners[:, 0], corners[:, 1], color='#dbe6fb', zorder=1)
    for k, foot in enumerate(feet):
        fill = COLORS[k] if in_contact[k] else 'white'
        axes.plot(*foot, 'o', color=COLORS[k], markerfacecolor=fill, markersize=6, zorder=3)
    axes.set_aspect('equal')


def draw_body(axes: Axes, pose: Array, half_length: float, half_width: float) -> None:
    """Draw a body from above: pose x, y, yaw."""
    x = np.array([1.0, 1.0, -1.0, -1.0, 1.0]) * half_length
    y = np.array([1.0, -1.0, -1.0, 1.0, 1.0]) * half_width
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    axes.plot(pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y, color='0.35', linewidth=1.0)
    axes.plot(
        [pose[0], pose[0] + cos * half_length], [pose[1], pose[1] + sin * half_length],
        color='0.35', linewidth=1.0,
    )  # fmt: skip
