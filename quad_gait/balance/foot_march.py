"""
The feet of a trotting robot from knot to knot, compiled: twenty knots in the time of one.

:func:`march` is called; the rest are its parts, each a law of docs/balance.md. What Python holds of
feet is :mod:`~quad_gait.balance.feet`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_gait.balance.feet import Demand
from quad_gait.balance.foot_laws import (
    Pace,
    ground_velocity,
    landing_place,
    pace_after,
    sway_velocity,
    swing_height,
    swing_on,
    tilted_back,
)
from quad_gait.balance.phase_clock import STANDS, PhaseClock, pendulum_factor, swing_phase

Array = NDArray[np.float64]
Feet = NDArray[np.void]


class Manner(NamedTuple):
    """How one robot moves its feet: what it is, and its gains."""

    capture_time: float
    """Length of the capture step over the error of the velocity [s]."""
    rate: float
    """Rate of the body as a pendulum, sqrt(g / h) [1/s]."""
    largest: float
    """Distance from its neutral place at which a foot is put, at most [m]."""
    landing: float
    """Fraction of its swing, at its end, in which a foot comes down with the ground."""
    lift: float
    """Height to which feet are lifted on even ground [m]."""
    most_lift: float
    """The same on any ground, at most [m]."""
    rough_from: float
    """Height by which feet are off the plane of the ground from which on it is rough [m]."""
    leveling_at_large_tilt: float
    """Part of a large tilt that swinging feet make up for."""
    righting_time: float
    """Time constant with which a leg that has landed rights the body [s]."""
    # The rest is as BalanceOptions has it.
    rough_lift: float
    giving_way: float
    turn_giving_way: float
    leveling: float
    small_tilt: float
    large_tilt: float
    easing: float
    freeze_time: float
    leaning_time: float
    acceleration: float
    turn_acceleration: float


class Legs(NamedTuple):
    """What is known of each leg."""

    neutral: Array
    """Places of the feet under a standing body, shape (4, 3) [m]."""
    rolling: Array
    """Velocity of a foot's center over that of the ground under it, shape (4, 2, 2)."""


class _Law(NamedTuple):
    """How feet move for a moment."""

    mean: Pace
    """Velocity that is wanted on average."""
    given_way: Pace
    """Velocity with which standing feet go."""
    excess: tuple[float, float]
    """Step to the capture point [m]."""
    settling: float
    """Height by which the body as a whole is to rise; nan where each foot that stands goes over to
    the plane of the ground [m]."""
    risen: float
    """Height by which that plane has risen since the first knot [m]."""


@compiled_loop
def march(
    knots: Feet,
    paces: Array,
    places: Array,
    times: Array,
    clock: PhaseClock,
    demand: Demand,
    manner: Manner,
    legs: Legs,
) -> None:
    """
    Move feet on from knot to knot.

    Parameters
    ----------
    knots : ndarray, shape (m, 4)
        Feet of the type :data:`~quad_gait.balance.feet.FOOT`; the first ones are given, on the
        ground that is demanded, and the others filled in.
    paces : ndarray, shape (m, 3)
        Velocities that are planned [m/s], [rad/s]; the same.
    places : ndarray, shape (m, 4, 3)
        Feet in the body's axes [m]; filled in but for the first.
    times : ndarray, shape (m,)
        Times of the knots [s].
    clock : PhaseClock
        When feet swing.
    demand : Demand
        What is to be done.
    manner : Manner
        How.
    legs : Legs
        With which legs.
    """
    risen = 0.0
    for k in range(len(times) - 1):
        begin, end = times[k], times[k + 1]
        here = _here(demand, paces[k], begin >= clock.end)
        pace = pace_after(
            paces[k], here.pace, end - begin, manner.acceleration, manner.turn_acceleration
        )
        paces[k + 1, 0], paces[k + 1, 1], paces[k + 1, 2] = pace.forward, pace.left, pace.turn
        before = knots[k]
        settling = _settling(before, here, risen, manner)
        if here.ground.is_known:
            risen += (1.0 - _kept(end - begin, manner)) * settling
        middle = (begin + end) / 2.0
        sway = sway_velocity((middle - clock.start) / clock.period, here.sway)
        in_cycle = pendulum_factor(clock, middle, manner.rate), sway
        law = _law(pace, here, in_cycle, settling, risen, manner)
        if begin < clock.start and (here.slope.ahead != 0.0 or here.slope.aside != 0.0):
            law = _leaning(before, law, manner, legs)
        for leg in range(len(before)):
            foot = knots[k + 1][leg]
            _copy(before[leg], foot)
            _advance(foot, leg, begin, end, law, here, clock, manner, legs)
            x, y, z = tilted_back(foot.x, foot.y, foot.z, foot.roll, foot.pitch)
            places[k + 1, leg, 0], places[k + 1, leg, 1], places[k + 1, leg, 2] = x, y, z


