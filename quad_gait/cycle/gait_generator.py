"""
One generator for every gait: a cycle of body, feet and joints from gait and motion.

Body and footholds are planned in the cycle's ground frame (S4 sec. 1), feet are
brought into the body frame, and inverse kinematics gives the joints. Everything is
vectorised over the cycle's samples.

Cycles join: all feet are down at both ends, the body is on its course without sway, and
a cycle begins with the feet and the speed that the last one ended with.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, JointLimitExceeded, UnstableCycle
from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_common.robot.robot import LEGS, Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.body_motion import BodyMotion, smooth_progress
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.part_check import check_own_parts
from quad_gait.cycle.schedule import (
    Schedule,
    legs_in_order,
    mid_swing_progress,
    schedule_of,
    schedule_of_orders,
    setback,
)
from quad_gait.cycle.stability import stability_margin

Array = NDArray[np.float64]

_ROLLING_SAMPLES = 50
"""Of a cycle, at which the rolling of the feet is computed."""

_ROLLING_PASSES = 2
"""Rolling changes how the calves turn, and that changes the rolling, a tenth as much."""

_OTHERS = np.array([[k for k in range(4) if k != leg] for leg in range(4)])
"""The three other legs, of each."""

FootTracking = Callable[[Robot, Array, Array, Array], tuple[Array, Array]]
"""Robot, times (n,), feet and their velocities in the body frame (n, 4, 3), to joint
positions and velocities (n, 4, 3)."""


@dataclass(frozen=True)
class Cycle:
    """One planned cycle, sampled; n samples, ground frame as in ``body_motion``."""

    gait: Gait
    motion: BodyMotion
    entry: Twist2D
    """Velocity of the body at the start, on average over a cycle at that pace."""
    exit: Twist2D
    """Velocity of the body at the end, on average over a cycle at that pace."""
    times: Array
    """From the start of the cycle, shape (n,) [s]."""
    body: Array
    """x, y, yaw of base_link in the ground frame, sway included, shape (n, 3) [m, rad]."""
    feet: Array
    """Centers of the feet in the ground frame, shape (n, 4, 3) [m]."""
    in_contact: NDArray[np.bool_]
    """Shape (n, 4)."""
    joint_positions: Array
    """Shape (n, 4, 3) [rad]."""
    joint_velocities: Array
    """Shape (n, 4, 3) [rad/s]."""
    end_feet: Array
    """Centers of the feet in the body frame at the end, shape (4, 3) [m]."""
    center_of_mass: Array
    """Projected to the ground, in the ground frame, shape (n, 2) [m]."""
    margin: Array
    """Static stability margin, shape (n,) [m]."""
    limit: str = ''
    """What forbade more of the motion that was wanted; empty if nothing did."""

    @property
    def least_margin(self) -> float:
        """Least stability margin of the cycle [m]."""
        return float(np.min(self.margin))

    @property
    def period(self) -> float:
        """How long the cycle takes [s]."""
        return self.gait.cycle_period

    def sample(self, time: float) -> int:
        """Return the index of the sample nearest to a time from the cycle's start [s]."""
        return min(max(round(time / float(self.times[1])), 0), len(self.times) - 1)

    def pose_at(self, time: float) -> Pose2D:
        """Return where the body is planned to be, sway included, in the ground frame."""
        x, y, yaw = (float(np.interp(time, self.times, self.body[:, k])) for k in range(3))
        return Pose2D(x, y, yaw)

    @property
    def is_at_rest_first(self) -> bool:
        """Whether no joint moves before the gait's ``motion_start``."""
        return not self.entry

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
        start = self.gait.motion_start if self.is_at_rest_first else 0.0
        first = int(np.searchsorted(self.times, start + 1e-9, side='right')) - 1
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
    entry: Twist2D = STILL,
    exit: Twist2D = STILL,
    sample_period: float = 0.02,
    least_margin: float = -np.inf,
    track: FootTracking | None = None,
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
        Where the body is to be at the end, and along which arc it goes there.
    start_feet : ndarray, shape (4, 3), optional
        Feet in the body frame at the start [m]; the initial posture if not given.
    entry, exit : Twist2D
        Velocity of the body at the start and at the end. A body that ends at rest has
        its feet in the initial posture.
    sample_period : float
        Longest time between samples, which are evenly spaced [s].
    least_margin : float
        Refuse a cycle whose stability margin falls below this [m].
    track : callable, optional
        How foot paths become joint motion; closed-form inverse kinematics if not given.

    Returns
    -------
    Cycle
        The cycle.

    Raises
    ------
    FootTargetUnreachable, JointLimitExceeded
        If the motion is too large for the legs or too fast for the joints.
    PartsTooNear
        If parts of the robot would come too near to one another, or to the ground.
    UnstableCycle
        If the margin falls below ``least_margin``.
    """
    schedule = schedule_of(gait, sample_period)
    to_ground = np.array([0.0, 0.0, robot.standing_height])
    start = (robot.neutral_feet if start_feet is None else start_feet) + to_ground
    target = _footholds(robot, gait, motion, entry, exit) + to_ground

    legs = legs_in_order(gait)
    body, body_velocity = _body(gait, legs, schedule, motion, entry, exit, start, target)
    rolling = _rolling(robot, schedule, start, target, body, body_velocity)
    in_body, velocities_in_body, feet = _feet_in_body(
        schedule, robot.standing_height, start, target, body, body_velocity, rolling
    )
    if track is None:
        positions = robot.joint_angles(in_body)
        velocities = robot.joint_velocities(positions, velocities_in_body)
    else:
        positions, velocities = track(robot, schedule.times, in_body, velocities_in_body)
        robot.check_joint_limits(positions)
    _check_joint_speeds(robot, velocities)
    chain = robot.stacked_legs.chain(positions)
    check_own_parts(robot, schedule.times, schedule.body_lift, positions, chain)

    center_of_mass = _center_of_mass(robot, chain, body)
    margin = stability_margin(center_of_mass, feet[..., :2], schedule.in_contact)
    cycle = Cycle(
        gait=gait,
        motion=motion,
        entry=entry,
        exit=exit,
        times=schedule.times,
        body=body,
        feet=feet,
        in_contact=schedule.in_contact,
        joint_positions=positions,
        joint_velocities=velocities,
        end_feet=in_body[-1],
        center_of_mass=center_of_mass,
        margin=margin,
    )
    if cycle.least_margin < least_margin:
        raise UnstableCycle(cycle.least_margin, least_margin)
    return cycle


def generate_steady_cycle(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    sample_period: float = 0.02,
    least_margin: float = -np.inf,
) -> Cycle:
    """
    Plan a cycle in the midst of many equal ones.

    Parameters
    ----------
    robot, gait, motion, sample_period, least_margin
        As for :func:`generate_cycle`.

    Returns
    -------
    Cycle
        With the feet and the speed at its start that it also ends with. For S4's wave
        gait its start is the proper initial posture.
    """
    speed = motion.rate(gait.cycle_period) if gait.is_steady else STILL
    return generate_cycle(
        robot,
        gait,
        motion,
        start_feet=steady_feet(robot, gait, motion),
        entry=speed,
        exit=speed,
        sample_period=sample_period,
        least_margin=least_margin,
    )


def steady_feet(robot: Robot, gait: Gait, motion: BodyMotion) -> Array:
    """
    Place the feet at the start of one of many equal cycles (S4 eq. 5).

    Parameters
    ----------
    robot, gait, motion
        As for :func:`generate_cycle`.

    Returns
    -------
    ndarray, shape (4, 3)
        In the body frame [m].
    """
    speed = motion.rate(gait.cycle_period) if gait.is_steady else STILL
    return motion.end.inverse().transform(_footholds(robot, gait, motion, speed, speed))


def margins_of_orders(
    robot: Robot, orders: Sequence[Gait], motion: BodyMotion, sample_period: float
) -> Array:
    """
    Find the least margins of steady cycles that differ in the order of their legs only.

    All at once, as arrays with an axis for the orders: 24 of them take little longer than two
    of :func:`generate_steady_cycle`.

    Parameters
    ----------
    robot : Robot
        The robot.
    orders : sequence of Gait
        A gait with its legs exchanged.
    motion : BodyMotion
        Of the body in a cycle.
    sample_period : float
        Longest time between samples [s].

    Returns
    -------
    ndarray, shape (len(orders),)
        Stability margins [m]; minus infinity where a joint would leave its range. Neither
        joints' speeds nor parts too near to one another are looked at.

    Raises
    ------
    FootTargetUnreachable, SingularPosture
        If one of the orders is too much for the legs.
    """
    gait = orders[0]
    schedule = schedule_of_orders(tuple(orders), sample_period)
    legs = np.stack([legs_in_order(order) for order in orders])
    speed = motion.rate(gait.cycle_period) if gait.is_steady else STILL
    stances = _stances(gait, motion, speed, speed)
    if stances is None:
        footholds = motion.end.transform(robot.neutral_feet)
        footholds = np.broadcast_to(footholds, (len(orders), *footholds.shape))
    else:
        # By turn and leg; each order picks which leg has which turn.
        by_turn = np.stack([stance.transform(robot.neutral_feet) for stance in stances])
        footholds = by_turn[np.argsort(legs, axis=1), np.arange(len(LEGS))]
    to_ground = np.array([0.0, 0.0, robot.standing_height])
    start, target = motion.end.inverse().transform(footholds) + to_ground, footholds + to_ground
    body, body_velocity = _body(gait, legs, schedule, motion, speed, speed, start, target)
    rolling = _rolling(robot, schedule, start, target, body, body_velocity)
    in_body, _, feet = _feet_in_body(
        schedule, robot.standing_height, start, target, body, body_velocity, rolling
    )
    positions = robot.stacked_legs.inverse(in_body)
    center_of_mass = _center_of_mass(robot, robot.stacked_legs.chain(positions), body)
    margin = stability_margin(center_of_mass, feet[..., :2], schedule.in_contact)
    result: Array = np.where(robot.within_joint_limits(positions), margin, -np.inf).min(axis=1)
    return result


def generate_largest_cycle(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    start_feet: Array | None = None,
    entry: Twist2D = STILL,
    exit: Twist2D = STILL,
    sample_period: float = 0.02,
    least_margin: float = -np.inf,
    track: FootTracking | None = None,
    accept: Callable[[Cycle], None] = lambda _: None,
) -> Cycle:
    """
    Plan a cycle, shortening its motion as far as the legs and the margin require.

    Parameters
    ----------
    robot, gait, motion, start_feet, entry, exit, sample_period, least_margin, track
        As for :func:`generate_cycle`.
    accept : callable, optional
        Raises a GaitError for a cycle that will not do after all.

    Returns
    -------
    Cycle
        The cycle; its :attr:`Cycle.motion` says what is left of the motion, and its
        :attr:`Cycle.limit` why.

    Raises
    ------
    GaitError
        If the robot cannot even come to rest, or, from rest, not even an eighth of the
        motion is possible.
    """
    rest = BodyMotion.during(entry, (1.0 - gait.acceleration_fraction) * gait.cycle_period)
    share, limit = 1.0, ''
    while True:
        scaled = BodyMotion(
            share * motion.forward + (1.0 - share) * rest.forward,
            share * motion.left + (1.0 - share) * rest.left,
            share * motion.turn + (1.0 - share) * rest.turn,
        )
        try:
            cycle = generate_cycle(
                robot,
                gait,
                scaled,
                start_feet=start_feet,
                entry=entry,
                exit=exit.scaled(share),
                sample_period=sample_period,
                least_margin=least_margin,
                track=track,
            )
            accept(cycle)
            return replace(cycle, limit=limit)
        except GaitError as error:
            limit = limit or str(error)
            share -= 0.125
            if share < 0.0 or (share == 0.0 and not entry):
                raise


def _footholds(
    robot: Robot, gait: Gait, motion: BodyMotion, entry: Twist2D, exit: Twist2D
) -> Array:
    """
    Choose where the feet are to stand next, ground frame at hip level, (4, 3) [m].

    In mid-stance a foot is where it is in the initial posture: so every foot uses its
    working range evenly, whatever the motion (S4 eq. 5 for straight walking). A pendulum
    that is to gain speed stands farther back.
    """
    stances = _stances(gait, motion, entry, exit)
    if stances is None:
        return motion.end.transform(robot.neutral_feet)
    footholds = np.empty((len(LEGS), 3))
    for leg, stance in zip(legs_in_order(gait), stances):
        footholds[leg] = stance.transform(robot.neutral_feet[leg])
    return footholds


def _stances(gait: Gait, motion: BodyMotion, entry: Twist2D, exit: Twist2D) -> list[Pose2D] | None:
    """
    Say where the body is in mid-stance of each foot's next stand, in the order of swings.

    None if all feet are to stand under the body's end pose.
    """
    if gait.footholds == 'initial_posture' or not exit:
        return None
    period = gait.cycle_period
    onward = BodyMotion.during(exit, period)
    gain = exit.minus(entry)
    gathered = BodyMotion.during(gain, gait.acceleration_fraction * period)
    before = motion.minus(gathered) if gait.pendulum_rate > 0.0 else motion
    set_back = BodyMotion.during(gain, -setback(gait)).end
    stances = []
    for swing in gait.swings:
        middle = (swing.touchdown + period + swing.liftoff) / 2.0
        if middle <= period:
            share = middle / period
            if gait.body_progress is not None:
                share = float(smooth_progress(gait.body_progress, np.array([middle]))[0][0])
            body = _pose(before, share) @ set_back
        else:
            body = motion.end @ _pose(onward, middle / period - 1.0)
        stances.append(body)
    return stances


def _pose(motion: BodyMotion, share: float) -> Pose2D:
    x, y, yaw = motion.pose_at(np.array(share))
    return Pose2D(float(x), float(y), float(yaw))


@dataclass(frozen=True)
class _Rolling:
    """How the balls of the standing feet roll over the ground."""

    displacement: Array
    """Of their centers since the start of the cycle, shape (..., n, 4, 2) [m]."""
    velocity: Array
    """Shape (..., n, 4, 2) [m/s]."""


def _rolling(
    robot: Robot,
    schedule: Schedule,
    start: Array,
    target: Array,
    body: Array,
    body_velocity: Array,
) -> _Rolling | None:
    """
    Find how far the feet roll, from how their calves turn.

    The center of a ball of radius r that rolls with the angular velocity omega moves
    with r (omega_y, -omega_x). Without it robots with legs that are short for their feet
    go up to a tenth too far.
    """
    radius = robot.foot_radius
    if radius <= 0.0:
        return None
    stride = max(1, (len(schedule.times) - 1) // _ROLLING_SAMPLES)
    coarse = schedule.thinned(stride)
    poses, velocities = body[..., ::stride, :], body_velocity[..., ::stride, :]
    rolling = None
    for _ in range(_ROLLING_PASSES):
        arms, arm_velocities, _ = _feet_in_body(
            coarse, robot.standing_height, start, target, poses, velocities, rolling
        )
        joints = robot.stacked_legs.inverse(arms)
        joint_velocities = robot.joint_velocities(joints, arm_velocities)
        spin = robot.calf_angular_velocities(joints, joint_velocities)
        cos, sin = np.cos(poses[..., 2])[..., None], np.sin(poses[..., 2])[..., None]
        x, y = spin[..., 0], spin[..., 1]
        speed = radius * np.stack([sin * x + cos * y, sin * y - cos * x], axis=-1)
        rolling = _rolled(coarse, speed)
    return _rolled(schedule, _interpolated(schedule.times, coarse.times, speed))


def _rolled(schedule: Schedule, speed: Array) -> _Rolling:
    """Add up the rolling of the feet on the ground."""
    velocity = np.where(schedule.in_contact[..., None], speed, 0.0)
    displacement = np.zeros_like(velocity)
    step = schedule.times[1]
    both = velocity[..., 1:, :, :] + velocity[..., :-1, :, :]
    np.cumsum(both * (step / 2.0), axis=-3, out=displacement[..., 1:, :, :])
    return _Rolling(displacement, velocity)


def _interpolated(times: Array, known_times: Array, values: Array) -> Array:
    """Interpolate samples (..., n, 4, 2) linearly, between evenly spaced times."""
    place = times / known_times[1]
    index = np.minimum(place.astype(int), len(known_times) - 2)
    share = (place - index)[:, None, None]
    before, after = values[..., index, :, :], values[..., index + 1, :, :]
    result: Array = before * (1.0 - share) + after * share
    return result


def _feet_in_body(
    schedule: Schedule,
    standing_height: float,
    start: Array,
    target: Array,
    body: Array,
    body_velocity: Array,
    rolling: _Rolling | None,
) -> tuple[Array, Array, Array]:
    """
    Move each foot from its start to its target while it swings.

    Returns the feet in the body frame, their velocities there, and the feet in the ground
    frame, each of shape (..., n, 4, 3), for starts and targets of shape (..., 4, 3).
    """
    step = target - start
    feet = np.empty((*step.shape[:-2], len(schedule.times), len(LEGS), 3))
    feet[:] = start[..., None, :, :]
    velocities = np.zeros_like(feet)
    if rolling is not None:
        feet[..., :2] += rolling.displacement
        velocities[..., :2] += rolling.velocity
        step = step.copy()
        step[..., :2] -= rolling.displacement[..., -1, :, :]
    step = step[..., None, :, :]
    feet += schedule.step[..., None] * step
    velocities += schedule.step_rate[..., None] * step
    feet[..., 2] += schedule.lift
    velocities[..., 2] += schedule.lift_rate
    return *_in_body(schedule, standing_height, feet, velocities, body, body_velocity), feet


def _body(
    gait: Gait,
    legs: NDArray[np.intp],
    schedule: Schedule,
    motion: BodyMotion,
    entry: Twist2D,
    exit: Twist2D,
    start: Array,
    target: Array,
) -> tuple[Array, Array]:
    """Move the body along its arc, at its speeds at both ends, swaying on the way."""
    body = motion.pose_at(schedule.progress)
    heading = body[:, 2]
    cos, sin = np.cos(heading), np.sin(heading)
    velocity = schedule.progress_rate[:, None] * np.stack(
        [
            motion.forward * cos - motion.left * sin,
            motion.forward * sin + motion.left * cos,
            np.full_like(heading, motion.turn),
        ],
        axis=1,
    )
    # At its ends a cycle is as much faster than on average as its progress is there.
    pace = schedule.progress_rate[0] * gait.cycle_period if gait.is_steady else 1.0
    before = pace * _velocity(entry, 0.0) - velocity[0]
    after = pace * _velocity(exit, motion.turn) - velocity[-1]
    for curve, rate, change in (
        (schedule.entry, schedule.entry_rate, before),
        (schedule.exit, schedule.exit_rate, after),
    ):
        if np.any(change):
            body += curve[:, None] * change
            velocity += rate[:, None] * change
    if gait.sways:
        moves = _sway(gait, legs, motion, start, target)
        shape = (*moves.shape[:-2], *body.shape)
        body, velocity = (np.broadcast_to(a, shape).copy() for a in (body, velocity))
        body[..., :2] += schedule.sway @ moves
        velocity[..., :2] += schedule.sway_rate @ moves
    return body, velocity


def _velocity(twist: Twist2D, heading: float) -> Array:
    """Write a velocity in the ground frame, shape (3,)."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.array(
        [
            twist.forward * cos - twist.left * sin,
            twist.forward * sin + twist.left * cos,
            twist.turn,
        ]
    )


