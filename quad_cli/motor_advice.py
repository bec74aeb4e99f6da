"""
Whether a robot's motors are quick and strong enough for its gaits, and which would be.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from quad_common.errors import GaitError, JointLimitExceeded
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_steady_cycle
from quad_gait.cycle.joint_torques import (
    TORQUE_USED,
    TorqueDemand,
    torque_demand,
    unaided_demand,
    unaided_torques,
)

_LITTLE = 0.01
"""Motion of a trot of which is asked whether joints are fast enough, over the hips' height."""

_GAITS = ('crawl', 'trot')
"""Gaits whose torques are looked at: on three legs, and on two."""


@dataclass(frozen=True)
class StanceTorque:
    """What stepping on the spot asks of the joint that has the least in hand."""

    gait: str
    """Name of the gait."""
    demand: TorqueDemand
    """Joint that has the least in hand, and its torques."""
    efforts: tuple[float, ...]
    """Torques that suffice, of the three kinds of joints from the body outward [N m]."""
    is_possible: bool
    """Whether the joint may give way until friction at the feet bears the rest."""


@dataclass(frozen=True)
class MotorAdvice:
    """What is too slow or too weak about a robot's motors."""

    robot: Robot
    """The robot."""
    speed_to_trot: float | None
    """Speed that gives a trot where joints are too slow for any [rad/s]; else None."""
    torques: tuple[StanceTorque, ...]
    """What gaits ask for on the spot."""

    def figures(self) -> dict[str, Any]:
        """Return the figures, for programs."""
        torques = {own.gait: asdict(own.demand) for own in self.torques}
        return {'speed_to_trot': self.speed_to_trot, 'torques_on_the_spot': torques}

    def sentences(self) -> list[str]:
        """Say what is too slow or too weak, one sentence each; none if nothing is."""
        said = []
        if self.speed_to_trot is not None:
            said.append(
                f'too slow to trot: knees of {float(self.robot.velocity.min()):g} rad/s; if the '
                f'motors are faster than that, import it again with '
                f'--speed {_rounded_up(self.speed_to_trot):g}'
            )
        # Of all gaits, so that what is said last does not ask for an import once more.
        efforts = [max(kinds) for kinds in zip(*(own.efforts for own in self.torques))]
        for own in self.torques:
            demand = own.demand
            if demand.is_too_much:
                what = 'strides stay short' if own.is_possible else f'the robot cannot {own.gait}'
                said.append(
                    f'too weak to {own.gait} with full strides: stepping on the spot takes '
                    f'{demand.torque:.3g} N m from {demand.joint}, whose limit is '
                    f'{demand.effort:g} N m, so {what}; if the motors are stronger than that, '
                    f'import the robot again with --effort '
                    f'{" ".join(f"{effort:g}" for effort in efforts)}'
                )
        return said


def motor_advice(robot: Robot) -> MotorAdvice:
    """
    Find out whether a robot's motors are quick and strong enough for its gaits.

    Parameters
    ----------
    robot : Robot
        The robot.
    """
    torques = []
    for name in _GAITS:
        gait = load_gait(name, robot)
        try:
            cycle = generate_steady_cycle(robot, gait, BodyMotion())
        except GaitError:
            # Something else forbids the gait: "quadwalk gait check" says what.
            continue
        is_possible = not torque_demand(robot, cycle).is_too_much
        asked = np.abs(unaided_torques(robot, cycle)).max(axis=(0, 1)) / TORQUE_USED
        efforts = tuple(
            float(own) if need <= own else _rounded_up(float(need))
            for need, own in zip(asked, robot.effort.max(axis=0))
        )
        torques.append(StanceTorque(name, unaided_demand(robot, cycle), efforts, is_possible))
    return MotorAdvice(robot, speed_to_trot(robot), tuple(torques))


def speed_to_trot(robot: Robot) -> float | None:
    """
    Say which speed of the joints gives a trot, if a robot's own joints are too slow for any.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    float or None
        Twice what the least of a trot takes [rad/s]; None if joints are fast enough, or something
        else forbids it.
    """
    trot = load_gait('trot', robot)
    try:
        generate_steady_cycle(robot, trot, BodyMotion(forward=_LITTLE * robot.hip_height))
    except JointLimitExceeded as error:
        return 2.0 * abs(error.value) if error.unit == 'rad/s' else None
    except GaitError:
        pass
    return None


def _rounded_up(value: float) -> float:
    """Return a number with two digits that is no smaller."""
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return round(math.ceil(value / step) * step, 9)
