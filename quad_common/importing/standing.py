"""
A robot's frame, legs and stance, from its description and its feet.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.description.poses import inverse, moved
from quad_common.description.tree import KinematicTree
from quad_common.errors import LegNotFeasible
from quad_common.importing.any_axes import in_window, serial_leg_of
from quad_common.importing.body_frame import body_frame, corners
from quad_common.importing.chains import LegChain
from quad_common.importing.feet import Foot
from quad_common.importing.leg_axes import LegAxes
from quad_common.importing.leg_geometry import LegAtZero, leg_geometry
from quad_common.importing.masses import Parts, exact_masses
from quad_common.importing.options import ImportOptions, Notes
from quad_common.importing.ranges import RangedLeg, with_ranges
from quad_common.importing.sizes import Sizes, body_box, link_radii
from quad_common.importing.stance import over_feet, stance
from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.robot_build import LEGS

Array = NDArray[np.float64]

_SHORTEST = 0.005
"""Length of a link that is too short to walk with [m]."""


@dataclass(frozen=True, eq=False)
class StandingRobot:
    """A robot in its stance; legs in the order of ``LEGS``."""

    leg_type: str
    """Build of the legs, one of ``LEG_TYPES``."""
    to_base: Array
    """Takes points of the root link's frame to base_link's, shape (4, 4)."""
    order: tuple[int, ...]
    """Indices of the legs in the description's order."""
    chains: tuple[LegChain, ...]
    """Joints of the legs."""
    legs: tuple[RangedLeg, ...]
    """Geometry and ranges of the legs."""
    feet: tuple[Foot, ...]
    """Feet, in the root's frame with all joints at 0."""
    parts: Parts
    """Links and masses of the moving parts."""
    masses: ExactMasses
    """Masses in the axes of the legs."""
    sizes: Sizes
    """Sizes of body and links."""
    initial: Array
    """Initial posture, shape (4, 3) [rad]."""
    foot_radius: float
    """Radius of the feet [m]."""

    @property
    def hip_height(self) -> float:
        """Mean height of the hips above the feet's centers in the initial posture [m]."""
        heights = [
            float((leg.leg.hip - leg.leg.forward(angles))[2])
            for leg, angles in zip(self.legs, self.initial)
        ]
        return float(np.mean(heights))

    @property
    def leg_length(self) -> float:
        """Mean length of the straight legs, from pitch axis to foot [m]."""
        return float(np.mean([leg.leg.thigh_length + leg.leg.calf_length for leg in self.legs]))


def standing_robot(
    tree: KinematicTree,
    legs: tuple[list[LegChain], LegAxes, list[Foot]],
    parts: Parts,
    options: ImportOptions,
    notes: Notes,
) -> StandingRobot:
    """
    Find a robot's frame, the geometry and ranges of its legs, and a stance.

    Parameters
    ----------
    tree : KinematicTree
        The description.
    legs : tuple
        Joints, axes and feet of the legs, in the description's order.
    parts : Parts
        Links and masses of the moving parts, in the same order.
    options : ImportOptions
        What the description leaves open.
    notes : Notes
        What was found and assumed is added to it.

    Raises
    ------
    DescriptionError
        If the legs are none that can be walked with.
    """
    path = tree.path
    chains, axes, feet = legs
    centers = np.array([foot.center for foot in feet])
    to_base, leg_type = body_frame(path, chains, axes, centers, options.forward, notes)
    order = corners(moved(to_base, axes.hips), path)
    chains, feet = [chains[k] for k in order], [feet[k] for k in order]
    parts = replace(parts, legs=tuple(parts.legs[k] for k in order))
    at_zero = _at_zero(axes, order, feet, to_base)
    ranged = [
        _ranged_leg(leg, chain, leg_type, options.knees, notes, path)
        for leg, chain in zip(at_zero, chains)
    ]
    masses = exact_masses(parts, [own.leg for own in ranged], to_base)
    foot_radius = float(np.mean([foot.radius for foot in feet]))
    sizes = _sizes(tree, (list(parts.body.links), chains), at_zero, feet, to_base, notes)
    initial = over_feet(ranged, masses, stance(ranged, sizes, foot_radius, path))
    ranged = [in_window(*own, notes) for own in zip(ranged, chains, initial)]
    return StandingRobot(
        leg_type=leg_type,
        to_base=to_base,
        order=tuple(order),
        chains=tuple(chains),
        legs=tuple(ranged),
        feet=tuple(feet),
        parts=parts,
        masses=masses,
        sizes=sizes,
        initial=initial,
        foot_radius=foot_radius,
    )


def _sizes(
    tree: KinematicTree,
    links: tuple[list[str], list[LegChain]],
    at_zero: list[LegAtZero],
    feet: list[Foot],
    to_base: Array,
    notes: Notes,
) -> Sizes:
    """Measure the body, by its links, and the legs, by theirs."""
    of_body, chains = links
    box = body_box(tree, of_body, to_base, np.array([leg.hip for leg in at_zero]), notes)
    return Sizes(*box, _radii(tree, chains, at_zero, feet, to_base, notes))


def _ranged_leg(
    at_zero: LegAtZero, chain: LegChain, leg_type: str, knees: str, notes: Notes, path: Path
) -> RangedLeg:
    """Find a leg's geometry and ranges; refuse one whose links have no length."""
    if leg_type == 'serial':
        return serial_leg_of(at_zero, chain, knees, notes, path)
    leg = leg_geometry(at_zero, leg_type == 'yaw_pitch_pitch')
    if min(float(leg.thigh_length), float(leg.calf_length)) < _SHORTEST:
        problem = f'has links without length between {chain.joints[1].name} and its foot'
        raise LegNotFeasible(path, str(leg.name), problem)
    return with_ranges(leg, chain, knees, notes)


def _at_zero(axes: LegAxes, order: list[int], feet: list[Foot], to_base: Array) -> list[LegAtZero]:
    hips, points = moved(to_base, axes.hips), moved(to_base, axes.points)
    directions = axes.directions @ to_base[:3, :3].T
    return [
        LegAtZero(
            name=name,
            hip=hips[k],
            axes=directions[k],
            points=points[k],
            foot=moved(to_base, foot.center),
        )
        for name, k, foot in zip(LEGS, order, feet)
    ]


def _radii(
    tree: KinematicTree,
    chains: list[LegChain],
    at_zero: list[LegAtZero],
    feet: list[Foot],
    to_base: Array,
    notes: Notes,
) -> dict[str, float]:
    back = inverse(to_base)
    ends = np.array(
        [[moved(back, np.array(pair)) for pair in _middle_lines(leg)] for leg in at_zero]
    )
    across = np.array([leg.axes[1] for leg in at_zero]) @ to_base[:3, :3]
    foot_links = [foot.link for foot, chain in zip(feet, chains) if foot.link != chain.links[-1]]
    return link_radii(tree, chains, ends, across, foot_links, notes)


def _middle_lines(leg: LegAtZero) -> list[tuple[Array, Array]]:
    """Return both ends of hip, thigh and calf in base_link, all in the plane of the foot [m]."""
    across = leg.axes[1]
    pitch_axis, knee = (
        point + across * float((leg.foot - point) @ across) for point in leg.points[1:]
    )
    return [(leg.hip, pitch_axis), (pitch_axis, knee), (knee, leg.foot)]
