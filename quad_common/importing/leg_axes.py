"""
The axes of the four legs at the zero of all joints, and whether closed formulas hold for them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.description.tree import KinematicTree
from quad_common.importing.chains import LegChain

Array = NDArray[np.float64]

_PARALLEL = 1e-4
"""Deviation from 1 of the cosine between pitch and knee axes."""

_SQUARE = 2e-3
"""Cosine between the first axis and the pitch axis that counts as none."""


@dataclass(frozen=True, eq=False)
class LegAxes:
    """Where the joints of the four legs are, in the root link's frame."""

    directions: Array
    """Unit vectors along the axes, shape (4, 3, 3)."""
    points: Array
    """Origins of the joints, shape (4, 3, 3) [m]."""

    @property
    def hips(self) -> Array:
        """Points of the first axes that are level with the pitch axes, shape (4, 3) [m]."""
        first, along = self.points[:, 0], self.directions[:, 0]
        arms = self.points[:, 1] - first
        hips: Array = first + along * np.sum(arms * along, axis=1, keepdims=True)
        return hips


def leg_axes(tree: KinematicTree, legs: list[LegChain]) -> LegAxes:
    """Find the legs' axes."""
    poses = np.array([[tree.pose(joint.child) for joint in leg.joints] for leg in legs])
    axes = np.array([[joint.axis for joint in leg.joints] for leg in legs])
    directions = np.einsum('ljab,ljb->lja', poses[..., :3, :3], axes)
    return LegAxes(directions, poses[..., :3, 3])


def unlike_formulas(legs: list[LegChain], axes: LegAxes) -> str:
    """
    Say why closed formulas do not hold for the legs; empty if they do.

    They want axes of pitch and knee that are parallel, and at right angles to the first.
    """
    for leg, (first, pitch, knee) in zip(legs, axes.directions):
        names = [joint.name for joint in leg.joints]
        if abs(pitch @ knee) < 1.0 - _PARALLEL:
            angle = np.degrees(np.arccos(min(1.0, abs(float(pitch @ knee)))))
            return f'{names[1]} and {names[2]} turn about axes {angle:.1f} degrees apart'
        if abs(first @ pitch) > _SQUARE:
            angle = np.degrees(np.arccos(min(1.0, abs(float(first @ pitch)))))
            return f'{names[0]} and {names[1]} turn about axes {angle:.1f} degrees apart'
    return ''
