"""
What every simulator offers: reset, step, observe, close.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import yaw_from_quaternion
from quad_sim.world.world import Obstacle

Array = NDArray[np.float64]

FAILURES = ('free', 'stuck')
"""
Kinds of failure. A ``free`` motor gives no torque, and the joint has its gear's friction alone;
a ``stuck`` joint keeps the angle it had, whatever is commanded, with its drive's largest torque.
"""

FRICTION_FRACTION = 0.01
"""Friction of a free joint by its drive's largest torque; chosen: a gear gives way."""


@dataclass(frozen=True)
class JointFailure:
    """One joint fails."""

    joint: str
    """Name of the joint."""
    kind: str
    """One of :data:`FAILURES`."""
    time: float = 0.0
    """When, in simulated time; at once if that is over [s]."""

    def __post_init__(self) -> None:
        if self.kind not in FAILURES:
            raise ParameterError('failure', self.kind, f'one of {", ".join(FAILURES)}')


GROUND, OBSTACLE, BALL = 'ground', 'obstacle', 'ball'
"""What :attr:`Contact.other` says of the world; geometries of MuJoCo have names that begin so."""


@dataclass(frozen=True)
class Ball:
    """A ball that is thrown: it does not rebound."""

    mass: float
    """[kg]"""
    radius: float
    """[m]"""
    position: Array
    """Of its center in the world, shape (3,) [m]."""
    velocity: Array
    """In the world, shape (3,) [m/s]."""


@dataclass(frozen=True)
class Contact:
    """A part of the robot touches something that it should not."""

    link: str
    """Link of the robot, for example ``lf_calf``."""
    other: str
    """``ground``, ``obstacle``, ``ball``, another link of the robot, or ``robot`` and another one's
    name."""

    def __str__(self) -> str:
        return f'{self.link} touches {self.other}'


@dataclass(frozen=True)
class Observation:
    """The robot's state at one instant. World: x and y in the map's plane, z up."""

    time: float
    """Simulated time since the simulator was made [s]."""
    position: Array
    """base_link in the world, shape (3,) [m]."""
    orientation: Array
    """base_link in the world, quaternion xyzw, shape (4,)."""
    linear_velocity_base_in_base: Array
    """Shape (3,) [m/s]."""
    angular_velocity_base_in_base: Array
    """Shape (3,) [rad/s]."""
    specific_force_in_base: Array
    """What an accelerometer measures: +g upward at rest, shape (3,) [m/s^2]; the mean of
    :class:`Accelerometer`."""
    joint_positions: Array
    """Angles in the order of ``Robot.joint_names``, shape (12,) [rad]."""
    joint_velocities: Array
    """Shape (12,) [rad/s]."""
    joint_efforts: Array
    """Torques of the motors about the joints' axes in the last step, shape (12,) [N m]."""
    contacts: tuple[Contact, ...]
    """Contacts of anything but feet with anything, and of feet with anything but the ground."""
    has_fallen: bool
    """The body lies on the ground or is tilted beyond recovery."""

    @property
    def pose(self) -> Pose2D:
        """Position and heading in the plane."""
        return Pose2D(
            float(self.position[0]), float(self.position[1]), yaw_from_quaternion(self.orientation)
        )


class Simulator(Protocol):
    """One robot in one world, stepped with a fixed time step."""

    time_step: float
    """[s]"""
    failures: tuple[str, ...]
    """Those of :data:`FAILURES` that it can let happen."""

    @property
    def time(self) -> float:
        """Simulated time since the simulator was made [s]; a reset does not turn it back."""

    def reset(self, pose: Pose2D) -> None:
        """
        Stand the robot at a pose, in its initial posture, at rest, with all joints sound.

        Parameters
        ----------
        pose : Pose2D
            Pose of base_link in the world. On uneven ground the body is as parallel to the ground
            and as near to it as no foot in the ground allows.
        """

    def fail_joint(self, joint: int, kind: str) -> None:
        """
        Let a joint fail from now on, until :meth:`reset`.

        Parameters
        ----------
        joint : int
            Its place in ``Robot.joint_names``.
        kind : str
            One of :data:`FAILURES`.
        """

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        """Advance by one time step with the joints commanded as given, shape (12,)."""

    def observe(self) -> Observation:
        """Return the robot's state."""

    def close(self) -> None:
        """Release what the simulator holds."""