@compiled_part
def _here(demand: Demand, pace: Array, no_more_lifts: bool) -> Demand:
    """Return what is to be done at a knot; a body that is slowed down goes as it is planned."""
    if math.isnan(demand.lead):
        return demand
    size = math.hypot(pace[0], pace[1])
    ahead = 1.0 + (demand.lead / size if size > demand.lead else 0.0)
    # What stands is not to move by a trim.
    x, y = (0.0, 0.0) if no_more_lifts else demand.trim
    measured = Pace(ahead * pace[0] - x, ahead * pace[1] - y, pace[2])
    return Demand(
        demand.pace, measured, demand.roll, demand.pitch, demand.slope, (x, y),
        demand.roughness, demand.lead, demand.ground, demand.leveling, demand.capturing,
        demand.upright, demand.roughest, demand.sway, demand.swaying,
    )  # fmt: skip


@compiled_part
def _law(
    pace: Pace,
    demand: Demand,
    in_cycle: tuple[float, float],
    settling: float,
    risen: float,
    manner: Manner,
) -> _Law:
    """Return how feet move, for a body that is faster than on average by a factor, and sways."""
    factor, sway = in_cycle
    measured = demand.measured
    mean = Pace(pace.forward - demand.trim[0], pace.left - demand.trim[1], pace.turn)
    aim = Pace(factor * mean.forward, factor * mean.left, factor * mean.turn)
    ex, ey = measured.forward - aim.forward, measured.left - aim.left
    given_way = Pace(
        aim.forward + manner.giving_way * ex,
        aim.left + sway + manner.giving_way * (ey - demand.swaying),
        aim.turn + manner.turn_giving_way * (measured.turn - aim.turn),
    )
    # The step to the capture point, and what a curve needs: (h / g) w x v.
    capture_time = demand.capturing * manner.capture_time
    leaning = mean.turn / (manner.rate * manner.rate)
    excess = (
        capture_time * ex + leaning * mean.left,
        capture_time * ey - leaning * mean.forward,
    )
    return _Law(mean, given_way, excess, settling, risen)


@compiled_part
def _leaning(feet: Feet, law: _Law, manner: Manner, legs: Legs) -> _Law:
    """Return how feet move while the body leans to above them, on a slope, before it trots."""
    rate = 1.0 / (len(feet) * manner.leaning_time)
    x = y = 0.0
    for leg in range(len(feet)):
        x += rate * (feet[leg].x - legs.neutral[leg, 0])
        y += rate * (feet[leg].y - legs.neutral[leg, 1])
    given_way = Pace(x, y, law.given_way.turn)
    return _Law(law.mean, given_way, (0.0, 0.0), law.settling, law.risen)


@compiled_part
def _kept(dt: float, manner: Manner) -> float:
    """Return which part of what a leg rights is left after a time [s]."""
    return math.exp(-dt / manner.righting_time)


@compiled_part
def _settling(feet: Feet, demand: Demand, risen: float, manner: Manner) -> float:
    """Return by what height the body is to rise as a whole [m]; nan if each foot goes its way."""
    if demand.ground.is_known:
        return demand.ground.body - risen
    return _mean_rise(feet) if demand.roughness > manner.rough_from else math.nan


@compiled_part
def _mean_rise(feet: Feet) -> float:
    """Return the mean height above the plane of what feet stand on [m]."""
    total, count = 0.0, 0
    for leg in range(len(feet)):
        if feet[leg].swings == 0.0:
            total += feet[leg].rise
            count += 1
    return total / max(count, 1)


@compiled_part
def _copy(source: Any, to: Any) -> None:
    to.x, to.y, to.z, to.vx, to.vy = source.x, source.y, source.z, source.vx, source.vy
    to.rise, to.roll, to.pitch, to.swings = source.rise, source.roll, source.pitch, source.swings
    to.target_x, to.target_y, to.lift = source.target_x, source.target_y, source.lift
    to.has_landed = source.has_landed


@compiled_part
def _advance(
    foot: Any,
    leg: int,
    begin: float,
    end: float,
    law: _Law,
    demand: Demand,
    clock: PhaseClock,
    manner: Manner,
    legs: Legs,
) -> None:
    """Move a foot on from one time to another [s]: it stands, swings, lifts or lands."""
    dt = end - begin
    fraction, left = swing_phase(clock, leg, end)
    if foot.has_landed != 0.0 or (fraction == STANDS and foot.swings == 0.0):
        _stand(foot, leg, dt, law, demand, manner, legs)
        if fraction == STANDS:
            foot.has_landed = 0.0
        return
    # Liftoff and touchdown lie between knots: it swings for a part of the time.
    duration = clock.swing_fractions[leg] * clock.period
    if foot.swings == 0.0:
        swung = min(dt, fraction * duration)
        _stand(foot, leg, dt - swung, law, demand, manner, legs)
        foot.lift = lift_over(leg, demand, manner)
    elif fraction == STANDS:
        until = swing_phase(clock, leg, begin)[1]
        swung = min(dt, until) if until > 0.0 else dt
    else:
        swung = dt
    swing = SwingTime(
        swung, left, duration, (1.0 - clock.swing_fractions[leg]) * clock.period, fraction
    )
    _swing(foot, leg, swing, law, demand, manner, legs)
    if swung < dt and fraction == STANDS:
        _stand(foot, leg, dt - swung, law, demand, manner, legs)


