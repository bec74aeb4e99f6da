"""
What MuJoCo's constraints drive toward: motors turn joints, anchors hold what stands.

Both are set between the two halves of MuJoCo's step, by references of its constraints. A
constraint with the velocity v_i tends to the acceleration a_i = -B v_i + r_i; here r is added.

A motor is dry friction whose largest torque is the drive's. With r = B v it brings its joint to
the velocity v, B dt of the way in one step, as long as its torque suffices.

MuJoCo's friction of contacts is soft: a steady force lets a contact creep at a steady speed,
however small the force. So each contact has an anchor, as in Bullet. By edge e of its pyramid of
friction, whose direction is n + mu t, and the opposite one, n - mu t, the contact has crept by
s_e += dt (v_e - v_-e) / 2, and r_e = -g s_e / dt^2 takes the fraction g of that back in one step.

They are soft across the ground, too: a foot sinks in the farther the more it carries, and a body
whose load goes from foot to foot tilts. Stiffer contacts sink in less, but push a trotting body as
feet come down. So a contact stiffens while it lasts: to the acceleration k p that drives a foot out
of the depth p comes s k p, where s grows from 0 to its most. What comes down and leaves again
within a trot's stance hardly notices it.

What runs in each step is compiled: a dozen calls of NumPy would be a third of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop
from quad_common.robot.robot import Robot
from quad_sim.engines.simulator import FRICTION_FRACTION, check_commands

Array = NDArray[np.float64]

_POSITION_GAIN = 0.3
"""Fraction of a joint's position error that its motor takes back in one step, as Bullet's does."""

_ANCHOR_GAIN = 0.05
"""Fraction of a contact's creep that is taken back in one step. An anchor is a spring beside the
friction that damps it; with 0.3 it rocks a trotting body, cuhk on the spot by half a degree."""

_LONGEST_CREEP = 1.5e-3
"""Creep, times the coefficient of friction, from which on a contact slips [m]: its anchor follows,
and never pulls by more. With 0.0012 a foot that was put down on a slope of 0.15 rad creeps."""

_STIFFENING = 2.5
"""Most that a contact which lasts is stiffer by, as a fraction of what it is at first: under a load
that stays a foot sinks in by two sevenths of what it would without."""

_STIFFENING_TIME = 2.0
"""Time constant with which contacts stiffen [s], longer than the stances of trots: with 1 s cuhk,
turning on the spot by trotting, rocks by half a degree."""

_FAR = 10.0
"""Position error beyond which a motor does not pull more [rad]."""

_TOO_FAST = 10.0
"""Largest velocity that a motor drives toward, over that of the robot's data."""

_EDGES = 4
"""Number of constraints of a contact: edges of its pyramid, each followed by the opposite one."""

_GONE = -1
"""Number in place of that of a geometry that is no more."""

_PAIR = 8
"""Size of a pair of geometries in MuJoCo's list of contacts [bytes]."""

_COUNT = 12
"""Number of motors of a robot."""

CREEP, STIFFENING, IS_NEW = range(3)
"""What is known of a constraint: by which reference its creep is taken back [m/s^2], by how much it
has stiffened [1/s^2], and whether it came with this step."""


