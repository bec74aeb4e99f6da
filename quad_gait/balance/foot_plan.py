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
        self.capture_time = options.capture_gain * pendulum_time(self.height)
        """Length of the capture step over the error of the velocity [s]."""
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
        part, kept = options.giving_way, math.exp(-dt / options.righting_time)
        pace = self._pace_after(plan.pace, demand.pace, dt)
        aim = Pace(pace.forward - demand.trim[0], pace.left - demand.trim[1], pace.turn)
        error = measured.forward - aim.forward, measured.left - aim.left
        given_way = Pace(
            aim.forward + part * error[0],
            aim.left + part * error[1],
            pace.turn + options.turn_giving_way * (measured.turn - pace.turn),
        )
        excess = self.capture_time * error[0], self.capture_time * error[1]
        phases = clock.swing_phases(times[1])
        feet = []
        for foot, neutral, (fraction, left), stance in zip(
            plan.feet, self._neutral, phases, clock.stance_times
        ):
            if fraction is None and not foot.swings:
                feet.append(_standing(foot, neutral[2], given_way, dt, kept))
                continue
            vx, vy = foot.vx, foot.vy
            if not foot.swings:
                # It leaves as fast as the ground.
                vx, vy = ground_velocity(foot.x, foot.y, given_way)
            target = foot.target
            if not foot.swings or left >= options.freeze_time:
                target = landing_place(neutral[0], neutral[1], aim, excess, stance, self._largest)
            at_landing = ground_velocity(*target, given_way)
            x, vx = swing_on(foot.x, vx, target[0], at_landing[0], left + dt, dt)
            y, vy = swing_on(foot.y, vy, target[1], at_landing[1], left + dt, dt)
            lift = 0.0 if fraction is None else self._swing_height * swing_height(fraction)
            part = options.leveling
            feet.append(
                Foot(
                    x, y, neutral[2] + lift, vx, vy,
                    part * demand.roll, part * demand.pitch, fraction is not None, target,
                )
            )  # fmt: skip
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


def _standing(foot: Foot, height: float, given_way: Pace, dt: float, kept: float) -> Foot:
    """Return a foot that stands after a time [s], with the part of its tilt that is kept."""
    vx, vy = ground_velocity(foot.x, foot.y, given_way)
    x, y = foot.x + dt * vx, foot.y + dt * vy
    return Foot(x, y, height, vx, vy, kept * foot.roll, kept * foot.pitch, False, foot.target)


def _toward(value: float, wanted: float, step: float) -> float:
    return value + min(max(wanted - value, -step), step)
