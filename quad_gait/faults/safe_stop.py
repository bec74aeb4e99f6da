"""
Brings a robot to a standstill when a joint of one leg has failed.

A leg that may still bear is left to: the others put down what swings, and the robot stops
on four feet. One that has given way is none: the body goes down at once, as far as it
goes and away from that leg, so that little is left to fall. What is left is then done
slowly: level the body, bring its center of mass well inside the three sound feet, and
lift the lame leg with the joints that it still has. Where three feet do not bear the body,
it sits down on the ground.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.faults.joint_fault import JointFault
from quad_gait.faults.tipping import level_axes, tilt_of_body, tipping
from quad_gait.state.body_placement import balanced
from quad_gait.state.stance import Stance

Array = NDArray[np.float64]

_SHARES = tuple(np.linspace(1.0, 0.0, 11).tolist())
"""Of a motion, of which the legs may reach a part only."""

_RISES = (0.0, 0.03, 0.06, 0.09)
"""So much higher the body may go where it cannot be levelled as low as it is [m]."""

_TRIES = 15
"""Angles of a joint that are tried over its range."""

_SCRAPE = 0.002
"""A leg that is lifted may go so much lower than it is [m]."""

_LANDING_TURN, _LANDINGS = 0.8, 161
"""To put a lame leg down its sound joint is turned by so much at most [rad], in so many tries."""

_LANDING_ERROR = 0.01
"""Error of its foot's height with which it counts as put down [m]."""

_FOLDED = 0.85
"""Share of the knee's range to which a leg is folded."""


@dataclass(frozen=True)
class SafeStopOptions:
    """How a lame robot comes to a standstill; lengths are TITAN-VIII's."""

    sample_period: float = 0.02
    """Between a trajectory's points [s]."""
    reaction: float = 0.02
    """The first trajectory begins so long after the measurement [s]."""
    catch_time: float = 0.25
    """In which swinging feet are put down, and the body is lowered [s]."""
    press: float = 0.01
    """Feet are put down to so far below where the ground may be [m]."""
    settle_time: float = 1.2
    """For the body to go over the sound feet [s]."""
    pause: float = 0.3
    """Between two of these motions, for the body to come to rest [s]."""
    margin: float = 0.035
    """How far inside the sound feet the center of mass is brought, if they give so much [m]."""
    clearance: float = 0.02
    """Of the lifted leg over the ground [m]."""
    least_margin: float = 0.01
    """With less the robot sits down [m]."""
    giving_way: float = 0.1
    """A body that tilts by so much more has lost the leg that was to bear [rad]."""
    attempts: int = 3
    """To bring the center of mass there."""
    shifts_at_once: bool = False
    """Whether the center of mass goes over the sound feet while those that swing are put down."""
    lands_on_it: bool = False
    """Whether a lame leg that swings is put down too, if it may bear: then it is a foot more."""
    sufficient: float = 0.8
    """Share of ``margin`` with which the body is not moved any more."""
    largest_tilt: float = 0.05
    """Nor is it if it is tilted by less [rad]."""

    @classmethod
    def hasty(cls) -> SafeStopOptions:
        """Return the options for a gait that is not static: it leaves no time to settle."""
        return cls(
            catch_time=0.27,
            settle_time=0.45,
            pause=0.08,
            attempts=2,
            shifts_at_once=True,
            lands_on_it=True,
            sufficient=0.45,
            largest_tilt=0.08,
        )


class _Stage(enum.Enum):
    CATCH = 'catch'
    SETTLE = 'settle'
    LIFT = 'lift'
    SIT = 'sit'
    OVER = 'over'


