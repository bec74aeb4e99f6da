"""
A robot: what follows from its numbers, its kinematics and its limits.

Joint arrays have one row per leg, in the order :data:`~quad_common.robot.robot_build.LEGS`,
and one column per joint of a leg. Robots are loaded by
:func:`~quad_common.robot_files.robot_file.load_robot`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.robot import reach
from quad_common.robot.jointed_robot import JointedRobot
from quad_common.robot.leg_kinematics import Leg, stack_legs
from quad_common.robot.own_parts import LEAST_CLEARANCE, OwnParts
from quad_common.robot.robot_shape import RobotShape

Array = NDArray[np.float64]

_REACHING_OUT = 1.1
"""Footprints that the standing robot may reach to before its footprint does not stand for it."""

_HIP_HEIGHT_OF_TITAN_VIII = 0.243
"""S0 sec. 6 [m]."""


@dataclass(frozen=True)
class Robot(JointedRobot):
    """One quadruped: four legs of one kind, each with its own geometry."""

    @cached_property
    def stacked_legs(self) -> Leg:
        """The four legs as one, for arrays of shape (..., 4, 3)."""
        return stack_legs(self.legs)

    @cached_property
    def neutral_feet(self) -> Array:
        """Feet in the initial posture, body frame, shape (4, 3) [m]."""
        return self.foot_positions(self.initial_joint_angles)

    @cached_property
    def hip_height(self) -> float:
        """Height of the hips above the feet's centers in the initial posture, H0 [m]."""
        return float(self.legs[0].hip[2] - np.mean(self.neutral_feet[:, 2]))

    @cached_property
    def relative_size(self) -> float:
        """Hip height as a fraction of TITAN-VIII's, for which many lengths were chosen."""
        return self.hip_height / _HIP_HEIGHT_OF_TITAN_VIII

    @cached_property
    def standing_height(self) -> float:
        """Height of base_link above the ground in the initial posture [m]."""
        return float(self.foot_radius - np.mean(self.neutral_feet[:, 2]))

    @cached_property
    def center_height(self) -> float:
        """Height of the center of mass over the ground in the initial posture [m]."""
        center = self.center_of_mass(self.initial_joint_angles)
        return float(center[2] + self.standing_height)

    @cached_property
    def stance_reach(self) -> float:
        """Horizontal distance from hip point to foot in the initial posture, L0 [m]."""
        return float(np.linalg.norm(self.neutral_feet[0, :2] - self.legs[0].hip[:2]))

    @cached_property
    def largest_stride(self) -> float:
        """S_max of S0 [m], from the legs' geometry."""
        if self.leg_type == 'roll_pitch_pitch':
            return min(
                reach.largest_step(leg, foot, self.roughness)
                for leg, foot in zip(self.legs, self.neutral_feet)
            )
        if self.leg_type == 'serial':
            return min(
                reach.farthest_step(leg, foot, self.roughness)
                for leg, foot in zip(self.legs, self.neutral_feet)
            )
        stretch = reach.largest_stretch(self.legs[0], self.hip_height, self.roughness)
        return reach.largest_stride(stretch, self.stance_reach)

    @cached_property
    def largest_turn(self) -> float:
        """phi_max of S0 [rad], from the legs' geometry."""
        if self.leg_type != 'yaw_pitch_pitch':
            distance = max(math.hypot(x, y) for x, y, _ in self.neutral_feet)
        else:
            distance = float(self.neutral_feet[0, 1])
        return reach.largest_turn(self.largest_stride, distance)

    @cached_property
    def step_height(self) -> float:
        """Highest step that the robot climbs [m], from the legs' geometry."""
        stride = reach.STEP_FRACTION * self.largest_stride
        if self.leg_type == 'roll_pitch_pitch':
            lower = min(
                reach.lowest_at_step(leg, foot, stride)
                for leg, foot in zip(self.legs, self.neutral_feet)
            )
        elif self.leg_type == 'serial':
            lower = min(
                reach.deepest_step(leg, foot, stride)
                for leg, foot in zip(self.legs, self.neutral_feet)
            )
        else:
            stretch = math.hypot(stride, self.stance_reach)
            lower = reach.lowest_at_stretch(self.legs[0], self.hip_height, stretch)
        return reach.largest_step_height(lower, self.hip_height)

    @cached_property
    def mesh_size(self) -> float:
        """Mesh of S0 eq. 5 [m]: body length between the hip axes plus S_max."""
        return 2.0 * float(self.legs[0].hip[0]) + self.largest_stride

    @cached_property
    def footprint_radius(self) -> float:
        """Radius of the circle around base_link that holds feet and body [m]."""
        feet = float(np.max(np.linalg.norm(self.neutral_feet[:, :2], axis=1))) + self.foot_radius
        return max(feet, math.hypot(self.body_size[0], self.body_size[1]) / 2.0)

    @cached_property
    def standing_radius(self) -> float:
        """
        Radius of the circle around base_link that obstacles and other robots are kept out of [m].

        That of the footprint, which knees may leave by a tenth: the safety distance has room for
        it. Where they reach out farther, as those of an a1 do, the circle that holds them too.
        """
        ends, radii = self.shape.part_ends(self.initial_joint_angles[None])
        parts = float(np.max(np.hypot(ends[..., 0], ends[..., 1]) + radii))
        footprint = self.footprint_radius
        return parts if parts > _REACHING_OUT * footprint else footprint

    @cached_property
    def shape(self) -> RobotShape:
        """Shapes of the body and of the links."""
        radii = {kind: link.radius for kind, link in self.links.items()}
        return RobotShape(self.stacked_legs, self.body_center, self.body_size, radii)

    @cached_property
    def own_parts(self) -> OwnParts:
        """The robot's parts, which must keep clear of one another."""
        least = LEAST_CLEARANCE * self.relative_size
        return OwnParts(self.shape, self.initial_joint_angles, self.lower, self.upper, least)

    def foot_positions(self, joint_angles: Array) -> Array:
        """
        Place the four feet.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            Feet in the body frame [m].
        """
        return self.stacked_legs.forward(joint_angles)

    def foot_jacobians(self, joint_angles: Array) -> Array:
        """
        Differentiate the feet's positions by their own legs' joint angles.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray, shape (..., 4, 3, 3)
            J with foot velocity = J @ joint velocity, in the body frame [m/rad].
        """
        return self.stacked_legs.jacobian(joint_angles)

    def calf_angular_velocities(self, joint_angles: Array, joint_velocities: Array) -> Array:
        """
        Find how fast the calves turn relative to the body.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].
        joint_velocities : ndarray, shape (..., 4, 3)
            [rad/s].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            Angular velocities in the body's axes [rad/s].
        """
        return self.stacked_legs.angular_velocity(joint_angles, joint_velocities)

    def joint_angles(self, feet: Array) -> Array:
        """
        Find joint angles for the four feet, within the joints' limits.

        Parameters
        ----------
        feet : ndarray, shape (..., 4, 3)
            Feet in the body frame [m].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            [rad].

        Raises
        ------
        FootTargetUnreachable
            If a leg is too short or cannot fold that far.
        JointLimitExceeded
            If a joint would leave its range.
        """
        angles = self.stacked_legs.inverse(feet)
        self.check_joint_limits(angles)
        return angles

    def joint_velocities(self, joint_angles: Array, foot_velocities: Array) -> Array:
        """
        Find the joint speeds that give the feet their velocities.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].
        foot_velocities : ndarray, shape (..., 4, 3)
            In the body frame [m/s].

        Returns
        -------
        ndarray, shape (..., 4, 3)
            [rad/s].

        Raises
        ------
        SingularPosture
            If a leg cannot move its foot in every direction.
        """
        return self.stacked_legs.joint_velocities(joint_angles, foot_velocities)

    def center_of_mass(self, joint_angles: Array) -> Array:
        """
        Find the center of mass of body and legs.

        Where :attr:`exact_masses` are known they are taken; otherwise each link's mass sits
        halfway between its ends, the foot's at the leg's end.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].

        Returns
        -------
        ndarray, shape (..., 3)
            In the body frame [m].
        """
        return self.center_of_mass_of(joint_angles, self.stacked_legs.chain(joint_angles))

    def center_of_mass_of(self, joint_angles: Array, chain: tuple[Array, Array, Array]) -> Array:
        """
        Find the center of mass where it is known where the legs' joints are.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad].
        chain : tuple of ndarray
            Pitch axes, knees and feet in the body frame, each of shape (..., 4, 3), where these
            angles place them [m].

        Returns
        -------
        ndarray, shape (..., 3)
            As :meth:`center_of_mass` [m].
        """
        if self.exact_masses is not None:
            return self.exact_masses.center(self.stacked_legs, joint_angles, chain)
        mass = {kind: link.mass for kind, link in self.links.items()}
        pitch_axis, knee, feet = chain
        moment = 0.5 * (mass['hip'] + mass['thigh']) * pitch_axis
        moment += 0.5 * (mass['thigh'] + mass['calf']) * knee
        moment += (0.5 * mass['calf'] + mass['foot']) * feet
        fixed = self.body_mass * np.asarray(self.body_center)
        fixed += 0.5 * mass['hip'] * self.stacked_legs.hip.sum(axis=0)
        total: Array = moment.sum(axis=-2)
        return (total + fixed) / self.mass
