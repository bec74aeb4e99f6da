"""
Plans motions of body and feet over ground that is not flat, from where the feet stand.

Nothing is remembered here: what has been met, and what comes next, `uneven_stride` knows.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import product
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, JointLimitExceeded
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.cycle.part_check import check_nearing_parts
from quad_gait.state.body_placement import BodyPose, balanced, body_over, heading_over, rotation_of
from quad_gait.state.stance import Stance
from quad_gait.uneven.ground_model import FootholdChoice, GroundModel
from quad_gait.uneven.joint_motion import JointMotion

Array = NDArray[np.float64]
Planned = TypeVar('Planned')

_LIFT_AT = 0.85
"""A foot is lifted after this share of the time in which the body goes over the others."""

_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Of a step, of which the legs may reach one only."""

_TILTS = (0.0, 0.5, 1.0)
"""Shares of the ground's tilt that the body may take."""

_LOWER = (0.0, 0.03, 0.06)
"""How much lower than in its initial posture the body may be [m]."""

_STRETCHED = 0.4
"""Share of its speed at which a leg comes back from where there was no ground: it is stretched
then, and its knee would be too fast."""

BIT = 3
"""So many samples of a search are given out at a time: a foot presses on for no longer."""

_STANCE = (0.5, 0.0, -0.5, -1.0)
"""Where a foot stands beside its place under the body, in strides, until it is lifted."""

_ON_SHIN = np.linspace(0.0, 0.7, 8)
"""Points between foot and knee, higher than which no step is."""

_WAYS = sorted(
    product(_SHARES, _TILTS, _LOWER),
    # A lower body costs little, a shorter step more, and a tilt most.
    key=lambda way: (1.0 - way[0]) + 0.75 * way[1] + 3.0 * way[2],
)
"""How a swing may be done, in the order in which it is tried."""

_POSTURES = tuple(product(_TILTS, _LOWER))
"""Of tilt and lowering, in the order in which they are tried."""


@dataclass(frozen=True)
class UnevenOptions:
    """How a robot walks where the ground is not flat; lengths are TITAN-VIII's."""

    sample_period: float = 0.02
    """Between a trajectory's points [s]."""
    reaction_time: float = 0.06
    """A trajectory that answers to a contact begins so long after it [s]: it must have come
    to the joints by then, and the foot presses on meanwhile."""
    margin: float = 0.035
    """How far inside its three feet the center of mass is kept, if they give so much [m]."""
    contact_share: float = 0.05
    """A foot that bears more than this share of the weight stands."""
    clearance: float = 0.03
    """Over what a height map shows in the way of a foot [m]."""
    search_speed: float = 0.12
    """At which a foot is lowered where the ground may be [m/s]."""
    search_above: float = 0.01
    """The search begins so far above the ground that a height map shows [m]."""
    shift_time: float = 0.4
    """For the body to go over three feet [s]."""
    shift_speed: float = 0.2
    """Farther moves take longer [m/s], on average."""
    lift_time: float = 0.2
    """[s]"""
    transfer_time: float = 0.35
    """[s]"""
    lower_time: float = 0.2
    """[s]"""
    foot_speed: float = 0.65
    """Longer ways of a foot take longer than these times [m/s], on average."""
    foothold_reach: float = 0.08
    """How far a foot may be put beside its place, for a better hold [m]."""
    foothold_radius: float = 0.045
    """Around a foot the ground should be even [m]."""
    shin_clearance: float = 0.01
    """Around foot and shin what is higher than they are is kept so far away [m]."""
    largest_step: float = 0.025
    """Heights around a foot differ by at most so much on even ground [m]."""


@dataclass(frozen=True)
class PlannedSwing:
    """A motion in which one foot swings, or feels for the ground."""

    motion: JointMotion
    """Of all joints."""
    lifted_at: int
    """Sample from which on the foot is in the air."""
    feels_from: int
    """Sample from which on it may meet the ground."""
    depth: float
    """How far below the ground where it should be the foot feels for it [m]."""
    limit: str = ''
    """Why it is shorter than wanted; empty if it is not."""