class SafeStop:
    """
    The motions that bring a lame robot to a standstill, one after the other.

    Parameters
    ----------
    robot : Robot
        The robot.
    fault : JointFault
        What has failed.
    commanded : ndarray, shape (4, 3)
        Where the joints are commanded to be now [rad].
    standing : ndarray of bool, shape (4,)
        Which feet are planned to be down now.
    options : SafeStopOptions, optional
        How.
    """

    def __init__(
        self,
        robot: Robot,
        fault: JointFault,
        commanded: Array,
        standing: NDArray[np.bool_],
        options: SafeStopOptions | None = None,
    ) -> None:
        self._robot = robot
        self._fault = fault
        self._options = SafeStopOptions() if options is None else options
        self._scale = robot.relative_size
        self._wanted = self._options.sufficient * self._scale * self._options.margin
        self._leg = fault.leg
        self._sound = np.arange(len(LEGS)) != fault.leg
        self._joints = commanded.copy()
        self._standing = standing.copy()
        # A joint that turns about the vertical carries no weight.
        has_lever = abs(robot.foot_jacobians(commanded)[self._leg, 2, fault.joint % 3]) > 1e-6
        turns_freely = fault.joint % 3 == 0 and not has_lever
        self.bears = bool(standing[self._leg]) and (not fault.is_slack or turns_freely)
        """Whether the lame leg bears the body as well."""
        # In the air a motor needs no torque: one that does not move may hold.
        self._lands = (
            self._options.lands_on_it
            and not standing[self._leg]
            and (turns_freely or fault.kind == 'stuck')
        )
        # One that has not moved may be stuck, with nothing to bear: it is not given up at once.
        self._is_lost = bool(standing[self._leg]) and not self.bears and fault.kind == 'free'
        self._tilt = 0.0
        self._tilt_before = np.inf
        self._stage: _Stage | None = None
        self._attempts = 0
        self._end = -np.inf
        self._motion = (-np.inf, commanded, commanded)
        self._has_fallen = False
        self._is_held = False
        self.prediction = ''
        """What would have become of the stance, as a sentence."""
        self.margin = np.nan
        """Of the center of mass inside the feet that bear, at the end [m]."""
        self.sits = False
        """Whether the body lies on the ground in the end."""

    @property
    def is_over(self) -> bool:
        """Whether nothing more is to be done."""
        return self._stage is _Stage.OVER

    @property
    def end(self) -> float:
        """When the last motion is done [s]."""
        return self._end

    @property
    def joint_positions(self) -> Array:
        """Where the joints are commanded to end, shape (4, 3) [rad]."""
        return self._joints

    def __str__(self) -> str:
        """Say what the robot does, or has done."""
        if self._has_fallen:
            return 'the robot has fallen'
        if self._is_held:
            return 'all joints were held by the emergency stop'
        if self._stage is not _Stage.OVER:
            return 'the robot is being brought to a standstill'
        if self.sits:
            return 'the robot sits on the ground'
        feet = 'four feet' if self.bears else 'three legs'
        return f'the robot stands on {feet} with a margin of {1e3 * self.margin:.0f} mm'

    def hold(self) -> None:
        """Do nothing more: an emergency stop holds all joints."""
        self._stage = _Stage.OVER
        self._is_held = True

    def give_up(self) -> None:
        """Do nothing more: the robot has fallen."""
        self._stage = _Stage.OVER
        self._is_lost = self._has_fallen = True

    def update(self, now: Stance) -> JointTrajectory | None:
        """
        Take a measurement; begin the next motion if it is time to.

        Parameters
        ----------
        now : Stance
            The robot as it stands.

        Returns
        -------
        JointTrajectory or None
            What replaces the last one, if anything does.
        """
        if self._stage is None:
            self._predict(now)
            self._stage = _Stage.CATCH
            self._tilt = tilt_of_body(now)
            return self._catch(now)
        if not self._is_lost and tilt_of_body(now) > self._tilt + self._options.giving_way:
            self._is_lost, self.bears = True, False
            self._joints = self._commanded(now.time)
            self._stage = _Stage.CATCH
            return self._catch(now)
        if self._stage is _Stage.OVER or now.time < self._end + self._options.pause:
            return None
        return self._next(now)

    # What to do next

    def _next(self, now: Stance) -> JointTrajectory | None:
        carries = self._sound | self.bears
        up = now.body.rotation[2]
        self.margin, _ = tipping(self._robot, now.joint_positions, up, carries)
        if self.bears or self._stage is _Stage.SIT:
            self._stage = _Stage.OVER
            self.sits = not self.bears
            return None
        if self._stage in (_Stage.CATCH, _Stage.SETTLE):
            is_done = self.margin >= self._wanted and tilt_of_body(now) < self._options.largest_tilt
            # Three feet that do not bear the body lever it over the lame leg: no more of that.
            tips = tilt_of_body(now) > self._tilt_before + self._options.giving_way
            if not is_done and not tips and self._attempts < self._options.attempts:
                self._attempts += 1
                self._stage = _Stage.SETTLE
                return self._settle(now)
            if self.margin >= self._scale * self._options.least_margin:
                self._stage = _Stage.LIFT
                return self._lift(now)
        elif tilt_of_body(now) > self._tilt + self._options.giving_way and self._attempts:
            self._attempts = 0
            self._stage = _Stage.SETTLE
            return self._settle(now)
        elif self.margin >= self._scale * self._options.least_margin:
            self._stage = _Stage.OVER
            return None
        self._stage = _Stage.SIT
        return self._sit(now)

    def _predict(self, now: Stance) -> None:
        """Say what would become of the stance with this leg gone."""
        if self.bears:
            self.prediction = 'its leg still bears'
            return
        carries = self._standing & self._sound
        if np.count_nonzero(carries) < 2:
            carries = self._sound
        margin, angle = tipping(self._robot, self._joints, now.body.rotation[2], carries)
        # A stance that stands by itself is left in peace.
        self._is_lost = self._is_lost and margin < self._wanted
        if margin >= 0.0:
            self.prediction = f'without its leg the stance stands, by {1e3 * margin:.0f} mm'
        else:
            self.prediction = (
                f'without its leg the stance falls: the center of mass was {-1e3 * margin:.0f} mm '
                f'outside the other feet, and the body would tip by {np.degrees(angle):.0f} degrees'
            )

    # Motions

    def _catch(self, now: Stance) -> JointTrajectory:
        """Put down what swings; lower the body if a foot that bore has given way."""
        options, robot = self._options, self._robot
        start = self._joints.copy()
        posture = self._as_measured(now)
        level = level_axes(now.body.rotation[2])
        feet = robot.foot_positions(posture) @ level.T
        under = feet[self._standing, 2] if self._standing.any() else feet[:, 2].min(keepdims=True)
        ground = float(under.mean())
        target = feet.copy()
        landing = self._sound & ~self._standing
        press = self._scale * options.press
        shift = np.zeros(3)
        lame = posture[self._leg]
        if self._lands and not self._is_lost:
            # On four feet it is not to rock from one diagonal to the other.
            put_down = self._put_down(posture, level, ground)
            self._lands = False
            if put_down is not None:
                self.bears, press, lame = True, 0.0, put_down
        target[landing, 2] = ground - press
        if self._is_lost:
            lame = self._helpful(posture)
            crouch = -float(robot.foot_positions(crouching_joint_angles(robot))[:, 2].mean())
            shift[2] = -max(0.0, -ground - crouch)
        elif options.shifts_at_once and not self.bears:
            shift[:2] = self._way_over(posture, level, target)
        return self._move(
            now.time + options.reaction,
            options.catch_time,
            start,
            level,
            level,
            target,
            shift,
            lame,
        )

    def _settle(self, now: Stance) -> JointTrajectory:
        """Level the body over the sound feet, with its center of mass well inside them."""
        self._tilt_before = tilt_of_body(now)
        start = self._joints.copy()
        level = level_axes(now.body.rotation[2])
        joints = now.joint_positions.copy()
        feet = self._robot.foot_positions(joints) @ level.T
        shift = np.zeros(3)
        shift[:2] = self._way_over(joints, level, feet)
        time = now.time + self._options.reaction
        lame = self._as_measured(now)[self._leg]
        return self._move(
            time, self._options.settle_time, start, level, np.eye(3), feet, shift, lame
        )

    def _lift(self, now: Stance) -> JointTrajectory:
        """Lift the lame leg with the joints that it still has."""
        start = self._joints.copy()
        posture = self._as_measured(now)
        end = posture.copy()
        feet = self._robot.foot_positions(now.joint_positions)[self._sound]
        ground = float(feet[:, 2].min()) - self._robot.foot_radius
        end[self._leg] = self._lifted(posture, ground)
        return self._through(
            now.time + self._options.reaction, self._options.settle_time, start, end
        )

    def _sit(self, now: Stance) -> JointTrajectory:
        """Lower the body to the ground."""
        robot = self._robot
        start = self._joints.copy()
        level = level_axes(now.body.rotation[2])
        feet = robot.foot_positions(now.joint_positions) @ level.T
        shift = np.array([0.0, 0.0, float(feet[self._sound, 2].mean()) + robot.body_size[2] / 2.0])
        shift[2] = min(shift[2] + 0.3 * robot.hip_height, 0.0)
        time = now.time + self._options.reaction
        duration = self._options.settle_time
        lame = self._as_measured(now)[self._leg]
        return self._move(time, duration, start, level, level, feet, shift, lame)

    def _as_measured(self, now: Stance) -> Array:
        """Return the commanded posture, with the lame leg where it is, within its range."""
        posture, robot, leg = self._joints.copy(), self._robot, self._leg
        posture[leg] = np.clip(now.joint_positions[leg], robot.lower[leg], robot.upper[leg])
        return posture

    # How to do it

    def _way_over(self, joints: Array, level: Array, feet: Array) -> Array:
        """Return the way that brings the center of mass well inside the sound feet, (2,) [m]."""
        center = (level @ self._robot.center_of_mass(joints))[:2]
        triangle = feet[self._sound, :2]
        way: Array = balanced(center, triangle, self._scale * self._options.margin) - center
        return way

    def _move(
        self,
        time: float,
        duration: float,
        start: Array,
        level: Array,
        level_after: Array,
        feet: Array,
        shift: Array,
        lame: Array,
    ) -> JointTrajectory:
        """Move the body over its feet as far as the legs reach, not faster than joints turn."""
        for share, rise in product(_SHARES, _RISES if level_after is not level else (0.0,)):
            rotation = level_after if share > 0.0 else level
            way = share * shift + np.array([0.0, 0.0, self._scale * rise])
            arms = (feet - way) @ rotation
            arms[self._leg] = self._robot.neutral_feet[self._leg]
            try:
                end = self._robot.joint_angles(arms)
            except GaitError:
                continue
            end[self._leg] = lame
            return self._through(time, duration, start, end)
        end = start.copy()
        end[self._leg] = lame
        return self._through(time, duration, start, end)

    def _through(self, time: float, duration: float, start: Array, end: Array) -> JointTrajectory:
        """Turn all joints, longer if they are not fast enough."""
        robot, options = self._robot, self._options
        change = (end - start).reshape(-1)
        # Minimum jerk is at most 15/8 times as fast as the mean.
        fastest = np.max(np.abs(change) / np.broadcast_to(robot.velocity, (4, 3)).reshape(-1))
        duration = max(duration, 1.875 * float(fastest))
        steps = max(2, round(duration / options.sample_period))
        times = np.linspace(0.0, duration, steps + 1, dtype=np.float64)
        share, rate = minimum_jerk(0.0, duration, times)
        self._joints = end.copy()
        self._end = time + duration
        self._motion = (time, start, end)
        return JointTrajectory(
            joint_names=robot.joint_names,
            stamp=time,
            times=times,
            positions=start.reshape(-1) + share[:, None] * change,
            velocities=rate[:, None] * change,
        )

    def _commanded(self, time: float) -> Array:
        """Return where the joints are commanded to be at a time [s], shape (4, 3) [rad]."""
        begin, start, end = self._motion
        share = minimum_jerk(begin, self._end, np.array([time]))[0][0]
        joints: Array = start + share * (end - start)
        return joints

    def _put_down(self, joints: Array, level: Array, height: float) -> Array | None:
        """
        Return a posture of the lame leg with its foot at a height, turned by its sound joints.

        Heights are in level axes through base_link [m]; None if the foot does not get there.
        """
        other = 1 if self._fault.joint % 3 == 2 else 2
        now: Array = joints[self._leg]
        if self._fault.joint % 3 == 0:
            # Both other joints: straight down.
            arms = self._robot.foot_positions(joints) @ level.T
            arms[self._leg, 2] = height
            try:
                straight: Array = self._robot.joint_angles(arms @ level)[self._leg]
            except GaitError:
                return None
            straight[0] = now[0]
            return straight
        lower, upper = self._robot.lower[self._leg, other], self._robot.upper[self._leg, other]
        tried = np.repeat(now[None], _LANDINGS, axis=0)
        tried[:, other] = np.linspace(
            max(lower, now[other] - _LANDING_TURN),
            min(upper, now[other] + _LANDING_TURN),
            _LANDINGS,
        )
        _, _, feet = self._robot.legs[self._leg].chain(tried)
        off = np.abs((feet @ level.T)[:, 2] - height)
        fits = np.flatnonzero(off <= max(float(off.min()), self._scale * _LANDING_ERROR / 2.0))
        best = int(fits[np.abs(tried[fits, other] - now[other]).argmin()])
        if off[best] > self._scale * _LANDING_ERROR:
            return None
        landed: Array = tried[best]
        return landed

    def _helpful(self, joints: Array) -> Array:
        """Return a posture of the lame leg in which its knee may bear, or it is not in the way."""
        joint = self._fault.joint % 3
        angles: Array = joints[self._leg].copy()
        if joint == 0:
            return angles
        lower, upper = self._robot.lower[self._leg], self._robot.upper[self._leg]
        if joint == 1:
            # The leg swings about the hip: fold it.
            angles[2] = _FOLDED * max(lower[2], upper[2], key=abs)
            return angles
        # The thigh points down as far as the crouching body leaves it room.
        room = -float(self._robot.foot_positions(crouching_joint_angles(self._robot))[:, 2].mean())
        tries = []
        for pitch in np.linspace(lower[1], upper[1], 41):
            tried = np.array([angles[0], pitch, angles[2]])
            _, knee, foot = self._robot.legs[self._leg].chain(tried)
            depth = -float(knee[2])
            # The knee may be stuck after all: its foot must not prop up the body.
            if max(depth, -float(foot[2])) <= room:
                tries.append((round(depth, 4), -abs(pitch - angles[1]), pitch))
        angles[1] = max(tries)[2] if tries else angles[1]
        return angles

    def _lifted(self, joints: Array, ground: float) -> Array:
        """
        Return a posture of the lame leg that is clear of the ground, whatever its lame joint does.

        The nearest one that can be reached without pressing on the ground; if there is none,
        the leg stays as it is. The ground is given as its height in the body's frame [m].
        """
        joint = self._fault.joint % 3
        now: Array = joints[self._leg]
        lower, upper = self._robot.lower[self._leg], self._robot.upper[self._leg]
        turns = np.linspace(lower, upper, _TRIES).T
        others = [k for k in (1, 2) if k != joint]
        wanted = ground + self._robot.foot_radius + self._scale * self._options.clearance
        least = min(self._lowest(now), ground + self._robot.foot_radius)
        ways = []
        for tried in product(*(turns[k] for k in others)):
            end = now.copy()
            end[others] = tried
            if self._lowest(end) < wanted:
                continue
            path = [now + share * (end - now) for share in (0.25, 0.5, 0.75)]
            if min(map(self._lowest, path)) >= least - self._scale * _SCRAPE:
                ways.append((float(np.abs(end - now).sum()), tuple(end)))
        return np.array(min(ways)[1]) if ways else now

    def _lowest(self, angles: Array) -> float:
        """Return how low a leg reaches in the body's frame, its lame joint being anywhere [m]."""
        joint = self._fault.joint % 3
        leg = self._robot.legs[self._leg]
        lower, upper = self._robot.lower[self._leg], self._robot.upper[self._leg]
        if not self._fault.is_slack or joint == 0:
            may_be = angles[None]
        else:
            may_be = np.repeat(angles[None], _TRIES, axis=0)
            may_be[:, joint] = np.linspace(lower[joint], upper[joint], _TRIES)
        _, knee, foot = leg.chain(may_be)
        # A leg that hangs free comes to rest with its foot low.
        hanging = int(np.argmin(foot[:, 2]))
        return float(min(knee[hanging, 2], foot[hanging, 2]))