def _sway(
    gait: Gait, legs: NDArray[np.intp], motion: BodyMotion, start: Array, target: Array
) -> Array:
    """
    List the body's sideways moves, ground frame, shape (..., 5, 2) [m].

    In each interval with all feet down the body moves towards the centroid of the next
    support triangle, weighted by mu (S4 eq. 4), and back to its arc at the end. The legs
    are those that swing, one after the other, shape (..., 4).
    """
    shape = (*legs.shape, 2)
    feet = np.broadcast_to(start[..., :2], shape).copy()
    target = np.broadcast_to(target[..., :2], shape)
    course = np.zeros((*legs.shape[:-1], 6, 2))
    on_arc = motion.pose_at(mid_swing_progress(gait))
    forward, left = gait.sway_weight
    for k, body in enumerate(on_arc):
        leg = legs[..., k, None]
        triangle = np.take_along_axis(feet, _OTHERS[legs[..., k]][..., None], axis=-2)
        off = triangle.mean(axis=-2) - body[:2]
        cos, sin = np.cos(body[2]), np.sin(body[2])
        ahead = forward * (cos * off[..., 0] + sin * off[..., 1])
        aside = left * (cos * off[..., 1] - sin * off[..., 0])
        course[..., k + 1, 0] = cos * ahead - sin * aside
        course[..., k + 1, 1] = sin * ahead + cos * aside
        swung = np.take_along_axis(target, leg[..., None], axis=-2)
        np.put_along_axis(feet, leg[..., None], swung, axis=-2)
    return np.diff(course, axis=-2)


