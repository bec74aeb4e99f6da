"""
The legs of a plan: which turning points of a path are kept.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.grid.array_types import Points
from quad_planner.outline.heading_kernels import CLASSES, STEP, Integers
from quad_planner.outline.outline_zones import Zones, fitting_classes, has_room_to_turn, leg_fits
from quad_planner.outline.turn_rule import may_turn

Floats = NDArray[np.float64]

_TURN_COST = 0.15
"""Length that a turn by one radian counts where the gait's pace is not known [m]."""

_OVERSHOOT = 0.1
"""Distance that a robot may walk on before it comes to rest for a turn [m]."""

_TIGHT_CYCLES = 6.0
"""Cycles that a turn counts more where there is little room."""

_TIGHT_LENGTH = 2.0
"""The same where lengths are counted [m]."""

_NEAR_GOAL = 12
"""Turning points before the goal that may be moved as the goal is."""


class LegCosts(NamedTuple):
    """Costs of legs and turns, in cycles or in lengths."""

    stride: float
    """Length of a cycle; 0 to count lengths [cells]."""
    turn: float
    """Turn of a cycle [rad]; or the cost of a radian."""
    stopping: float
    """Part of a cycle that is added to each."""
    bend: float
    """Smaller turns cost nothing [rad]."""
    tight: float
    """Cost of a turn where there is little room: it is better made elsewhere."""
    overshoot: float
    """Distance that a robot may walk on before it comes to rest for a turn [cells]."""

    @classmethod
    def of(cls, pace: WalkingTimeModel | None, resolution: float) -> LegCosts:
        """Take the costs of a gait, or lengths if there is none; resolution in [m]."""
        far = _OVERSHOOT / resolution
        if pace is None:
            return cls(0.0, _TURN_COST / resolution, 0.0, 0.0, _TIGHT_LENGTH / resolution, far)
        stride = pace.stride / resolution
        return cls(stride, pace.turn, pace.stopping, pace.bend, _TIGHT_CYCLES, far)


@dataclass(frozen=True)
class LegEnds:
    """Start and goal of the legs, in the axes of the cells."""

    start: Points
    """Place of the start [cells]."""
    start_yaw: float
    """Heading there [rad]."""
    goal: Points
    """Place of the goal [cells]."""
    goal_yaw: float
    """Heading there [rad]."""
    fixed_class: int
    """Class of the heading that is kept all along; -1 where the robot walks ahead."""


def chosen_legs(
    zones: Zones, path: Points, ends: LegEnds, costs: LegCosts, window: int
) -> Points | None:
    """
    Choose the turning points that cost least, of those of a path.

    Parameters
    ----------
    zones : Zones
        The map.
    path : ndarray, shape (n, 2)
        Places where moves begin and end, from the start to the cell of the goal [cells].
    ends : LegEnds
        Start and goal.
    costs : LegCosts
        Costs of legs and turns.
    window : int
        Turning points that one leg passes over, at most.

    Returns
    -------
    ndarray, shape (m, 2), or None
        From the start to the goal [cells]; None where no legs lead to the goal's very place.
    """
    points, order = _turning_places(path, ends)
    count = len(points)
    # By a turning point, and how many on the leg leads: one leg passes over few.
    most = int((np.searchsorted(order, order + window, side='right') - np.arange(count)).max())
    shape = (count, most)
    before = np.empty(shape, dtype=np.int64)
    last = _choose(
        zones,
        points,
        order,
        np.array([ends.start_yaw, ends.goal_yaw]),
        ends.fixed_class,
        window,
        costs,
        np.full(shape, np.inf),
        before,
        np.empty(shape),
        (np.empty(CLASSES, dtype=np.int64), np.empty(count, dtype=np.int64)),
    )
    if last < 0:
        return None
    chosen = [count - 1, last]
    while chosen[-1] != 0:
        chosen.append(int(before[chosen[-1], chosen[-2] - chosen[-1]]))
    result: Points = points[chosen[::-1]]
    return result


def _turning_places(path: Points, ends: LegEnds) -> tuple[Points, NDArray[np.int64]]:
    """
    List where legs may begin and end, and after how many corners of the path each lies.

    Where the goal is off its cell's center, the last corners are moved with it, too.
    """
    inner = _corners(path)[1:]
    shift = ends.goal - inner[-1]
    is_off = bool(np.abs(shift).max() > 1e-9)
    nodes, ranks = [ends.start], [0]
    for rank, point in enumerate(inner[: None if is_off else -1], start=1):
        nodes.append(point)
        ranks.append(rank)
        if is_off and len(inner) - rank <= _NEAR_GOAL and rank < len(inner):
            nodes.append(point + shift)
            ranks.append(rank)
    nodes.append(ends.goal)
    ranks.append(len(inner) + 1)
    return np.array(nodes), np.array(ranks)


