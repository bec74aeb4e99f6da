"""
The feet of a trotting robot at one knot, and at the next.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.rotations import matrix_from_angles
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import Demand, Foot, FootPlan
from quad_gait.balance.foot_laws import (
    GRAVITY,
    STILL,
    Pace,
    ground_velocity,
    landing_place,
    pendulum_time,
    swing_height,
    swing_on,
)
from quad_gait.balance.ground_slope import LEVEL, Slope
from quad_gait.balance.leg_rates import lift_height, rolling_factors, swing_use
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import Gait

Array = NDArray[np.float64]


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
    fraction: float | None
    """Fraction of the swing that is over by the next knot; None if it stands by then."""


class _Law(NamedTuple):
    """How feet move for a moment."""

    mean: Pace
    """Velocity that is wanted on average."""
    given_way: Pace
    """Velocity with which standing feet go."""
    excess: tuple[float, float]
    """Step to the capture point [m]."""
    slope: Slope
    """The ground."""
    neutral: list[tuple[float, ...]]
    """Places of the feet under a standing body [m]."""
    rise: float | None = None
    """Mean height above the plane of what the feet stand on, where it is rough; else None [m]."""


class FootPlanner:
    """
    Moves the feet of one robot on from knot to knot.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        Its trot.
    options : BalanceOptions
        Gains.
    """

    def __init__(self, robot: Robot, gait: Gait, options: BalanceOptions) -> None:
        self._options = options
        self._most_lift = lift_height(robot, gait, options.easing, options.lift_speed)
        self._lift = min(gait.swing_height, self._most_lift)
        self._rough = options.rough * gait.swing_height
        center = robot.center_of_mass(robot.initial_joint_angles)
        self.height = float(center[2] + robot.standing_height)
        """Height of the center of mass [m]."""
        self.capture_time = options.capture_gain * pendulum_time(self.height)
        """Length of the capture step over the error of the velocity [s]."""
        self._rate = 1.0 / pendulum_time(self.height)
        self._center = center
        self._radius = robot.foot_radius
        clock = PhaseClock.of(gait)
        self._known = clock, 0.0, clock.swing_phases(0.0)
        self._neutral = [tuple(foot) for foot in robot.neutral_feet.tolist()]
        self._rolling = rolling_factors(robot)
        spare = 1.0 - options.speed_kept - swing_use(robot, gait, self._lift)
        self._landing = min(max(spare, 0.0), options.landing_fraction)
        fast = options.reach_speed * math.sqrt(GRAVITY * self.height)
        self._largest = min(
            0.5 * options.reach_fraction * robot.largest_stride,
            fast * clock.longest_swing,
        )

    def at_rest(
        self, places: Array, slope: Slope = LEVEL, roll: float = 0.0, pitch: float = 0.0
    ) -> FootPlan:
        """
        Return the plan of a robot that stands.

        Parameters
        ----------
        places : ndarray, shape (4, 3)
            Its feet in the body's axes [m].
        slope : Slope
            The ground.
        roll, pitch : float
            Tilt of the body [rad].

        Returns
        -------
        FootPlan
        """
        level = places
        if roll or pitch:
            level = places @ matrix_from_angles(np.array([roll, pitch, 0.0])).T
        feet = tuple(
            Foot(
                x, y, z,
                rise=0.0 if slope.is_level else z - self._neutral[k][2] - slope.rise(x, y),
                roll=roll, pitch=pitch, target=(x, y),
            )
            for k, (x, y, z) in enumerate(level.tolist())
        )  # fmt: skip
        return FootPlan(feet, STILL, slope)

    def advance(
        self, plan: FootPlan, clock: PhaseClock, times: tuple[float, float], demand: Demand
    ) -> FootPlan:
        """
        Return the plan of the next knot.

        Parameters
        ----------
        plan : FootPlan
            The plan of this one.
        clock : PhaseClock
            When feet swing.
        times : tuple of float
            Times of this knot and of the next [s].
        demand : Demand
            What is to be done between them.

        Returns
        -------
        FootPlan
        """
        dt = times[1] - times[0]
        pace = self._pace_after(plan.pace, demand.pace, dt)
        law = self._law(pace, demand, clock.pendulum_factor(sum(times) / 2.0, self._rate), dt)
        plan = self._on(plan, demand.slope)
        if self._is_rough(demand.roughness):
            rises = [foot.rise for foot in plan.feet if not foot.swings]
            law = law._replace(rise=sum(rises) / max(len(rises), 1))
        if times[0] < clock.start and not law.slope.is_level:
            law = self._leaning(plan, law)
        before, after = self._phases(clock, times[0]), self._phases(clock, times[1])
        feet = []
        for k, foot in enumerate(plan.feet):
            fraction, left = after[k]
            if foot.has_landed or (fraction is None and not foot.swings):
                stands = self._standing(k, foot, dt, law)
                if foot.has_landed and fraction is not None:
                    stands = stands._replace(has_landed=True)
                feet.append(stands)
                continue
            # Liftoff and touchdown lie between knots: it swings for a part of the time.
            if not foot.swings:
                swung = min(dt, (fraction or 0.0) * clock.swing_times[k])
                foot = self._standing(k, foot, dt - swung, law)
                foot = foot._replace(lift=self._lift_over(demand.roughness))
            else:
                swung = dt if fraction is not None else min(dt, before[k][1] or dt)
            swing = SwingTime(swung, left, clock.swing_times[k], clock.stance_times[k], fraction)
            foot = self._swinging(k, foot, swing, law, demand)
            if swung < dt and fraction is None:
                foot = self._standing(k, foot, dt - swung, law)
            feet.append(foot)
        return FootPlan(tuple(feet), pace, demand.slope)

    def met(self, plan: FootPlan, clock: PhaseClock, time: float, body: BodyEstimate) -> FootPlan:
        """
        Return a plan in which feet stand that met rough ground before their time.

        Parameters
        ----------
        plan : FootPlan
            The plan of a knot.
        clock : PhaseClock
            When feet swing.
        time : float
            When the body was measured [s].
        body : BodyEstimate
            Which of its feet bear load, and how rough the ground is.

        Returns
        -------
        FootPlan
        """
        options = self._options
        if body.contacts is None or not self._is_rough(body.roughness):
            return plan
        feet = []
        for k, (fraction, _) in enumerate(clock.swing_phases(time)):
            foot = plan.feet[k]
            comes_down = fraction is not None and fraction > options.touching_phase
            if foot.swings and comes_down and body.contacts[k]:
                rise = foot.z - self._neutral[k][2] - plan.slope.rise(foot.x, foot.y)
                foot = foot._replace(
                    swings=False, has_landed=True, rise=rise, target=(foot.x, foot.y)
                )
            feet.append(foot)
        return plan._replace(feet=tuple(feet))

    def _phases(self, clock: PhaseClock, time: float) -> list[tuple[float | None, float]]:
        """Return the phases of swings; a knot begins with those the last one ended with."""
        if self._known[0] is not clock or self._known[1] != time:
            self._known = clock, time, clock.swing_phases(time)
        return self._known[2]

    def _law(self, pace: Pace, demand: Demand, factor: float, dt: float) -> _Law:
        """Return how feet move for a time [s], for a body that is to be faster than on average."""
        options, measured = self._options, demand.measured
        mean = Pace(pace.forward - demand.trim[0], pace.left - demand.trim[1], pace.turn)
        aim = Pace(factor * mean.forward, factor * mean.left, factor * mean.turn)
        error = measured.forward - aim.forward, measured.left - aim.left
        given_way = Pace(
            aim.forward + options.giving_way * error[0],
            aim.left + options.giving_way * error[1],
            aim.turn + options.turn_giving_way * (measured.turn - aim.turn),
        )
        leaning = self._rate**-2 * mean.turn
        excess = (
            self.capture_time * error[0] + leaning * mean.left,
            self.capture_time * error[1] - leaning * mean.forward,
        )
        return _Law(mean, given_way, excess, demand.slope, self._neutral_on(demand.slope))

    def _neutral_on(self, slope: Slope) -> list[tuple[float, ...]]:
        """
        Return where the feet are under a standing body, as it is tilted over the ground [m].

        Its hips move with it, and its center of mass; a ball touches the ground uphill of its
        center.
        """
        if slope.is_level:
            return self._neutral
        rotation = matrix_from_angles(np.array([slope.roll, slope.pitch, 0.0]))
        center, normal = self._center, slope.normal
        arms = np.array(self._neutral) - center
        arms[:, 2] = 0.0
        places = (arms @ rotation.T + rotation @ center)[:, :2] + self._radius * np.array(
            normal[:2]
        )
        return [(x, y, self._neutral[k][2]) for k, (x, y) in enumerate(places.tolist())]

    def _is_rough(self, roughness: float) -> bool:
        """Return whether ground is rough on which feet are off its plane by a height [m]."""
        return roughness > self._rough

    def _lift_over(self, roughness: float) -> float:
        """Return how high a foot is lifted over ground that is rough by a height [m]."""
        options, usual = self._options, self._lift
        more = options.rough_lift * max(roughness - self._rough, 0.0)
        return max(usual, min(usual + more, options.highest_lift * usual, self._most_lift))

    def _on(self, plan: FootPlan, slope: Slope) -> FootPlan:
        """Return the plan on ground that is known better by now; no foot jumps."""
        if slope == plan.slope:
            return plan
        feet = tuple(
            foot._replace(
                rise=foot.rise + plan.slope.rise(foot.x, foot.y) - slope.rise(foot.x, foot.y)
            )
            for foot in plan.feet
        )
        return plan._replace(feet=feet, slope=slope)

    def _leaning(self, plan: FootPlan, law: _Law) -> _Law:
        """Return how feet move while the body leans to above them, on a slope, before it trots."""
        apart = [(f.x - n[0], f.y - n[1]) for f, n in zip(plan.feet, law.neutral)]
        rate = 1.0 / (len(apart) * self._options.leaning_time)
        x, y = (rate * sum(place) for place in zip(*apart))
        way = law.given_way
        return law._replace(given_way=way._replace(forward=x, left=y), excess=(0.0, 0.0))

    def _drift(self, leg: int, x: float, y: float, pace: Pace) -> tuple[float, float]:
        """Return how fast a foot that stands at a place rolls by beside a body [m/s]."""
        (a, b), (c, d) = self._rolling[leg]
        vx, vy = ground_velocity(x, y, pace)
        return a * vx + b * vy, c * vx + d * vy

    def _standing(self, leg: int, foot: Foot, dt: float, law: _Law) -> Foot:
        """Return a foot that stands for a time [s], with the part of its tilt that is kept."""
        vx, vy = self._drift(leg, foot.x, foot.y, law.given_way)
        kept = math.exp(-dt / self._options.righting_time)
        x, y, slope = foot.x + dt * vx, foot.y + dt * vy, law.slope
        # On level ground and slopes each foot goes over to the plane; else the body as a whole.
        rise = foot.rise - (1.0 - kept) * (foot.rise if law.rise is None else law.rise)
        return Foot(
            x, y, self._neutral[leg][2] + slope.rise(x, y) + rise, vx, vy, rise,
            slope.roll + kept * (foot.roll - slope.roll),
            slope.pitch + kept * (foot.pitch - slope.pitch),
            False, foot.target, foot.lift,
        )  # fmt: skip

    def _swinging(self, leg: int, foot: Foot, swing: SwingTime, law: _Law, demand: Demand) -> Foot:
        """Return a foot that swings for a time."""
        options, neutral, slope = self._options, law.neutral[leg], law.slope
        target, dt = foot.target, swing.dt
        if not foot.swings or swing.left >= options.freeze_time:
            drift = self._drift(leg, neutral[0], neutral[1], law.mean)
            target = landing_place(neutral, drift, law.excess, swing.stance, self._largest)
        vx, vy = self._drift(leg, *target, law.given_way)
        # At the end of its swing it is above the ground, as fast, and comes down.
        early = self._landing * swing.duration
        until = swing.left + dt - early
        going = min(dt, max(until, 0.0))
        x, y, with_ground = foot.x, foot.y, dt - going
        speed = foot.vx, foot.vy
        if going > 0.0:
            x, speed_x = swing_on(x, foot.vx, target[0] - early * vx, vx, until, going)
            y, speed_y = swing_on(y, foot.vy, target[1] - early * vy, vy, until, going)
            speed = speed_x, speed_y
        if with_ground > 0.0:
            x, y, speed = x + with_ground * vx, y + with_ground * vy, (vx, vy)
        lift = 0.0
        if swing.fraction is not None:
            lift = foot.lift * swing_height(swing.fraction, options.easing)
        rise = foot.rise * swing.left / (swing.left + dt)
        return Foot(
            x, y, neutral[2] + slope.rise(x, y) + rise + lift, *speed, rise,
            slope.roll + options.leveling * demand.roll,
            slope.pitch + options.leveling * demand.pitch,
            swing.fraction is not None, target, foot.lift,
        )  # fmt: skip

    def _pace_after(self, last: Pace, wanted: Pace, dt: float) -> Pace:
        """Return the pace after a time [s], gathered no faster than the options allow."""
        step = dt * GRAVITY * self._options.acceleration
        turn_step = dt * self._options.turn_acceleration
        return Pace(
            _toward(last.forward, wanted.forward, step),
            _toward(last.left, wanted.left, step),
            _toward(last.turn, wanted.turn, turn_step),
        )


def _toward(value: float, wanted: float, step: float) -> float:
    return value + min(max(wanted - value, -step), step)
