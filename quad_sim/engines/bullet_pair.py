"""
A planar pair of legs in PyBullet's physics, with some of its joints held and the others free.

What :mod:`quad_common.planar_pair.active_pair` works out, physics must find by themselves: the body
slides along x and z and turns in their plane, without friction, with two legs on it; each foot is
pinned to its place by a constraint, as on a ball joint. What is held has a motor; what is free
has none, and only the slight damping that lets it come to rest. Gravity pulls at all of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from quad_common.errors import ParameterError
from quad_common.planar_pair.planar_pair import (
    ActivePair,
    JointAngles,
    PairPosture,
    points_of,
    posture_of,
    wrap,
)
from quad_common.process.temporary_folder import temporary_folder

JOINTS = ('hip_x', 'hip_z', 'theta', 'u1_i', 'u2_i', 'u1_j', 'u2_j')
"""What may be held: hip i's place, the body's angle, the angles of the legs' joints."""

_TIME_STEP = 2.5e-4
"""Short: what pins and motors yield to gravity goes with it [s]."""

_ITERATIONS = 100

_GRAVITY = 9.80665

_FORCE = 2e3
"""The most that a motor or a pin exerts [N or N m]."""

_DAMPING = 0.2
"""Damping of every joint [N m s]."""

_RAMP = 0.5
"""Time that motors take from where they start to what they hold in the end [s]."""

_REST = 3e-4
"""Joint speed that counts as rest [rad/s and m/s]."""

_LONGEST = 2.5
"""Time after which a pair that still moves is left [s]."""


@dataclass(frozen=True)
class SettledPair:
    """Where a pair came to rest."""

    posture: PairPosture
    """As the joints of the simulation say it."""
    foot_error: float
    """Distance by which the pins gave: the larger one of a foot from its place [m]."""
    speed: float
    """Largest joint speed at the end [rad/s or m/s]."""
    time: float
    """Duration in simulated time [s]."""


def settle(
    client: Any,
    pair: ActivePair,
    start: PairPosture,
    held: Mapping[str, float],
) -> SettledPair:
    """
    Let a pair go from one posture to where it settles with three of its freedoms held.

    Parameters
    ----------
    client : BulletClient
        An empty world, as ``quad_sim.engines.bullet_simulator.headless_client`` makes it; what is
        put into it is taken away again.
    pair : ActivePair
        The pair.
    start : PairPosture
        Where it starts: one posture. The feet are pinned where they are in it.
    held : mapping of str to float
        Some of :data:`JOINTS`, and where motors bring them within half a second [m or rad]. The
        others have no motor.

    Returns
    -------
    SettledPair
        Where it came to rest.

    Raises
    ------
    ParameterError
        If something else than :data:`JOINTS` is to be held.
    """
    for name in held.keys() - set(JOINTS):
        raise ParameterError('held', name, f'one of {", ".join(JOINTS)}')
    body, number = _loaded(client, pair)
    first = _joints_in(start)
    for name, value in first.items():
        client.resetJointState(body, number[name], value)
        # Every joint has a motor at first, which holds still: none is left.
        client.setJointMotorControl2(body, number[name], client.VELOCITY_CONTROL, force=0.0)
    points = points_of(pair, start)
    _pin(client, body, (number['u1_i'], pair.leg_i.lower), complex(points.foot_i))
    _pin(client, body, (number['u1_j'], pair.leg_j.lower), complex(points.foot_j))
    displacements = {
        number[name]: (first[name], _displacement(name, first[name], float(value)))
        for name, value in held.items()
    }
    speed, steps = np.inf, 0
    while steps * _TIME_STEP < _LONGEST and (steps * _TIME_STEP < _RAMP or speed > _REST):
        steps += 1
        _drive(client, body, displacements, min(steps * _TIME_STEP / _RAMP, 1.0))
        client.stepSimulation()
        states = {name: client.getJointState(body, number[name])[:2] for name in JOINTS}
        speed = max(abs(state[1]) for state in states.values())
    hip_x, hip_z, theta, *angles = (states[name][0] for name in JOINTS)
    posture = posture_of(pair, complex(hip_x, hip_z), theta, JointAngles(*angles))
    ends = points_of(pair, posture)
    off = max(abs(ends.foot_i - points.foot_i), abs(ends.foot_j - points.foot_j))
    client.resetSimulation()
    return SettledPair(posture, float(off), float(speed), steps * _TIME_STEP)


def _joints_in(posture: PairPosture) -> dict[str, float]:
    """Return the joints' places in a posture by their names [m or rad]."""
    hip = {'hip_x': float(posture.hip_i.real), 'hip_z': float(posture.hip_i.imag)}
    return {**hip, **{name: float(getattr(posture, name)) for name in JOINTS[2:]}}