def with_approaches(path: Points, distance: float) -> Points:
    """
    Add places before and after each leg on its line, from where it is walked straight.

    Parameters
    ----------
    path : ndarray, shape (n, 2), n >= 2
        Where legs begin and end [cells].
    distance : float
        Distance of those places from the leg [cells].

    Returns
    -------
    ndarray, shape (m, 2)
        The path, with places that a leg may begin or end at, or pass over [cells].
    """
    places = [path[0]]
    for at, (begin, end) in enumerate(pairwise(path)):
        ahead = distance * (end - begin) / max(float(np.hypot(*(end - begin))), 1e-9)
        if at > 0:
            places += [begin - ahead, begin]
        places.append(end)
        if at + 2 < len(path):
            places += [end + ahead, end]
    return np.array(places)


def _corners(path: Points) -> Points:
    """Leave out places where a path goes straight on."""
    steps = np.diff(path, axis=0)
    across = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    ahead = (steps[:-1] * steps[1:]).sum(axis=1)
    turns = (np.abs(across) > 1e-9) | (ahead < 0.0)
    keeps = np.concatenate(([True], turns, [True]))
    result: Points = path[keeps]
    return result


@compiled_part
def _class(heading: float) -> int:
    return math.floor(heading / STEP + 0.5) % CLASSES


@compiled_part
def _turn_cost(angle: float, costs: LegCosts) -> float:
    size = abs(angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5))
    if costs.stride == 0.0:
        return size * costs.turn
    if size <= costs.bend:
        return 0.0
    return max(1.0, math.ceil(size / costs.turn + costs.stopping - 1e-5))


@compiled_part
def _leg_cost(length: float, costs: LegCosts) -> float:
    if costs.stride == 0.0:
        return length
    # The length decides among equals.
    return math.ceil(length / costs.stride + costs.stopping - 1e-5) + 1e-5 * length


@compiled_part
def _may_overshoot(zones: Zones, x: float, y: float, heading: float, costs: LegCosts) -> bool:
    """Return whether a robot that does not stop in time fits where it comes to."""
    to_x, to_y = x + costs.overshoot * math.cos(heading), y + costs.overshoot * math.sin(heading)
    return leg_fits(zones, x, y, to_x, to_y, _class(heading))


@compiled_loop
def _choose(
    zones: Zones,
    points: Floats,
    ranks: Integers,
    yaws: Floats,
    fixed_class: int,
    window: int,
    costs: LegCosts,
    cheapest: Floats,
    before: Integers,
    headings: Floats,
    notes: tuple[Integers, Integers],
) -> int:
    """
    Fill costs of legs and the turning points before them; return the one before the goal.

    Of legs from a to b they are at [a, b - a].
    """
    count = len(points)
    # By the place before: whether the robot may overshoot, -1 where that was not looked at.
    fitting, may_overshoot = notes
    best, last = np.inf, -1
    begin = 0
    for at in range(count):
        # Legs from places before it pass over too many.
        while ranks[at] - ranks[begin] > window:
            begin += 1
        for h in range(begin, at):
            may_overshoot[h] = -1
        x, y = points[at]
        free = fitting_classes(zones, math.floor(x), math.floor(y), fitting)
        is_roomy = has_room_to_turn(zones, math.floor(x), math.floor(y)) if free else False
        if at == count - 1:
            for h in range(begin, at):
                if cheapest[h, at - h] < np.inf:
                    heading = yaws[0] if fixed_class >= 0 else headings[h, at - h]
                    cost = cheapest[h, at - h] + _turn_cost(yaws[1] - heading, costs)
                    if cost < best and may_turn(
                        fitting, free, _class(heading), _class(yaws[1]), True
                    ):
                        best, last = cost, h
            return last
        for to in range(at + 1, count):
            far = ranks[to] - ranks[at]
            if far > window:
                break
            if far == 0:
                continue
            dx, dy = points[to, 0] - x, points[to, 1] - y
            heading = math.atan2(dy, dx)
            k = _class(heading) if fixed_class < 0 else fixed_class
            least, via = np.inf, -1
            if at == 0:
                if fixed_class >= 0:
                    least = 0.0
                elif may_turn(fitting, free, _class(yaws[0]), k, False):
                    least = _turn_cost(heading - yaws[0], costs)
            for h in range(begin, at):
                if cheapest[h, at - h] < np.inf:
                    cost = cheapest[h, at - h]
                    if fixed_class < 0:
                        cost += _turn_cost(heading - headings[h, at - h], costs)
                        if _class(headings[h, at - h]) != k:
                            if is_roomy and may_overshoot[h] < 0:
                                ends_well = _may_overshoot(zones, x, y, headings[h, at - h], costs)
                                may_overshoot[h] = 1 if ends_well else 0
                            if not is_roomy or may_overshoot[h] == 0:
                                cost += costs.tight
                    if cost < least and (
                        fixed_class >= 0
                        or may_turn(fitting, free, _class(headings[h, at - h]), k, False)
                    ):
                        least, via = cost, h
            if least < np.inf and leg_fits(zones, x, y, points[to, 0], points[to, 1], k):
                cheapest[at, to - at] = least + _leg_cost(math.hypot(dx, dy), costs)
                before[at, to - at] = via
                headings[at, to - at] = heading
    return last
