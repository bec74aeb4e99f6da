"""
The robot's own shape: a box for the body, a capsule for each link, a ball for each foot.

They are the shapes that :mod:`quad_common.robot.urdf` writes, with round ends in place of a
cylinder's flat ones, so that they hold the URDF's. Links that a joint connects are not
compared: they always touch.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_kinematics import Leg
from quad_common.robot.segment_distance import distance_between_segments, distance_to_box

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Chain = tuple[Array, Array, Array]
"""Pitch axes, knees and feet in the body frame, each of shape (..., 4, 3) [m]."""

LINKS = ('hip', 'thigh', 'calf', 'foot')
"""The parts of a leg, from the body outward."""

BODY = 'base_link'

_FOLDED = (('hip', 'calf'), ('hip', 'foot'), ('thigh', 'foot'))
"""Parts of one leg that may touch when it folds."""

_BESIDE_BODY = ('thigh', 'calf', 'foot')
"""Parts of a leg that are not connected to the body."""


@dataclass(frozen=True)
class PartPair:
    """Two parts of the robot, by their links' names in the URDF."""

    first: str
    """Name of the first link."""
    second: str
    """Name of the second link."""

    def __str__(self) -> str:
        return f'{self.first} and {self.second}'


@dataclass(frozen=True)
class PairGroup:
    """Pairs of parts that are compared together: a leg's, or those of two legs."""

    legs: tuple[int, ...]
    """One leg, or two different ones."""
    with_body: bool
    """Whether one leg's parts are compared with the body."""
    first: Indices
    """Parts, counted leg by leg as :data:`LINKS`, shape (m,)."""
    second: Indices
    """The parts that they are compared with, shape (m,); empty for the body."""
    pairs: tuple[PartPair, ...]
    """Names of the parts, m of them."""