class MujocoMotors:
    """
    The motors of one robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    time_step : float
        Fixed step [s].
    """

    def __init__(self, robot: Robot, time_step: float) -> None:
        self._largest_efforts = robot.effort.reshape(-1)
        self._fastest = _TOO_FAST * np.broadcast_to(robot.velocity, (4, 3)).reshape(-1)
        self._ahead = time_step / _POSITION_GAIN
        self._ordinary = (self._ahead * float(self._fastest.min())) ** 2
        self._free: list[int] = []
        self._stuck: dict[int, float] = {}
        self._gain = 0.0
        self._rows = slice(0, _COUNT)
        self.references: Array = np.zeros(_COUNT)
        """What is added to the references of the motors' constraints in the next step."""

    def bind(self, model: Any, data: Any, angles: slice, speeds: slice, number: int = 0) -> None:
        """
        Take over a model that was compiled, or compiled again; failures stay.

        Parameters
        ----------
        model, data : MjModel, MjData
            What is simulated.
        angles, speeds : slice
            Places of the joints in ``qpos`` and ``qvel``.
        number : int
            Number of the robot among those of the model, from 0: MuJoCo's constraints that are dry
            friction come first, robot after robot, one for each joint.
        """
        if model.neq:
            raise RuntimeError("the motors are not the first of MuJoCo's constraints")
        self._model, self._data, self._speeds = model, data, speeds
        self._rows = slice(_COUNT * number, _COUNT * (number + 1))
        # It shows MuJoCo's own numbers, whatever they become.
        self._angles = data.qpos[angles]
        time_constant, _ = model.dof_solref[speeds.start]
        damping = 2.0 / (model.dof_solimp[speeds.start, 1] * time_constant)
        self._gain = damping / self._ahead
        self._set_frictions()

    def reset(self) -> None:
        """Have all joints sound."""
        self._free, self._stuck = [], {}
        self._set_frictions()

    def fail_joint(self, joint: int, kind: str) -> None:
        """Let a joint fail from now on; see :meth:`Simulator.fail_joint`."""
        if kind == 'free':
            self._free.append(joint)
            self._set_frictions()
        else:
            self._stuck[joint] = float(self._angles[joint])

    def aim(self, joint_positions: Array, joint_velocities: Array) -> None:
        """
        Drive toward positions and velocities in the next step.

        Parameters
        ----------
        joint_positions, joint_velocities : ndarray, shape (12,)
            Wanted at the end of the step [rad, rad/s].

        Raises
        ------
        ParameterError
            If one of them is not finite.
        """
        wanted, ahead = self.references, self._ahead
        joint_positions = np.ascontiguousarray(joint_positions, np.float64)
        joint_velocities = np.ascontiguousarray(joint_velocities, np.float64)
        missing = aim_motors(joint_positions, joint_velocities, self._angles, wanted, ahead)
        if not missing < self._ordinary:
            check_commands(joint_positions, joint_velocities)
            # No motor is commanded more than it could ever give: a command that is far off must
            # not make MuJoCo unstable, which would put the robot back to where it began.
            fastest = self._fastest
            np.clip(joint_positions, -_FAR, _FAR, wanted)
            wanted += ahead * np.clip(joint_velocities, -fastest, fastest)
            wanted -= self._angles
            np.clip(wanted, -ahead * fastest, ahead * fastest, wanted)
        for joint, angle in self._stuck.items():
            wanted[joint] = angle - float(self._angles[joint])
        if self._free:
            wanted[self._free] = 0.0
        wanted *= self._gain

    def efforts(self) -> Array:
        """Return the torques of the motors in the last step, shape (12,) [N m]."""
        efforts: Array = self._data.efc_force[self._rows].copy()
        if self._free:
            # What is left there is the gear's friction.
            efforts[self._free] = 0.0
        return efforts

    def _set_frictions(self) -> None:
        """Give each motor its largest torque, and free joints the friction of their gears."""
        efforts = self._largest_efforts.copy()
        efforts[self._free] *= FRICTION_FRACTION
        self._model.dof_frictionloss[self._speeds] = efforts


class MujocoDrives:
    """
    The motors of all robots in a model, and the anchors of contacts.

    Parameters
    ----------
    motors : sequence of MujocoMotors
        Motors of each robot, in the order of MuJoCo's joints.
    time_step : float
        Fixed step [s].
    """

    def __init__(self, motors: Sequence[MujocoMotors], time_step: float) -> None:
        self._robots = tuple(motors)
        self._count = _COUNT * len(self._robots)
        self._time_step = time_step
        warm_up()
        self._laws = np.array(
            [
                -_ANCHOR_GAIN / (2.0 * time_step),
                _ANCHOR_GAIN * _LONGEST_CREEP / time_step**2,
                -math.expm1(-time_step / _STIFFENING_TIME),
                0.0,
            ]
        )
        self._motors: Array = np.zeros(self._count)
        for number, robot in enumerate(self._robots):
            robot.references = self._motors[_COUNT * number : _COUNT * (number + 1)]
        self._standing: list[str] = []
        self._touching: bytes | None = None
        self._anchors: dict[tuple[bytes, int], Array] = {}
        self.let_go()

    def bind(self, model: Any, data: Any) -> None:
        """
        Take over a model that was compiled, or compiled again; anchors stay.

        Parameters
        ----------
        model, data : MjModel, MjData
            What is simulated.
        """
        self._data = data
        self._renumber(model)
        # All that stands fast is equally stiff, at any depth.
        time_constant, damping_ratio = model.geom_solref[0]
        stiffness = 1.0 / (model.geom_solimp[0, 1] * (time_constant * damping_ratio) ** 2)
        self._laws[-1] = -_STIFFENING * stiffness

    def pull(self) -> None:
        """Set the references of the step's constraints, between the halves of a step."""
        data = self._data
        touching = data.contact.geom.tobytes()
        if touching != self._touching:
            self._anchor(touching)
        if data.nefc != self._size:
            # A contact that is no pyramid of friction: nothing is anchored in this step.
            self.let_go()
            data.efc_aref[: self._count] += self._motors
            return
        pull_contacts(
            data.efc_vel, data.efc_pos, data.efc_aref, self._motors, self._contacts, self._laws
        )

    def let_go(self) -> None:
        """Forget all anchors."""
        self._anchors = {}
        self._anchor(b'')

    @property
    def creeps(self) -> dict[tuple[bytes, int], Array]:
        """
        Creep that is being taken back now.

        By the two geometries that touch, as MuJoCo has them, and the number of the point at which
        they do: times the coefficient of friction, along the two directions of friction, shape (2,)
        [m].
        """
        scale = -(self._time_step**2) / _ANCHOR_GAIN
        return {key: scale * known[CREEP, ::2] for key, known in self._anchors.items()}

    def _renumber(self, model: Any) -> None:
        """Find the anchored geometries again: those that stand fast come first, and have names."""
        before = self._standing
        self._standing = [model.geom(k).name for k in np.flatnonzero(model.geom_bodyid == 0)]
        numbers = {name: number for number, name in enumerate(self._standing)}
        shift = len(self._standing) - len(before)

        def renumbered(geom: int) -> int:
            if geom >= len(before):
                return geom + shift
            return numbers.get(before[geom], _GONE)

        kept: dict[tuple[bytes, int], Array] = {}
        for (pair, point), pulls in self._anchors.items():
            geoms = [renumbered(geom) for geom in np.frombuffer(pair, np.int32).tolist()]
            if _GONE not in geoms:
                kept[np.array(geoms, np.int32).tobytes(), point] = pulls
        self._anchors = kept
        # Whatever touches in the next step, it is looked at which of it was anchored.
        self._touching = None

    def _anchor(self, touching: bytes) -> None:
        """
        Keep the anchors of contacts that go on, and lay new ones.

        Parameters
        ----------
        touching : bytes
            Pairs of geometries that touch, as MuJoCo has them.
        """
        pairs = [touching[i : i + _PAIR] for i in range(0, len(touching), _PAIR)]
        # Two geometries may touch at several points.
        keys = [(pair, pairs[:index].count(pair)) for index, pair in enumerate(pairs)]
        before, self._anchors = self._anchors, {}
        self._contacts = np.zeros((3, _EDGES * len(keys)))
        for index, key in enumerate(keys):
            known = self._contacts[:, _EDGES * index : _EDGES * (index + 1)]
            if key in before:
                known[:] = before[key]
            else:
                known[IS_NEW] = 1.0
            self._anchors[key] = known
        self._size = self._count + self._contacts.shape[1]
        self._touching = touching


