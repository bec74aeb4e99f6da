"""
How much of a motion one cycle of a gait can do: derived from legs, joints, margin and torques.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.planar_pose import Twist2D
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import CycleEnds
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.gait_generator import (
    CycleOptions,
    generate_cycle,
    generate_steady_cycle,
    margins_of_orders,
)
from quad_gait.cycle.joint_torques import torque_demand
from quad_gait.cycle.part_check import crossing_feet
from quad_gait.cycle.schedule import every_order

_SAMPLES = 80
"""Per trial cycle: limits are met between samples to a fraction of a percent."""

_SAMPLES_OF_TRIALS = 40
"""Enough to compare orders of swings."""

_BISECTIONS = 11

_BESIDE = 0.22
"""In a dynamic gait the center of mass may be beside its two feet by this fraction of its
height: farther out, small errors grow into falls."""

_MIDDLING = 0.4
"""Fraction of the largest stride at which orders of swings are compared."""

_GOOD = 0.9
"""A gait keeps its own order if its margin is at least this fraction of the best order's."""

_KEPT = 4096
"""Directions whose limits and orders are kept: joysticks and corrections bring ever new ones."""

_RESERVE = 0.95
"""Fraction of the largest motion that is used: what is left over corrects errors."""

Array = NDArray[np.float64]

_Direction = tuple[float, float, float]
"""Forward, left and turn of a motion of size 1, rounded."""

_Found = TypeVar('_Found')

Bound = Callable[[BodyMotion], tuple[float, str]]
"""Which fraction of a cycle's motion is possible, at most 1, and why no more; empty if all is."""


