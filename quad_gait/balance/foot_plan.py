"""
The feet of a trotting robot at one knot, and at the next.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.foot_laws import (
    GRAVITY,
    STILL,
    Pace,
    ground_velocity,
    landing_place,
    pendulum_time,
    swing_height,
    swing_on,
    tilted_back,
)
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import Gait

Array = NDArray[np.float64]


class Foot(NamedTuple):
    """A foot at a knot, beside the level body."""

    x: float
    """Place of its center along x [m]."""
    y: float
    """The same along y [m]."""
    z: float
    """The same along z [m]."""
    vx: float = 0.0
    """Velocity along x while it swings [m/s]."""
    vy: float = 0.0
    """The same along y [m/s]."""
    roll: float = 0.0
    """Roll of the body that the leg makes up for [rad]."""
    pitch: float = 0.0
    """Pitch of the body that the leg makes up for [rad]."""
    swings: bool = False
    """Whether it swings."""
    target: tuple[float, float] = (0.0, 0.0)
    """Place where it lands, or has landed [m]."""

    @property
    def in_body(self) -> tuple[float, float, float]:
        """Place in the body's axes [m]."""
        return tilted_back(self.x, self.y, self.z, self.roll, self.pitch)


class FootPlan(NamedTuple):
    """The feet at a knot, and how fast the body is to be."""

    feet: tuple[Foot, ...]
    """Feet in the order of ``LEGS``."""
    pace: Pace
    """Velocity that is planned by now."""


@dataclass(frozen=True)
class Demand:
    """What is to be done from one knot to the next."""

    pace: Pace
    """Velocity that is wanted."""
    measured: Pace
    """Velocity of the body."""
    roll: float = 0.0
    """Roll of the body [rad]."""
    pitch: float = 0.0
    """Pitch of the body [rad]."""
    trim: tuple[float, float] = (0.0, 0.0)
    """Velocity by which less is asked for than is wanted [m/s]."""


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
        self._swing_height = gait.swing_height
        center = robot.center_of_mass(robot.initial_joint_angles)
        self.height = float(center[2] + robot.standing_height)
        """Height of the center of mass [m]."""
        self.unit = math.sqrt(GRAVITY * self.height)
        self.capture_time = options.capture_gain * pendulum_time(self.height)
        """Length of the capture step over the error of the velocity [s]."""
        self._roll = _rolling(robot) if options.rolls else [((1.0, 0.0), (0.0, 1.0))] * 4
        self._lift = options.lift * gait.support_depth * gait.swing_height
        self._neutral = [tuple(foot) for foot in robot.neutral_feet.tolist()]
        fast = options.reach_speed * math.sqrt(GRAVITY * self.height)
        self._largest = min(
            0.5 * options.reach_fraction * robot.largest_stride,
            fast * PhaseClock.of(gait).longest_swing,
        )

    def at_rest(self, places: Array) -> FootPlan:
        """Return the plan of a robot that stands level, its feet at places (4, 3) [m]."""
        feet = tuple(Foot(x, y, z, target=(x, y)) for x, y, z in places.tolist())
        return FootPlan(feet, STILL)

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
        options, measured = self._options, demand.measured
        dt = times[1] - times[0]
        kept = math.exp(-dt / options.righting_time)
        pace = self._pace_after(plan.pace, demand.pace, dt)
        mean = Pace(pace.forward - demand.trim[0], pace.left - demand.trim[1], pace.turn)
        f = 1.0 if options.pendulum == 0 else clock.pendulum_factor((times[0]+times[1])/2, options.pendulum*math.sqrt(GRAVITY/self.height))
        aim = Pace(mean.forward*f, mean.left*f, mean.turn*f)
        error = measured.forward - aim.forward, measured.left - aim.left
        part = options.giving_way * _rise(math.hypot(*error), options.gives_from*self.unit, options.gives_all*self.unit)
        spin = measured.turn - aim.turn
        turn_part = options.turn_giving_way * _rise(abs(spin), options.turn_from, options.turn_all)
        given_way = Pace(
            aim.forward + part * error[0],
            aim.left + part * error[1],
            aim.turn + turn_part * spin,
        )
        excess = self.capture_time * error[0], self.capture_time * error[1]
        before, phases = clock.swing_phases(times[0]), clock.swing_phases(times[1])
        up = self._lift * sum(swing_height(f) for f in {p[0] for p in phases if p[0] is not None})
        feet = []
        for k, foot in enumerate(plan.feet):
            fraction, left = phases[k]
            neutral, roll = self._neutral[k], self._roll[k]
            swings = fraction is not None
            x, y, vx, vy = foot.x, foot.y, foot.vx, foot.vy
            roll_angle, pitch_angle = foot.roll, foot.pitch
            target = foot.target
            # Time for which it stands before it swings, swings, and stands again.
            stood = swung = 0.0
            if not foot.swings:
                stood = dt if not swings else max(dt - fraction * clock.swing_times[k], 0.0)
            if swings:
                swung = dt - stood
            elif foot.swings:
                swung = min(before[k][1], dt) if before[k][0] is not None else dt
            if stood > 0.0 or not foot.swings:
                vx, vy = rolled(roll, ground_velocity(x, y, given_way))
                x, y = x + stood * vx, y + stood * vy
            if swung > 0.0:
                if not foot.swings or left >= options.freeze_time:
                    stance = clock.stance_times[k]
                    target = landing_place(neutral, rolled(roll, ground_velocity(*neutral[:2], mean)), excess, stance, self._largest)
                at_landing = rolled(roll, ground_velocity(*target, given_way))
                x, vx = swing_on(x, vx, target[0], at_landing[0], left + swung, swung)
                y, vy = swing_on(y, vy, target[1], at_landing[1], left + swung, swung)
                roll_angle, pitch_angle = options.leveling * demand.roll, options.leveling * demand.pitch
            rest = dt - stood - swung
            if rest > 0.0:
                vx, vy = rolled(roll, ground_velocity(x, y, given_way))
                x, y = x + rest * vx, y + rest * vy
            if not swings and swung <= 0.0:
                roll_angle, pitch_angle = kept * roll_angle, kept * pitch_angle
            lift = 0.0 if fraction is None else self._swing_height * (swing_height(fraction) if options.soft <= 0 else swing_height(_eased(fraction, options.soft)))
            feet.append(Foot(x, y, neutral[2] + lift - up, vx, vy, roll_angle, pitch_angle, swings, target))
        return FootPlan(tuple(feet), pace)

    def _pace_after(self, last: Pace, wanted: Pace, dt: float) -> Pace:
        """Return the pace after a time [s], gathered no faster than the options allow."""
        step = dt * GRAVITY * self._options.acceleration
        turn_step = dt * self._options.turn_acceleration
        return Pace(
            _toward(last.forward, wanted.forward, step),
            _toward(last.left, wanted.left, step),
            _toward(last.turn, wanted.turn, turn_step),
        )