@compiled_loop
def aim_motors(
    positions: Array, velocities: Array, angles: Array, wanted: Array, ahead: float
) -> float:
    """
    Find what joints miss, as if velocities were to be reached by position errors alone.

    Parameters
    ----------
    positions, velocities : ndarray, shape (n,)
        Wanted at the end of the step [rad, rad/s].
    angles : ndarray, shape (n,)
        Where the joints are [rad].
    wanted : ndarray, shape (n,)
        Is filled [rad].
    ahead : float
        Error of a position that counts as much as one of a velocity [s].

    Returns
    -------
    float
        Sum of their squares [rad^2]; not a number if one of them is none.
    """
    total = 0.0
    for k in range(len(wanted)):
        missing = velocities[k] * ahead + positions[k] - angles[k]
        wanted[k] = missing
        total += missing * missing
    return total


@compiled_loop
def pull_contacts(
    velocities: Array,
    distances: Array,
    references: Array,
    motors: Array,
    contacts: Array,
    laws: Array,
) -> None:
    """
    Add to the references of a step's constraints: motors, then edges of contacts.

    Parameters
    ----------
    velocities, distances : ndarray, shape (n + m,)
        Of the constraints: ``efc_vel`` [rad/s, m/s], and ``efc_pos``, which is negative where
        geometries are within one another [m].
    references : ndarray, shape (n + m,)
        ``efc_aref``; is added to [rad/s^2, m/s^2].
    motors : ndarray, shape (n,)
        What is added for motors [rad/s^2].
    contacts : ndarray, shape (3, m)
        What is known of each edge of a contact, see `CREEP`; is brought up to date.
    laws : ndarray, shape (4,)
        By how much the creep's reference changes for a velocity [1/s], its most [m/s^2], the part
        of the way to the most stiffness that is gone in a step, and that [1/s^2].
    """
    count = len(motors)
    for k in range(count):
        references[k] += motors[k]
    gain, slip, part, stiffest = laws[0], laws[1], laws[2], laws[3]
    for edge in range(contacts.shape[1]):
        if contacts[IS_NEW, edge] > 0.0:
            # How a foot came down is no creep.
            contacts[IS_NEW, edge] = 0.0
        else:
            change = gain * (velocities[count + edge] - velocities[count + (edge ^ 1)])
            contacts[CREEP, edge] = min(max(contacts[CREEP, edge] + change, -slip), slip)
        contacts[STIFFENING, edge] += part * (stiffest - contacts[STIFFENING, edge])
        references[count + edge] += (
            contacts[CREEP, edge] + contacts[STIFFENING, edge] * distances[count + edge]
        )


def warm_up() -> None:
    """Have the loops compiled, or read what is kept of them, so that no step is late by that."""
    one = np.zeros(1)
    aim_motors(one, one, one, one, 0.0)
    pull_contacts(one, one, one, one, np.zeros((3, 0)), np.zeros(4))
