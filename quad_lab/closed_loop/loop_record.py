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
from quad_common.rotations import matrix_from_unit_quaternion, tilt_from_quaternion
from quad_gait.cycle.stability import stability_margin
from quad_sim.engines.simulator import Observation

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass
class Record:
    """What was seen of a walk, one entry per measurement."""

    times: list[float] = field(default_factory=list)
    """Times of the measurements [s]."""
    poses: list[Pose2D] = field(default_factory=list)
    """Poses of base_link [m, m, rad]."""
    tilts: list[float] = field(default_factory=list)
    """Angles between the body's z axis and the vertical [rad]."""
    margins: list[float] = field(default_factory=list)
    """Measured static stability margins [m]."""
    slips: list[float] = field(default_factory=list)
    """Motions of stance feet over the ground since the measurement before, summed [m]."""
    torques: list[float] = field(default_factory=list)
    """Root mean squares over the joints [N m]."""
    power: list[float] = field(default_factory=list)
    """Mechanical power of all joints, positive parts only [W]."""
    joints: list[Array] = field(default_factory=list)
    """Joint positions, each of shape (12,) [rad]."""
    has_fallen: bool = False
    feet: tuple[Array, Flags] | None = None
    """Centers of the feet in the world at the last measurement, shape (4, 3) [m], and stance."""

    @property
    def tilt_rms(self) -> float:
        """Root mean square of the tilt [rad]."""
        return float(np.sqrt(np.mean(np.square(self.tilts)))) if self.tilts else math.nan

    @property
    def heading(self) -> Array:
        """Heading, without jumps at +-pi [rad]."""
        return np.asarray(np.unwrap([pose.yaw for pose in self.poses]), dtype=np.float64)

    @property
    def positions(self) -> Array:
        """Shape (n, 2) [m]."""
        return np.array([(pose.x, pose.y) for pose in self.poses])

    def note(self, robot: Robot, seen: Observation, in_contact: Flags) -> None:
        """
        Add a measurement.

        Parameters
        ----------
        robot : Robot
            The robot.
        seen : Observation
            Its state.
        in_contact : ndarray of bool, shape (4,)
            Which feet are to be in stance.
        """
        joints = seen.joint_positions.reshape(4, 3)
        rotation = matrix_from_unit_quaternion(seen.orientation)
        feet = robot.foot_positions(joints) @ rotation.T + seen.position
        center = robot.center_of_mass(joints) @ rotation.T + seen.position
        self.times.append(seen.time)
        self.poses.append(seen.pose)
        self.tilts.append(tilt_from_quaternion(seen.orientation))
        self.margins.append(float(stability_margin(center[:2], feet[:, :2], in_contact)))
        slip = 0.0
        if self.feet is not None:
            before, was_in_contact = self.feet
            standing = in_contact & was_in_contact
            slip = float(np.linalg.norm((feet - before)[standing, :2], axis=1).sum())
        self.feet = (feet, in_contact)
        self.slips.append(slip)
        self.torques.append(float(np.sqrt(np.mean(np.square(seen.joint_efforts)))))
        power = seen.joint_efforts * seen.joint_velocities
        self.power.append(float(np.maximum(power, 0.0).sum()))
        self.joints.append(seen.joint_positions)
        self.has_fallen = self.has_fallen or seen.has_fallen
