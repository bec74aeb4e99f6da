"""
Masses of a robot's moving parts, and the links of which each part consists.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.description.mass import Mass, box_inertia, total
from quad_common.description.poses import inverse, moved
from quad_common.description.shapes import points_of
from quad_common.description.tree import KinematicTree
from quad_common.importing.chains import LegChain
from quad_common.importing.gaps import fill_masses
from quad_common.importing.options import Notes
from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.leg_kinematics import Leg
from quad_common.serial_legs.serial_leg import SerialLeg

Array = NDArray[np.float64]

_SMALLEST = 0.01
"""Least side of the box whose inertia replaces one that no body has [m]."""


@dataclass(frozen=True, eq=False)
class Part:
    """What moves as one: the body, or what moves with one joint."""

    link: str
    """Name of the link that gives the part its name: the heaviest of the body, a joint's child."""
    links: tuple[str, ...]
    """Names of all its links."""
    mass: Mass
    """Mass in the root's frame at the zero of all joints, its inertia possible."""


@dataclass(frozen=True, eq=False)
class Parts:
    """The body and the twelve parts of the legs."""

    body: Part
    """The body, and what it carries."""
    legs: tuple[tuple[Part, ...], ...]
    """Hip, thigh and calf of each leg, the foot with the calf."""


def find_parts(tree: KinematicTree, legs: list[LegChain], notes: Notes, mass: float = 0.0) -> Parts:
    """
    Divide a robot's links into its moving parts.

    Parameters
    ----------
    tree : KinematicTree
        The description.
    legs : list of LegChain
        The four legs; every other joint is held at 0.
    notes : Notes
        Inertias that are replaced are added to it.
    mass : float
        Mass of the whole robot, where the description states none of some parts; 0 if it is not
        known [kg].

    Raises
    ------
    DescriptionError
        If a part has no mass, and the robot's is not given.
    """
    heads = [joint.child for leg in legs for joint in leg.joints]
    members: dict[str, list[str]] = {head: [] for head in (tree.root, *heads)}
    waiting = [(tree.root, tree.root)]
    while waiting:
        link, head = waiting.pop(0)
        head = link if link in heads else head
        members[head].append(link)
        waiting += [(joint.child, head) for joint in tree.children[link]]
    fill_masses(tree, members, mass, notes)
    body = members[tree.root]
    # The first of the heaviest: a frame without mass at the root names nothing.
    trunk = max(body, key=lambda link: tree.mass_of(link).amount)
    replaced: list[str] = []
    parts = Parts(
        body=_part(tree, trunk, body, replaced),
        legs=tuple(
            tuple(_part(tree, link, members[link], replaced) for link in leg.links) for leg in legs
        ),
    )
    if replaced:
        names = ', '.join(replaced[:4]) + (' ...' if len(replaced) > 4 else '')
        notes.assume(
            'inertias that no body can have are replaced by those of boxes around the shapes '
            f'({names})'
        )
    return parts


def _part(tree: KinematicTree, name: str, links: list[str], replaced: list[str]) -> Part:
    masses = [tree.mass_of(link) for link in links]
    mass = total(masses)
    # No part of a robot is as large as all of it.
    extent = max(float(np.linalg.norm(tree.pose(link)[:3, 3])) for link in tree.links)
    if not all(_is_sound(m, extent) for m in masses) or not mass.is_possible:
        replaced.append(name)
        # Each link's own inertia counts; that they are apart is known of their centers.
        mass = total([_replaced(tree, link, m, extent) for link, m in zip(links, masses)])
    return Part(name, tuple(links), mass)


def _is_sound(mass: Mass, extent: float) -> bool:
    """Whether a mass can have its inertia, and lies within an extent [m]."""
    return mass.amount == 0.0 or (mass.is_possible and mass.radius_of_gyration <= extent)


def _replaced(tree: KinematicTree, link: str, mass: Mass, extent: float) -> Mass:
    """Return a mass with a sound inertia: its own, or that of a box around its shapes."""
    if _is_sound(mass, extent):
        return mass
    pose = tree.pose(link)
    places = [
        (moved(inverse(pose), shape.places), shape.radius) for shape in points_of(tree, [link])
    ]
    size = np.full(3, _SMALLEST)
    if places:
        low = np.min([(p - r).min(axis=0) for p, r in places], axis=0)
        high = np.max([(p + r).max(axis=0) for p, r in places], axis=0)
        size = np.maximum(size, high - low)
    turned = pose[:3, :3]
    inertia = turned @ box_inertia(mass.amount, size) @ turned.T
    return Mass(mass.amount, mass.center, inertia)


def exact_masses(parts: Parts, legs: list[Leg], to_base: Array) -> ExactMasses:
    """
    Give masses, centers and inertias in the axes of :class:`ExactMasses`.

    Parameters
    ----------
    parts : Parts
        The robot's parts.
    legs : list of Leg
        Geometry of the legs, in the order of ``parts.legs``.
    to_base : ndarray, shape (4, 4)
        Takes points of the root's frame to base_link's.
    """
    amounts, centers, inertias = np.empty((4, 3)), np.empty((4, 3, 3)), np.empty((4, 3, 3, 3))
    for k, (leg, own) in enumerate(zip(legs, parts.legs)):
        starts, axes = _frames_at_zero(leg)
        for j, part in enumerate(own):
            mass = part.mass.moved(to_base)
            amounts[k, j] = mass.amount
            centers[k, j] = axes[j] @ (mass.center - starts[j])
            inertias[k, j] = axes[j] @ mass.inertia @ axes[j].T
    body = moved(to_base, parts.body.mass.center)
    return ExactMasses(parts.body.mass.amount, body, amounts, centers, inertias)


def _frames_at_zero(leg: Leg) -> tuple[list[Array], list[Array]]:
    """Return where hip, thigh and calf begin, and the rows of their axes, with joints at 0."""
    if isinstance(leg, SerialLeg):
        return list(leg.points), [np.eye(3)] * 3
    first, pitch, bend = (float(zero) for zero in leg.zeros)
    zeta = leg.first_axis
    rho = math.cos(first) * leg.radial_direction + math.sin(first) * leg.lateral_direction
    nu = np.cross(zeta, rho)
    pitch_axis, knee, _ = leg.chain(np.zeros(3))
    axes = [np.array([rho, nu, zeta])]
    for angle in (pitch, pitch + bend):
        along = math.cos(angle) * rho - math.sin(angle) * zeta
        axes.append(np.array([along, nu, np.cross(along, nu)]))
    return [np.asarray(leg.hip), pitch_axis, knee], axes
