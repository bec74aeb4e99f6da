"""
Dijkstra's algorithm, on any graph whose vertices can be hashed (S0 eq. 4).

    L_k(s, v) = min { L_{k-1}(s, v); L_{k-1}(s, u) + w(u, v) }

with s the source, u the vertex visited last, w(u, v) >= 0 the cost of the edge, and
L_k(s, v) the least cost known after visit k. The vertex of least L is visited next, and
its L is final; S0 collects the visited vertices in its vector V.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from itertools import count
from typing import Generic, TypeVar

from quad_planner.search.search_loop import path_back

V = TypeVar('V', bound=Hashable)
Cost = TypeVar('Cost', int, float)

_VISITS_BETWEEN_CHECKS = 256
"""A check costs as much as a visit."""


@dataclass(frozen=True)
class DijkstraResult(Generic[V, Cost]):
    """A cheapest path and how it was found."""

    path: tuple[V, ...]
    """Nodes from the source to the goal."""
    cost: Cost
    """Cost of the path, in the unit of the edges."""
    visited: tuple[V, ...]
    """The vertices in the order in which their cost became final: S0's V."""


def shortest_path(
    neighbours: Callable[[V], Iterable[tuple[V, Cost]]],
    source: V,
    goal: V,
    check: Callable[[], None] = lambda: None,
) -> DijkstraResult[V, Cost] | None:
    """
    Find a cheapest path.

    Among equal costs the vertex that was reached first is visited first, so the result
    depends on the graph alone.

    Parameters
    ----------
    neighbours : callable
        Takes a vertex u and gives its edges as pairs (v, w(u, v)), all w >= 0.
    source, goal : hashable
        Ends of the path.
    check : callable
        Called now and then; raises to end the search.

    Returns
    -------
    DijkstraResult or None
        None if the goal cannot be reached.
    """
    least: dict[V, Cost] = {source: 0}
    previous: dict[V, V] = {}
    visited: dict[V, None] = {}
    order = count()
    # The running number decides among equal costs: vertices need not be comparable.
    queue: list[tuple[Cost, int, V]] = [(0, next(order), source)]
    while queue:
        cost, _, u = heapq.heappop(queue)
        if u in visited:
            continue
        visited[u] = None
        if u == goal:
            return DijkstraResult(
                tuple(path_back(previous.__getitem__, goal, source)), cost, tuple(visited)
            )
        if len(visited) % _VISITS_BETWEEN_CHECKS == 0:
            check()
        for v, w in neighbours(u):
            through_u = cost + w
            if v not in least or through_u < least[v]:
                least[v] = through_u
                previous[v] = u
                heapq.heappush(queue, (through_u, next(order), v))
    return None
