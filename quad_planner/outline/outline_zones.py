"""
Whether the robot fits in a cell at a class of headings.

It does wherever its circle fits, at any heading, as for every planning method; and where the
outline keeps its distance. On maps up to a size that is known of all cells and classes in advance
(:mod:`~quad_planner.outline.class_layers`); on larger ones it is looked at when a search asks, and
remembered.

All of it lies in one array, so that compiled functions hand on few.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from quad_common.compiled import compiled_loop, compiled_part
from quad_planner.grid.bit_grid import Bits
from quad_planner.outline.heading_kernels import CLASSES, Integers, Kernels

_ONE = np.uint64(1)
_ALL = ~np.uint64(0)
_LARGEST = 2**24
"""Cells of the largest map of which is remembered what fits."""

_BLOCKED, _CIRCLE, _INNER, _NARROW = range(4)
_MEMORY = 4
"""Words a cell: 2 of what fits, 2 of what is known."""


class Zones(NamedTuple):
    """A map as compiled code is given it; :func:`zones_of` makes it."""

    width: int
    """Width of the map [cells]."""
    height: int
    """Height of the map [cells]."""
    words: int
    """Words of a row of bits."""
    rows: int
    """Rows of a kernel to either side of its cell."""
    kernels_at: int
    """Index of the kernels."""
    memory_at: int
    """Index of what is remembered; 0 if nothing is."""
    classes_at: int
    """Index of the bits of cells where each class does not fit; 0 where they are not known."""
    left: int
    """Least x around a start that may be nearer to obstacles [cells]."""
    right: int
    """Largest x; less than the least where there is none [cells]."""
    bottom: int
    """Least y [cells]."""
    top: int
    """Largest y [cells]."""
    data: Bits
    """
    Bits of cells by rows: obstacles, where the circle does not fit, where no heading fits, and
    where a move leads to from where the circle does not fit; then kernels, and the classes or the
    memory.
    """


def zones_of(
    layers: tuple[Bits, Bits, Bits, Bits],
    width: int,
    kernels: tuple[Kernels, Kernels],
    classes: Bits | None,
) -> Zones:
    """
    Put together what compiled code needs.

    Parameters
    ----------
    layers : tuple of ndarray of uint64, each of shape (height, n)
        The bits of cells, as of :class:`Zones`.
    width : int
        Width of the map [cells].
    kernels : tuple of Kernels
        Those of the outline, and those around a start that may be nearer, with no more rows.
    classes : ndarray of uint64, shape (72, height, n), or None
        As of :func:`~quad_planner.outline.class_layers.class_layers`.

    Returns
    -------
    Zones
        None of them is around a start.
    """
    height, words = layers[0].shape
    rows = kernels[0].rows
    reach = np.ones((2, CLASSES, 2 * rows + 1, 2), dtype=np.int64)
    reach[..., 1] = 0
    for at, kernel in enumerate(kernels):
        inside = slice(rows - kernel.rows, rows + kernel.rows + 1)
        reach[at, :, inside, 0], reach[at, :, inside, 1] = kernel.low, kernel.high
    kernels_at = len(layers) * height * words
    further_at = kernels_at + reach.size
    remembers = classes is None and width * height <= _LARGEST
    further = _MEMORY * width * height if remembers else 0 if classes is None else classes.size
    # Zeros cost nothing until they are touched.
    data = np.zeros(further_at + further, dtype=np.uint64)
    for at, layer in enumerate(layers):
        data[at * height * words : (at + 1) * height * words] = layer.reshape(-1)
    data[kernels_at:further_at] = reach.reshape(-1).view(np.uint64)
    if classes is not None:
        data[further_at:] = classes.reshape(-1)
    memory_at = further_at if remembers else 0
    classes_at = 0 if classes is None else further_at
    sizes = (width, height, words, rows)
    return Zones(*sizes, kernels_at, memory_at, classes_at, 0, -1, 0, -1, data)


def around_start(zones: Zones, x: int, y: int) -> Zones:
    """Return zones in which a robot may be nearer to obstacles around a start's cell."""
    reach = 2 * zones.rows
    return zones._replace(left=x - reach, right=x + reach, bottom=y - reach, top=y + reach)


@compiled_part
def _bit(zones: Zones, layer: int, x: int, y: int) -> bool:
    word = zones.data[(layer * zones.height + y) * zones.words + (x >> 6)]
    return bool(word >> np.uint64(x & 63) & _ONE)


@compiled_part
def is_room(zones: Zones, x: int, y: int) -> bool:
    """Return whether the circle fits in a cell."""
    if x < 0 or y < 0 or x >= zones.width or y >= zones.height:
        return False
    return not _bit(zones, _CIRCLE, x, y)


@compiled_part
def is_narrow(zones: Zones, x: int, y: int) -> bool:
    """Return whether a move from a cell of the map may lead to where the circle does not fit."""
    return _bit(zones, _NARROW, x, y)