@runtime_checkable
class SolidSimulator(Simulator, Protocol):
    """One that also has a world to touch, in which obstacles come and go."""

    def foot_forces(self) -> Array:
        """Return the normal forces against the feet in the order of ``LEGS``, shape (4,) [N]."""

    def push(self, force: Array) -> None:
        """
        Push against the center of mass of the robot's body from now on, until the next push.

        Parameters
        ----------
        force : ndarray, shape (3,)
            In the world's axes [N]; zeros to leave it alone.
        """

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""


@runtime_checkable
class ThrowingSimulator(SolidSimulator, Protocol):
    """One in which a ball may be thrown at the robot."""

    def throw(self, ball: Ball | None) -> None:
        """Let a ball fly from now on, in the place of the last one; None takes that away."""


@runtime_checkable
class VisibleSimulator(SolidSimulator, Protocol):
    """One whose world can be looked at."""

    def place(
        self, position: Array, orientation: Sequence[float] | Array, joint_angles: Array
    ) -> None:
        """
        Put the robot somewhere, at rest, without a look at what is there: for pictures.

        Parameters
        ----------
        position : ndarray, shape (3,)
            Of base_link in the world [m].
        orientation : array_like, shape (4,)
            Unit quaternion xyzw.
        joint_angles : ndarray, shape (12,)
            In the order of ``Robot.joint_names`` [rad].
        """

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Lay the goal's marker on the floor, or move it."""

    def prepare_pictures(self) -> None:
        """Make ready what draws pictures; SimulatorError if nothing here can."""

    def render(self, view: Array, projection: Array, width: int, height: int) -> NDArray[np.uint8]:
        """Draw a picture; see :class:`quad_sim.world.simulated_camera.Scene`."""


GRAVITY = 9.80665
"""Acceleration of free fall [m/s^2]."""


_MEAN_TIME = 0.02
"""Time over which an accelerometer takes the mean [s]."""


class Accelerometer:
    """
    An accelerometer, which measures the mean over the last 20 ms.

    Those of legged robots filter what is too fast for the rate at which they are read. Feet that
    land change a body's velocity within milliseconds: who samples that now and then misses it, or
    takes it for far more than it was.

    Parameters
    ----------
    time_step : float
        Time between two velocities [s].
    """

    def __init__(self, time_step: float) -> None:
        self._time_step = time_step
        self._before: deque[Sequence[float] | Array] = deque(
            maxlen=max(1, round(_MEAN_TIME / time_step))
        )

    def reset(self) -> None:
        """Forget: the body was put somewhere, at rest."""
        self._before.clear()

    def note(self, velocity: Sequence[float] | Array) -> None:
        """Take the body's velocity in the world before a step, shape (3,) [m/s]."""
        self._before.append(velocity)

    def specific_force(self, velocity: Array) -> Array:
        """Return what it measures after the steps, in the world's axes, shape (3,) [m/s^2]."""
        force = np.array([0.0, 0.0, GRAVITY])
        if self._before:
            force += (velocity - self._before[0]) / (len(self._before) * self._time_step)
        return force


def falls_of(robot: Robot) -> frozenset[Contact]:
    """Return the contacts of a robot that has fallen."""
    return frozenset(Contact(link, 'ground') for link in robot.part_names.falls)


_FOOT_ZONE = 2.5
"""Distance from a foot's center, in its radii: meshes of calves reach around their feet."""


def foot_zone(robot: Robot) -> float:
    """
    Return how near to its foot's center a calf stands on the ground as the foot does [m].

    The rod of a calf that is made of a data file ends in the middle of the foot's ball: where a
    hard landing presses half of the ball into the ground, the rod's end touches it too.
    """
    return (_FOOT_ZONE if robot.own_urdf else 1.0) * robot.foot_radius


def robot_contact(name: str) -> str:
    """Return what :attr:`Contact.other` is where another robot of the world is touched."""
    return f'robot {name}'


TILT_OF_A_FALL = np.deg2rad(45.0)
"""A body tilted farther than this has fallen [rad]."""


def check_commands(joint_positions: Array, joint_velocities: Array) -> None:
    """Raise ParameterError if a command, in [rad] or [rad/s], is not finite: it would stay so."""
    for name, values in (('positions', joint_positions), ('velocities', joint_velocities)):
        # Of so few numbers numpy's own takes ten times as long.
        if not all(map(math.isfinite, values.tolist())):
            raise ParameterError(f'joint_{name}', list(values), 'finite numbers')
