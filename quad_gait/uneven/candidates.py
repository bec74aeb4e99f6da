"""
What is tried of a swing, and of a motion of the body, in which order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import product
from typing import TypeVar

from quad_common.errors import GaitError
from quad_common.footing.postures import HIGHER, LOWER, LOWERINGS, TILTS

Planned = TypeVar('Planned')

_FRACTIONS = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Fractions of a step, of which the legs may reach one only."""

_LOW_LIFT = 0.3
"""Fraction of its usual height over the ground at which a foot whose thigh is in the way swings."""

LOWEST = LOWER[-1]
"""Largest of these distances [m]."""


def _swing_cost(kind: tuple[float, ...]) -> float:
    """Return what a swing is worse by: a lower body costs little, a tilt most."""
    fraction, tilt, lower, clearance = kind
    unusual = 2.0 * (lower < 0.0) + 2.0 * (clearance < 1.0)
    # A foot that is put down where it stood gets on least of all.
    return (1.0 - fraction) + 0.75 * tilt + 3.0 * abs(lower) + unusual + 10.0 * (fraction == 0.0)


VARIANTS = sorted(
    [
        *product(_FRACTIONS, TILTS, LOWERINGS, (1.0,)),
        *product((1.0, 0.5), (0.0, 1.0), (0.0, HIGHER[0]), (_LOW_LIFT,)),
    ],
    key=_swing_cost,
)
"""Kinds of swings in the order in which they are tried: fraction of the step, tilt, lowering, and
fraction of the height that the foot is to be above the ground."""

_LONG_VARIANTS = [kind for kind in VARIANTS if kind[0] >= 0.5]
"""Those of steps that are no less than half as long."""

LEVEL_VARIANTS = [kind for kind in _LONG_VARIANTS if kind[1] == 0.0]
"""Those of them in which the body stays level, tried where a shin would meet an edge."""

STRAINED_VARIANTS = [(*kind, 1.0) for kind in _LONG_VARIANTS if kind[3] == 1.0]
"""Those of them that are lifted as high as usual, with the center of mass less far inside the other
feet, as a fifth number says: tried last, where legs do not reach otherwise."""

_PACES = (1.0, 0.6, 0.35)
"""Fractions of its speed at which a foot goes to a foothold that was chosen for it."""

IN_PLACE = [
    (*kind[1:], pace, less)
    for less in (0.0, 1.0)
    for kind in VARIANTS
    if kind[0] == 1.0
    for pace in _PACES
]
"""The same of swings that do the whole step, with the fraction of a foot's speed in place of that
of the step, and whether less margin will do."""

LEANS = sorted(
    product(_FRACTIONS, TILTS, LOWER),
    # Where the body is counts more than how low it is, and less than that it is level.
    key=lambda kind: (1.0 - kind[0]) + 3.0 * kind[1] + 3.0 * kind[2],
) + list(product(_FRACTIONS, TILTS, HIGHER))
"""Fractions of the way to its place that the body leans, tilts and lowerings, in that order."""

SEARCHES, QUICK_SEARCHES = ((1.0,),), ((3.0,), (2.0,), (1.0,))
"""Multiples of its speed at which a foot is lowered, usually and where another one slips."""

POSTURES = tuple(product(TILTS, LOWERINGS))
"""Tilts and lowerings, in the order in which they are tried."""


def first_possible(
    plan: Callable[..., Planned],
    candidates: Iterable[tuple[float, ...]],
    may_do: Callable[..., bool] | None = None,
) -> tuple[Planned, GaitError | None]:
    """
    Plan by one candidate after the other.

    Parameters
    ----------
    plan : callable
        Plans by a candidate, or raises GaitError.
    candidates : iterable of tuple of float
        In the order in which they are tried.
    may_do : callable, optional
        Looks at a candidate quickly: where it returns False, `plan` would raise.

    Returns
    -------
    planned
        By the first candidate that works.
    problem : GaitError or None
        What was wrong with the first one.

    Raises
    ------
    GaitError
        What was wrong with the first one, if none works.
    """
    problem: GaitError | None = None
    for candidate in candidates:
        # Of the first one that does not work it is said why, so that is planned in any case.
        if problem is not None and may_do is not None and not may_do(*candidate):
            continue
        try:
            return plan(*candidate), problem
        except GaitError as error:
            problem = problem or error
    assert problem is not None
    raise problem
