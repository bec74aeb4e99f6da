"""
Costs of steps, turns and whole gait cycles for searches over cells and eight headings.

Costs are whole numbers, so equal costs are equal. The bound on what is left (:func:`total_cost`)
is the length of the shortest path, and the least turns that a path over free ground takes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import inlined_part
from quad_common.robot_files.walking_time import LENGTH_SLACK
from quad_planner.search.cell_steps import DIAGONAL, STRAIGHT
from quad_planner.search.walk_terms import WalkTerms

Numbers = NDArray[np.int64]


HEADINGS = 8
"""Heading k points at k times 45 degrees."""


_SCALES = ((470832, 665857), (80782, 114243), (13860, 19601), (2378, 3363))
"""Straight and diagonal steps in whole numbers: the nearer to sqrt 2, the larger."""


def _leading() -> NDArray[np.bool_]:
    """Tabulate whether headings a and b lead into sector s (`_sector`), shape (16, 8, 8)."""
    sector, low, high = np.ogrid[:16, :16:2, :16:2]
    cone = (high - low) % 16
    is_between: NDArray[np.bool_] = (cone < 8) & ((sector - low) % 16 <= cone)
    return is_between | is_between.transpose(0, 2, 1)


_LEADS = _leading()


NOT_REACHED = 2**31 - 1


LARGEST = 2**30
"""Costs up to here are looked at: there is room for what is added to them."""


class Costs(NamedTuple):
    """Costs of steps, cycles and turns, in whole numbers."""

    straight: int
    """Cost of a step to a cell beside."""
    diagonal: int
    """Cost of a diagonal step."""
    cycle: int
    """Cost of one cycle: where the robot turns, costs are rounded up to a multiple of it."""
    pause: int
    """Cost of the pause of a stretch: a part of the cost of the turn before it."""
    bucket: int
    """States wait together whose costs, with the bound on what is left, are so near."""
    longest: int
    """A path must cost less."""
    scale: float
    """Cost of a step, of its length in :mod:`quad_planner.search.cell_steps`, at least."""
    turns: Numbers
    """Costs of a turn and the pause of the stretch that follows it, shape (8, 8)."""
    first_turns: Numbers
    """
    Costs of the turns from the start's heading to each of the eight, with the pause, shape (8,).
    """
    last_turns: Numbers
    """Costs of the turns from each to the goal's heading, shape (8,)."""
    least_turns: Numbers
    """Least costs of turns, shape (8, 17), see :func:`least_turns_of`."""
    excess: Numbers
    """How much more a turn may cost from one heading than from another: :func:`excess_of`."""


def costs_of(terms: WalkTerms) -> Costs:
    """Count the costs of a pace on the finest scale that can hold the bound's cycles."""
    pace, bound = terms.pace, terms.bound
    strides = pace.stride / terms.resolution * (1.0 + LENGTH_SLACK)
    scale = 0
    while scale + 1 < len(_SCALES) and bound * strides * _SCALES[scale][0] > LARGEST:
        scale += 1
    straight, diagonal = _SCALES[scale]
    cycle = max(1, math.floor(strides * straight))
    pause = round(pace.stopping * cycle)
    headings = [math.radians(45.0 * k) for k in range(HEADINGS)]
    turns = [[pace.turn_cycles(b - a) * cycle + pause for b in headings] for a in headings]
    first = [pace.turn_cycles(b - terms.start_yaw) * cycle + pause for b in headings]
    last = np.array([pace.last_turn_cycles(terms.goal_yaw - a) * cycle for a in headings])
    longest = min(bound * cycle, LARGEST // cycle * cycle)
    least = least_turns_of(np.array(turns), last)
    least_scale = min(straight / STRAIGHT, diagonal / DIAGONAL)
    return Costs(
        straight,
        diagonal,
        cycle,
        pause,
        cycle,
        longest,
        least_scale,
        np.array(turns),
        np.array(first),
        last,
        least,
        excess_of(np.array(turns)),
    )


def excess_of(turns: Numbers) -> Numbers:
    """
    Tabulate how much more a turn may cost from one heading than from another, to any heading.

    Parameters
    ----------
    turns : ndarray of int, shape (8, 8)
        Costs of turns.

    Returns
    -------
    ndarray of int, shape (8, 8)
        If the robot can rest at a place in heading a at a cost, then in heading b it is of no use
        to turn there at that cost and excess[a, b].
    """
    from_one = np.where(np.eye(HEADINGS, dtype=np.bool_), 0, turns)
    # From b to b is no turn.
    from_other = np.where(np.eye(HEADINGS, dtype=np.bool_), NOT_REACHED, turns)
    excess: Numbers = (from_one[:, None] - from_other[None]).max(axis=2)
    return excess


def least_turns_of(turns: Numbers, last_turns: Numbers) -> Numbers:
    """
    Tabulate the least that turns may cost between a cell and the goal over free ground.

    A path over free ground goes along one heading or two (of more, two would do: any
    displacement in the plane lies between two of those it is made of).

    Parameters
    ----------
    turns, last_turns : ndarray of int, shapes (8, 8) and (8,)
        Costs of turns.

    Returns
    -------
    ndarray of int, shape (8, 17)
        Least costs by the heading of the robot and the sector of the goal, see `_sector`.
    """
    # To be content with nearly the goal's heading may save a cycle in an earlier turn: two
    # turns may then cost less than one.
    least_last = np.minimum(last_turns, (turns + last_turns).min(axis=1))
    to_other = np.where(np.eye(HEADINGS, dtype=np.bool_), 0, turns)
    # From the robot's heading to a, walk, to b, walk, and to the goal's.
    paths = to_other[:, :, None] + (to_other + least_last)
    over_ground = np.where(_LEADS, paths[:, None], NOT_REACHED).min(axis=(2, 3))
    return np.column_stack((over_ground, least_last))


@inlined_part
def _sector(dx: int, dy: int) -> int:
    """
    Return where a displacement points.

    2 k along heading k, 2 k + 1 between headings k and k + 1, 16 for none.
    """
    along, across = abs(dx), abs(dy)
    if along == 0 and across == 0:
        return 16
    if across == 0:
        return 0 if dx > 0 else 8
    if along == 0:
        return 4 if dy > 0 else 12
    quarter = 1 if along > across else (2 if along == across else 3)
    if dy > 0:
        return quarter if dx > 0 else 8 - quarter
    return 16 - quarter if dx > 0 else 8 + quarter


@inlined_part
def total_cost(
    cost: int, left: int, dx: int, dy: int, heading: int, scale: float, least_turns: Numbers
) -> int:
    """
    Return a cost and the least that is left.

    The length is that of the shortest path, `left`, as in `cell_steps`; so far from the goal a
    heading needs turns. Cells where it is negative are on no path that is short enough.
    """
    if left < 0:
        return NOT_REACHED
    return cost + int(scale * left) + int(least_turns[heading, _sector(dx, dy)])
