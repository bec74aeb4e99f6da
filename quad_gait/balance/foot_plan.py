"""
The feet of a trotting robot at one knot, and at the next.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.rotations import matrix_from_angles
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import FOOT, Demand, Foot, FootPlan, GroundAhead, Landings
from quad_gait.balance.foot_laws import GRAVITY, STILL, Pace, leveled, pendulum_time
from quad_gait.balance.foot_march import Legs, Manner, march
from quad_gait.balance.leg_rates import lift_height, rolling_factors, swing_use
from quad_gait.balance.phase_clock import STANDS, PhaseClock
from quad_gait.cycle.gait import Gait
from quad_gait.ground.ground_slope import LEVEL, Slope

Array = NDArray[np.float64]


_GAINS = tuple(name for name in Manner._fields if name in BalanceOptions.__dataclass_fields__)
"""What of a manner is an option as it is."""


class March(NamedTuple):
    """Plans of m knots."""

    feet: NDArray[np.void]
    """Feet, shape (m, 4), of the type :data:`~quad_gait.balance.feet.FOOT`."""
    paces: Array
    """Velocities that are planned, shape (m, 3) [m/s], [rad/s]."""
    places: Array
    """Feet in the body's axes, shape (m, 4, 3) [m]; the first ones are not told."""
    slope: Slope
    """The ground."""

    def at(self, knot: int) -> FootPlan:
        """Return the plan of a knot."""
        return FootPlan(self.feet[knot], Pace(*self.paces[knot].tolist()), self.slope)

    def plans(self) -> list[FootPlan]:
        """Return the plans of all knots."""
        return [self.at(knot) for knot in range(len(self.feet))]

    def reached(self, places: Array, times: Sequence[float]) -> March:
        """
        Return the plans of feet that come only as far as slowed joints bring them.

        What follows goes on from there: a foot that landed short of its target is not to be drawn
        there over the ground.

        Parameters
        ----------
        places : ndarray, shape (m, 4, 3)
            Where they bring them, in the body's axes [m].
        times : sequence of float
            Times of the knots [s].

        Returns
        -------
        March
        """
        feet = self.feet.copy()
        steps = np.diff(np.array(times))[:, None]
        in_plane = leveled(places, feet['roll'], feet['pitch'])
        for axis, values in zip('xy', in_plane, strict=True):
            feet[axis][1:] = values[1:]
            feet[f'v{axis}'][1:] = np.diff(values, axis=0) / steps
        return self._replace(feet=feet)


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
        self._touching_phase = options.touching_phase
        self.height = robot.center_height
        """Height of the center of mass [m]."""
        self.capture_time = options.capture_gain * pendulum_time(self.height)
        """Length of the capture step over the error of the velocity [s]."""
        self._center = robot.center_of_mass(robot.initial_joint_angles)
        self._radius = robot.foot_radius
        self._neutral: Array = np.array(robot.neutral_feet)
        self._rolling = np.array(rolling_factors(robot))
        lift, most_lift = (
            lift_height(robot, gait, options.easing, fraction)
            for fraction in (options.lift_speed, options.rough_lift_speed)
        )
        lift = min(gait.swing_height, lift)
        spare = 1.0 - options.speed_kept - swing_use(robot, gait, lift)
        low = 1.0 - lift / (options.low_lift * self.height)
        fast = options.reach_speed * math.sqrt(GRAVITY * self.height)
        self._manner = Manner(
            capture_time=self.capture_time,
            rate=1.0 / pendulum_time(self.height),
            largest=min(
                0.5 * options.reach_fraction * robot.largest_stride,
                fast * PhaseClock.of(gait).longest_swing,
            ),
            landing=min(max(spare, 0.0), options.landing_fraction),
            lift=lift,
            most_lift=min(options.highest_lift * lift, most_lift),
            rough_from=options.rough * gait.swing_height,
            leveling_at_large_tilt=min(
                1.0, options.large_tilt_leveling + options.low_leveling * max(low, 0.0)
            ),
            righting_time=options.righting * PhaseClock.of(gait).stance_times[0],
            **{name: getattr(options, name) for name in _GAINS},
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
        feet = []
        for (x, y, z), neutral in zip(level.tolist(), self._neutral.tolist()):
            rise = z - neutral[2] - slope.rise(x, y)
            feet.append(Foot(x, y, z, rise=rise, roll=roll, pitch=pitch, target_x=x, target_y=y))
        return FootPlan(np.array(feet, dtype=FOOT), STILL, slope)

    def march(
        self, plan: FootPlan, clock: PhaseClock, times: Sequence[float], demand: Demand
    ) -> March:
        """
        Return the plans of knots.

        Parameters
        ----------
        plan : FootPlan
            The plan of the first one.
        clock : PhaseClock
            When feet swing.
        times : sequence of float
            Times of all [s].
        demand : Demand
            What is to be done between them.

        Returns
        -------
        March
        """
        count, slope = len(times), demand.slope
        feet = np.empty((count, len(self._neutral)), dtype=FOOT)
        paces, places = np.empty((count, 3)), np.empty((count, len(self._neutral), 3))
        feet[0], paces[0] = plan.records, plan.pace
        if slope != plan.slope:
            # On ground that is known better by now no foot jumps.
            for foot in feet[0]:
                foot.rise += plan.slope.rise(foot.x, foot.y) - slope.rise(foot.x, foot.y)
        legs = Legs(self._neutral_on(slope), self._rolling)
        march(feet, paces, places, np.array(times), clock, demand, self._manner, legs)
        return March(feet, paces, places, slope)

    def advance(
        self, plan: FootPlan, clock: PhaseClock, times: tuple[float, float], demand: Demand
    ) -> FootPlan:
        """Return the plan of the next knot; as :meth:`march` for two."""
        return self.march(plan, clock, times, demand).at(1)

    def met(self, plan: FootPlan, clock: PhaseClock, time: float, body: BodyEstimate) -> FootPlan:
        """
        Return a plan in which feet stand that met the ground before their time.

        Parameters
        ----------
        plan : FootPlan
            The plan of a knot.
        clock : PhaseClock
            When feet swing.
        time : float
            When the body was measured [s].
        body : BodyEstimate
            Which of its feet bear load.

        Returns
        -------
        FootPlan
        """
        if body.contacts is None:
            return plan
        feet = list(plan.feet)
        for k, (fraction, _) in enumerate(clock.swing_phases(time)):
            foot = feet[k]
            if foot.swings and fraction > self._touching_phase and body.contacts[k]:
                rise = foot.z - float(self._neutral[k, 2]) - plan.slope.rise(foot.x, foot.y)
                feet[k] = foot._replace(
                    swings=False, has_landed=True, rise=rise, target_x=foot.x, target_y=foot.y
                )
        return plan.with_feet(feet)

    def rejoined(self, plan: FootPlan, places: Array, time: float) -> FootPlan:
        """
        Return a plan whose feet are where joints have them that did something else.

        Parameters
        ----------
        plan : FootPlan
            The plan of a knot.
        places : ndarray, shape (2, 4, 3)
            Where the joints have the feet at the knot before and at this one, in the body [m].
        time : float
            Time between these [s].

        Returns
        -------
        FootPlan
        """
        records, slope = plan.records.copy(), plan.slope
        for axis, values in zip(
            'xy', leveled(places, records['roll'], records['pitch']), strict=True
        ):
            records[axis] = values[1]
            records[f'v{axis}'] = (values[1] - values[0]) / time
        for foot, neutral, place in zip(records, self._neutral, places[1]):
            if foot.swings == 0.0:
                rotation = matrix_from_angles(np.array([foot.roll, foot.pitch, 0.0]))
                height = float(rotation[2] @ place)
                foot.rise = height - neutral[2] - slope.rise(foot.x, foot.y)
                foot.z = height
        return plan._replace(records=records)

    def landings(
        self, plan: FootPlan, clock: PhaseClock, time: float, body: BodyEstimate
    ) -> Landings:
        """
        Return where feet land next, by how fast the body is.

        Parameters
        ----------
        plan : FootPlan
            The plan of a knot.
        clock : PhaseClock
            When feet swing.
        time : float
            Time of the knot [s].
        body : BodyEstimate
            How the body moves, and over which plane.

        Returns
        -------
        Landings
        """
        records, slope = plan.records, body.slope
        feet = np.stack([records['x'], records['y']], axis=-1)
        rises = np.array(records['rise'])
        if slope != plan.slope:
            rises += feet @ (np.array(plan.slope[:2]) - np.array(slope[:2]))
        neutral = self._neutral_on(slope)[:, :2]
        targets = neutral + 0.5 * clock.stance_times[0] * np.array(body.velocity)
        stand = records['swings'] == 0.0
        times = np.empty(len(feet))
        for leg, (fraction, left) in enumerate(clock.swing_phases(time)):
            times[leg] = left if fraction != STANDS else clock.until_landing(leg, time)
            if fraction != STANDS and not stand[leg]:
                targets[leg] = records['target_x'][leg], records['target_y'][leg]
        return Landings(feet, rises, stand, targets, times, neutral, clock.stance_times[0], slope)

    def risen(self, ground: GroundAhead, time: float) -> float:
        """Return by what height the plane of the ground rises in a time [s], under a body [m]."""
        return ground.body * (1.0 - math.exp(-time / self._manner.righting_time))

    def _neutral_on(self, slope: Slope) -> Array:
        """
        Return where the feet are under a standing body, as it is tilted over the ground [m].

        Its hips move with it, and its center of mass; a ball touches the ground uphill of its
        center.
        """
        if slope.is_level:
            return self._neutral
        rotation = matrix_from_angles(np.array([slope.roll, slope.pitch, 0.0]))
        center, normal = self._center, np.array(slope.normal)
        places: Array = self._neutral - center
        places[:, 2] = 0.0
        places = places @ rotation.T + rotation @ center + self._radius * normal
        places[:, 2] = self._neutral[:, 2]
        return places
