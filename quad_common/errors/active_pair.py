"""
Errors of planar pairs of legs.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors.base import QuadError

Index = int | tuple[int, ...] | None
"""Index of one of several postures; None where there is one only."""


class ActivePairError(QuadError):
    """A planar pair of legs cannot stand as it was asked to."""


@dataclass(eq=False, repr=False)
class PairCannotClose(ActivePairError):
    """No posture of a pair of legs has what is given: its links are too short, or too long."""

    index: Index
    """Index of the first of several postures that fails; None where there is one only."""
    ends: str
    """Two points between which links are to reach, as the beginning of "... are 1 m apart"."""
    links: str
    """Links that are to reach, with their verb, as the beginning of "... 1 to 2 m"."""
    distance: float
    """Distance between the ends, which is what is needed [m]."""
    reach: tuple[float, float]
    """Least and largest distance that the links reach [m]."""

    def sentence(self) -> str:
        """Say how far the links reach."""
        low, high = self.reach
        # Where rounding would hide by how much, more is shown.
        off = max(low - self.distance, self.distance - high)
        digits = 3 if not 0.0 < off < 2e-3 else 9
        between = f'{low:.{digits}f} to {high:.{digits}f}' if low < high else f'{low:.{digits}f}'
        return (
            f'{_posture(self.index)}{self.ends} are {self.distance:.{digits}f} m apart; '
            f'{self.links} {between} m'
        )


@dataclass(eq=False, repr=False)
class PairUndetermined(ActivePairError):
    """What is given of a pair of legs leaves it free to turn about a point."""

    index: Index
    """Index of the first of several postures that fails; None where there is one only."""
    why: str
    """Points that coincide, as a clause."""

    def sentence(self) -> str:
        """Say what coincides."""
        return f'{_posture(self.index)}the pair may still turn: {self.why}'


@dataclass(eq=False, repr=False)
class BodyOutOfReach(ActivePairError):
    """Legs of given lengths do not carry the body to its place over the feet."""

    index: Index
    """Index of the first of several postures that fails; None where there is one only."""
    x: float
    """Place of the point midway between the hips, along x [m]."""
    reach: tuple[float, float]
    """Places between which the legs carry it, along x [m]."""

    def sentence(self) -> str:
        """Say where the legs carry the body."""
        return (
            f'{_posture(self.index)}the middle of the body would be at x = {self.x:.3f} m; '
            f'the legs carry it from {self.reach[0]:.3f} to {self.reach[1]:.3f} m'
        )


@dataclass(eq=False, repr=False)
class FreeJointPoseNotFound(ActivePairError):
    """No pose of a pair of legs has all joints but one at the given angles."""

    free: str
    """Name of the joint that is free."""
    why: str
    """Reason."""

    def sentence(self) -> str:
        """Say why there is none."""
        return self.why


def _posture(index: Index) -> str:
    return '' if index is None else f'posture {index}: '
