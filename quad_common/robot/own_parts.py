"""
Whether a robot's own parts keep clear of one another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.folding import FoldingLimits
from quad_common.robot.robot_shape import Chain, PairGroup, PartPair, RobotShape
from quad_common.robot.separating_planes import SeparatingPlanes

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_CLEARANCE = 0.005
"""Distance that parts keep on a robot of TITAN-VIII's size: joints follow commands to half a
degree, which is 3 mm at the end of its legs [m]."""

GROUND = 'ground'
"""Word in place of a part's name."""


@dataclass(frozen=True)
class Approach:
    """Two parts at the sample at which they are nearest to each other."""

    pair: PartPair
    """Parts that come near."""
    clearance: float
    """Distance between their surfaces, negative if they reach into each other [m]."""
    least: float
    """Distance that they must keep [m]."""
    sample: int
    """Index of the sample."""

    @property
    def spare(self) -> float:
        """Distance beyond what they must keep, negative if they are too near [m]."""
        return self.clearance - self.least


class OwnParts:
    """
    Tells parts that come too near to one another.

    Pairs that are too near in the initial posture are left out, as the shapes of such a robot
    overlap by construction; :attr:`ignored` names them. Feet may come as near to one another
    as is possible without touching: how they are spaced is for the gait to plan.

    Parameters
    ----------
    shape : RobotShape
        The robot's parts.
    posture : ndarray, shape (4, 3)
        Joint angles of the initial posture [rad].
    lower, upper : ndarray, shape (4, 3)
        Limits of the joints [rad].
    least : float
        Distance that parts must keep, but for two feet [m].
    """

    def __init__(
        self, shape: RobotShape, posture: Array, lower: Array, upper: Array, least: float
    ) -> None:
        self.shape = shape
        self.least = least
        """Distance that parts must keep, but for two feet [m]."""
        self._posture = posture
        folding = FoldingLimits(shape, lower, upper, least)
        self._planes = SeparatingPlanes(shape, posture, folding, least)

    @cached_property
    def ignored(self) -> tuple[PartPair, ...]:
        """Pairs that are too near in the initial posture already."""
        clearances = self.shape.clearances(self._posture)
        return tuple(pair for pair, c in zip(self.shape.pairs, clearances) if c < self.least)

    @cached_property
    def kneels(self) -> bool:
        """Whether knees are too near to the ground in the initial posture already."""
        pitch_axis, knee, foot = self.shape.legs.chain(self._posture[None])
        ground = foot[:, :, 2].mean(axis=1) - self.shape.radii['foot']
        return self._lowest_knee((pitch_axis, knee, foot), ground).spare < 0.0

    def too_near(self, joint_angles: Array, chain: Chain | None = None) -> Approach | None:
        """
        Find the parts that come too near by the most.

        Parameters
        ----------
        joint_angles : ndarray, shape (n, 4, 3)
            [rad]
        chain : tuple of ndarray, optional
            Where these angles place pitch axes, knees and feet, each of shape (n, 4, 3) [m].

        Returns
        -------
        Approach or None
            None if all parts keep their distance.
        """
        if chain is None:
            chain = self.shape.legs.chain(joint_angles)
        doubts = self._planes.doubts(chain, joint_angles)
        worst = min(self._measured(doubts, chain), key=lambda found: found.spare, default=None)
        return worst if worst is not None and worst.spare < 0.0 else None

    def leg_keeps_clear(self, leg: int, joint_angles: Array) -> Mask:
        """
        Tell where a leg keeps clear of the body, and its parts of one another.

        Parameters
        ----------
        leg : int
            Index of the leg.
        joint_angles : ndarray, shape (n, 3)
            Of its joints [rad].

        Returns
        -------
        ndarray of bool, shape (n,)
            Whether they do; the other legs are not looked at.
        """
        angles = np.repeat(self._posture[None], len(joint_angles), axis=0)
        angles[:, leg] = joint_angles
        segments = self.shape.segments(self.shape.legs.chain(angles))
        is_clear = np.ones(len(joint_angles), dtype=bool)
        for group in self.shape.groups:
            if group.legs == (leg,):
                least = np.array([self._least_of(pair) for pair in group.pairs])
                doubts = np.flatnonzero(is_clear & ~self.shape.clears_body(group, segments, least))
                clearances = self.shape.group_clearances(group, segments[doubts])
                is_clear[doubts] = (clearances >= least).all(axis=1)
        return is_clear

    def too_low(self, chain: Chain, ground: Array) -> Approach | None:
        """
        Find the knee that comes nearest to the ground, if it comes too near.

        With its foot on the ground or above it, a shin is clear of the ground if its knee is.

        Parameters
        ----------
        chain : tuple of ndarray
            Pitch axes, knees and feet, each of shape (n, 4, 3) [m].
        ground : ndarray, shape (n,)
            Height of level ground in the body frame [m].

        Returns
        -------
        Approach or None
            None if all knees keep :attr:`least`, or the robot stands on them anyway.
        """
        found = self._lowest_knee(chain, ground)
        return found if found.spare < 0.0 and not self.kneels else None

    def nearest(self, joint_angles: Array) -> Approach:
        """Find the parts with the least to spare, however far apart; shape (n, 4, 3) [rad]."""
        always: Mask = np.ones(len(joint_angles), dtype=bool)
        doubts = [(group, always) for group in self.shape.groups]
        chain = self.shape.legs.chain(joint_angles)
        return min(self._measured(doubts, chain), key=lambda found: found.spare)

    def _measured(self, doubts: list[tuple[PairGroup, Mask]], chain: Chain) -> Iterator[Approach]:
        """Yield the nearest two parts of each group, at the given samples."""
        for group, mask in doubts:
            samples = np.flatnonzero(mask)
            pitch_axis, knee, foot = (points[samples] for points in chain)
            segments = self.shape.segments((pitch_axis, knee, foot))
            clearances = self.shape.group_clearances(group, segments)
            least = np.array([self._least_of(pair) for pair in group.pairs])
            at, which = divmod(int(np.argmin(clearances - least)), len(least))
            clearance = float(clearances[at, which])
            yield Approach(group.pairs[which], clearance, float(least[which]), int(samples[at]))

    def _least_of(self, pair: PartPair) -> float:
        """Return the distance that two parts must keep [m]."""
        if pair in self.ignored:
            return -np.inf
        two_feet = pair.first.endswith('_foot') and pair.second.endswith('_foot')
        return 0.0 if two_feet else self.least

    def _lowest_knee(self, chain: Chain, ground: Array) -> Approach:
        """Find the lowest knee, over ground at heights (n,) in the body frame [m]."""
        radii = self.shape.radii
        heights = chain[1][..., 2] - ground[:, None]
        lowest = int(np.argmin(heights))
        sample, leg = divmod(lowest, heights.shape[1])
        link = 'calf' if radii['calf'] >= radii['thigh'] else 'thigh'
        pair = PartPair(f'{self.shape.legs.name[leg]}_{link}', GROUND)
        return Approach(pair, float(heights.flat[lowest]) - radii[link], self.least, sample)
