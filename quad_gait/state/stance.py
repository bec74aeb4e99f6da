"""
How a robot stands: its body, its feet, and what they bear.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import angles_from_quaternion
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.foot_forces import foot_forces

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stance:
    """What is known of a robot at one instant."""

    time: float
    """Time at which it was measured [s]."""
    body: BodyPose
    """Pose of the body; x, y and yaw in the plan's frame, z from base_link, so it is 0 here."""
    feet: Array
    """Centers of the feet in the same frame, shape (4, 3) [m]."""
    joint_positions: Array
    """Positions of the joints, shape (4, 3) [rad]."""
    find_loads: Callable[[], Array | None]
    """Function that finds :attr:`loads` when they are needed: it takes longer than the rest."""

    @cached_property
    def loads(self) -> Array | None:
        """Vertical force on each foot, shape (4,) [N]; None where motors do not tell."""
        return self.find_loads()

    def place_in(self, later: Stance, leg: int) -> Array:
        """
        Return where the place lies, in a later stance, on which a foot stood in this one.

        Heights are from base_link, which is raised and lowered: they are known beside the others,
        which have stood since.

        Parameters
        ----------
        later : Stance
            The robot as it stands then.
        leg : int
            Index of the leg whose foot has been lifted since.

        Returns
        -------
        ndarray, shape (3,)
            Center of the foot where it stood, in the frame of that stance [m].
        """
        risen = np.median(np.delete(later.feet[:, 2] - self.feet[:, 2], leg))
        place: Array = self.feet[leg] + np.array([0.0, 0.0, risen])
        return place

    @classmethod
    def measured(
        cls,
        robot: Robot,
        time: float,
        pose: Pose2D,
        orientation: Array,
        joint_positions: Array,
        joint_efforts: Array | None,
    ) -> Stance:
        """
        Find the feet and their loads.

        Parameters
        ----------
        robot : Robot
            The robot.
        time : float
            [s]
        pose : Pose2D
            base_link in the plan's frame.
        orientation : ndarray, shape (4,)
            Quaternion xyzw; its heading does not count.
        joint_positions, joint_efforts : ndarray, shape (12,)
            [rad] and [N m].

        Returns
        -------
        Stance
        """
        roll, pitch, _ = angles_from_quaternion(orientation)
        body = BodyPose(np.array([pose.x, pose.y, 0.0]), roll, pitch, pose.yaw)
        joints = joint_positions.reshape(4, 3)

        def find_loads() -> Array | None:
            if joint_efforts is None or not np.any(joint_efforts):
                return None
            up = body.rotation[2]
            forces = foot_forces(robot, joints, joint_efforts.reshape(4, 3), up)
            loads: Array = np.nan_to_num(forces @ up)
            return loads

        feet = body.transform(robot.foot_positions(joints))
        return cls(time, body, feet, joints, find_loads)


class CenterOfMass:
    """
    Finds the center of mass of a robot as it stands, once for each stance.

    Parameters
    ----------
    robot : Robot
        The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._found: tuple[Stance | None, Array] = (None, np.zeros(3))

    def in_body(self, now: Stance) -> Array:
        """Return where it is in the body frame, shape (3,) [m]."""
        stance, center = self._found
        if stance is not now:
            center = self._robot.center_of_mass(now.joint_positions)
            self._found = now, center
        return center

    def over(self, now: Stance) -> Array:
        """Return where it is in the frame of the stance, shape (2,) [m]."""
        place: Array = now.body.transform(self.in_body(now))[:2]
        return place
