"""
One generator for every gait: a cycle of body, feet and joints from gait and motion.

Body and footholds are planned in the cycle's ground frame (S4 sec. 1), feet are
brought into the body frame, and inverse kinematics gives the joints. Everything is
vectorised over the cycle's samples.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, JointLimitExceeded, UnstableCycle
from quad_common.joint_trajectory import JointTrajectory
from quad_common.robot import JOINTS_PER_LEG, LEGS, Robot
from quad_gait.body_motion import BodyMotion, minimum_jerk, smooth_progress
from quad_gait.gait import Gait, Swing
from quad_gait.stability import stability_margin

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Cycle:
    """One planned cycle, sampled; n samples, ground frame as in ``body_motion``."""

    gait: Gait
    motion: BodyMotion
    times: Array
    """From the start of the cycle, shape (n,) [s]."""
    body: Array
    """x, y, yaw of base_link in the ground frame, sway included, shape (n, 3) [m, rad]."""
    feet: Array
    """Centres of the feet in the ground frame, shape (n, 4, 3) [m]."""
    in_contact: NDArray[np.bool_]
    """Shape (n, 4)."""
    joint_positions: Array
    """Shape (n, 4, 3) [rad]."""
    joint_velocities: Array
    """Shape (n, 4, 3) [rad/s]."""
    center_of_mass: Array
    """Projected to the ground, in the ground frame, shape (n, 2) [m]."""
    margin: Array
    """Static stability margin, shape (n,) [m]."""

    @property
    def least_margin(self) -> float:
        """Least stability margin of the cycle [m]."""
        return float(np.min(self.margin))

    def trajectory(self, robot: Robot, stamp: float) -> JointTrajectory:
        """
        Write the cycle's motion as a joint trajectory.

        Parameters
        ----------
        robot : Robot
            Whose joints.
        stamp : float
            When the cycle starts [s].

        Returns
        -------
        JointTrajectory
            From the first movement to the end of the cycle; before it the joints rest.
        """
        first = int(np.searchsorted(self.times, self.gait.motion_start + 1e-9, side='right')) - 1
        joints = len(robot.joint_names)
        return JointTrajectory(
            joint_names=robot.joint_names,
            stamp=stamp,
            times=self.times[first:],
            positions=self.joint_positions[first:].reshape(-1, joints),
            velocities=self.joint_velocities[first:].reshape(-1, joints),
        )


def generate_cycle(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    start_feet: Array | None = None,
    sample_period: float = 0.02,
    least_margin: float = -np.inf,
) -> Cycle:
    """
    Plan one cycle of a gait.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        The gait.
    motion : BodyMotion
        What the body is to do; the feet end in the initial posture under its end.
    start_feet : ndarray, shape (4, 3), optional
        Feet in the body frame at the start [m]; the initial posture if not given.
    sample_period : float
        Longest time between samples, which are evenly spaced [s].
    least_margin : float
        Refuse a cycle whose stability margin falls below this [m].

    Returns
    -------
    Cycle
        The cycle; its joints start and end at rest.

    Raises
    ------
    FootTargetUnreachable, JointLimitExceeded
        If the motion is too large for the legs or too fast for the joints.
    UnstableCycle
        If the margin falls below ``least_margin``.
    """
    steps = max(1, int(np.ceil(gait.cycle_period / sample_period - 1e-9)))
    times = np.linspace(0.0, gait.cycle_period, steps + 1)
    to_ground = np.array([0.0, 0.0, robot.standing_height])
    start = (robot.neutral_feet if start_feet is None else start_feet) + to_ground
    target = motion.end.transform(robot.neutral_feet + to_ground)

    feet, foot_velocities, in_contact = _feet(gait, times, start, target)
    body, body_velocity = _body(gait, motion, times, start, target)

    arms = feet - to_ground
    arms[..., :2] -= body[:, None, :2]
    arm_velocities = foot_velocities.copy()
    arm_velocities[..., :2] -= body_velocity[:, None, :2]
    in_body = _turn_back(arms, body[:, 2])
    velocities_in_body = _turn_back(arm_velocities, body[:, 2])
    # The body's own turning carries the feet the other way round.
    yaw_rate = body_velocity[:, 2, None]
    velocities_in_body[..., 0] += yaw_rate * in_body[..., 1]
    velocities_in_body[..., 1] -= yaw_rate * in_body[..., 0]

    positions = robot.joint_angles(in_body)
    velocities = robot.joint_velocities(positions, velocities_in_body)
    _check_joint_speeds(robot, velocities)

    center = robot.center_of_mass(positions)
    cos, sin = np.cos(body[:, 2]), np.sin(body[:, 2])
    center_of_mass = body[:, :2] + np.stack(
        [cos * center[:, 0] - sin * center[:, 1], sin * center[:, 0] + cos * center[:, 1]], axis=1
    )
    margin = stability_margin(center_of_mass, feet[..., :2], in_contact)
    cycle = Cycle(
        gait=gait,
        motion=motion,
        times=times,
        body=body,
        feet=feet,
        in_contact=in_contact,
        joint_positions=positions,
        joint_velocities=velocities,
        center_of_mass=center_of_mass,
        margin=margin,
    )
    if cycle.least_margin < least_margin:
        raise UnstableCycle(cycle.least_margin, least_margin)
    return cycle


def generate_largest_cycle(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    sample_period: float = 0.02,
    least_margin: float = -np.inf,
) -> Cycle:
    """
    Plan a cycle, shortening its motion as far as the legs and the margin require.

    Parameters
    ----------
    robot, gait, motion, sample_period, least_margin
        As for :func:`generate_cycle`.

    Returns
    -------
    Cycle
        The cycle; its :attr:`Cycle.motion` says what is left of the motion.

    Raises
    ------
    GaitError
        If not even an eighth of the motion is possible.
    """
    share = 1.0
    while True:
        scaled = BodyMotion(share * motion.forward, share * motion.left, share * motion.turn)
        try:
            return generate_cycle(
                robot, gait, scaled, sample_period=sample_period, least_margin=least_margin
            )
        except GaitError:
            share -= 0.125
            if share <= 0.0:
                raise


def _feet(
    gait: Gait, times: Array, start: Array, target: Array
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Move each foot from its start to its target while it swings."""
    feet = np.repeat(start[None], len(times), axis=0)
    velocities = np.zeros_like(feet)
    in_contact = np.ones((len(times), len(LEGS)), dtype=bool)
    for swing in gait.swings:
        leg = LEGS.index(swing.leg)
        share, rate = minimum_jerk(swing.liftoff, swing.touchdown, times)
        step = target[leg] - start[leg]
        feet[:, leg] += share[:, None] * step
        velocities[:, leg] = rate[:, None] * step
        lift, lift_rate = _lift(swing, gait.swing_height, times)
        feet[:, leg, 2] += lift
        velocities[:, leg, 2] += lift_rate
        in_contact[:, leg] = (times <= swing.liftoff) | (times >= swing.touchdown)
    return feet, velocities, in_contact


