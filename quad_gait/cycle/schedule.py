"""
What a gait does at each instant of a cycle, whatever the motion: computed once.

A cycle is a sum of these curves, weighted by where body and feet start and end.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_motion import gather_speed, minimum_jerk, smooth_progress
from quad_gait.cycle.gait import Gait, Swing

Array = NDArray[np.float64]

_BLEND = 0.2
"""Fraction of an elliptic swing in which it gathers speed, and again slows down."""


_KEPT = 128
"""Schedules: two gaits have 24 orders of their legs each, some at three sample periods."""


@dataclass(frozen=True, eq=False)
class Schedule:
    """The curves of a gait, sampled at n times; each rate is a derivative by time."""

    times: Array
    """Times, evenly spaced from 0 to the cycle period, shape (n,) [s]."""
    in_contact: NDArray[np.bool_]
    """Whether a foot is on the ground, shape (n, 4)."""
    progress: Array
    """Fraction of the body's motion, shape (n,)."""
    progress_rate: Array
    """Rate of the progress, shape (n,) [1/s]."""
    entry: Array
    """Displacement for a speed that differs from the progress' at the start, (n,) [s]."""
    entry_rate: Array
    """Rate of the entry, shape (n,)."""
    exit: Array
    """Displacement for a speed that differs from the progress' at the end, (n,) [s]."""
    exit_rate: Array
    """Rate of the exit, shape (n,)."""
    sway: Array
    """Fraction of each of the body's five sideways moves, shape (n, 5)."""
    sway_rate: Array
    """Rate of the sway, shape (n, 5) [1/s]."""
    body_lift: Array
    """Height of the body above its standing height, shape (n,) [m]."""
    body_lift_rate: Array
    """Rate of the body lift, shape (n,) [m/s]."""
    step: Array
    """Fraction of each foot's step, shape (n, 4)."""
    step_rate: Array
    """Rate of the steps, shape (n, 4) [1/s]."""
    lift: Array
    """Height of each foot above the ground, shape (n, 4) [m]."""
    lift_rate: Array
    """Rate of the lift, shape (n, 4) [m/s]."""
    stride: int = 1
    """Every so-many-th sample of the full schedule is here."""

    def thinned(self, stride: int) -> Schedule:
        """Keep every so-many-th sample, as far as they are evenly spaced."""
        return _thinned(self, stride)


@lru_cache(maxsize=_KEPT)
def schedule_of(gait: Gait, sample_period: float) -> Schedule:
    """
    Sample a gait.

    Parameters
    ----------
    gait : Gait
        The gait.
    sample_period : float
        Longest time between samples [s].

    Returns
    -------
    Schedule
        The gait's curves.
    """
    return _with_legs(_schedule_of_turns(_with_turns_as_legs(gait), sample_period), _turns(gait))


@lru_cache(maxsize=32)
def _schedule_of_turns(gait: Gait, sample_period: float) -> Schedule:
    """Sample a gait whatever its order: the first leg has the first turn, and so on."""
    period = gait.cycle_period
    steps = max(1, int(np.ceil(period / sample_period - 1e-9)))
    times = np.linspace(0.0, period, steps + 1, dtype=np.float64)
    if gait.pendulum_rate > 0.0:
        progress, progress_rate = _pendulum_progress(gait, times)
    elif gait.body_progress is None:
        progress, progress_rate = times / period, np.full_like(times, 1.0 / period)
    else:
        progress, progress_rate = smooth_progress(gait.body_progress, times)
    entry, entry_rate = gather_speed(period, times)
    exit_, exit_rate = -entry[::-1], entry_rate[::-1]
    if gait.pendulum_rate > 0.0:
        exit_, exit_rate = _pendulum_exit(
            gait, times, (progress, entry), (progress_rate, entry_rate)
        )
    sway, sway_rate = _sway(gait, times)
    shape = (len(times), len(LEGS))
    step, step_rate, lift, lift_rate = (np.zeros(shape) for _ in range(4))
    in_contact = np.ones(shape, dtype=bool)
    for swing in gait.swings:
        leg = LEGS.index(swing.leg)
        curves = _ellipse if gait.swing_path == 'ellipse' else _smooth
        step[:, leg], step_rate[:, leg], lift[:, leg], lift_rate[:, leg] = curves(swing, times)
        in_contact[:, leg] = (times <= swing.liftoff) | (times >= swing.touchdown)
    body_lift, body_lift_rate = _body_lift(gait, times)
    return Schedule(
        times=times,
        in_contact=in_contact,
        progress=progress,
        progress_rate=progress_rate,
        entry=entry,
        entry_rate=entry_rate,
        exit=exit_,
        exit_rate=exit_rate,
        sway=sway,
        sway_rate=sway_rate,
        body_lift=body_lift,
        body_lift_rate=body_lift_rate,
        step=step,
        step_rate=step_rate,
        lift=gait.swing_height * lift,
        lift_rate=gait.swing_height * lift_rate,
    )


