"""
Figures of S3's active pair: how exactly postures come back, how fast, and what physics says.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ActivePairError, FreeJointPoseNotFound, MissingOptionalDependency
from quad_common.planar_pair.active_pair import (
    with_hip_held,
    with_hip_joints_held,
    with_hips_placed,
    with_knee_held,
)
from quad_common.planar_pair.body_over_feet import pose_with_free_joint
from quad_common.planar_pair.planar_pair import (
    ActivePair,
    JointAngles,
    PairPoints,
    PairPosture,
    PlanarLeg,
    points_of,
    posture_of,
    wrap,
)
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure

PAIRS = 10
"""Pairs of random measures among which the random postures are."""

FLATTEST = 1e-3
"""
Least ratio of a triangle's doubled area to its longest side, squared.

Where a triangle is flat both of its solutions meet, and rounding of what is given is
amplified without bound: no method has the angle to a billionth there.
"""

_QUICK_SETTLES = 2
_SETTLES = 8
"""Postures of each case that are brought to rest in physics."""

_BATCH = 100_000
"""Postures at a time where the rate is measured."""

Solve = Callable[..., PairPosture]


@dataclass(frozen=True)
class Case:
    """One causality of a pair."""

    causality: str
    solve: Solve
    """From the pair, a posture, its points and the names of branches, or a posture before it."""
    branches: tuple[str, ...]
    """Arguments that choose a branch."""
    held: tuple[str, ...]
    """What a motor holds, by the names of ``quad_sim.engines.bullet_pair``."""


CASES = (
    Case(
        'motor00-motor01',
        lambda pair, p, x, **how: with_knee_held(pair, p.hip_i, x.foot_i, x.foot_j, p.u1_j, **how),
        ('branch', 'knee_i'),
        ('hip_x', 'hip_z', 'u1_j'),
    ),
    Case(
        'motor00-motor02',
        lambda pair, p, x, **how: with_hip_held(pair, p.hip_i, x.foot_i, x.foot_j, p.u2_j, **how),
        ('branch', 'knee_i'),
        ('hip_x', 'hip_z', 'u2_j'),
    ),
    Case(
        'motor00-motor00',
        lambda pair, p, x, **how: with_hips_placed(
            pair, p.hip_i, p.hip_j, x.foot_i, x.foot_j, **how
        ),
        ('knee_i', 'knee_j'),
        ('hip_x', 'hip_z', 'theta'),
    ),
    Case(
        'motor02-motor02',
        lambda pair, p, x, **how: with_hip_joints_held(
            pair, p.theta, p.u2_i, p.u2_j, x.foot_i, x.foot_j, **how
        ),
        ('branch',),
        ('theta', 'u2_i', 'u2_j'),
    ),
)


def active_pair_bars(quick: bool, seed: int) -> list[Criterion]:
    """
    Measure the active pair.

    Parameters
    ----------
    quick : bool
        Fewer postures in physics.
    seed : int
        Of the postures.

    Returns
    -------
    list of Criterion
        Errors, rates, and the largest differences from where physics settles.
    """
    rng = np.random.default_rng(seed)
    bars = [
        at_most(
            f'S3, {case.causality}: largest error of 100 000 random postures',
            recovery_error(case, rng, 100_000),
            'rad or m',
            1e-9,
        )
        for case in CASES
    ]
    for case in CASES:
        name = f'S3, {case.causality}: postures per second on one core'
        rate = postures_per_second(case, rng)
        # The paper's own case is the one that has a bar.
        published = case is CASES[0]
        bars.append(at_least(name, rate, '1/s', 1e6) if published else figure(name, rate, '1/s'))
    return bars + _settle_bars(rng, _QUICK_SETTLES if quick else _SETTLES)


def recovery_error(case: Case, rng: np.random.Generator, count: int) -> float:
    """
    Draw postures, place their feet, and find the postures again.

    Returns
    -------
    float
        The largest difference of any angle [rad] or hip [m], for the better branch.
    """
    largest = 0.0
    for pair, posture in random_postures(rng, count):
        points = points_of(pair, posture)
        best = np.full(posture.theta.shape, np.inf)
        for names in np.ndindex(*[2] * len(case.branches)):
            how = {name: ('up', 'down')[n] for name, n in zip(case.branches, names)}
            best = np.minimum(best, _error(case.solve(pair, posture, points, **how), posture))
        largest = max(largest, float(best.max()))
    return largest


def postures_per_second(case: Case, rng: np.random.Generator) -> float:
    """Time one batch several times, and take the fastest [1/s]."""
    pair, posture = next(random_postures(rng, PAIRS * _BATCH))
    points = points_of(pair, posture)
    times = []
    for _ in range(7):
        began = time.perf_counter()
        case.solve(pair, posture, points)
        times.append(time.perf_counter() - began)
    return posture.theta.size / min(times)


def random_postures(
    rng: np.random.Generator, count: int
) -> Iterator[tuple[ActivePair, PairPosture]]:
    """Yield pairs of random measures, and postures of each at any angles, ``count`` in all."""
    for _ in range(PAIRS):
        legs = [PlanarLeg(*rng.uniform(0.1, 0.5, 2)) for _ in range(2)]
        span = rng.uniform(0.2, 0.8) * rng.choice([-1.0, 1.0])
        lambda_i = rng.uniform(-0.5, 0.5)
        pair = ActivePair(legs[0], legs[1], lambda_i, lambda_i + span)
        taken: list[PairPosture] = []
        size = count // PAIRS
        while sum(part.theta.size for part in taken) < size:
            place = rng.uniform(-1.0, 1.0, size) + 1j * rng.uniform(-1.0, 1.0, size)
            theta, *angles = rng.uniform(-math.pi, math.pi, (5, size))
            drawn = posture_of(pair, place, theta, JointAngles(*angles))
            taken.append(drawn[flatness(pair, points_of(pair, drawn)) >= FLATTEST])
        parts = [[getattr(part, field.name) for part in taken] for field in fields(PairPosture)]
        yield pair, PairPosture(*(np.concatenate(part)[:size] for part in parts))


def flatness(pair: ActivePair, points: PairPoints) -> NDArray[np.float64]:
    """Return the least ratio of doubled area to longest side, squared, of all triangles."""
    R_i, K_i, G_i, R_j, K_j, G_j = points
    triangles = (
        (R_j - R_i, G_j - R_j),
        (K_j - R_i, G_j - K_j),
        (K_i - R_i, G_i - K_i),
        (K_j - R_j, G_j - K_j),
        (G_i - K_i, G_j - K_j),
    )
    ratios = [_flatness(one, other) for one, other in triangles]
    least: NDArray[np.float64] = np.minimum.reduce(ratios)
    return least


def _flatness(one: Any, other: Any) -> NDArray[np.float64]:
    """Return the ratio for the triangle of two sides and their sum."""
    longest = np.maximum.reduce([np.abs(side) for side in (one, other, one + other)])
    ratio: NDArray[np.float64] = np.abs((one.conjugate() * other).imag) / longest**2
    return ratio


def _error(found: PairPosture, wanted: PairPosture) -> NDArray[np.float64]:
    angles = ('theta', 'u1_i', 'u2_i', 'u1_j', 'u2_j')
    off = [np.abs(wrap(getattr(found, name) - getattr(wanted, name))) for name in angles]
    off += [np.abs(found.hip_i - wanted.hip_i), np.abs(found.hip_j - wanted.hip_j)]
    largest: NDArray[np.float64] = np.maximum.reduce(off)
    return largest


def _settle_bars(rng: np.random.Generator, count: int) -> list[Criterion]:
    """Compare with where physics settles; one pair of bars for all cases."""
    name = 'S3: {}, from where PyBullet settles'
    try:
        from quad_sim.engines.bullet_simulator import headless_client
    except MissingOptionalDependency:
        worst: tuple[float | None, float | None] = (None, None)
    else:
        off = settle_errors(headless_client(), rng, count)
        worst = (math.degrees(max(a for a, _ in off)), 1e3 * max(d for _, d in off))
    return [
        at_most(name.format('largest difference of an angle'), worst[0], 'deg', 0.5),
        at_most(name.format('largest difference of a joint or foot'), worst[1], 'mm', 1.0),
    ]


def settle_errors(client: Any, rng: np.random.Generator, count: int) -> list[tuple[float, float]]:
    """
    Let pairs settle in physics: each causality, and each of the four joints free alone.

    Parameters
    ----------
    client : BulletClient
        An empty world.
    rng : Generator
        Draws the postures.
    count : int
        Of each.

    Returns
    -------
    list of tuple of float
        Differences of angles [rad] and places [m] from what is predicted.
    """
    from quad_sim.engines.bullet_pair import JOINTS, difference, settle

    drawn = [(*_start_and_end(rng, case.solve), case.held) for case in CASES for _ in range(count)]
    for free in JOINTS[3:]:
        held = tuple(name for name in JOINTS[3:] if name != free)
        pivot = free.replace('u1', 'knee').replace('u2', 'hip')
        drawn.append((*_start_and_end(rng, _free(free), pivot), held))
    off = []
    for pair, start, end, names in drawn:
        values = {'hip_x': end.hip_i.real, 'hip_z': end.hip_i.imag}
        held_at = {
            name: float(values[name] if name in values else getattr(end, name)) for name in names
        }
        off.append(difference(pair, settle(client, pair, start, held_at).posture, end))
    return off


def _free(joint: Any) -> Solve:
    def solve(
        pair: ActivePair, p: PairPosture, x: PairPoints, previous: PairPosture
    ) -> PairPosture:
        angles = {name: float(getattr(p, name)) for name in ('u1_i', 'u2_i', 'u1_j', 'u2_j')}
        angles[joint] = float(getattr(previous, joint))
        feet = (complex(x.foot_i), complex(x.foot_j))
        found = pose_with_free_joint(pair, *feet, JointAngles(**angles), joint)
        if found.posture is None:
            raise FreeJointPoseNotFound(str(joint), found.why)
        return found.posture

    return solve


def _least_flatness(pair: ActivePair, posture: PairPosture, pivot: str) -> float:
    points = points_of(pair, posture)
    least = float(flatness(pair, points))
    if pivot:
        point = getattr(points, pivot)
        least = min(least, float(_flatness(point - points.foot_i, points.foot_j - point)))
    return least


def _start_and_end(
    rng: np.random.Generator, solve: Solve, pivot: str = ''
) -> tuple[ActivePair, PairPosture, PairPosture]:
    """
    Draw a posture like a standing robot's, and one on the same feet with other inputs.

    ``pivot`` is the point, of :class:`PairPoints`, about which a joint is free alone: it and
    the feet are a triangle too.
    """
    while True:
        pair = ActivePair(
            PlanarLeg(*rng.uniform(0.15, 0.25, 2)),
            PlanarLeg(*rng.uniform(0.15, 0.25, 2)),
            -0.2,
            0.2,
        )
        bends = rng.uniform(0.5, 1.4, 2) * rng.choice([-1.0, 1.0], 2)
        hips = -math.pi / 2.0 - bends / 2.0 + rng.uniform(-0.3, 0.3, 2)
        theta, hip_i = rng.uniform(-0.3, 0.3), complex(*rng.uniform(-0.2, 0.2, 2))
        start = posture_of(pair, hip_i, theta, JointAngles(bends[0], hips[0], bends[1], hips[1]))
        feet = points_of(pair, start)
        other = posture_of(
            pair,
            hip_i + complex(*rng.uniform(-0.02, 0.02, 2)),
            theta + rng.uniform(-0.1, 0.1),
            JointAngles(
                *(
                    float(angle) + rng.uniform(-0.1, 0.1)
                    for angle in (start.u1_i, start.u2_i, start.u1_j, start.u2_j)
                )
            ),
        )
        try:
            end = solve(pair, other, feet, previous=start)
        except ActivePairError:
            continue
        # Not through a flat triangle, where pins and motors press against their own slack, and
        # where a pair could leave its branch.
        flat = min(_least_flatness(pair, part, pivot) for part in (start, end))
        if flat > 0.15 and float(_error(end, start)) < 0.8:
            return pair, start, end
