"""
One gait cycle over ground that is not flat: a swing at a time, ended by what the foot meets.

On flat ground a whole cycle is planned ahead. Here each swing is planned when it begins,
from where the feet really stand: the body goes over the three others, level if the legs
reach, the foot is lifted over what is in its way and lowered until it bears load. It may
meet the ground early, or later than expected: the cycle goes on from there.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    FootholdNotFound,
    GaitError,
    JointLimitExceeded,
    ParameterError,
)
from quad_common.height_map import HeightMap
from quad_common.joint_trajectory import JointTrajectory
from quad_common.planar_pose import Pose2D
from quad_common.robot import LEGS, Robot
from quad_gait.body_motion import BodyMotion, minimum_jerk
from quad_gait.body_placement import (
    BodyPose,
    angles_of,
    balanced,
    body_over,
    heading_over,
    rotation_of,
)
from quad_gait.foot_forces import GRAVITY, foot_forces
from quad_gait.gait import Gait
from quad_gait.ground_model import FootholdChoice, GroundModel
from quad_gait.joint_motion import JointMotion

Array = NDArray[np.float64]

_BIT = 3
"""So many samples of a search are given out at a time: a foot presses on for no longer."""

_SURE = 3.0
"""So many times the load that counts as contact needs no second measurement."""

_LIFT_AT = 0.85
"""A foot is lifted after this share of the time in which the body goes over the others."""

_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Of a step, of which the legs may reach one only."""

_TILTS = (0.0, 0.5, 1.0)
"""Shares of the ground's tilt that the body may take."""

_LOWER = (0.0, 0.03, 0.06)
"""How much lower than in its initial posture the body may be [m]."""

_WAYS = sorted(
    product(_SHARES, _TILTS, _LOWER),
    # A lower body costs little, a shorter step more, and a tilt most.
    key=lambda way: (1.0 - way[0]) + 0.75 * way[1] + 3.0 * way[2],
)
"""How a swing may be done, in the order in which it is tried."""


@dataclass(frozen=True)
class UnevenOptions:
    """How a robot walks where the ground is not flat; lengths are TITAN-VIII's."""

    sample_period: float = 0.02
    """Between a trajectory's points [s]."""
    reaction_time: float = 0.06
    """A trajectory that answers to a contact begins so long after it [s]: it must have come
    to the joints by then, and the foot presses on meanwhile."""
    margin: float = 0.035
    """How far inside its three feet the centre of mass is kept, if they give so much [m]."""
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
    largest_step: float = 0.025
    """Heights around a foot differ by at most so much on even ground [m]."""


def check_suits_uneven_ground(gait: Gait) -> None:
    """Raise ParameterError for a gait whose cycles do not begin and end at rest."""
    if gait.is_steady or not gait.is_static:
        raise ParameterError(
            'gait',
            gait.name,
            'one that rests between its cycles where the ground is uneven, as crawl and crab do',
        )


@dataclass(frozen=True)
class Stance:
    """What is known of a robot at one instant."""

    time: float
    """[s]"""
    body: BodyPose
    """x, y and yaw in the plan's frame; z is measured from base_link, so it is 0 here."""
    feet: Array
    """Their centres in the same frame, shape (4, 3) [m]."""
    joint_positions: Array
    """Shape (4, 3) [rad]."""
    find_loads: Callable[[], Array | None]
    """Finds :attr:`loads`, when they are asked for: it takes longer than all the rest."""

    @cached_property
    def loads(self) -> Array | None:
        """Vertical force on each foot, shape (4,) [N]; None where motors do not tell."""
        return self.find_loads()

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
        roll, pitch, _ = angles_of(orientation)
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


class _Phase(enum.Enum):
    SEEKING = 'seeking'
    SWINGING = 'swinging'
    FINISHING = 'finishing'
    OVER = 'over'