def _lift(swing: Swing, height: float, times: Array) -> tuple[Array, Array]:
    """Lift a foot and put it down again, at rest at both ends."""
    duration = swing.touchdown - swing.liftoff
    u = np.clip((times - swing.liftoff) / duration, 0.0, 1.0)
    rate = 32.0 * height * u * (1.0 - u) * (1.0 - 2.0 * u) / duration
    return 16.0 * height * u**2 * (1.0 - u) ** 2, rate


def _body(
    gait: Gait, motion: BodyMotion, times: Array, start: Array, target: Array
) -> tuple[Array, Array]:
    """Move the body along its arc, swaying towards each support triangle."""
    share, rate = smooth_progress(gait.body_progress, times)
    body = motion.pose_at(share)
    heading = body[:, 2]
    velocity = rate[:, None] * np.stack(
        [
            motion.forward * np.cos(heading) - motion.left * np.sin(heading),
            motion.forward * np.sin(heading) + motion.left * np.cos(heading),
            np.full_like(heading, motion.turn),
        ],
        axis=1,
    )
    if gait.sway_weight == 0.0:
        return body, velocity
    for offset, begin, end in _sway(gait, motion, start, target):
        moved, speed = minimum_jerk(begin, end, times)
        body[:, :2] += moved[:, None] * offset
        velocity[:, :2] += speed[:, None] * offset
    return body, velocity


def _sway(
    gait: Gait, motion: BodyMotion, start: Array, target: Array
) -> list[tuple[Array, float, float]]:
    """
    List the body's sideways moves: displacement [m], begin and end [s].

    In each interval with all feet down the body moves towards the centroid of the next
    support triangle, weighted by mu (S4 eq. 4), and back to its arc at the end.
    """
    feet = start[:, :2].copy()
    offsets = [np.zeros(2)]
    for swing in gait.swings:
        leg = LEGS.index(swing.leg)
        middle = np.array([(swing.liftoff + swing.touchdown) / 2.0])
        on_arc = motion.pose_at(smooth_progress(gait.body_progress, middle)[0])[0, :2]
        centroid = np.delete(feet, leg, axis=0).mean(axis=0)
        offsets.append(gait.sway_weight * (centroid - on_arc))
        feet[leg] = target[leg, :2]
    offsets.append(np.zeros(2))
    begins = [gait.sway_start, *(swing.touchdown for swing in gait.swings)]
    ends = [*(swing.liftoff for swing in gait.swings), gait.cycle_period]
    return [
        (after - before, begin, end)
        for before, after, begin, end in zip(offsets, offsets[1:], begins, ends)
    ]


def _turn_back(vectors: Array, yaw: Array) -> Array:
    """Bring vectors (n, 4, 3) of the ground frame into the body's axes."""
    cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x, vectors[..., 2]], axis=-1)


def _check_joint_speeds(robot: Robot, velocities: Array) -> None:
    excess = np.abs(velocities) / robot.velocity
    if np.max(excess) > 1.0:
        worst = int(np.argmax(excess))
        joint = worst % (len(LEGS) * JOINTS_PER_LEG)
        limit = float(robot.velocity[joint % JOINTS_PER_LEG])
        raise JointLimitExceeded(
            robot.joint_names[joint], float(velocities.reshape(-1)[worst]), -limit, limit, 'rad/s'
        )