@compiled_part
def _is_clear(zones: Zones, x: int, y: int, kernel: int) -> bool:
    """Return whether no obstacle is in the rows of a kernel."""
    rows = zones.rows
    for row in range(max(0, y - rows), min(zones.height, y + rows + 1)):
        at = zones.kernels_at + 2 * (kernel * (2 * rows + 1) + row - y + rows)
        first = max(0, x + int(np.int64(zones.data[at])))
        last = min(zones.width - 1, x + int(np.int64(zones.data[at + 1])))
        if first > last:
            continue
        for word_at in range(first >> 6, (last >> 6) + 1):
            word = zones.data[(_BLOCKED * zones.height + row) * zones.words + word_at]
            if word_at == first >> 6:
                word &= _ALL << np.uint64(first & 63)
            if word_at == last >> 6:
                word &= _ALL >> np.uint64(63 - (last & 63))
            if word:
                return False
    return True


@compiled_part
def _is_clear_by_class(zones: Zones, x: int, y: int, kernel: int) -> bool:
    """Return the same of a cell of the map, where it is known of all."""
    at = zones.classes_at + (kernel * zones.height + y) * zones.words + (x >> 6)
    return not zones.data[at] >> np.uint64(x & 63) & _ONE


@compiled_part
def fits(zones: Zones, x: int, y: int, heading_class: int) -> bool:
    """Return whether the robot fits in a cell at a class of headings."""
    if not (0 <= x < zones.width and 0 <= y < zones.height):
        return False
    if not _bit(zones, _CIRCLE, x, y):
        return True
    if zones.left <= x <= zones.right and zones.bottom <= y <= zones.top:
        return _is_clear(zones, x, y, CLASSES + heading_class)
    if zones.classes_at:
        return _is_clear_by_class(zones, x, y, heading_class)
    if _bit(zones, _INNER, x, y):
        return False
    if zones.memory_at == 0:
        return _is_clear(zones, x, y, heading_class)
    at = zones.memory_at + _MEMORY * (y * zones.width + x) + (heading_class >> 6)
    place = np.uint64(heading_class & 63)
    if zones.data[at + 2] >> place & _ONE:
        return bool(zones.data[at] >> place & _ONE)
    clear = _is_clear(zones, x, y, heading_class)
    if clear:
        zones.data[at] |= _ONE << place
    zones.data[at + 2] |= _ONE << place
    return clear


@compiled_part
def has_room_to_turn(zones: Zones, x: int, y: int) -> bool:
    """Return whether the outline itself fits in a cell of the map at every heading."""
    k = 0
    if zones.classes_at:
        while k < CLASSES and _is_clear_by_class(zones, x, y, k):
            k += 1
        return k == CLASSES
    while k < CLASSES and _is_clear(zones, x, y, k):
        k += 1
    return k == CLASSES


@compiled_loop
def fits_in(zones: Zones, x: int, y: int, heading_class: int) -> bool:
    """Return whether the robot fits in a cell at a class of headings."""
    return fits(zones, x, y, heading_class)


@compiled_part
def leg_fits(zones: Zones, x0: float, y0: float, x1: float, y1: float, heading_class: int) -> bool:
    """Return whether the robot fits in all cells that a segment touches, at a class [cells]."""
    if y1 < y0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    slope = (x1 - x0) / (y1 - y0) if y1 - y0 > 1e-9 else 0.0
    for row in range(math.floor(y0 - 1e-9), math.floor(y1 + 1e-9) + 1):
        if y1 - y0 > 1e-9:
            begin = x0 + (min(max(y0, row - 1e-9), y1) - y0) * slope
            end = x0 + (max(min(y1, row + 1.0 + 1e-9), y0) - y0) * slope
        else:
            begin, end = x0, x1
        first = math.floor(min(begin, end) - 1e-9)
        for column in range(first, math.floor(max(begin, end) + 1e-9) + 1):
            if not is_room(zones, column, row) and not fits(zones, column, row, heading_class):
                return False
    return True


@compiled_loop
def fitting_classes(zones: Zones, x: int, y: int, result: Integers) -> int:
    """Fill an array of 72 with 1 where a class fits in a cell; return how many do."""
    count = 0
    for k in range(CLASSES):
        result[k] = fits(zones, x, y, k)
        count += result[k]
    return count


@compiled_part
def classes_beside(zones: Zones, x: int, y: int, heading_class: int, result: Integers) -> int:
    """
    Fill an array of 72 with 1 where a class fits in a cell, and all from a given one to it.

    Returns how many do: all, or those to either side up to the first that does not fit.
    """
    for k in range(CLASSES):
        result[k] = 0
    result[heading_class] = 1
    count = 1
    for side in (-1, 1):
        for step in range(1, CLASSES):
            k = (heading_class + side * step) % CLASSES
            if result[k] or not fits(zones, x, y, k):
                break
            result[k] = 1
            count += 1
    return count
