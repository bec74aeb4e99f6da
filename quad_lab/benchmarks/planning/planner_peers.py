"""
Other methods for a shortest path on a grid, from well-known libraries, to compare times with.

Each takes the occupied cells, the radius and two cells, and returns the path's length; a
library that is not installed is left out.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Cell = tuple[int, int]
Peer = Callable[[Mask, float, Cell, Cell], float]


def available_peers() -> dict[str, Peer]:
    """Return those whose library is there, by name."""
    peers: dict[str, tuple[str, Peer]] = {
        'scipy: exact distances, csgraph.dijkstra': ('scipy', _scipy),
        'OpenCV and skimage route_through_array': ('skimage', _skimage),
        'OpenCV and pyastar2d': ('pyastar2d', _pyastar2d),
        'OpenCV and tcod': ('tcod', _tcod),
    }
    return {
        name: peer
        for name, (module, peer) in peers.items()
        if importlib.util.find_spec(module) is not None
    }


def _forbidden(occupied: Mask, radius: float) -> Mask:
    """Inflate as a user of OpenCV does: centers nearer than the radius to a center."""
    if not occupied.any():
        return occupied
    distance = cv2.distanceTransform(1 - occupied.astype(np.uint8), cv2.DIST_L2, 5)
    return np.asarray(distance < radius, dtype=np.bool_)


def _scipy(occupied: Mask, radius: float, start: Cell, goal: Cell) -> float:
    from scipy.ndimage import distance_transform_edt
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    free = np.asarray(distance_transform_edt(~occupied)) >= radius
    height, width = free.shape
    numbers = np.arange(height * width).reshape(free.shape)
    firsts, seconds, lengths = [], [], []
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        rows, left, right = slice(0, height - dy), max(-dx, 0), width - max(dx, 0)
        here = (rows, slice(left, right))
        there = (slice(dy, height), slice(left + dx, right + dx))
        may = free[here] & free[there]
        if dy and dx:
            # No corner is cut.
            may &= free[rows, left + dx : right + dx] & free[dy:height, left:right]
        firsts.append(numbers[here][may])
        seconds.append(numbers[there][may])
        lengths.append(np.full(may.sum(), math.hypot(dx, dy)))
    graph = coo_array(
        (np.concatenate(lengths), (np.concatenate(firsts), np.concatenate(seconds))),
        shape=(height * width, height * width),
    ).tocsr()
    source, target = (y * width + x for x, y in (start, goal))
    return float(dijkstra(graph, directed=False, indices=source)[target])


def _skimage(occupied: Mask, radius: float, start: Cell, goal: Cell) -> float:
    from skimage.graph import route_through_array

    costs = np.where(_forbidden(occupied, radius), -1.0, 1.0)
    _, length = route_through_array(costs, start[::-1], goal[::-1], geometric=True)
    return float(length)


def _pyastar2d(occupied: Mask, radius: float, start: Cell, goal: Cell) -> float:
    import pyastar2d

    costs = np.where(_forbidden(occupied, radius), np.float32(np.inf), np.float32(1.0))
    path = pyastar2d.astar_path(costs, start[::-1], goal[::-1], allow_diagonal=True)
    return math.inf if path is None else float(np.hypot(*np.diff(path, axis=0).T).sum())


def _tcod(occupied: Mask, radius: float, start: Cell, goal: Cell) -> float:
    import tcod.path

    free = (~_forbidden(occupied, radius)).astype(np.int32)
    graph = tcod.path.SimpleGraph(cost=free, cardinal=70, diagonal=99)
    finder = tcod.path.Pathfinder(graph)
    finder.add_root(start[::-1])
    path = finder.path_to(goal[::-1])
    return float(np.hypot(*np.diff(path, axis=0).T).sum()) if len(path) > 1 else math.inf
