"""
Imports a robot: from a description to everything that a gait needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.description.poses import inverse, moved
from quad_common.description.reading import read_description
from quad_common.description.tree import KinematicTree
from quad_common.errors import JointFiguresMissing, LegNotFeasible
from quad_common.importing.any_axes import in_window, serial_leg_of
from quad_common.importing.body_frame import body_frame, corners
from quad_common.importing.chains import LegChain, find_legs
from quad_common.importing.feet import Foot, find_foot
from quad_common.importing.leg_axes import LegAxes, leg_axes
from quad_common.importing.leg_geometry import LegAtZero, leg_geometry
from quad_common.importing.masses import Parts, exact_masses, find_parts
from quad_common.importing.missing_meshes import leave_out_missing
from quad_common.importing.options import ImportOptions, Notes, file_name
from quad_common.importing.ranges import RangedLeg, with_ranges
from quad_common.importing.sizes import Sizes, body_box, link_radii
from quad_common.importing.stance import over_feet, stance
from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.robot_build import JOINTS_PER_LEG, LEGS

Array = NDArray[np.float64]

_SHORTEST = 0.005
"""Length of a link that is too short to walk with [m]."""

_SPEEDS, _EFFORTS = (0.01, 200.0), (1e-3, 1e5)
"""Least and largest speeds [rad/s] and torques [N m]; what is outside stands for none: exporters
write 1000 where nobody said anything."""

_NO_NAMES = ('robot', 'urdf', 'xacro', 'main', 'model', 'description', 'scene')
"""Names of files that name no robot."""


@dataclass(frozen=True, eq=False)
class ImportedRobot:
    """What a description says of a robot, in quadwalk's terms; legs in the order of ``LEGS``."""

    name: str
    """Name of the robot."""
    leg_type: str
    """Build of the legs, one of ``LEG_TYPES``."""
    tree: KinematicTree
    """The description."""
    to_base: Array
    """Takes points of the root link's frame to base_link's, shape (4, 4)."""
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
    velocity: Array
    """Largest speeds of the joints, shape (4, 3) [rad/s]."""
    effort: Array
    """Largest torques of the joints, shape (4, 3) [N m]."""
    initial: Array
    """Initial posture, shape (4, 3) [rad]."""
    foot_radius: float
    """Radius of the feet [m]."""
    notes: Notes
    """What was found and what was assumed, in words."""

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


def import_robot(path: str | Path, options: ImportOptions | None = None) -> ImportedRobot:
    """
    Find out what a gait needs to know of a robot from its description.

    Parameters
    ----------
    path : str or Path
        URDF, xacro or MJCF file.
    options : ImportOptions, optional
        What the description leaves open.

    Returns
    -------
    ImportedRobot
        The robot, and what was found and assumed.

    Raises
    ------
    DescriptionError
        If the file cannot be read, is no quadruped that can be walked, or lacks figures.
    MissingOptionalDependency
        If the packages that read descriptions are not installed.
    """
    options, notes, path = options or ImportOptions(), Notes(), Path(path)
    robot = read_description(path, dict(options.arguments))
    tree = KinematicTree(robot, path)
    chains = find_legs(tree, notes)
    leave_out_missing(tree, chains, notes)
    axes = leg_axes(tree, chains)
    feet = _feet(tree, chains, axes, notes)
    centers = np.array([foot.center for foot in feet])
    to_base, leg_type = body_frame(path, chains, axes, centers, options.forward, notes)
    order = corners(moved(to_base, axes.hips), path)
    chains, feet = [chains[k] for k in order], [feet[k] for k in order]
    at_zero = _at_zero(axes, order, feet, to_base)
    ranged = partial(_ranged_leg, leg_type=leg_type, knees=options.knees, notes=notes, path=path)
    legs = [ranged(leg, chain) for leg, chain in zip(at_zero, chains)]
    parts = find_parts(tree, chains, notes, options.mass)
    masses = exact_masses(parts, [ranged.leg for ranged in legs], to_base)
    foot_radius = float(np.mean([foot.radius for foot in feet]))
    sizes = _sizes(tree, (list(parts.body.links), chains), at_zero, feet, to_base, notes)
    initial = over_feet(legs, masses, stance(legs, sizes, foot_radius, path))
    legs = [in_window(*own, notes) for own in zip(legs, chains, initial)]
    return ImportedRobot(
        name=file_name(options.name) if options.name else _name(path, robot.name),
        leg_type=leg_type,
        tree=tree,
        to_base=to_base,
        chains=tuple(chains),
        legs=tuple(legs),
        feet=tuple(feet),
        parts=parts,
        masses=masses,
        sizes=sizes,
        velocity=_figures(tree, chains, 'speed', options.speed),
        effort=_figures(tree, chains, 'effort', options.effort),
        initial=initial,
        foot_radius=foot_radius,
        notes=notes,
    )


def _feet(tree: KinematicTree, chains: list[LegChain], axes: LegAxes, notes: Notes) -> list[Foot]:
    return [
        find_foot(tree, chain, points[2], directions[2], notes)
        for chain, points, directions in zip(chains, axes.points, axes.directions)
    ]


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


def _name(path: Path, own: object) -> str:
    """Return the file's name, as people call robots; the description's own if that says nothing."""
    stem = path.name.partition('.')[0]
    return file_name(str(own) if stem.lower() in _NO_NAMES and own else stem)


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


def _figures(
    tree: KinematicTree, chains: list[LegChain], figure: str, given: tuple[float, ...]
) -> Array:
    """Return the largest efforts or speeds, shape (4, 3): given ones, or the description's."""
    if given:
        return np.tile(np.broadcast_to(np.array(given, dtype=float), JOINTS_PER_LEG), (4, 1))
    field, unit = ('velocity', 'rad/s') if figure == 'speed' else ('effort', 'N m')
    least, most = _SPEEDS if figure == 'speed' else _EFFORTS
    joints = [joint for chain in chains for joint in chain.joints]
    stated = [getattr(joint, field) for joint in joints]
    missing = [
        (joint.name, own)
        for joint, own in zip(joints, stated)
        if own is None or not least <= own <= most
    ]
    if missing:
        names = tuple(name for name, _ in missing)
        raise JointFiguresMissing(tree.path, figure, unit, names, missing[0][1] or 0.0)
    return np.array(stated, dtype=float).reshape(len(chains), JOINTS_PER_LEG)