def _rolling(robot):
    joints = robot.initial_joint_angles
    jac = robot.foot_jacobians(joints)
    out = []
    for leg in range(4):
        cols = []
        for axis in range(2):
            u = np.zeros((4, 3)); u[leg, axis] = 1.0
            q = np.linalg.solve(jac, u[..., None])[..., 0]
            w = robot.calf_angular_velocities(joints, q)[leg]
            cols.append([robot.foot_radius * w[1], -robot.foot_radius * w[0]])
        k = np.array(cols).T
        out.append(tuple(map(tuple, np.linalg.inv(np.eye(2) - k).tolist())))
    return out


def rolled(m, v):
    return m[0][0] * v[0] + m[0][1] * v[1], m[1][0] * v[0] + m[1][1] * v[1]


def _standing(foot: Foot, height: float, speed, dt: float, kept: float) -> Foot:
    """Return a foot that stands after a time [s], with the part of its tilt that is kept."""
    vx, vy = speed
    x, y = foot.x + dt * vx, foot.y + dt * vy
    return Foot(x, y, height, vx, vy, kept * foot.roll, kept * foot.pitch, False, foot.target)


def _rise(value: float, first: float, last: float) -> float:
    s = min(max((value - first) / (last - first), 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


def _eased(u: float, b: float) -> float:
    if u < b:
        r = u * u / (2.0 * b)
    elif u > 1.0 - b:
        r = 1.0 - b - (1.0 - u) ** 2 / (2.0 * b)
    else:
        r = u - b / 2.0
    return r / (1.0 - b)


def _toward(value: float, wanted: float, step: float) -> float:
    return value + min(max(wanted - value, -step), step)
