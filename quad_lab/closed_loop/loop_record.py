"""
What is seen of a robot that walks without topics, measurement by measurement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import matrix_from_unit_quaternion
from quad_gait.cycle.stability import stability_margin
from quad_sim.engines.simulator import Observation

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass
class Record:
    """
    What was seen of a walk, one entry per measurement.

    What follows from the measurements is worked out when somebody asks for it, all at once: most
    walks are looked at when they are over, if at all.
    """

    robot: Robot
    """The robot."""
    times: list[float] = field(default_factory=list)
    """Times of the measurements [s]."""
    poses: list[Pose2D] = field(default_factory=list)
    """Poses of base_link [m, m, rad]."""
    has_fallen: bool = False
    """Whether it fell."""
    _seen: list[Observation] = field(default_factory=list, repr=False)
    _in_contact: list[Flags] = field(default_factory=list, repr=False)
    _known: tuple[int, _Figures] | None = field(default=None, repr=False)

    def note(self, seen: Observation, in_contact: Flags) -> None:
        """
        Add a measurement.

        Parameters
        ----------
        seen : Observation
            The robot's state.
        in_contact : ndarray of bool, shape (4,)
            Which feet are to be in stance.
        """
        self.times.append(seen.time)
        self.poses.append(seen.pose)
        self.has_fallen = self.has_fallen or seen.has_fallen
        self._seen.append(seen)
        self._in_contact.append(in_contact)

    @property
    def tilts(self) -> Array:
        """Angles between the body's z axis and the vertical, shape (n,) [rad]."""
        return self._figures.tilts

    @property
    def rolls_and_pitches(self) -> Array:
        """Roll and pitch of the body, as an inclinometer has them, shape (n, 2) [rad]."""
        quaternions = np.array([seen.orientation for seen in self._seen]).reshape(-1, 4)
        x, y, z, w = quaternions.T
        roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        return np.stack([roll, np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))], axis=-1)

    @property
    def margins(self) -> Array:
        """Measured static stability margins, shape (n,) [m]."""
        return self._figures.margins

    @property
    def slips(self) -> Array:
        """Motions of stance feet since the measurement before, summed, shape (n,) [m]."""
        return self._figures.slips

    @property
    def torques(self) -> Array:
        """Root mean squares over the joints, shape (n,) [N m]."""
        efforts = np.array([seen.joint_efforts for seen in self._seen]).reshape(-1, 12)
        rms: Array = np.sqrt(np.mean(np.square(efforts), axis=1))
        return rms

    @property
    def power(self) -> Array:
        """Mechanical power of all joints, positive parts only, shape (n,) [W]."""
        powers = [seen.joint_efforts * seen.joint_velocities for seen in self._seen]
        total: Array = np.maximum(np.array(powers).reshape(-1, 12), 0.0).sum(axis=1)
        return total

    @property
    def joints(self) -> Array:
        """Joint positions, shape (n, 12) [rad]."""
        return np.array([seen.joint_positions for seen in self._seen]).reshape(-1, 12)

    @property
    def last_seen(self) -> Observation:
        """What was seen last; of a walk that has been seen."""
        return self._seen[-1]

    @property
    def last_feet(self) -> Array | None:
        """Centers of the feet in the world at the last measurement, shape (4, 3) [m]."""
        if not self._seen:
            return None
        seen = self._seen[-1]
        feet = self.robot.foot_positions(seen.joint_positions.reshape(4, 3))
        placed: Array = feet @ matrix_from_unit_quaternion(seen.orientation).T + seen.position
        return placed

    @property
    def tilt_rms(self) -> float:
        """Root mean square of the tilt [rad]."""
        return float(np.sqrt(np.mean(np.square(self.tilts)))) if self.times else math.nan

    @property
    def heading(self) -> Array:
        """Heading, without jumps at +-pi [rad]."""
        return np.asarray(np.unwrap([pose.yaw for pose in self.poses]), dtype=np.float64)

    @property
    def positions(self) -> Array:
        """Shape (n, 2) [m]."""
        return np.array([(pose.x, pose.y) for pose in self.poses])

    @property
    def _figures(self) -> _Figures:
        if self._known is None or self._known[0] != len(self._seen):
            self._known = len(self._seen), _figures(self.robot, self._seen, self._in_contact)
        return self._known[1]


@dataclass(frozen=True)
class _Figures:
    tilts: Array
    margins: Array
    slips: Array


def _figures(robot: Robot, seen: list[Observation], in_contact: list[Flags]) -> _Figures:
    """Work out what follows from n measurements."""
    joints = np.array([one.joint_positions for one in seen]).reshape(-1, 4, 3)
    quaternions = np.array([one.orientation for one in seen]).reshape(-1, 4)
    rotations = np.moveaxis(matrix_from_unit_quaternion(quaternions.T), -1, 0)
    positions = np.array([one.position for one in seen]).reshape(-1, 3)
    down = np.array(in_contact, dtype=bool).reshape(-1, 4)
    feet = np.einsum('nij,nkj->nki', rotations, robot.foot_positions(joints))
    feet += positions[:, None]
    center = np.einsum('nij,nj->ni', rotations, robot.center_of_mass(joints)) + positions
    moved = np.linalg.norm(np.diff(feet[..., :2], axis=0), axis=-1)
    stayed = down[1:] & down[:-1]
    slips = np.append(np.zeros(min(len(seen), 1)), np.where(stayed, moved, 0.0).sum(axis=1))
    x, y, _, _ = quaternions.T
    return _Figures(
        np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0)),
        stability_margin(center[:, :2], feet[..., :2], down),
        slips,
    )