def _in_body(
    schedule: Schedule,
    standing_height: float,
    feet: Array,
    foot_velocities: Array,
    body: Array,
    body_velocity: Array,
) -> tuple[Array, Array]:
    """Bring feet (..., n, 4, 3) and their velocities from the ground frame into the body's."""
    cos, sin = np.cos(body[..., 2, None]), np.sin(body[..., 2, None])
    yaw_rate = body_velocity[..., 2, None]
    x, y = feet[..., 0] - body[..., 0, None], feet[..., 1] - body[..., 1, None]
    arms = np.empty_like(feet)
    arms[..., 0] = cos * x + sin * y
    arms[..., 1] = cos * y - sin * x
    arms[..., 2] = feet[..., 2] - (standing_height + schedule.body_lift[:, None])
    x = foot_velocities[..., 0] - body_velocity[..., 0, None]
    y = foot_velocities[..., 1] - body_velocity[..., 1, None]
    velocities = np.empty_like(feet)
    # The body's own turning carries the feet the other way round.
    velocities[..., 0] = cos * x + sin * y + yaw_rate * arms[..., 1]
    velocities[..., 1] = cos * y - sin * x - yaw_rate * arms[..., 0]
    velocities[..., 2] = foot_velocities[..., 2] - schedule.body_lift_rate[:, None]
    return arms, velocities


def _center_of_mass(robot: Robot, chain: tuple[Array, Array, Array], body: Array) -> Array:
    """Project the center of mass to the ground, ground frame, shape (..., n, 2) [m]."""
    center = robot.center_of_mass_of(chain)
    cos, sin = np.cos(body[..., 2]), np.sin(body[..., 2])
    x, y = center[..., 0], center[..., 1]
    result: Array = body[..., :2] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    return result


def _check_joint_speeds(robot: Robot, velocities: Array) -> None:
    excess = np.abs(velocities) / robot.velocity
    if np.max(excess) > 1.0:
        worst = int(np.argmax(excess))
        joint = worst % len(robot.joint_names)
        limit = float(np.broadcast_to(robot.velocity, velocities.shape[1:]).reshape(-1)[joint])
        raise JointLimitExceeded(
            robot.joint_names[joint], float(velocities.reshape(-1)[worst]), -limit, limit, 'rad/s'
        )