@lru_cache(maxsize=32)
def _thinned(schedule: Schedule, stride: int) -> Schedule:
    every = slice(None, None, stride)
    curves = {}
    for field in fields(Schedule):
        if field.name != 'stride':
            curve = getattr(schedule, field.name)
            # The last axis is that of feet or sways, if there is another one.
            curves[field.name] = curve[every] if curve.ndim == 1 else curve[..., every, :]
    return Schedule(**curves, stride=stride)


@lru_cache(maxsize=8)
def schedule_of_orders(orders: tuple[Gait, ...], sample_period: float) -> Schedule:
    """
    Sample gaits that differ in the order of their legs only.

    Parameters
    ----------
    orders : tuple of Gait
        A gait with its legs exchanged.
    sample_period : float
        Longest time between samples [s].

    Returns
    -------
    Schedule
        In which the curves of the feet have a first axis for the orders, (len(orders), n, 4).
    """
    schedule = _schedule_of_turns(_with_turns_as_legs(orders[0]), sample_period)
    return _with_legs(schedule, np.stack([_turns(order) for order in orders]))


def _with_turns_as_legs(gait: Gait) -> Gait:
    swings = tuple(replace(swing, leg=leg) for swing, leg in zip(gait.swings, LEGS))
    return replace(gait, swings=swings)


def _turns(gait: Gait) -> NDArray[np.intp]:
    """Return which turn each leg has, (4,)."""
    return np.argsort(legs_in_order(gait))


def _with_legs(schedule: Schedule, turns: NDArray[np.intp]) -> Schedule:
    """Give the curves of the turns to the legs that have them, turns (..., 4)."""

    def given(curve: Array) -> Array:
        return np.ascontiguousarray(np.moveaxis(curve[:, turns], 0, -2))

    return replace(
        schedule,
        in_contact=np.ascontiguousarray(np.moveaxis(schedule.in_contact[:, turns], 0, -2)),
        step=given(schedule.step),
        step_rate=given(schedule.step_rate),
        lift=given(schedule.lift),
        lift_rate=given(schedule.lift_rate),
    )


@lru_cache(maxsize=128)
def legs_in_order(gait: Gait) -> NDArray[np.intp]:
    """Return which legs swing, by their numbers, in the order of their swings, (4,)."""
    return np.array([LEGS.index(swing.leg) for swing in gait.swings], dtype=np.intp)


def _pendulum_progress(gait: Gait, times: Array) -> tuple[Array, Array]:
    """
    Let the body move over each pair of standing feet as an inverted pendulum does.

    Over its support x'' = omega^2 x, so x = A sinh(omega t) from mid-stance: slower above
    the feet, faster between two supports. A body that moves at an even pace instead needs
    a moment that two feet cannot give it, and rocks from one diagonal to the other.
    """
    edges = np.array(gait.support_edges)
    support = np.clip(np.searchsorted(edges, times, side='right') - 1, 0, len(edges) - 2)
    duration = np.diff(edges)[support]
    middle = edges[support] + duration / 2.0
    angle = gait.pendulum_rate * (times - middle)
    scale = duration / 2.0 / np.sinh(gait.pendulum_rate * duration / 2.0)
    progress = (middle + scale * np.sinh(angle)) / gait.cycle_period
    return progress, scale * gait.pendulum_rate * np.cosh(angle) / gait.cycle_period


def _pendulum_exit(
    gait: Gait, times: Array, values: tuple[Array, Array], rates: tuple[Array, Array]
) -> tuple[Array, Array]:
    """
    Change the speed as an inverted pendulum does whose last support is set back.

    Set back by d, it falls forward by d (cosh(omega t) - 1) besides. What the change adds to
    the body's displacement by the end is taken off its progress, so that the curve ends in 0.

    Parameters
    ----------
    gait : Gait
        With a pendulum rate.
    times : ndarray, shape (n,)
        [s]
    values, rates : pair of ndarray, each of shape (n,)
        The progress and the curve for the entry, and their derivatives.

    Returns
    -------
    tuple of ndarray, each of shape (n,)
        As :attr:`Schedule.exit` and :attr:`Schedule.exit_rate`.
    """
    rate, fraction = gait.pendulum_rate, gait.acceleration_fraction
    begin, end = gait.support_edges[-2:]
    angle = rate * np.maximum(times - begin, 0.0)
    last = rate * (end - begin)
    added = np.tanh(last / 2.0) / rate
    value = (
        (np.cosh(angle) - 1.0) / (rate * np.sinh(last)) - added * values[0] + fraction * values[1]
    )
    speed = np.sinh(angle) / np.sinh(last) - added * rates[0] + fraction * rates[1]
    return value / (1.0 - fraction), speed / (1.0 - fraction)