class SwingPlanner:
    """
    Plans swings, searches and shifts of the body.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    swing_height : float
        Of the gait on even ground [m].
    """

    def __init__(self, robot: Robot, options: UnevenOptions, swing_height: float) -> None:
        self._robot = robot
        self._options = options
        self._swing_height = swing_height
        self._scale = robot.relative_size

    def swing(
        self, now: Stance, commanded: Array | None, ground: GroundModel, leg: int, place: Array
    ) -> PlannedSwing:
        """
        Plan a swing, shorter or with the body at a tilt if the legs do not reach.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        commanded : ndarray, shape (4, 3), or None
            Where the joints are commanded to be [rad]; None: where they are.
        ground : GroundModel
            What is known of the ground.
        leg : int
            Which one swings.
        place : ndarray, shape (2,)
            Where its foot should stand then [m].

        Returns
        -------
        PlannedSwing
            The first that legs and joints can do, of many ways.

        Raises
        ------
        GaitError
            If they can do none.
        """
        start = now.feet[leg]
        shin = self._shin(leg, place - start[:2], now.body.yaw)

        def plan(share: float, tilt: float, lower: float) -> tuple[float, PlannedSwing]:
            target = self._target(ground, start, place, share, shin)
            return share, self._swing_to(now, commanded, ground, leg, target, 1.0, tilt, lower)

        (share, swing), problem = _first_possible(plan, _WAYS)
        return swing if share == 1.0 else replace(swing, limit=f'a step was shortened: {problem}')

    def swing_back(
        self, now: Stance, commanded: Array | None, ground: GroundModel, leg: int, target: Array
    ) -> PlannedSwing:
        """Plan the way back to where a foot stood, its center, shape (3,) [m]; as `swing`."""

        def plan(tilt: float, lower: float) -> PlannedSwing:
            return self._swing_to(now, commanded, ground, leg, target, _STRETCHED, tilt, lower)

        return _first_possible(plan, _POSTURES)[0]

    def search(self, now: Stance, commanded: Array | None, legs: list[int]) -> JointMotion:
        """Plan how feet that bear nothing are lowered, a little more than the ground is rough."""
        depth = 1.5 * self._robot.roughness
        speed = self._scale * self._options.search_speed
        times = self._times(depth / speed + _ramp(depth))
        feet = np.repeat(now.feet[None], len(times), axis=0)
        feet[:, legs, 2] -= _searched(times, speed, depth)[:, None]
        still = np.zeros(len(times))
        return self._planned(now, commanded, times, now.body, still, feet, sure=2, given=BIT)

    def search_deeper(
        self, now: Stance, commanded: Array | None, leg: int, depth: float
    ) -> PlannedSwing:
        """Plan how the body is lowered, so that a foot gets farther down."""
        speed = self._scale * self._options.search_speed
        target = _lowered(now.body, self._scale * _LOWER[-1])
        shift = self._shift_duration(now.body, target)
        times = self._times(shift + depth / speed + _ramp(depth))
        path = np.repeat(now.feet[None], len(times), axis=0)
        path[:, leg, 2] -= _searched(times - shift, speed, depth)
        share = minimum_jerk(0.0, shift, times)[0]
        sure = int(np.searchsorted(times, shift))
        motion = self._planned(now, commanded, times, target, share, path, sure + 1, sure)
        return PlannedSwing(motion, lifted_at=0, feels_from=0, depth=depth)

    def shift(self, now: Stance, commanded: Array | None, ground: GroundModel) -> JointMotion:
        """Plan how the body gets over its four feet; raise GaitError if no posture will do."""
        yaw = heading_over(self._robot, now.feet)

        def plan(tilt: float, lower: float) -> JointMotion:
            target = body_over(self._robot, now.feet, yaw, ground.slope, tilt)
            target = _lowered(target, self._scale * lower)
            duration = self._shift_duration(now.body, target)
            times = self._times(duration)
            share = minimum_jerk(0.0, duration, times)[0]
            feet = np.repeat(now.feet[None], len(times), axis=0)
            return self._planned(now, commanded, times, target, share, feet)

        return _first_possible(plan, _POSTURES)[0]

    def _swing_to(
        self,
        now: Stance,
        commanded: Array | None,
        ground: GroundModel,
        leg: int,
        target: Array,
        pace: float,
        tilt: float,
        lower: float,
    ) -> PlannedSwing:
        options, robot, scale = self._options, self._robot, self._scale
        start = now.feet[leg]
        feet = now.feet.copy()
        feet[leg] = 0.5 * (start + target)
        feet[leg, 2] = target[2]
        yaw = heading_over(robot, feet)
        body = _lowered(body_over(robot, feet, yaw, ground.slope, tilt), scale * lower)
        body = self._balanced_over(body, now, leg)

        shift = self._shift_duration(now.body, body)
        top, above = self._heights(ground, start, target, now.loads is not None)
        depth = 0.0
        if now.loads is not None:
            known = ground.height_map is not None
            depth = 0.5 * robot.roughness if known else 1.1 * robot.step_height
        # The body need not be quite there: it is slow at the end of its way.
        lift = _LIFT_AT * shift
        lift_end = lift + self._lasting(top - start[2], options.lift_time, pace)
        across = math.dist(start[:2], target[:2])
        over_end = lift_end + self._lasting(across, options.transfer_time, pace)
        fall = over_end - 0.2 * options.transfer_time
        to_feel = top - target[2] - above
        low = fall + (self._lasting(to_feel, options.lower_time, pace) if to_feel > 0.0 else 0.0)
        search = (above + depth) / (scale * options.search_speed)
        times = self._times(low + search + _ramp(search))
        over = minimum_jerk((lift + lift_end) / 2.0, over_end, times)[0]
        height = start[2] + (top - start[2]) * minimum_jerk(lift, lift_end, times)[0]
        if low > fall:
            height += (target[2] + above - top) * minimum_jerk(fall, low, times)[0]
        height -= _searched(times - low, scale * options.search_speed, above + depth)
        path = np.repeat(now.feet[None], len(times), axis=0)
        path[:, leg, :2] += over[:, None] * (target - start)[:2]
        path[:, leg, 2] = height
        body_share = minimum_jerk(0.0, shift, times)[0]
        # What is below the ground only matters where it is missing: as deep as legs reach.
        sure = int(np.searchsorted(times, low + above / (scale * options.search_speed)))
        given = None
        if now.loads is not None:
            # Without a map the ground may be anywhere on the way down.
            given = sure if ground.height_map is not None else int(np.searchsorted(times, low))
        motion = self._planned(now, commanded, times, body, body_share, path, sure + 1, given)
        lifted_at, feels_from = (int(np.searchsorted(times, t)) for t in (lift, lift_end))
        return PlannedSwing(motion, lifted_at, feels_from, depth)

    def _shin(self, leg: int, stride: Array, yaw: float) -> Array:
        """
        Place points of foot and shin while the foot stands, shape (n, 3) [m].

        They are measured from the point below the foot. The body goes on by one stride,
        shape (2,), until the foot is lifted again; how it sways meanwhile does not count.
        """
        robot, c, s = self._robot, math.cos(yaw), math.sin(yaw)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        way = np.array([*stride, 0.0]) @ turn
        shins = []
        for share in _STANCE:
            foot = robot.neutral_feet[leg] + share * way
            try:
                shins.append(robot.legs[leg].chain(robot.legs[leg].inverse(foot))[1] - foot)
            except GaitError:
                continue
        shin = np.array(shins).reshape(-1, 1, 3)
        points = _ON_SHIN[:, None] * shin
        # The foot rolls under its shin.
        points[..., :2] += robot.foot_radius * (_lean(shin) - _lean(shin[:1]))
        points[..., 2] += robot.foot_radius
        turned: Array = points.reshape(-1, 3) @ turn.T
        return turned

    def _target(
        self, ground: GroundModel, start: Array, place: Array, share: float, shin: Array
    ) -> Array:
        """Choose where a foot goes: its center, shape (3,) [m]."""
        options, scale = self._options, self._scale
        wanted = start[:2] + share * (place - start[:2])
        if share > 0.0:
            choice = FootholdChoice(
                scale * options.foothold_reach,
                max(scale * options.foothold_radius, self._robot.foot_radius),
                scale * options.largest_step,
                self._robot.roughness + scale * self._swing_height,
                shin,
                self._robot.foot_radius + scale * options.shin_clearance,
            )
            wanted = ground.best_foothold(wanted, choice)
        return np.array([*wanted, float(ground.height(wanted)) + self._robot.foot_radius])

    def _heights(
        self, ground: GroundModel, start: Array, target: Array, feels: bool
    ) -> tuple[float, float]:
        """Return how high a foot is lifted, and how far above its place it begins to feel."""
        options, robot, scale = self._options, self._robot, self._scale
        radius = robot.foot_radius
        highest = ground.highest_between(start[:2], target[:2], radius + scale * 0.01) + radius
        highest = max(highest, float(start[2]), float(target[2]))
        if ground.height_map is not None:
            top = highest + scale * options.clearance
            above = scale * options.search_above
        else:
            # It may meet the ground anywhere on its way down: all of it is slow.
            top = highest + max(1.2 * self._swing_height, 1.5 * robot.roughness)
            above = top - float(target[2])
        return top, above if feels else 0.0

    def _balanced_over(self, body: BodyPose, now: Stance, leg: int) -> BodyPose:
        """Move the body so that its center of mass is inside the other three feet."""
        offset = (body.rotation @ self._robot.center_of_mass(now.joint_positions))[:2]
        center = body.position[:2] + offset
        triangle = np.delete(now.feet[:, :2], leg, axis=0)
        moved = balanced(center, triangle, self._scale * self._options.margin) - offset
        return BodyPose(np.array([*moved, body.position[2]]), body.roll, body.pitch, body.yaw)

    def _lasting(self, way: float, least: float, pace: float) -> float:
        """Return how long a foot takes for a way [s]."""
        return max(least, float(way) / (self._scale * pace * self._options.foot_speed))

    def _shift_duration(self, start: BodyPose, end: BodyPose) -> float:
        way = float(np.linalg.norm(end.position - start.position))
        turned = np.abs([end.roll - start.roll, end.pitch - start.pitch, _turn(start, end)]).max()
        way = max(way, self._robot.footprint_radius * float(turned))
        return max(self._options.shift_time, way / (self._scale * self._options.shift_speed))

    def _times(self, duration: float) -> Array:
        count = max(2, round(duration / self._options.sample_period))
        return np.linspace(0.0, duration, count + 1, dtype=np.float64)

    def _planned(
        self,
        now: Stance,
        commanded: Array | None,
        times: Array,
        end: BodyPose,
        share: Array,
        feet: Array,
        sure: int | None = None,
        given: int | None = None,
    ) -> JointMotion:
        """
        Turn paths of body and feet into joint motion, from where the joints are commanded.

        Samples from ``sure`` on are left out where a leg does not reach; those up to ``given``
        are given out at once, all of them if it is None.
        """
        robot, start = self._robot, now.body
        position = start.position + share[:, None] * (end.position - start.position)
        turns = np.array([end.roll - start.roll, end.pitch - start.pitch, _turn(start, end)])
        angles = np.array([start.roll, start.pitch, start.yaw]) + share[:, None] * turns
        arms = np.einsum('nji,nkj->nki', rotation_of(angles), feet - position[:, None])
        needed = len(times) if sure is None else min(sure, len(times))
        joints = robot.joint_angles(arms[:needed])
        while needed < len(times):
            # Beyond what is sure the foot goes only as deep as the leg reaches.
            try:
                joints = np.concatenate([joints, robot.joint_angles(arms[needed : needed + 1])])
            except GaitError:
                break
            needed += 1
        times, share = times[:needed], share[:needed]
        commanded = now.joint_positions if commanded is None else commanded
        blend = minimum_jerk(0.0, min(self._options.shift_time, float(times[-1])), times)[0]
        joints = joints + (1.0 - blend)[:, None, None] * (commanded - joints[0])
        velocities = np.gradient(joints, times, axis=0)
        velocities[0] = velocities[-1] = 0.0
        excess = np.abs(velocities) / robot.velocity
        if np.max(excess) > 1.0:
            leg, kind = np.unravel_index(int(np.argmax(excess.max(axis=0))), (4, 3))
            limit = float(np.broadcast_to(robot.velocity, (4, 3))[leg, kind])
            fastest = float(np.abs(velocities[:, leg, kind]).max())
            name = robot.joint_names[3 * int(leg) + int(kind)]
            raise JointLimitExceeded(name, fastest, -limit, limit, 'rad/s')
        check_nearing_parts(robot, times, joints)
        last = len(times) - 1
        return JointMotion(
            robot.joint_names,
            times,
            joints,
            velocities,
            np.broadcast_to(robot.velocity, (4, 3)).reshape(-1),
            start=now.time + self._options.reaction_time,
            given=last if given is None else min(given, last),
        )


