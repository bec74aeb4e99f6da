"""
Which torques a planned cycle asks of the joints: of those that stand, and of legs in the air.

The feet that stand carry the robot's weight and accelerate its mass: their forces F have the
sum m (c'' + g) and no moment about the center of mass c. That leaves forces open with which feet
pull at one another; first there are none (the least forces that will do). A joint then gives
tau = g(q) - J^T F, where g is the weight of its own leg's links. Static gaits gain and lose their
speed on four feet, within a tenth of a second, in which joints lag but little: there c'' is 0.

A joint that cannot give that much gives way until friction at the feet bears what is missing.
So where torques do not suffice, feet may pull at one another as far as little friction lets
them: so that the largest tau / tau_max becomes small, by weighted least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_moments import GRAVITY, weight_torques
from quad_common.robot.robot import Robot
from quad_gait.cycle.cycle import Cycle

Array = NDArray[np.float64]

TORQUE_USED = 0.9
"""Fraction of a joint's largest torque that a cycle may ask for: touching down and following
take the rest. In simulation A1's and Spot's joints gave a tenth more than what is worked out."""

_FRICTION = 0.2
"""Coefficient of friction that feet may make use of when they pull at one another; rubber has 0.6
and more, of which walking takes its part."""

_EVERY = 8
"""Samples for which the weight of the legs themselves is taken to be the same."""

_WEIGHTINGS = 6
"""Weightings of the joints' torques that are tried, each by what the one before left."""

_SOFT = 1e-7
"""Softness against which forces are found, so that feet in a line have some, too."""


@dataclass(frozen=True)
class TorqueDemand:
    """The joint that a cycle asks for most, as a fraction of what it can give."""

    joint: str
    """Name of the joint."""
    torque: float
    """Largest torque that it is asked for [N m]."""
    effort: float
    """Largest torque that it can give [N m]."""
    time: float
    """Time in the cycle at which it is asked for that [s]."""

    @property
    def fraction(self) -> float:
        """Torque asked for over the largest torque."""
        return self.torque / self.effort

    @property
    def is_too_much(self) -> bool:
        """Whether it leaves less in hand than cycles must."""
        return self.fraction > TORQUE_USED

    def sentence(self) -> str:
        """Say what is asked for, and what there is."""
        return (
            f'joint {self.joint} would have to give {self.torque:.3g} N m {self.time:.2f} s into '
            f'the cycle; {100.0 * TORQUE_USED:.0f} % of its largest torque are '
            f'{TORQUE_USED * self.effort:.3g} N m'
        )


def unaided_torques(robot: Robot, cycle: Cycle) -> Array:
    """Return the joints' torques in a cycle whose feet do not pull, shape (n, 4, 3) [N m]."""
    return _unaided(robot, cycle)[1]


def unaided_demand(robot: Robot, cycle: Cycle) -> TorqueDemand:
    """
    Find the largest torque of a cycle whose feet do not pull at one another.

    Parameters
    ----------
    robot : Robot
        The robot.
    cycle : Cycle
        Any cycle, of 8 samples or more.

    Returns
    -------
    TorqueDemand
        Of the joint that has the least in hand.
    """
    return _largest(robot, *_unaided(robot, cycle)[:2])


def torque_demand(robot: Robot, cycle: Cycle) -> TorqueDemand:
    """
    Find the largest torque of a cycle whose feet pull at one another where joints need it.

    Parameters
    ----------
    robot : Robot
        The robot.
    cycle : Cycle
        Any cycle, of 8 samples or more.

    Returns
    -------
    TorqueDemand
        Of the joint that has the least in hand; as :func:`unaided_demand` says if that is
        not too much.
    """
    times, torques, forces, rows = _unaided(robot, cycle)
    unaided = _largest(robot, times, torques)
    if not unaided.is_too_much:
        return unaided
    return _largest(robot, times, _relief(robot, torques, forces, rows))


@dataclass(frozen=True, eq=False)
class _Rows:
    """Matrices that take the forces of four feet, n samples, axes of the body."""

    wrenches: Array
    """To force and moment about the center of mass, with lengths in its height, (n, 6, 12)."""
    torques: Array
    """To the joints' torques, (n, 12, 12) [m]."""


def _unaided(robot: Robot, cycle: Cycle) -> tuple[Array, Array, Array, _Rows]:
    """Return times (n,), torques and forces (n, 4, 3), and what forces come to."""
    count = len(cycle.times)
    wrenches = _wrench_rows(robot, cycle)
    wanted = np.zeros((count, 6))
    if not cycle.gait.is_static:
        wanted[:, :2] = robot.mass * _in_body(cycle, _acceleration(cycle))
    wanted[:, 2] = robot.mass * GRAVITY
    across = np.swapaxes(wrenches, -1, -2)
    soft = wrenches @ across + _SOFT * np.eye(6)
    forces = (across @ np.linalg.solve(soft, wanted[..., None])).reshape(count, 4, 3)
    jacobians = robot.foot_jacobians(cycle.joint_positions) * cycle.in_contact[..., None, None]
    rows = np.zeros((count, 4, 3, 4, 3))
    legs = np.arange(4)
    rows[:, legs, :, legs] = -np.swapaxes(jacobians, -1, -2).transpose(1, 0, 2, 3)
    own = weight_torques(robot, cycle.joint_positions[::_EVERY], np.eye(3)[2])
    torques = np.repeat(own, _EVERY, axis=0)[:count] - np.einsum('nlij,nli->nlj', jacobians, forces)
    return cycle.times, torques, forces, _Rows(wrenches, rows.reshape(count, 12, 12))


