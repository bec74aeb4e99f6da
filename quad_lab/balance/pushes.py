"""
How hard a push a trotting robot survives: from many directions, at many phases.
"""

from __future__ import annotations

import math
import os
import pickle
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import numpy as np

from quad_common.rotations import tilt_from_quaternion
from quad_lab.balance.balance_case import BalanceCase, BalanceWalk

Result = TypeVar('Result')

Disturb = Callable[[BalanceWalk, float, float], tuple[bool, float]]
"""What disturbs a robot with an impulse from an angle, and tells whether it survives."""

PUSH = 0.1
"""Duration of a push [s]."""

_AFTER, _AT_LEAST = 1.2, 0.2
"""Time after it in which the robot must have caught itself [s]; and two cycles and a little."""

_UPRIGHT, _CALM, _LOST = math.radians(12.0), math.radians(2.5), math.radians(30.0)
"""Tilt that a survivor has at the end at most, that ends a trial well at once, and badly."""

_LOOK = 0.3
"""Time over which tilts are looked at [s]."""

_BISECTIONS = 5

HARDEST_PUSH = 1.6
"""Hardest push, over sqrt(g h)."""


@dataclass(frozen=True)
class Survival:
    """How hard a push a robot survives."""

    case: BalanceCase
    """Who, how fast, and what made it harder."""
    impulses: tuple[float, ...]
    """Hardest push that was survived, by direction and phase, over m sqrt(g h)."""
    gained: tuple[float, ...]
    """Velocity that the body had gained at the end of each, over sqrt(g h)."""
    has_fallen: bool
    """Whether it fell, or stopped, before any push."""

    def survived_by(self, fraction: float) -> float:
        """Return the impulse that a fraction of the pushes survive."""
        if self.has_fallen:
            return 0.0
        return float(np.percentile(self.impulses, 100.0 * (1.0 - fraction)))


def survival(case: BalanceCase, directions: int, phases: int, seed: int = 0) -> Survival:
    """
    Find the hardest pushes that are survived.

    Parameters
    ----------
    case : BalanceCase
        Who is pushed.
    directions, phases : int
        Number of directions, and of phases of a cycle.
    seed : int
        Seed of the sensors' errors.

    Returns
    -------
    Survival
    """
    walk = BalanceWalk(case, seed)
    found: list[tuple[float, float]] = []
    try:
        is_lost = walk.is_lost
        if not is_lost:
            for _ in range(phases):
                walk.loop.run(walk.period / phases)
                angles = [2.0 * math.pi * k / directions for k in range(directions)]
                found += [_hardest(walk, angle) for angle in angles]
        impulses, gained = zip(*found) if found else ((), ())
        return Survival(case, impulses, gained, is_lost)
    finally:
        walk.close()


def pushed(walk: BalanceWalk, impulse: float, angle: float) -> tuple[bool, float]:
    """
    Push a robot's body for 0.1 s.

    Parameters
    ----------
    walk : BalanceWalk
        The robot.
    impulse : float
        Over m sqrt(g h).
    angle : float
        Direction in which it is pushed, in the world [rad].

    Returns
    -------
    survives : bool
        Whether it catches itself.
    gained : float
        Velocity that its body has gained when the push ends, over sqrt(g h).
    """
    size = walk.robot.mass * impulse * walk.unit / PUSH
    before = walk.velocity
    walk.push(size * np.array([math.cos(angle), math.sin(angle), 0.0]))
    walk.loop.run(PUSH)
    gained = float(np.linalg.norm(walk.velocity - before)) / walk.unit
    walk.push(np.zeros(3))
    return catches_itself(walk), gained


def survivors(
    case: BalanceCase, impulse: float, directions: int, phases: int, disturb: Disturb = pushed
) -> float:
    """
    Return the fraction of pushes with an impulse, over m sqrt(g h), that are survived.

    None, of a robot that does not trot: one that stands is not what is measured. ``disturb`` is
    :func:`pushed` or what takes the same.
    """
    walk = BalanceWalk(case)
    count = 0
    try:
        if walk.is_lost:
            return 0.0
        for _ in range(phases):
            walk.loop.run(walk.period / phases)
            for k in range(directions):
                angle = 2.0 * math.pi * k / directions
                count += apart(partial(disturb, walk, impulse, angle))[0]
        return count / (phases * directions)
    finally:
        walk.close()


def _hardest(walk: BalanceWalk, angle: float) -> tuple[float, float]:
    """Return the hardest push from an angle [rad] that is survived, and what the body gained."""
    low, high, gained = 0.0, HARDEST_PUSH, 0.0
    for _ in range(_BISECTIONS):
        impulse = (low + high) / 2.0
        has_survived, gain = apart(partial(pushed, walk, impulse, angle))
        if has_survived:
            low, gained = impulse, gain
        else:
            high = impulse
    return low, gained


def catches_itself(walk: BalanceWalk) -> bool:
    """Return whether a robot that was disturbed just now is soon upright and calm again."""
    loop, record = walk.loop, walk.loop.record
    began = loop.time
    least = began + 2.0 * walk.period + _AT_LEAST
    tilts: list[tuple[float, float]] = []

    def is_decided() -> bool:
        seen = record.last_seen
        tilts.append((loop.time, tilt_from_quaternion(seen.orientation)))
        if record.has_fallen or tilts[-1][1] > _LOST:
            return True
        recent = max(tilt for time, tilt in tilts if time > loop.time - _LOOK)
        return loop.time > least and recent < _CALM

    loop.run(max(_AFTER, least - began), until=is_decided)
    recent = max(tilt for time, tilt in tilts if time > loop.time - _LOOK)
    return not record.has_fallen and recent < _UPRIGHT


def apart(work: Callable[[], Result]) -> Result:
    """
    Do some work in a copy of this process, which leaves everything here as it was.

    Whatever engine runs: a simulation goes on from here as often as it is asked to.

    Parameters
    ----------
    work : callable
        What is done; its result must be picklable.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            with os.fdopen(writing, 'wb') as pipe:
                pickle.dump(work(), pipe)
            status = 0
        finally:
            os._exit(status)
    os.close(writing)
    with os.fdopen(reading, 'rb') as pipe:
        answer = pipe.read()
    _, status = os.waitpid(child, 0)
    if status:
        raise RuntimeError('a trial ended without a result')
    result: Result = pickle.loads(answer)
    return result