def _loaded(client: Any, pair: ActivePair) -> tuple[int, dict[str, int]]:
    """Put a pair into an empty world; return its body and the numbers of its joints."""
    client.resetSimulation()
    client.setGravity(0.0, 0.0, -_GRAVITY)
    client.setPhysicsEngineParameter(fixedTimeStep=_TIME_STEP, numSolverIterations=_ITERATIONS)
    with temporary_folder() as folder:
        path = folder / 'pair.urdf'
        path.write_text(_urdf(pair), encoding='utf-8')
        body: int = client.loadURDF(
            str(path), useFixedBase=True, flags=client.URDF_USE_INERTIA_FROM_FILE
        )
    count = client.getNumJoints(body)
    return body, {client.getJointInfo(body, k)[1].decode(): k for k in range(count)}


def _pin(client: Any, body: int, shank: tuple[int, float], foot: complex) -> None:
    """Pin the end of a shank, given by its number and its length [m], to where a foot is [m]."""
    number, length = shank
    # Places in a link count from its center of mass.
    place = (length / 2.0, 0.0, 0.0)
    world = (float(foot.real), 0.0, float(foot.imag))
    kind = client.JOINT_POINT2POINT
    pin = client.createConstraint(body, number, -1, -1, kind, (0.0, 0.0, 0.0), place, world)
    client.changeConstraint(pin, maxForce=_FORCE)


def _drive(
    client: Any, body: int, displacements: dict[int, tuple[float, float]], part: float
) -> None:
    """Have motors bring joints, by their numbers, along a part of where they are to go."""
    for number, (begin, displacement) in displacements.items():
        client.setJointMotorControl2(
            body,
            number,
            client.POSITION_CONTROL,
            targetPosition=begin + displacement * part * part * (3.0 - 2.0 * part),
            force=_FORCE,
        )


def difference(pair: ActivePair, one: PairPosture, other: PairPosture) -> tuple[float, float]:
    """
    Compare two postures.

    Returns
    -------
    tuple of float
        Largest difference of an angle [rad], and of the place of a hip, knee or foot [m].
    """
    angle = max(
        float(np.max(np.abs(wrap(np.asarray(getattr(one, name)) - getattr(other, name)))))
        for name in JOINTS[2:]
    )
    places = zip(points_of(pair, one), points_of(pair, other))
    return angle, max(float(np.max(np.abs(here - there))) for here, there in places)


def _displacement(name: str, begin: float, end: float) -> float:
    """Return the displacement, for angles the shorter one [m or rad]."""
    return end - begin if name.startswith('hip') else float(wrap(np.asarray(end - begin)))


def _urdf(pair: ActivePair) -> str:
    """
    Write the pair as a URDF, every link along its own x axis.

    Axes of rotation are -y, so that angles are counter-clockwise from x towards z.
    """
    i, j = pair.leg_i, pair.leg_j
    slider = ('prismatic', 0.0, 0.1, 0.1)
    parts = (
        # Joint, its kind, child link's center, length and mass, axis, parent and place on it.
        ('hip_x', slider, '1 0 0', 'world', 0.0),
        ('hip_z', slider, '0 0 1', 'hip_x', 0.0),
        ('theta', ('continuous', pair.span / 2.0, abs(pair.span), 4.0), '0 -1 0', 'hip_z', 0.0),
        ('u2_i', ('continuous', i.upper / 2.0, i.upper, 0.5), '0 -1 0', 'theta', 0.0),
        ('u1_i', ('continuous', i.lower / 2.0, i.lower, 0.3), '0 -1 0', 'u2_i', i.upper),
        ('u2_j', ('continuous', j.upper / 2.0, j.upper, 0.5), '0 -1 0', 'theta', pair.span),
        ('u1_j', ('continuous', j.lower / 2.0, j.lower, 0.3), '0 -1 0', 'u2_j', j.upper),
    )
    text = ['<robot name="pair"><link name="world"/>']
    for name, (kind, center, length, mass), axis, parent, place in parts:
        # A rod's inertia, of a thickness that keeps the matrix regular.
        inertia = mass * length * length / 12.0 + 1e-4 * mass
        limit = '<limit lower="-100" upper="100" effort="1e6" velocity="1e3"/>'
        text.append(
            f'<link name="{name}"><inertial><origin xyz="{center} 0 0"/><mass value="{mass}"/>'
            f'<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/>'
            f'</inertial></link><joint name="{name}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="{name}"/><origin xyz="{place} 0 0"/><axis xyz="{axis}"/>{limit}'
            f'<dynamics damping="{_DAMPING}" friction="0"/></joint>'
        )
    return ''.join([*text, '</robot>'])
