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

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.faults.joint_fault import JointFault
from quad_gait.faults.lame_leg import LameLeg
from quad_gait.faults.safe_stop_options import SafeStopOptions
from quad_gait.faults.stop_motions import BodyShift, StopMotions
from quad_gait.faults.tipping import level_axes, tilt_of_body, tipping
from quad_gait.state.body_placement import balanced
from quad_gait.state.stance import Stance

Array = NDArray[np.float64]


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
        self._motions = StopMotions(robot, fault.leg, commanded, self._options.sample_period)
        self._lame = LameLeg(robot, fault, self._scale * self._options.clearance)
        self._standing = standing.copy()
        if self._options.lands_on_it and self._hangs(commanded):
            self._standing[self._leg] = False
        stands = bool(self._standing[self._leg])
        # Vertical distance that its foot goes with the joint: lever of the weight that it carries.
        lever = abs(robot.foot_jacobians(commanded)[self._leg, 2, fault.joint % 3])
        # A joint that turns about the vertical carries no weight.
        turns_freely = fault.joint % 3 == 0 and not lever > 1e-6
        self.bears = stands and (not fault.is_slack or turns_freely)
        """Whether the lame leg bears the body as well."""
        # In the air a motor needs no torque: one that does not move may hold.
        self._lands = (
            self._options.lands_on_it and not stands and (turns_freely or fault.kind != 'free')
        )
        # One that has not moved may be stuck, with nothing to bear: it is not given up at once.
        # Nor is one that falls to its side, slowly, or that hardly has to bear.
        is_quick = lever >= self._options.least_lever * robot.hip_height
        gives_way = is_quick and fault.kind == 'free' and fault.joint % 3 != 0
        self._is_lost = stands and not self.bears and gives_way
        slowly = self._options.slowly_giving_way
        self._giving_way = self._options.giving_way if is_quick else slowly
        self._tilt = 0.0
        self._tilt_before = np.inf
        self._stage: _Stage | None = None
        self._attempts = 0
        self._has_fallen = False
        self._is_held = False
        self.is_over = False
        """Whether nothing more is to be done."""
        self.end = self._motions.end
        """Time at which the last motion is done [s]."""
        self.prediction = ''
        """What would have become of the stance, as a sentence."""
        self.margin = np.nan
        """Margin of the center of mass inside the feet that bear, at the end [m]."""
        self.sits = False
        """Whether the body lies on the ground in the end."""

    @property
    def joint_positions(self) -> Array:
        """Where the joints are commanded to end, shape (4, 3) [rad]."""
        return self._motions.joint_positions

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
        self.is_over = self._is_held = True

    def give_up(self) -> None:
        """Do nothing more: the robot has fallen."""
        self._stage = _Stage.OVER
        self.is_over = self._is_lost = self._has_fallen = True

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
        trajectory = self._decide(now)
        self.end, self.is_over = self._motions.end, self._stage is _Stage.OVER
        return trajectory

    def _decide(self, now: Stance) -> JointTrajectory | None:
        if self._stage is None:
            self._predict(now)
            self._stage = _Stage.CATCH
            self._tilt = tilt_of_body(now)
            return self._catch(now)
        if not self._is_lost and tilt_of_body(now) > self._tilt + self._giving_way:
            self._is_lost, self.bears = True, False
            self._motions.interrupt(now.time)
            self._stage = _Stage.CATCH
            return self._catch(now)
        if self._stage is _Stage.OVER or now.time < self.end + self._options.pause:
            return None
        return self._next(now)

    def _hangs(self, commanded: Array) -> bool:
        """Return whether the lame foot is over the ground, though it is planned to be down."""
        if self._fault.kind == 'free':
            # A leg that has given way is off its command because it bore.
            return False
        measured = commanded.copy()
        measured[self._leg, self._fault.joint % 3] = self._fault.measured
        robot, leg = self._robot, self._leg
        rise = robot.foot_positions(measured)[leg, 2] - robot.foot_positions(commanded)[leg, 2]
        return bool(rise > self._scale * self._options.press)

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
            self.prediction = 'the leg still bears load'
            return
        carries = self._standing & self._sound
        if np.count_nonzero(carries) < 2:
            carries = self._sound
        margin, angle = tipping(self._robot, self.joint_positions, now.body.rotation[2], carries)
        # A stance that stands by itself is left in peace.
        self._is_lost = self._is_lost and margin < self._wanted
        if margin >= 0.0:
            self.prediction = (
                f'the other feet support the robot without this leg, with a margin of '
                f'{1e3 * margin:.0f} mm'
            )
        else:
            self.prediction = (
                f'the other feet do not support the robot without this leg: the center of mass was '
                f'{-1e3 * margin:.0f} mm outside their support, and the body would tip by '
                f'{np.degrees(angle):.0f} degrees'
            )

    # Motions

    def _catch(self, now: Stance) -> JointTrajectory:
        """Put down what swings; lower the body if a foot that bore has given way."""
        options, robot = self._options, self._robot
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
            put_down = self._lame.put_down(posture, level, ground)
            self._lands = False
            if put_down is not None:
                self.bears, press, lame = True, 0.0, put_down
        target[landing, 2] = ground - press
        if self._is_lost:
            lame = self._lame.helpful(posture)
            crouch = -float(robot.foot_positions(crouching_joint_angles(robot))[:, 2].mean())
            shift[2] = -max(0.0, -ground - crouch)
        elif options.shifts_at_once and not (self.bears and self._standing[self._leg]):
            # A lame leg that is put down may give way: the body is not to rock over it.
            shift[:2] = self._shift_over(posture, level, target)
        body = BodyShift(level, target, shift, lame)
        return self._motions.move(now.time + options.reaction, options.catch_time, body)

    def _settle(self, now: Stance) -> JointTrajectory:
        """Level the body over the sound feet, with its center of mass well inside them."""
        self._tilt_before = tilt_of_body(now)
        level = level_axes(now.body.rotation[2])
        joints = now.joint_positions.copy()
        feet = self._robot.foot_positions(joints) @ level.T
        shift = np.zeros(3)
        shift[:2] = self._shift_over(joints, level, feet)
        time = now.time + self._options.reaction
        lame = self._as_measured(now)[self._leg]
        body = BodyShift(level, feet, shift, lame, levels=True)
        return self._motions.move(time, self._options.settle_time, body)

    def _lift(self, now: Stance) -> JointTrajectory:
        """Lift the lame leg with the joints that it still has."""
        posture = self._as_measured(now)
        end = posture.copy()
        feet = self._robot.foot_positions(now.joint_positions)[self._sound]
        ground = float(feet[:, 2].min()) - self._robot.foot_radius
        end[self._leg] = self._lame.lifted(posture, ground)
        time = now.time + self._options.reaction
        return self._motions.turn(time, self._options.settle_time, end)

    def _sit(self, now: Stance) -> JointTrajectory:
        """Lower the body to the ground."""
        robot = self._robot
        level = level_axes(now.body.rotation[2])
        feet = robot.foot_positions(now.joint_positions) @ level.T
        shift = np.array([0.0, 0.0, float(feet[self._sound, 2].mean()) + robot.body_size[2] / 2.0])
        shift[2] = min(shift[2] + 0.3 * robot.hip_height, 0.0)
        time = now.time + self._options.reaction
        duration = self._options.settle_time
        lame = self._as_measured(now)[self._leg]
        return self._motions.move(time, duration, BodyShift(level, feet, shift, lame))

    def _as_measured(self, now: Stance) -> Array:
        """Return the commanded posture, with the lame leg where it is, within its range."""
        posture, robot, leg = self.joint_positions.copy(), self._robot, self._leg
        posture[leg] = np.clip(now.joint_positions[leg], robot.lower[leg], robot.upper[leg])
        return posture

    # How to do it

    def _shift_over(self, joints: Array, level: Array, feet: Array) -> Array:
        """Return the shift that brings the center of mass well inside the sound feet, (2,) [m]."""
        center = (level @ self._robot.center_of_mass(joints))[:2]
        triangle = feet[self._sound, :2]
        shift: Array = balanced(center, triangle, self._scale * self._options.margin) - center
        return shift
