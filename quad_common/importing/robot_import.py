"""
Imports a robot: from a description to everything that a gait needs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.description.reading import read_description
from quad_common.description.tree import KinematicTree
from quad_common.errors import DescriptionEntryInvalid, JointFiguresMissing
from quad_common.importing.chains import LegChain, find_legs
from quad_common.importing.feet import Foot, find_foot, foot_on_ground
from quad_common.importing.gaps import leave_out_missing
from quad_common.importing.leg_axes import LegAxes, leg_axes
from quad_common.importing.masses import find_parts
from quad_common.importing.options import ImportOptions, Notes, file_name
from quad_common.importing.standing import StandingRobot, standing_robot
from quad_common.robot.robot_build import JOINTS_PER_LEG, LEGS, LONGEST_PART_NAME

Array = NDArray[np.float64]

_SPEEDS, _EFFORTS = (0.01, 200.0), (1e-3, 1e5)
"""Least and largest speeds [rad/s] and torques [N m]; what is outside stands for none: exporters
write 1000 where nobody said anything."""

_MOST_TURNS = 4.0 * math.pi
"""Range of a joint beyond which its limits are no angles of a leg [rad]."""

_UNLIKE = 0.15
"""Part by which a leg is longer or shorter than most before it is said."""

_NO_NAMES = ('robot', 'urdf', 'xacro', 'main', 'model', 'description', 'scene')
"""Names of files that name no robot."""


@dataclass(frozen=True, eq=False)
class ImportedRobot(StandingRobot):
    """What a description says of a robot, in quadwalk's terms; legs in the order of ``LEGS``."""

    name: str
    """Name of the robot."""
    tree: KinematicTree
    """The description."""
    velocity: Array
    """Largest speeds of the joints, shape (4, 3) [rad/s]."""
    effort: Array
    """Largest torques of the joints, shape (4, 3) [N m]."""
    notes: Notes
    """What was found and what was assumed, in words."""


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
    parts = find_parts(tree, chains, notes, options.mass)
    feet = _feet(tree, chains, axes, notes)
    if any(foot.end is not None for foot in feet):
        # How the end of a leg meets the ground shows in the stance, which takes a foot to find.
        first = standing_robot(tree, (chains, axes, feet), parts, options, Notes())
        feet = _on_ground(tree, feet, axes, first, notes)
    found = standing_robot(tree, (chains, axes, feet), parts, options, notes)
    _check_names(found, path)
    _note_doubts(found, notes)
    return ImportedRobot(
        **vars(found),
        name=file_name(options.name) if options.name else _name(path, robot.name),
        tree=tree,
        velocity=_figures(tree, found.chains, 'speed', options.speed),
        effort=_figures(tree, found.chains, 'effort', options.effort),
        notes=notes,
    )


def _check_names(robot: StandingRobot, path: Path) -> None:
    """Refuse names that a robot's data file cannot have."""
    named = [('joint', joint.name) for chain in robot.chains for joint in chain.joints]
    named += [('link', name) for chain in robot.chains for name in chain.links]
    named += [('link', foot.link) for foot in robot.feet]
    for kind, name in (*named, ('link', robot.parts.body.link)):
        if len(name) > LONGEST_PART_NAME:
            problem = f'has a name of {len(name)} characters; {LONGEST_PART_NAME} are the most'
        elif not name.isprintable():
            problem = 'has a name with a line break, or another character that is not printable'
        else:
            continue
        raise DescriptionEntryInvalid(path, f"{kind} '{name[:LONGEST_PART_NAME]}'", problem)


def _note_doubts(robot: StandingRobot, notes: Notes) -> None:
    """Say what is possible in a description, and more often a slip."""
    for joint in (joint for chain in robot.chains for joint in chain.joints):
        if math.isfinite(joint.upper - joint.lower) and joint.upper - joint.lower > _MOST_TURNS:
            notes.assume(
                f"joint '{joint.name}' has no limits: its description has {joint.lower:g} and "
                f'{joint.upper:g} rad, more than two turns; if these are degrees, correct it'
            )
    lengths = [float(leg.leg.thigh_length + leg.leg.calf_length) for leg in robot.legs]
    usual = float(np.median(lengths))
    odd = int(np.argmax(np.abs(np.array(lengths) - usual)))
    apart = lengths[odd] - usual
    if abs(apart) > _UNLIKE * usual:
        notes.assume(
            f'the leg {LEGS[odd]} is {1e3 * abs(apart):.0f} mm '
            f'{"longer" if apart > 0.0 else "shorter"} than the others, as described'
        )


def _feet(tree: KinematicTree, chains: list[LegChain], axes: LegAxes, notes: Notes) -> list[Foot]:
    return [
        find_foot(tree, chain, points[2], directions[2], notes)
        for chain, points, directions in zip(chains, axes.points, axes.directions)
    ]


def _on_ground(
    tree: KinematicTree, feet: list[Foot], axes: LegAxes, robot: StandingRobot, notes: Notes
) -> list[Foot]:
    """Find the feet again, in the description's order, where a stance is known."""
    found = list(feet)
    downward = -robot.to_base[2, :3]
    for k, chain, initial in zip(robot.order, robot.chains, robot.initial):
        angles = {joint.name: float(angle) for joint, angle in zip(chain.joints, initial)}
        calf = chain.links[-1]
        turned = tree.pose(calf)[:3, :3] @ tree.pose(calf, angles)[:3, :3].T
        knee, axis = axes.points[k, 2], axes.directions[k, 2]
        found[k] = foot_on_ground(feet[k], knee, axis, turned @ downward, notes)
    return found


def _name(path: Path, own: object) -> str:
    """Return the file's name, as people call robots; the description's own if that says nothing."""
    stem = path.name.partition('.')[0]
    return file_name(str(own) if stem.lower() in _NO_NAMES and own else stem)


def _figures(
    tree: KinematicTree, chains: tuple[LegChain, ...], figure: str, given: tuple[float, ...]
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