class MotionLimits:
    """
    The largest motions of one gait on one robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        The gait, fitted to the robot.
    least_margin : float
        Static stability margin that cycles of a static gait must keep [m].
    reserve : float
        Fraction of what is just possible that is used.
    bound : callable, optional
        What else forbids, of how the gait is walked.
    """

    def __init__(
        self,
        robot: Robot,
        gait: Gait,
        least_margin: float = 0.0,
        reserve: float = _RESERVE,
        bound: Bound | None = None,
    ) -> None:
        self._robot = robot
        self._gait = gait
        settings = robot.gaits.get(gait.name)
        self._fractions = settings.largest_fractions if settings is not None else None
        self._reserve = reserve
        self._bound = bound
        self._limits: dict[_Direction, _Limit] = {}
        self._orders: dict[_Direction, Gait] = {}
        center = robot.center_of_mass(robot.initial_joint_angles)[2] + robot.standing_height
        self.least_margin = least_margin if gait.is_static else -_BESIDE * float(center)
        """What cycles must keep; negative for a dynamic gait [m]."""
        # Four lengths of a leg.
        self._beyond_reach = 4.0 * max(float(leg.reach()[1]) for leg in robot.legs)
        self._variants = every_order(gait) if gait.is_static else [gait]

    @property
    def gait(self) -> Gait:
        """The gait."""
        return self._gait

    @property
    def period(self) -> float:
        """Duration of a cycle [s]."""
        return self._gait.cycle_period

    @property
    def is_steady(self) -> bool:
        """Whether the body may keep its speed from cycle to cycle."""
        return self._gait.is_steady

    @property
    def acceleration_fraction(self) -> float:
        """Fraction of a cycle's length at speed in which it gathers that speed."""
        return self._gait.acceleration_fraction

    def largest_scale(self, motion: BodyMotion) -> float:
        """
        Return how many times a motion fits into one cycle.

        Parameters
        ----------
        motion : BodyMotion
            Not zero: a stride, a turn, or any mixture.

        Returns
        -------
        float
            More than 1 if there is room for more; 0 if not even little of it is possible.
        """
        size = self.size(motion)
        return math.inf if size == 0.0 else self._limit(motion).size / size

    def possible_part(self, motion: BodyMotion) -> float:
        """
        Return which part of a motion fits into one cycle, at most 1.

        That all of it does is known in a third of the time in which the largest one is found.
        """
        if self.size(motion) == 0.0:
            return 1.0
        if self._direction(motion) not in self._limits and self._fits(motion):
            return 1.0
        return min(1.0, self.largest_scale(motion))

    def reason(self, motion: BodyMotion) -> str:
        """Say what forbids more of a motion: a leg's reach, a joint, the margin."""
        return '' if self.size(motion) == 0.0 else self._limit(motion).reason

    def gait_for(self, motion: BodyMotion) -> Gait:
        """
        Choose the order of swings for a motion.

        Parameters
        ----------
        motion : BodyMotion
            A stride, a turn, or any mixture.

        Returns
        -------
        Gait
            The gait as it is, or with its legs exchanged where that keeps the center of
            mass farther inside: backwards, sideways, or turning the other way.
        """
        if len(self._variants) == 1 or self.size(motion) == 0.0:
            return self._gait
        return self._order(self._direction(motion))

    def limited(self, twist: Twist2D) -> tuple[Twist2D, str]:
        """
        Slow a velocity down to what the gait can do, keeping its direction.

        Parameters
        ----------
        twist : Twist2D
            Wanted.

        Returns
        -------
        tuple of Twist2D and str
            The velocity, and which limit bites; empty if none does.
        """
        motion = BodyMotion.during(twist, self.period)
        fraction = self.possible_part(motion)
        return (twist, '') if fraction >= 1.0 else (twist.scaled(fraction), self.reason(motion))

    def _limit(self, motion: BodyMotion) -> _Limit:
        return _remembered(self._limits, self._direction(motion), self._search)

    def _order(self, direction: _Direction) -> Gait:
        return _remembered(self._orders, direction, self._best_variant)

    def _direction(self, motion: BodyMotion) -> _Direction:
        size = self.size(motion)
        return (
            round(motion.forward / size, 2),
            round(motion.left / size, 2),
            round(motion.turn / size, 2),
        )

    def size(self, motion: BodyMotion) -> float:
        """How far the motion carries the outermost foot, at most [m]."""
        radius = self._robot.footprint_radius
        return math.hypot(motion.forward, motion.left) + radius * abs(motion.turn)

    def _fits(self, motion: BodyMotion) -> bool:
        """Whether a motion is surely within its limit, which is not known."""
        towards = self._direction(motion)
        gait, direction, size = self._order(towards), BodyMotion(*towards), self.size(motion)
        if not gait.is_steady:
            # S0 has bounds of its own.
            return False
        asked, beyond = size / (self._reserve * self._used_of(direction)), direction.scaled(size)
        return (
            asked < self._beyond_reach
            and self._problem(gait, direction.scaled(asked)) is None
            and self._weakness(gait, beyond) is None
            and (self._bound is None or self._bound(beyond)[0] >= 1.0)
        )

    def _search(self, towards: _Direction) -> _Limit:
        """Bisect between what is possible and what is not."""
        gait, direction = self._order(towards), BodyMotion(*towards)
        high = self._beyond_reach
        if gait.footholds == 'initial_posture' and not gait.is_steady:
            # S0's S_max and phi_max keep a reserve for ground that is lower than expected.
            bound, reason = self._bound_of_s0(direction)
            if self._problem(gait, direction.scaled(bound)) is None:
                return self._weaker(gait, direction, _Limit(bound, reason))
            high = min(high, bound)
        low, reason = _bisected(high, lambda size: self._problem(gait, direction.scaled(size)))
        limit = _Limit(self._reserve * self._used_of(direction) * low, reason)
        return self._bounded(direction, self._weaker(gait, direction, limit))

    def _bounded(self, direction: BodyMotion, limit: _Limit) -> _Limit:
        """Take less of a motion if how the gait is walked forbids so much."""
        if self._bound is None:
            return limit
        fraction, reason = self._bound(direction.scaled(limit.size))
        return _Limit(fraction * limit.size, reason or limit.reason)

    def _weaker(self, gait: Gait, direction: BodyMotion, limit: _Limit) -> _Limit:
        """
        Take less of a motion if the joints' torques do not suffice for its limit.

        What legs and margin allow comes first: most robots are strong enough for that, and are
        asked once.
        """
        if self._weakness(gait, direction.scaled(limit.size)) is None:
            return limit
        low, reason = _bisected(
            limit.size, lambda size: self._weakness(gait, direction.scaled(size))
        )
        return _Limit(self._reserve * low, reason)

    def _weakness(self, gait: Gait, motion: BodyMotion) -> str | None:
        """Say which joint's torque does not suffice for a motion, if nothing else forbids it."""
        options = CycleOptions(gait.cycle_period / _SAMPLES)
        try:
            cycle = generate_steady_cycle(self._robot, gait, motion, options)
        except GaitError:
            return None
        demand = torque_demand(self._robot, cycle)
        return demand.sentence() if demand.is_too_much else None

    def _used_of(self, direction: BodyMotion) -> float:
        """Return which fraction of a motion's limit is used: the mean of its parts' fractions."""
        if self._fractions is None:
            return 1.0
        parts = (
            abs(direction.forward),
            abs(direction.left),
            self._robot.footprint_radius * abs(direction.turn),
        )
        return sum(parts) / sum(part / used for part, used in zip(parts, self._fractions))

    def _best_variant(self, towards: _Direction) -> Gait:
        """
        Take the order with the largest margin at a middling motion; its own if good.

        Margins come first, for all orders at once; whether joints are quick enough and
        parts keep apart is looked at for those that are to be taken. Cycles are awaited
        meanwhile, and every correction may have a direction of its own.
        """
        if len(self._variants) == 1:
            return self._gait
        direction = BodyMotion(*towards)
        middling = direction.scaled(_MIDDLING * self._bound_of_s0(direction)[0])
        margins = self._margins(middling)
        own, best = float(margins[0]), float(margins.max())
        if best > 0.0 and own >= _GOOD * best and self._works(0, middling):
            return self._gait
        for k in np.argsort(-margins, kind='stable'):
            best = float(margins[k])
            if best <= 0.0:
                break
            if self._works(k, middling):
                is_good = own >= _GOOD * best and self._works(0, middling)
                return self._gait if is_good else self._variants[k]
        return self._gait

    def _margins(self, motion: BodyMotion) -> Array:
        period = self._gait.cycle_period / _SAMPLES_OF_TRIALS
        try:
            return margins_of_orders(self._robot, self._variants, motion, period)
        except GaitError:
            # Some of them are too much for the legs: the others are found one by one.
            return np.array([self._margin(gait, motion) for gait in self._variants])

    def _works(self, variant: int, motion: BodyMotion) -> bool:
        return self._margin(self._variants[variant], motion) > -math.inf

    def _margin(self, gait: Gait, motion: BodyMotion) -> float:
        try:
            options = CycleOptions(gait.cycle_period / _SAMPLES_OF_TRIALS)
            cycle = generate_steady_cycle(self._robot, gait, motion, options)
        except GaitError:
            return -math.inf
        return cycle.least_margin

    def _bound_of_s0(self, direction: BodyMotion) -> tuple[float, str]:
        stride, turn = self._robot.largest_stride, self._robot.largest_turn
        fraction = (
            math.hypot(direction.forward, direction.left) / stride + abs(direction.turn) / turn
        )
        return 1.0 / fraction, (
            f'the largest stride is {stride:.3f} m and the largest turn '
            f'{math.degrees(turn):.1f} degrees a cycle'
        )

    def _problem(self, gait: Gait, motion: BodyMotion) -> str | None:
        """Say why a motion is not possible: from rest, steadily, and back to rest."""
        robot = self._robot
        options = CycleOptions(gait.cycle_period / _SAMPLES, self.least_margin)
        try:
            cycle = generate_steady_cycle(robot, gait, motion, options)
            crossing = crossing_feet(robot, cycle)
            if crossing:
                return crossing
            if gait.is_steady:
                speed = motion.rate(gait.cycle_period)
                first, last = (
                    motion.scaled(gait.acceleration_fraction),
                    motion.scaled(1.0 - gait.acceleration_fraction),
                )
                ends = CycleEnds(cycle.end_feet, entry=speed)
                generate_cycle(robot, gait, last, ends, options)
                if gait.is_static:
                    # Dynamic gaits gather speed over several cycles.
                    generate_cycle(robot, gait, first, CycleEnds(exit=speed), options)
        except GaitError as error:
            return str(error)
        return None


@dataclass(frozen=True)
class _Limit:
    """Of motions in one direction."""

    size: float
    """Distance by which the outermost foot may be carried [m]."""
    reason: str
    """Reason why more is not possible."""


def _bisected(high: float, problem: Callable[[float], str | None]) -> tuple[float, str]:
    """Return the largest size up to which there is no problem, and what the problem is beyond."""
    low, reason = 0.0, ''
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        found = problem(middle)
        if found is None:
            low = middle
        else:
            high, reason = middle, found
    return low, reason


def _remembered(
    known: dict[_Direction, _Found],
    direction: _Direction,
    find: Callable[[_Direction], _Found],
) -> _Found:
    """Look a direction up; find what is not known, and forget the oldest of too many."""
    if direction not in known:
        found = find(direction)
        if len(known) >= _KEPT:
            del known[next(iter(known))]
        known[direction] = found
    return known[direction]
