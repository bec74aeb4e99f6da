"""
What a recording has to be: as many messages as were published, and transforms that do not leap.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

Vector = tuple[float, ...]

_SPARE = 1.1
"""Joints that physics moves may be faster than they should by a little."""

_NOISE = 1e-3
"""Step that numbers with noise may make at any time [m, rad]."""


@dataclass(frozen=True)
class Moved:
    """A transform at a time."""

    parent: str
    """Name of the frame that it is in."""
    child: str
    """Name of the frame that it places."""
    time: float
    """Time of its stamp [s]."""
    position: Vector
    """Place in the parent's frame [m]."""
    turn: Vector
    """Orientation there, a quaternion xyzw."""


@dataclass(frozen=True)
class Limits:
    """How fast a frame moves at most."""

    speed: float
    """Of its origin [m/s]."""
    rate: float
    """Of its axes [rad/s]."""


def differing(heard: Sequence[object], recorded: Sequence[object], needed: int) -> int:
    """
    Count messages of a topic that only one of two listeners has.

    Both listened until the publisher was silent; either may have begun before the other.

    Parameters
    ----------
    heard, recorded : sequence
        What each received, in its order.
    needed : int
        Number of messages at the end of ``recorded`` for which both were there.

    Returns
    -------
    int
        0 if they end in the same messages, the needed ones at least; 1 at least otherwise.
    """
    both = min(len(heard), len(recorded))
    if both >= max(needed, 1) and list(heard[-both:]) == list(recorded[-both:]):
        return 0
    first, second = Counter(heard[-needed:]), Counter(recorded[-needed:])
    only_one = (first - second).total() + (second - first).total()
    return max(1, only_one) if heard or recorded else 0


def jumps(transforms: Iterable[Moved], limits: Mapping[str, Limits], others: Limits) -> int:
    """
    Count steps of frames that are larger than their speed allows, or go back in time.

    Parameters
    ----------
    transforms : iterable of Moved
        In the order in which they come.
    limits : mapping of str to Limits
        By names of frames.
    others : Limits
        Of all other frames.
    """
    last: dict[str, Moved] = {}
    count = 0
    for moved in transforms:
        before = last.get(moved.child)
        last[moved.child] = moved
        if before is None:
            continue
        passed, limit = moved.time - before.time, limits.get(moved.child, others)
        count += (
            passed < 0.0
            or moved.parent != before.parent
            or math.dist(moved.position, before.position) > _most(limit.speed, passed)
            or angle_between(moved.turn, before.turn) > _most(limit.rate, passed)
        )
    return count


def angle_between(first: Vector, second: Vector) -> float:
    """Return the angle between two orientations, quaternions [rad]."""
    # By the chord, which is exact for small angles as a cosine is not.
    apart = math.dist(first, second)
    opposite = math.hypot(*(a + b for a, b in zip(first, second)))
    return 4.0 * math.asin(min(1.0, min(apart, opposite) / 2.0))


def without_way(edges: Iterable[tuple[str, str]], root: str) -> set[str]:
    """Return the frames, of pairs of parent and child, that do not lead to a root."""
    parents = {child: parent for parent, child in edges}
    lost = set()
    for frame in parents:
        end, seen = frame, {frame}
        while end in parents and parents[end] not in seen:
            end = parents[end]
            seen.add(end)
        if end != root:
            lost.add(frame)
    return lost


def _most(speed: float, passed: float) -> float:
    return _SPARE * speed * passed + _NOISE