class SwingTime(NamedTuple):
    """When a foot swings in the time from one knot to the next."""

    dt: float
    """Time for which it does [s]."""
    left: float
    """Time until it lands after that [s]."""
    duration: float
    """Duration of its whole swing [s]."""
    stance: float
    """Duration of its stance [s]."""
    fraction: float
    """Fraction of the swing that is over by the next knot; STANDS if it stands by then."""


@compiled_part
def lift_over(leg: int, demand: Demand, manner: Manner) -> float:
    """Return how high a foot is lifted: over what is on its way, or by how rough the ground is."""
    if demand.ground.is_known:
        more = demand.ground.bumps[leg]
    else:
        roughness = max(demand.roughness, demand.roughest)
        more = manner.rough_lift * max(roughness - manner.rough_from, 0.0)
    return max(manner.lift, min(manner.lift + more, manner.most_lift))


@compiled_part
def _leveling(demand: Demand, manner: Manner) -> float:
    """Return which part of the tilt swinging feet make up for, by how large it is."""
    tilt = math.hypot(demand.roll, demand.pitch)
    large = (tilt - manner.small_tilt) / (manner.large_tilt - manner.small_tilt)
    more = min(max(large, 0.0), 1.0) * (manner.leveling_at_large_tilt - manner.leveling)
    return demand.leveling * (manner.leveling + more)


@compiled_part
def _drift(leg: int, x: float, y: float, pace: Pace, legs: Legs) -> tuple[float, float]:
    """Return how fast a foot that stands at a place rolls by beside a body [m/s]."""
    rolling = legs.rolling
    vx, vy = ground_velocity(x, y, pace)
    return (
        rolling[leg, 0, 0] * vx + rolling[leg, 0, 1] * vy,
        rolling[leg, 1, 0] * vx + rolling[leg, 1, 1] * vy,
    )


@compiled_part
def _stand(
    foot: Any,
    leg: int,
    dt: float,
    law: _Law,
    demand: Demand,
    manner: Manner,
    legs: Legs,
) -> None:
    """Let a foot stand for a time [s], and its leg right the body."""
    slope = demand.slope
    foot.vx, foot.vy = _drift(leg, foot.x, foot.y, law.given_way, legs)
    kept = _kept(dt, manner)
    foot.x += dt * foot.vx
    foot.y += dt * foot.vy
    # On level ground and slopes each foot goes over to the plane; else the body as a whole.
    foot.rise -= (1.0 - kept) * (foot.rise if math.isnan(law.settling) else law.settling)
    foot.z = legs.neutral[leg, 2] + (slope.ahead * foot.x + slope.aside * foot.y) + foot.rise
    roll, pitch = slope.roll + demand.upright[0], slope.pitch + demand.upright[1]
    foot.roll = roll + kept * (foot.roll - roll)
    foot.pitch = pitch + kept * (foot.pitch - pitch)
    foot.swings = 0.0


@compiled_part
def _swing(
    foot: Any, leg: int, swing: SwingTime, law: _Law, demand: Demand, manner: Manner, legs: Legs
) -> None:
    """Let a foot swing for a time."""
    slope, dt = demand.slope, swing.dt
    x, y, z = legs.neutral[leg, 0], legs.neutral[leg, 1], legs.neutral[leg, 2]
    if foot.swings == 0.0 or swing.left >= manner.freeze_time:
        drift = _drift(leg, x, y, law.mean, legs)
        foot.target_x, foot.target_y = landing_place(
            x, y, drift, law.excess, swing.stance, manner.largest
        )
    # At the end of its swing it is above the ground, as fast, and comes down.
    vx, vy = _drift(leg, foot.target_x, foot.target_y, law.given_way, legs)
    early = manner.landing * swing.duration
    until = swing.left + dt - early
    going = min(dt, max(until, 0.0))
    with_ground = dt - going
    if going > 0.0:
        above = foot.target_x - early * vx, foot.target_y - early * vy
        foot.x, foot.vx = swing_on(foot.x, foot.vx, above[0], vx, until, going)
        foot.y, foot.vy = swing_on(foot.y, foot.vy, above[1], vy, until, going)
    if with_ground > 0.0:
        foot.x += with_ground * vx
        foot.y += with_ground * vy
        foot.vx, foot.vy = vx, vy
    height = 0.0
    if swing.fraction != STANDS:
        height = foot.lift * swing_height(swing.fraction, manner.easing)
    landing = 0.0
    if demand.ground.is_known:
        landing = demand.ground.rises[leg] - law.risen
        foot.rise -= (1.0 - _kept(dt, manner)) * law.settling
    foot.rise = landing + swing.left / (swing.left + dt) * (foot.rise - landing)
    foot.z = z + (slope.ahead * foot.x + slope.aside * foot.y) + foot.rise + height
    part = _leveling(demand, manner)
    foot.roll = slope.roll + demand.upright[0] + part * demand.roll
    foot.pitch = slope.pitch + demand.upright[1] + part * demand.pitch
    foot.swings = 0.0 if swing.fraction == STANDS else 1.0