def _wrench_rows(robot: Robot, cycle: Cycle) -> Array:
    """Return what the forces of feet that stand add up to, (n, 6, 12), lengths in heights."""
    center = robot.center_of_mass(robot.initial_joint_angles)
    height = float(center[2]) + robot.standing_height
    arms = np.empty(cycle.feet.shape)
    arms[..., :2] = _in_body(cycle, cycle.feet[..., :2] - cycle.center_of_mass[:, None])
    arms[..., 2] = -height
    x, y, z = np.moveaxis(arms / height, -1, 0)
    rows = np.zeros((len(arms), 6, 4, 3))
    for axis in range(3):
        rows[:, axis, :, axis] = 1.0
    rows[:, 3, :, 1], rows[:, 3, :, 2] = -z, y
    rows[:, 4, :, 0], rows[:, 4, :, 2] = z, -x
    rows[:, 5, :, 0], rows[:, 5, :, 1] = -y, x
    rows *= cycle.in_contact[:, None, :, None]
    return rows.reshape(len(arms), 6, 12)


def _acceleration(cycle: Cycle) -> Array:
    """Return the acceleration of the center of mass in the ground frame, (n, 2) [m/s^2]."""
    step = float(cycle.times[1] - cycle.times[0])
    speed = np.gradient(cycle.center_of_mass, step, axis=0)
    acceleration: Array = np.gradient(speed, step, axis=0)
    return acceleration


def _in_body(cycle: Cycle, vectors: Array) -> Array:
    """Turn vectors (n, ..., 2) of the ground frame into the body's."""
    shape = (-1, *[1] * (vectors.ndim - 2))
    cos, sin = (f(cycle.body[:, 2]).reshape(shape) for f in (np.cos, np.sin))
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1)


def _relief(robot: Robot, torques: Array, forces: Array, rows: _Rows) -> Array:
    """Return torques (n, 4, 3) of feet that pull at one another: the best of a few weightings."""
    scaled = 1.0 / robot.effort.reshape(-1)
    own = scaled * torques.reshape(-1, 12)
    across = np.swapaxes(rows.wrenches, -1, -2)
    soft = rows.wrenches @ across + _SOFT * np.eye(6)
    # Whatever the forces are, what is left of them by this adds up to nothing.
    free = np.eye(12) - across @ np.linalg.solve(soft, rows.wrenches)
    moved = scaled[:, None] * (rows.torques @ free)
    best, weights = own, np.ones_like(own)
    for _ in range(_WEIGHTINGS):
        turned = np.swapaxes(weights[..., None] * moved, -1, -2)
        stiff = _SOFT * np.trace(turned @ moved, axis1=-2, axis2=-1) + np.finfo(float).tiny
        least = turned @ moved + stiff[:, None, None] * np.eye(12)
        pull = -np.linalg.solve(least, turned @ own[..., None])
        pulled = free @ pull
        kept = _within_friction(forces, pulled.reshape(forces.shape))[:, None] * pulled[..., 0]
        found = own + (scaled[:, None] * (rows.torques @ kept[..., None]))[..., 0]
        gains = np.abs(found).max(axis=-1) < np.abs(best).max(axis=-1)
        best = np.where(gains[:, None], found, best)
        # Joints that are asked for most come to count most.
        weights = weights * (0.1 + (found / np.abs(found).max(axis=-1, keepdims=True)) ** 2)
    return (best / scaled).reshape(torques.shape)


def _within_friction(forces: Array, pulled: Array) -> Array:
    """Return which part of a pull, 0 to 1, little friction bears beside the forces, (n,)."""
    rough = np.linspace(1.0, 0.0, 11)[:, None, None]
    total = forces + rough[..., None] * pulled
    aside = np.linalg.norm(total[..., :2], axis=-1)
    own = np.linalg.norm(forces[..., :2], axis=-1)
    # What walking itself takes of friction counts no further.
    holds = (aside <= np.maximum(own, _FRICTION * total[..., 2]) + _SOFT).all(axis=-1)
    part: Array = rough[np.argmax(holds, axis=0), 0, 0]
    return part


def _largest(robot: Robot, times: Array, torques: Array) -> TorqueDemand:
    fractions = np.abs(torques) / robot.effort
    sample, leg, joint = np.unravel_index(int(np.argmax(fractions)), fractions.shape)
    index = int(np.ravel_multi_index((leg, joint), fractions.shape[1:]))
    return TorqueDemand(
        robot.joint_names[index],
        float(abs(torques[sample, leg, joint])),
        float(robot.effort[leg, joint]),
        float(times[sample]),
    )
