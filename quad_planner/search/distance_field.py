"""
How far every cell of a map is from one of them, by straight and diagonal steps.

The lengths are those of :mod:`quad_planner.search.jump_points`: exact, no corner cut. Harabor
and Grastien's pruning rules (AAAI 2011) leave one path to most cells: diagonally first,
then straight on. So cells are reached by whole runs along rows, columns and diagonals,
and only where a wall beside a run ends, or a run has become long, its last cell has to
wait in a queue.

A cell is one word of 64 bits: the length found so far, the directions it was found from,
which neighbours are free, and where runs end. One look in the memory tells everything.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part, inlined_part
from quad_common.errors import ParameterError
from quad_planner.grid.array_types import Mask
from quad_planner.grid.bucket_queue import (
    bucket_queue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    push,
    with_room,
)
from quad_planner.search.cell_steps import DIAGONAL, ONWARD, STRAIGHT

Integers = NDArray[np.int64]

NOT_REACHED = -1
"""The length of cells that are not allowed, or that no path reaches."""

# A word: length << 24 | arrivals << 16 | around << 8 | runs; negative if not allowed.
# Bit k of arrivals and around stands for direction k, which is k times 45 degrees. Bit k of
# runs: a run in direction 2 k ends here. Bit 4 + k: one may step in direction 2 k + 1.
_LENGTH, _ARRIVALS, _AROUND = 24, 16, 8
_KEPT = (1 << _ARRIVALS) - 1
_FAR = (1 << 39) - 1
_BLOCKED = -1

_WINDOW = 64 * STRAIGHT
"""A run that is longer goes on when it is its turn: beyond, others may be shorter."""
_BUCKET = 12
"""Binary logarithm of the width of a bucket of the queue."""
_MOST_PUSHES = 4 + 4 * (2 * (_WINDOW // DIAGONAL + 2) + 1)
"""Number of cells that one expansion pushes at most."""
_EXPANSIONS = 4096
"""Number of expansions between two calls of `check`."""


class Beyond(NamedTuple):
    """Which cells are of no interest: those through which no path is short enough."""

    x: int
    """Cell where the paths through a cell end."""
    y: int
    """Cell where the paths through a cell end."""
    longest: int
    """Length that they have at most, in straight and diagonal steps."""


_NOWHERE = Beyond(0, 0, -1)


def distance_field(
    allowed: Mask,
    start: tuple[int, int],
    check: Callable[[], None] = lambda: None,
    beyond: Beyond = _NOWHERE,
) -> Integers:
    """
    Measure the shortest path from one cell to every other.

    Parameters
    ----------
    allowed : ndarray of bool, shape (height, width)
        Cells that a path may enter.
    start : tuple of int
        x and y of a cell of the map.
    check : callable
        Called again and again; raises to end the search.
    beyond : Beyond
        Cells of no interest. Their lengths may be too large, or missing; if it is left out, all
        cells are of interest.

    Returns
    -------
    ndarray of int64, shape (height, width)
        `STRAIGHT` for each straight step and `DIAGONAL` for each diagonal one;
        `NOT_REACHED` where no path leads, and everywhere if the start is not allowed.

    Raises
    ------
    ParameterError
        If the start is no cell of the map.
    """
    words = distance_words(allowed, start, check, beyond)
    _keep_lengths(words)
    return words[1:-1, 1:-1]


def distance_words(
    allowed: Mask,
    start: tuple[int, int],
    check: Callable[[], None] = lambda: None,
    beyond: Beyond = _NOWHERE,
) -> Integers:
    """
    Measure as :func:`distance_field` does, and keep what is known of each cell beside its length.

    Parameters
    ----------
    allowed, start, check, beyond
        As for :func:`distance_field`.

    Returns
    -------
    ndarray of int64, shape (height + 2, width + 2)
        Words of the cells, in a wall one cell wide, for :func:`word_length` and `may_step`.

    Raises
    ------
    ParameterError
        If the start is no cell of the map.
    """
    height, width = allowed.shape
    x, y = start
    if not (0 <= x < width and 0 <= y < height):
        raise ParameterError('start', start, f'a cell of a map of {width} x {height} cells')
    padded = np.zeros((height + 2, width + 2), dtype=np.uint8)
    padded[1:-1, 1:-1] = allowed
    words = np.empty((height + 2, width + 2), dtype=np.int64)
    _make_words(padded, words)
    if allowed[y, x]:
        _search(words, (y + 1) * (width + 2) + x + 1, beyond, check)
    return words


@inlined_part
def word_length(word: int) -> int:
    """Return the length that a cell's word holds; `NOT_REACHED` where there is none."""
    length = int(word) >> _LENGTH
    return length if length < _FAR else NOT_REACHED


@inlined_part
def may_step(word: int, direction: int) -> bool:
    """Return whether a step from a cell is free, by its word; a diagonal needs both beside it."""
    place = 4 + (direction >> 1) if direction & 1 else _AROUND + direction
    return bool(int(word) >> place & 1)


def _search(words: Integers, start: int, beyond: Beyond, check: Callable[[], None]) -> None:
    """Reach every cell; `start` is the place of a cell in `words`."""
    flat = words.reshape(-1)
    width = words.shape[1]
    offsets = np.array([1, width + 1, width, width - 1, -1, -width - 1, -width, 1 - width])
    queue = bucket_queue((_WINDOW + DIAGONAL >> _BUCKET) + 1)
    flat[start] &= _KEPT
    push(*queue, start, 0, 0)
    while not is_empty(queue.state):
        queue = with_room(queue, _MOST_PUSHES)
        _expand(flat, offsets, ONWARD, beyond, *queue, _EXPANSIONS)
        check()