def setback(gait: Gait) -> float:
    """
    Say how far behind its place in a steady gait the last support stands, to gain speed.

    Parameters
    ----------
    gait : Gait
        The gait.

    Returns
    -------
    float
        Per gain in mean speed [s]; 0 for gaits that do not move as a pendulum.
    """
    if gait.pendulum_rate == 0.0:
        return 0.0
    begin, end = gait.support_edges[-2:]
    return (end - begin) / (4.0 * math.sinh(gait.pendulum_rate * (end - begin) / 2.0) ** 2)


@lru_cache(maxsize=64)
def mid_swing_progress(gait: Gait) -> Array:
    """Return which fraction of the body's motion is done in the middle of each swing, (m,)."""
    middles = np.array([(swing.liftoff + swing.touchdown) / 2.0 for swing in gait.swings])
    if gait.body_progress is None:
        return middles / gait.cycle_period
    return smooth_progress(gait.body_progress, middles)[0]


def sway_windows(gait: Gait) -> list[tuple[float, float]]:
    """List when the body sways: before, between and after the swings, begin and end [s]."""
    begins = [gait.sway_start, *(swing.touchdown for swing in gait.swings)]
    ends = [*(swing.liftoff for swing in gait.swings), gait.cycle_period]
    return list(zip(begins, ends))


def _sway(gait: Gait, times: Array) -> tuple[Array, Array]:
    if not gait.sways:
        return np.zeros((len(times), 5)), np.zeros((len(times), 5))
    curves = [minimum_jerk(begin, end, times) for begin, end in sway_windows(gait)]
    return (
        np.stack([value for value, _ in curves], axis=1),
        np.stack([rate for _, rate in curves], axis=1),
    )


def _smooth(swing: Swing, times: Array) -> tuple[Array, Array, Array, Array]:
    """Step with minimum jerk, lifted and put down at rest."""
    duration = swing.touchdown - swing.liftoff
    step, step_rate = minimum_jerk(swing.liftoff, swing.touchdown, times)
    u = np.clip((times - swing.liftoff) / duration, 0.0, 1.0)
    lift = 16.0 * u**2 * (1.0 - u) ** 2
    return step, step_rate, lift, 32.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / duration


def _ellipse(swing: Swing, times: Array) -> tuple[Array, Array, Array, Array]:
    """
    Run along the upper half of an ellipse (S2 eq. 5).

    The angle psi falls from pi to 0; it starts and ends at rest, so that joints do not
    jump in speed at liftoff and touchdown, as they do with the paper's uniform psi.
    """
    angle, rate = _half_turn(swing, times)
    return (
        (1.0 - np.cos(angle)) / 2.0,
        np.sin(angle) * rate / 2.0,
        np.sin(angle),
        np.cos(angle) * rate,
    )


def _body_lift(gait: Gait, times: Array) -> tuple[Array, Array]:
    """Push the standing feet along the lower half of an ellipse (S2 eq. 6)."""
    depth = gait.support_depth * gait.swing_height
    lift, lift_rate = np.zeros_like(times), np.zeros_like(times)
    # Feet that swing at the same time share one lift of the body.
    for liftoff, touchdown in {(swing.liftoff, swing.touchdown) for swing in gait.swings}:
        angle, rate = _half_turn(Swing('', liftoff, touchdown), times)
        lift += depth * np.sin(angle)
        lift_rate += depth * np.cos(angle) * rate
    return lift, lift_rate


def _half_turn(swing: Swing, times: Array) -> tuple[Array, Array]:
    """Turn from 0 to pi: gather speed, go on steadily, and slow down again."""
    duration = swing.touchdown - swing.liftoff
    u = np.clip((times - swing.liftoff) / duration, 0.0, 1.0)
    rate = np.clip(np.minimum(u, 1.0 - u) / _BLEND, 0.0, 1.0) / (1.0 - _BLEND)
    early = u**2 / (2.0 * _BLEND)
    late = 1.0 - _BLEND - (1.0 - u) ** 2 / (2.0 * _BLEND)
    fraction = np.where(u < _BLEND, early, np.where(u > 1.0 - _BLEND, late, u - _BLEND / 2.0))
    return np.pi * fraction / (1.0 - _BLEND), np.pi * rate / duration


def every_order(gait: Gait) -> list[Gait]:
    """
    List a gait with every permutation of its legs.

    Parameters
    ----------
    gait : Gait
        The gait.

    Returns
    -------
    list of Gait
        24 gaits; the first is the gait as it is.
    """
    return [
        replace(
            gait,
            swings=tuple(replace(swing, leg=legs[LEGS.index(swing.leg)]) for swing in gait.swings),
        )
        for legs in permutations(LEGS)
    ]