def _first_possible(
    plan: Callable[..., Planned], ways: Iterable[tuple[float, ...]]
) -> tuple[Planned, GaitError | None]:
    """Plan in one way after the other; return the first that works, and what the first lacked."""
    problem: GaitError | None = None
    for way in ways:
        try:
            return plan(*way), problem
        except GaitError as error:
            problem = problem or error
    assert problem is not None
    raise problem


def _turn(start: BodyPose, end: BodyPose) -> float:
    return float((end.yaw - start.yaw + np.pi) % (2.0 * np.pi) - np.pi)


def _lowered(body: BodyPose, way: float) -> BodyPose:
    return BodyPose(body.position - np.array([0.0, 0.0, way]), body.roll, body.pitch, body.yaw)


def _lean(shin: Array) -> Array:
    """By which angles a shin, shape (..., 3), leans to x and y, shape (..., 2) [rad]."""
    return np.arctan2(shin[..., :2], shin[..., 2:])


def _ramp(duration: float) -> float:
    """How much longer a search takes because it begins gently [s]."""
    return 0.0 if duration <= 0.0 else 0.03


def _searched(times: Array, speed: float, way: float) -> Array:
    """Return how far down a foot has felt: it gathers speed, then keeps it [m]."""
    ramp = 2.0 * _ramp(1.0)
    gathered = np.where(times < ramp, times**2 / (2.0 * ramp), times - ramp / 2.0)
    return np.clip(speed * np.where(times > 0.0, gathered, 0.0), 0.0, way)
