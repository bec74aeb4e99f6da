"""
What searches have in common: the loop around compiled expansions, and how a path is read back.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from quad_planner.grid.bucket_queue import BucketQueue, with_room

V = TypeVar('V')

DONE, PAUSED, FULL = 0, 1, 2
"""Outcomes of a part of a search: it is over, it is to go on, or the queue needs more room."""


def run_search(
    expand: Callable[[BucketQueue], int],
    queue: BucketQueue,
    least_room: int,
    check: Callable[[], None],
) -> None:
    """
    Go on with a search until it is done.

    Parameters
    ----------
    expand : callable
        Does a part of it, and returns one of the outcomes above.
    queue : BucketQueue
        Queue of what waits.
    least_room : int
        Number of entries by which a full queue grows at least; it doubles if that is more.
    check : callable
        Called between two parts; raises to end the search.
    """
    while True:
        outcome = expand(queue)
        if outcome == DONE:
            return
        if outcome == FULL:
            queue = with_room(queue, max(least_room, len(queue.entries)))
        check()


def path_back(before: Callable[[V], V], last: V, first: V) -> list[V]:
    """
    Read a path from where each of its places was reached.

    Parameters
    ----------
    before : callable
        Takes a place and returns the one before it.
    last, first : hashable or int
        Ends of the path.

    Returns
    -------
    list
        The places from the first to the last.
    """
    places = [last]
    while places[-1] != first:
        places.append(before(places[-1]))
    return places[::-1]
