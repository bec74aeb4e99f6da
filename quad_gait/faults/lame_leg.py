"""
Postures of a leg of which one joint has failed, by the joints that it still has.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.faults.joint_fault import JointFault

Array = NDArray[np.float64]

_TRIES = 15
"""Number of angles of a joint that are tried over its range."""

_SCRAPE = 0.002
"""Height by which a leg that is lifted may go lower than it is [m]."""

_LANDING_TURN, _LANDINGS = 0.8, 161
"""Largest turn of the sound joint that puts a leg down [rad], and number of turns tried."""

_LANDING_ERROR = 0.01
"""Error of its foot's height with which it counts as put down [m]."""

_FOLDED = 0.85
"""Fraction of the knee's range to which a leg is folded."""


class LameLeg:
    """
    What can be done with the leg.

    Parameters
    ----------
    robot : Robot
        The robot.
    fault : JointFault
        Which joint has failed, and how.
    clearance : float
        Height of the lifted leg over the ground [m].
    """

    def __init__(self, robot: Robot, fault: JointFault, clearance: float) -> None:
        self._robot = robot
        self._fault = fault
        self._scale = robot.relative_size
        self._clearance = clearance

    def put_down(self, joints: Array, level: Array, height: float) -> Array | None:
        """
        Return a posture of the lame leg with its foot at a height, turned by its sound joints.

        Heights are in level axes through base_link [m]; None if the foot does not get there.
        """
        other = 1 if self._fault.joint % 3 == 2 else 2
        now: Array = joints[self._fault.leg]
        if self._fault.joint % 3 == 0:
            # Both other joints: straight down.
            arms = self._robot.foot_positions(joints) @ level.T
            arms[self._fault.leg, 2] = height
            try:
                straight: Array = self._robot.joint_angles(arms @ level)[self._fault.leg]
            except GaitError:
                return None
            straight[0] = now[0]
            return straight
        lower, upper = (
            self._robot.lower[self._fault.leg, other],
            self._robot.upper[self._fault.leg, other],
        )
        tried = np.repeat(now[None], _LANDINGS, axis=0)
        tried[:, other] = np.linspace(
            max(lower, now[other] - _LANDING_TURN),
            min(upper, now[other] + _LANDING_TURN),
            _LANDINGS,
        )
        _, _, feet = self._robot.legs[self._fault.leg].chain(tried)
        off = np.abs((feet @ level.T)[:, 2] - height)
        fits = np.flatnonzero(off <= max(float(off.min()), self._scale * _LANDING_ERROR / 2.0))
        best = int(fits[np.abs(tried[fits, other] - now[other]).argmin()])
        if off[best] > self._scale * _LANDING_ERROR:
            return None
        landed: Array = tried[best]
        return landed

    def helpful(self, joints: Array) -> Array:
        """Return a posture of the lame leg in which its knee may bear, or it is not in the way."""
        joint = self._fault.joint % 3
        angles: Array = joints[self._fault.leg].copy()
        if joint == 0:
            return angles
        lower, upper = self._robot.lower[self._fault.leg], self._robot.upper[self._fault.leg]
        if joint == 1:
            # The leg swings about the hip: fold it.
            angles[2] = _FOLDED * max(lower[2], upper[2], key=abs)
            return angles
        # The thigh points down as far as the crouching body leaves it room.
        room = -float(self._robot.foot_positions(crouching_joint_angles(self._robot))[:, 2].mean())
        tries = []
        for pitch in np.linspace(lower[1], upper[1], 41):
            tried = np.array([angles[0], pitch, angles[2]])
            _, knee, foot = self._robot.legs[self._fault.leg].chain(tried)
            depth = -float(knee[2])
            # The knee may be stuck after all: its foot must not prop up the body.
            if max(depth, -float(foot[2])) <= room:
                tries.append((round(depth, 4), -abs(pitch - angles[1]), pitch))
        angles[1] = max(tries)[2] if tries else angles[1]
        return angles

    def lifted(self, joints: Array, ground: float) -> Array:
        """
        Return a posture of the lame leg that is clear of the ground, whatever its lame joint does.

        The nearest one that can be reached without pressing on the ground; if there is none,
        the leg stays as it is. The ground is given as its height in the body's frame [m].
        """
        joint = self._fault.joint % 3
        now: Array = joints[self._fault.leg]
        lower, upper = self._robot.lower[self._fault.leg], self._robot.upper[self._fault.leg]
        turns = np.linspace(lower, upper, _TRIES).T
        others = [k for k in (1, 2) if k != joint]
        wanted = ground + self._robot.foot_radius + self._clearance
        least = min(self._lowest(now), ground + self._robot.foot_radius)
        postures = []
        for tried in product(*(turns[k] for k in others)):
            end = now.copy()
            end[others] = tried
            if self._lowest(end) < wanted:
                continue
            path = [now + fraction * (end - now) for fraction in (0.25, 0.5, 0.75)]
            if min(map(self._lowest, path)) >= least - self._scale * _SCRAPE:
                postures.append((float(np.abs(end - now).sum()), tuple(end)))
        return np.array(min(postures)[1]) if postures else now

    def _lowest(self, angles: Array) -> float:
        """Return how low a leg reaches in the body's frame, its lame joint being anywhere [m]."""
        joint = self._fault.joint % 3
        leg = self._robot.legs[self._fault.leg]
        lower, upper = self._robot.lower[self._fault.leg], self._robot.upper[self._fault.leg]
        if not self._fault.is_slack or joint == 0:
            may_be = angles[None]
        else:
            may_be = np.repeat(angles[None], _TRIES, axis=0)
            may_be[:, joint] = np.linspace(lower[joint], upper[joint], _TRIES)
        _, knee, foot = leg.chain(may_be)
        # A leg that hangs free comes to rest with its foot low.
        hanging = int(np.argmin(foot[:, 2]))
        return float(min(knee[hanging, 2], foot[hanging, 2]))