class UnevenStride:
    """
    Carries one step of the body out, leg by leg.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        In whose order the legs swing.
    motion : BodyMotion
        Where the body goes.
    pose : Pose2D
        From where, in the plan's frame.
    height_map : HeightMap, optional
        Of the ground, in the plan's frame; without one the feet feel their way.
    options : UnevenOptions
        How.
    """

    def __init__(
        self,
        robot: Robot,
        gait: Gait,
        motion: BodyMotion,
        pose: Pose2D,
        height_map: HeightMap | None,
        options: UnevenOptions,
    ) -> None:
        self._robot = robot
        self._options = options
        self._scale = robot.relative_size
        self._order = [LEGS.index(swing.leg) for swing in gait.swings]
        self._swing_height = gait.swing_height
        self._footholds = (pose @ motion.end).transform(robot.neutral_feet)[:, :2]
        self.height_map = height_map
        self._phase = _Phase.SEEKING
        self._next = 0
        self._untouched: Stance | None = None
        self._touched: Stance | None = None
        self._seeking: list[int] = []
        self._sought: set[int] = set()
        self._depth = 0.0
        # Samples of the motion: from when on the foot is in the air, and may meet the ground.
        self._lifted_at = self._feels_from = 0
        self._return_to: Array | None = None
        self._has_lowered = False
        self._left = np.zeros((len(LEGS), 3))
        self._motion: JointMotion | None = None
        self.limit = ''
        """What kept a leg from getting as far as it was to; empty if nothing did."""

    @property
    def is_over(self) -> bool:
        """Whether all legs have swung and the body is where it was to go."""
        return self._phase is _Phase.OVER

    @property
    def end(self) -> float:
        """When what was planned last is done [s]."""
        return -np.inf if self._motion is None else self._motion.end

    @property
    def joint_positions(self) -> Array | None:
        """Where the joints are commanded to end, shape (4, 3) [rad]; None before they move."""
        return None if self._motion is None else self._motion.positions[-1]

    @property
    def footholds(self) -> Array:
        """Where the feet would stand after it on even ground, shape (4, 3) [m]; z by the map."""
        height = np.zeros(len(LEGS))
        if self.height_map is not None:
            height = self.height_map.height_at(self._footholds, beyond=0.0)
        return np.column_stack([self._footholds, height])

    @property
    def in_contact(self) -> NDArray[np.bool_]:
        """Which feet stand, by what was measured last, shape (4,)."""
        standing = np.ones(len(LEGS), dtype=bool)
        motion = self._motion
        if self._phase is _Phase.SWINGING and motion is not None:
            is_in_the_air = motion.done >= self._lifted_at or self._return_to is not None
            standing[self._order[self._next]] = not is_in_the_air
        return standing

    def update(self, now: Stance) -> JointTrajectory | None:
        """
        Take a measurement; plan on if a foot has met the ground, or a motion is over.

        Parameters
        ----------
        now : Stance
            The robot as it stands.

        Returns
        -------
        JointTrajectory or None
            What replaces the last one, if anything does.

        Raises
        ------
        GaitError
            If the legs do not reach, or a foot finds no ground.
        """
        if self._phase is _Phase.OVER:
            return None
        if self._motion is not None:
            self._motion = self._motion.followed(now.time, now.joint_positions)
        if self._phase is _Phase.SEEKING:
            return self._seek(now)
        motion = self._motion
        assert motion is not None
        if self._phase is _Phase.FINISHING:
            if motion.is_done:
                self._phase = _Phase.OVER
            return None
        if motion.done < self._feels_from:
            return None
        leg = self._order[self._next]
        share = self._load_share(now, leg)
        if share <= self._options.contact_share:
            self._untouched, self._touched = now, None
        elif self._touched is None:
            self._touched = now
        if self._touched is not None:
            is_second = now is not self._touched
            if is_second or share > _SURE * self._options.contact_share:
                return self._land(self._as_touched(now, leg))
            return None
        if not motion.is_done:
            return self._give_more(now)
        if now.loads is None:
            return self._land(now)
        if now.time < motion.end + self._options.reaction_time:
            return None
        if self._return_to is None and not self._has_lowered:
            deeper = self._feel_deeper(now, leg)
            if deeper is not None:
                return deeper
        if self._return_to is None:
            # No ground here: back to where the foot stood.
            self._return_to = self._left[leg]
            return self._swing(now)
        raise FootholdNotFound(LEGS[leg], self._depth)

    # What to do next

    def _give_more(self, now: Stance) -> JointTrajectory | None:
        """Let a foot feel on, as nothing was met."""
        assert self._motion is not None
        more = self._motion.extended(now.time, self._options.reaction_time, _BIT)
        if more is None:
            return None
        self._motion = more
        return more.trajectory(self._options.reaction_time)

    def _load_share(self, now: Stance, leg: int) -> float:
        """Return what a foot bears, as a share of the robot's weight."""
        if now.loads is None:
            return 0.0
        return float(now.loads[leg]) / (self._robot.mass * GRAVITY)

    def _has_load(self, now: Stance, leg: int) -> bool:
        return self._load_share(now, leg) > self._options.contact_share

    def _as_touched(self, now: Stance, leg: int) -> Stance:
        """
        Return the robot as it was when the foot met the ground.

        Until the contact is sure the foot presses on, and tilts the body: the other feet are
        where they were before, and this one belongs where it was at the first touch.
        """
        before, touched = self._untouched, self._touched
        assert touched is not None
        if before is None:
            return now
        joints = now.joint_positions.copy()
        joints[leg] = touched.joint_positions[leg]
        feet = before.body.transform(self._robot.foot_positions(joints))
        return Stance(now.time, before.body, feet, joints, lambda: now.loads)

    def _seek(self, now: Stance) -> JointTrajectory | None:
        """Lower feet that bear nothing until all four stand."""
        motion = self._motion
        if motion is not None:
            found = [leg for leg in self._seeking if self._has_load(now, leg)]
            if not found and not motion.is_done:
                return self._give_more(now)
            self._sought.update(found or self._seeking)
        if now.loads is None:
            self._seeking = []
        else:
            little = 0.2 * self._options.contact_share * self._robot.mass * GRAVITY
            self._seeking = [
                leg
                for leg in range(len(LEGS))
                if now.loads[leg] < little and leg not in self._sought
            ]
        if not self._seeking:
            self._phase = _Phase.SWINGING
            return self._swing(now)
        depth = 1.5 * self._robot.roughness
        speed = self._scale * self._options.search_speed
        times = self._times(depth / speed + _ramp(depth))
        feet = np.repeat(now.feet[None], len(times), axis=0)
        feet[:, self._seeking, 2] -= _searched(times, speed, depth)[:, None]
        still = np.zeros(len(times))
        self._motion = self._planned(
            now, times, now.body, now.body, still, feet, sure=2, given=_BIT
        )
        return self._motion.trajectory(self._options.reaction_time)

    def _land(self, now: Stance) -> JointTrajectory:
        """Go on with the next leg, or bring the body to its place."""
        self._return_to = None
        self._next += 1
        if self._next < len(self._order):
            return self._swing(now)
        self._phase = _Phase.FINISHING
        self._next = len(self._order) - 1
        return self._finish(now)

    def _swing(self, now: Stance) -> JointTrajectory:
        """Plan the next swing, shorter or with the body at a tilt if the legs do not reach."""
        leg = self._order[self._next]
        ground = self._ground(now, leg if self._return_to is not None else None)
        problem: GaitError | None = None
        for share, tilt, lower in _WAYS:
            try:
                self._motion = self._plan_swing(now, ground, leg, share, tilt, lower)
            except GaitError as error:
                problem = problem or error
                continue
            if share < 1.0 and not self.limit:
                self.limit = f'a step was shortened: {problem}'
            self._untouched = self._touched = None
            self._has_lowered = False
            return self._motion.trajectory(self._options.reaction_time)
        assert problem is not None
        raise problem

    def _feel_deeper(self, now: Stance, leg: int) -> JointTrajectory | None:
        """Lower the body, so that a foot gets farther down; None if the legs do not reach."""
        self._has_lowered = True
        speed = self._scale * self._options.search_speed
        target = _lowered(now.body, self._scale * _LOWER[-1])
        shift = self._shift_duration(now.body, target)
        times = self._times(shift + self._depth / speed + _ramp(self._depth))
        path = np.repeat(now.feet[None], len(times), axis=0)
        path[:, leg, 2] -= _searched(times - shift, speed, self._depth)
        share = minimum_jerk(0.0, shift, times)[0]
        sure = int(np.searchsorted(times, shift))
        try:
            motion = self._planned(now, times, now.body, target, share, path, sure + 1, sure)
        except GaitError:
            return None
        self._motion = motion
        self._feels_from = self._lifted_at = 0
        return motion.trajectory(self._options.reaction_time)

    def _finish(self, now: Stance) -> JointTrajectory:
        """Bring the body over its four feet."""
        ground = self._ground(now, None)
        yaw = heading_over(self._robot, now.feet)
        problem: GaitError | None = None
        for tilt in _TILTS:
            for lower in _LOWER:
                target = body_over(self._robot, now.feet, yaw, ground.slope, tilt)
                target = _lowered(target, self._scale * lower)
                duration = self._shift_duration(now.body, target)
                times = self._times(duration)
                share = minimum_jerk(0.0, duration, times)[0]
                feet = np.repeat(now.feet[None], len(times), axis=0)
                try:
                    self._motion = self._planned(now, times, now.body, target, share, feet)
                    return self._motion.trajectory(self._options.reaction_time)
                except GaitError as error:
                    problem = problem or error
        assert problem is not None
        raise problem

    # Planning

    def _ground(self, now: Stance, but: int | None) -> GroundModel:
        """Find the ground under the feet that stand."""
        standing = [leg for leg in range(len(LEGS)) if leg != but]
        under = now.feet[standing] - np.array([0.0, 0.0, self._robot.foot_radius])
        return GroundModel.through(under, self.height_map)

    def _plan_swing(
        self,
        now: Stance,
        ground: GroundModel,
        leg: int,
        share: float,
        tilt: float,
        lower: float,
    ) -> JointMotion:
        options, robot, scale = self._options, self._robot, self._scale
        start = now.feet[leg]
        target = self._target(now, ground, leg, share)
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
        lift_end = lift + self._lasting(top - start[2], options.lift_time)
        over_end = lift_end + self._lasting(math.dist(start[:2], target[:2]), options.transfer_time)
        fall = over_end - 0.2 * options.transfer_time
        to_feel = top - target[2] - above
        low = fall + (self._lasting(to_feel, options.lower_time) if to_feel > 0.0 else 0.0)
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
        motion = self._planned(
            now, times, now.body, body, body_share, path, sure=sure + 1, given=given
        )
        self._lifted_at, self._feels_from = (
            int(np.searchsorted(times, time)) for time in (lift, lift_end)
        )
        self._depth = depth
        self._left = now.feet
        return motion

    def _target(self, now: Stance, ground: GroundModel, leg: int, share: float) -> Array:
        """Choose where a foot goes: its centre, shape (3,) [m]."""
        options, scale = self._options, self._scale
        if self._return_to is not None:
            return self._return_to
        start = now.feet[leg, :2]
        wanted = start + share * (self._footholds[leg] - start)
        if share > 0.0:
            choice = FootholdChoice(
                scale * options.foothold_reach,
                max(scale * options.foothold_radius, self._robot.foot_radius),
                scale * options.largest_step,
                self._robot.roughness + scale * self._swing_height,
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
        """Move the body so that its centre of mass is inside the other three feet."""
        offset = (body.rotation @ self._robot.center_of_mass(now.joint_positions))[:2]
        center = body.position[:2] + offset
        triangle = np.delete(now.feet[:, :2], leg, axis=0)
        moved = balanced(center, triangle, self._scale * self._options.margin) - offset
        return BodyPose(np.array([*moved, body.position[2]]), body.roll, body.pitch, body.yaw)

    def _lasting(self, way: float, least: float) -> float:
        """Return how long a foot takes for a way [s]."""
        # From where there was no ground a leg comes back stretched: its knee would be too fast.
        speed = self._options.foot_speed * (1.0 if self._return_to is None else 0.4)
        return max(least, float(way) / (self._scale * speed))

    def _shift_duration(self, start: BodyPose, end: BodyPose) -> float:
        way = float(np.linalg.norm(end.position - start.position))
        turned = np.abs([end.roll - start.roll, end.pitch - start.pitch, _turn(start, end)]).max()
        way = max(way, self._robot.footprint_radius * float(turned))
        return max(self._options.shift_time, way / (self._scale * self._options.shift_speed))

    def _times(self, duration: float) -> Array:
        count = max(2, round(duration / self._options.sample_period))
        return np.linspace(0.0, duration, count + 1)

    def _planned(
        self,
        now: Stance,
        times: Array,
        start: BodyPose,
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
        robot = self._robot
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
        commanded = now.joint_positions if self._motion is None else self._motion.commanded
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
        last = len(times) - 1
        return JointMotion(
            robot.joint_names,
            times,
            joints,
            velocities,
            start=now.time + self._options.reaction_time,
            given=last if given is None else min(given, last),
        )


def _turn(start: BodyPose, end: BodyPose) -> float:
    return float((end.yaw - start.yaw + np.pi) % (2.0 * np.pi) - np.pi)


def _lowered(body: BodyPose, way: float) -> BodyPose:
    return BodyPose(body.position - np.array([0.0, 0.0, way]), body.roll, body.pitch, body.yaw)


def _ramp(duration: float) -> float:
    """How much longer a search takes because it begins gently [s]."""
    return 0.0 if duration <= 0.0 else 0.03


def _searched(times: Array, speed: float, way: float) -> Array:
    """Return how far down a foot has felt: it gathers speed, then keeps it [m]."""
    ramp = 2.0 * _ramp(1.0)
    gathered = np.where(times < ramp, times**2 / (2.0 * ramp), times - ramp / 2.0)
    return np.clip(speed * np.where(times > 0.0, gathered, 0.0), 0.0, way)