class RobotShape:
    """
    Distances between the parts of a robot, from its joint angles.

    Parameters
    ----------
    legs : Leg
        Four stacked legs.
    body_center, body_size : tuple of float
        Of the body's box, in the body frame [m].
    radii : mapping of str to float
        Of the links :data:`LINKS` [m].
    """

    def __init__(
        self,
        legs: Leg,
        body_center: tuple[float, float, float],
        body_size: tuple[float, float, float],
        radii: Mapping[str, float],
    ) -> None:
        self.legs = legs
        self.body_center = np.array(body_center)
        self.half_size = 0.5 * np.array(body_size)
        self.radii: dict[str, float] = {link: float(radii[link]) for link in LINKS}
        """Radii of a leg's links [m]."""
        self._part_radii = np.tile([self.radii[link] for link in LINKS], len(legs.name))
        self.groups: tuple[PairGroup, ...] = tuple(_groups([str(name) for name in legs.name]))
        """All pairs that are compared: of each leg with the body, of each leg with itself, and
        of each two legs, in this order."""

    @property
    def pairs(self) -> tuple[PartPair, ...]:
        """All pairs, in the order of :meth:`clearances`."""
        return tuple(pair for group in self.groups for pair in group.pairs)

    def segments(self, chain: Chain) -> Array:
        """
        Place the axes of all parts.

        Parameters
        ----------
        chain : tuple of ndarray
            As of :meth:`quad_common.robot.leg_kinematics.Leg.chain`, shapes (..., 4, 3) [m].

        Returns
        -------
        ndarray, shape (..., 16, 2, 3)
            Both ends of each part, leg by leg as :data:`LINKS`; equal for the feet [m].
        """
        pitch_axis, knee, foot = chain
        hip = np.broadcast_to(self.legs.hip, pitch_axis.shape)
        ends = [(hip, pitch_axis), (pitch_axis, knee), (knee, foot), (foot, foot)]
        stacked = np.stack([np.stack(pair, axis=-2) for pair in ends], axis=-3)
        return stacked.reshape(*pitch_axis.shape[:-2], -1, 2, 3)

    def part_ends(self, joint_angles: Array) -> tuple[Array, Array]:
        """
        Place both ends of all parts of the legs.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad]

        Returns
        -------
        ends : ndarray, shape (..., 32, 3)
            In the body frame [m].
        radii : ndarray, shape (32,)
            Of the parts that end there [m].
        """
        segments = self.segments(self.legs.chain(joint_angles))
        ends = segments.reshape(*segments.shape[:-3], -1, 3)
        return ends, np.repeat(self._part_radii, 2)

    def body_corners(self) -> Array:
        """Return the corners of the body's box in the body frame, shape (8, 3) [m]."""
        signs = np.array(list(product((-1.0, 1.0), repeat=3)))
        corners: Array = self.body_center + signs * self.half_size
        return corners

    def clearances(self, joint_angles: Array) -> Array:
        """
        Measure all clearances.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 4, 3)
            [rad]

        Returns
        -------
        ndarray, shape (..., m)
            Distances between the surfaces of the m :attr:`pairs`; negative where they reach
            into each other, though not by how much of the body's box they do [m].
        """
        segments = self.segments(self.legs.chain(joint_angles))
        return np.concatenate([self.group_clearances(g, segments) for g in self.groups], axis=-1)

    def group_clearances(self, group: PairGroup, segments: Array) -> Array:
        """
        Measure the clearances of one group.

        Parameters
        ----------
        group : PairGroup
            One of :attr:`groups`.
        segments : ndarray, shape (..., 16, 2, 3)
            As of :meth:`segments` [m].

        Returns
        -------
        ndarray, shape (..., m)
            [m]
        """
        first = segments[..., group.first, :, :]
        radii = self._part_radii[group.first]
        if group.with_body:
            distances = distance_to_box(first - self.body_center, self.half_size)
        else:
            distances = distance_between_segments(first, segments[..., group.second, :, :])
            radii = radii + self._part_radii[group.second]
        clearances: Array = distances - radii
        return clearances

    def clears_body(self, group: PairGroup, segments: Array, least: Array) -> NDArray[np.bool_]:
        """
        Tell where parts keep a distance from the body's box along one of its axes already.

        Parameters
        ----------
        group : PairGroup
            One of :attr:`groups`; of one without the body nothing is known.
        segments : ndarray, shape (..., 16, 2, 3)
            As of :meth:`segments` [m].
        least : ndarray, shape (m,)
            Distances between the surfaces of its pairs [m].

        Returns
        -------
        ndarray of bool, shape (...)
            True where all of them do; where not all do they may still keep it.
        """
        if not group.with_body:
            return np.zeros(segments.shape[:-3], dtype=np.bool_)
        first = segments[..., group.first, :, :] - self.body_center
        beyond = self.half_size + (least + self._part_radii[group.first])[:, None]
        is_apart = (first.min(axis=-2) > beyond) | (first.max(axis=-2) < -beyond)
        clear: NDArray[np.bool_] = is_apart.any(axis=-1).all(axis=-1)
        return clear


def _groups(names: list[str]) -> list[PairGroup]:
    """List what is compared: each leg with the body, each with itself, each with each other."""

    def parts(leg: int, links: tuple[str, ...]) -> Indices:
        return np.array([len(LINKS) * leg + LINKS.index(link) for link in links])

    groups = []
    for leg, name in enumerate(names):
        pairs = tuple(PartPair(BODY, f'{name}_{link}') for link in _BESIDE_BODY)
        none = np.zeros(0, dtype=np.int64)
        groups.append(PairGroup((leg,), True, parts(leg, _BESIDE_BODY), none, pairs))
    for leg, name in enumerate(names):
        first, second = zip(*_FOLDED)
        pairs = tuple(PartPair(f'{name}_{a}', f'{name}_{b}') for a, b in _FOLDED)
        groups.append(PairGroup((leg,), False, parts(leg, first), parts(leg, second), pairs))
    for a, b in combinations(range(len(names)), 2):
        first, second = zip(*product(LINKS, LINKS))
        pairs = tuple(
            PartPair(f'{names[a]}_{one}', f'{names[b]}_{other}')
            for one, other in zip(first, second)
        )
        groups.append(PairGroup((a, b), False, parts(a, first), parts(b, second), pairs))
    return groups