@compiled_loop
def _make_words(padded: NDArray[np.uint8], words: Integers) -> None:
    """Describe cells by their neighbours; `padded` is 1 where allowed, in a wall of 0."""
    height, width = padded.shape
    words[0] = _BLOCKED
    words[height - 1] = _BLOCKED
    for y in range(1, height - 1):
        below, here, above = padded[y - 1], padded[y], padded[y + 1]
        words[y, 0] = _BLOCKED
        words[y, width - 1] = _BLOCKED
        for x in range(1, width - 1):
            e, w, n, s = here[x + 1], here[x - 1], above[x], below[x]
            ne, nw, se, sw = above[x + 1], above[x - 1], below[x + 1], below[x - 1]
            around = e | ne << 1 | n << 2 | nw << 3 | w << 4 | sw << 5 | s << 6 | se << 7
            # A wall ahead, or a wall beside the last cell and none beside this one.
            ends = e ^ 1 | n & (nw ^ 1) | s & (sw ^ 1)
            ends |= (n ^ 1 | w & (sw ^ 1) | e & (se ^ 1)) << 1
            ends |= (w ^ 1 | s & (se ^ 1) | n & (ne ^ 1)) << 2
            ends |= (s ^ 1 | e & (ne ^ 1) | w & (nw ^ 1)) << 3
            diagonals = e & ne & n | (n & nw & w) << 1 | (w & sw & s) << 2 | (s & se & e) << 3
            word = _FAR << _LENGTH | np.int64(around) << _AROUND | diagonals << 4 | ends
            words[y, x] = word if here[x] else _BLOCKED


@compiled_loop
def _keep_lengths(words: Integers) -> None:
    """Reduce words to their lengths."""
    for y in range(words.shape[0]):
        for x in range(words.shape[1]):
            length = words[y, x] >> _LENGTH
            words[y, x] = length if length < _FAR else NOT_REACHED


@compiled_loop
def _expand(
    words: Integers,
    offsets: Integers,
    onward: NDArray[np.uint8],
    beyond: Beyond,
    heads: Integers,
    entries: Integers,
    state: Integers,
    most: int,
) -> None:
    """
    Go on from cells that wait, the nearest first, by the width of a bucket.

    Returns after `most` of them, or when there is too little room for what may be pushed.
    """
    width = offsets[2]
    for _ in range(most):
        if is_empty(state) or not has_room(entries, state, _MOST_PUSHES):
            return
        limit = (next_bucket(heads, state) << _BUCKET) + _WINDOW
        cell, key = pop(heads, entries, state)
        word = words[cell]
        if word >> _ARRIVALS != key:
            # A shorter path was found, or another as short: that one waits too.
            continue
        length = word >> _LENGTH
        if beyond.longest >= 0:
            # There is a wall of one cell around the map.
            dx, dy = abs(cell % width - 1 - beyond.x), abs(cell // width - 1 - beyond.y)
            least = STRAIGHT * max(dx, dy) + (DIAGONAL - STRAIGHT) * min(dx, dy)
            if length + least > beyond.longest:
                # Nor is any cell farther on.
                continue
        directions = onward[(word >> _ARRIVALS) & 255, (word >> _AROUND) & 255]
        for k in range(0, 8, 2):
            if directions >> k & 1:
                end = _run(words, onward, cell, length, k, offsets[k], limit)
                _wait(words, heads, entries, state, end)
            if directions >> (k + 1) & 1:
                at, done = cell, length
                # Diagonally, and straight to both sides from every cell.
                while words[at] >> (4 + k // 2) & 1:
                    at += offsets[k + 1]
                    done += DIAGONAL
                    if not _reach(words, at, done, k + 1):
                        break
                    if done > limit:
                        _wait(words, heads, entries, state, at)
                        break
                    for side in (k, (k + 2) & 7):
                        end = _run(words, onward, at, done, side, offsets[side], limit)
                        _wait(words, heads, entries, state, end)


@compiled_part
def _wait(words: Integers, heads: Integers, entries: Integers, state: Integers, cell: int) -> None:
    """Let a cell wait, if it is one."""
    if cell >= 0:
        word = words[cell]
        push(heads, entries, state, cell, word >> _ARRIVALS, word >> (_LENGTH + _BUCKET))


@compiled_part
def _reach(words: Integers, cell: int, length: int, direction: int) -> bool:
    """Note a path to a cell; return whether it is to be followed."""
    word = words[cell]
    known = word >> _LENGTH
    arrival = 1 << (_ARRIVALS + direction)
    if length < known:
        words[cell] = length << _LENGTH | arrival | (word & _KEPT)
        return True
    if length == known and not word & arrival:
        words[cell] = word | arrival
        return True
    return False


@compiled_part
def _run(
    words: Integers,
    onward: NDArray[np.uint8],
    cell: int,
    length: int,
    direction: int,
    offset: int,
    limit: int,
) -> int:
    """Go straight on; return the cell from which others must be looked at, or -1."""
    end = 1 << (direction >> 1)
    while True:
        cell += offset
        length += STRAIGHT
        if not _reach(words, cell, length, direction):
            return -1
        word = words[cell]
        if word & end or length > limit:
            goes_on = onward[(word >> _ARRIVALS) & 255, (word >> _AROUND) & 255]
            return cell if goes_on else -1
