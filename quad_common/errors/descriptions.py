"""
Errors of robots' descriptions (URDF, xacro, MJCF), and of what is found in them.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike

from quad_common.errors.base import QuadError
from quad_common.errors.quoting import clipped, quoted


@dataclass(eq=False, repr=False)
class DescriptionError(QuadError):
    """Base of what is wrong with a robot's description."""

    path: str | PathLike[str]
    """Path of the description."""


@dataclass(eq=False, repr=False)
class DescriptionUnusable(DescriptionError):
    """A description cannot be read."""

    reason: str
    """Reason, as the reader of the format gives it."""

    def sentence(self) -> str:
        """Say what is wrong with the file."""
        return f'{self.path}: {clipped(self.reason)}'


@dataclass(eq=False, repr=False)
class DescriptionEntryInvalid(DescriptionError):
    """A link or a joint of a description is not what it can be."""

    part: str
    """Kind and name of the part, for example ``joint 'FL_hip'``."""
    problem: str
    """Problem of the part."""

    def sentence(self) -> str:
        """Say what is wrong with the part."""
        return f'{self.path}: {clipped(self.part)} {clipped(self.problem)}'


@dataclass(eq=False, repr=False)
class MeshNotFound(DescriptionError):
    """A mesh that a description names is not there."""

    mesh: str
    """Name of the mesh, as the description has it."""

    def sentence(self) -> str:
        """Say which mesh is missing, and where packages are looked for."""
        return (
            f'{self.path}: there is no mesh {quoted(self.mesh)}; packages are looked for around '
            'the file, in ROS_PACKAGE_PATH and in AMENT_PREFIX_PATH'
        )


@dataclass(eq=False, repr=False)
class NotAQuadruped(DescriptionError):
    """A description is not that of a robot with four legs of three joints."""

    found: str
    """Chains of moving joints that were found."""

    def sentence(self) -> str:
        """Say what was found instead."""
        return f'{self.path}: four legs of three joints each are needed; found {self.found}'


@dataclass(eq=False, repr=False)
class LegNotFeasible(DescriptionError):
    """A leg is none that a gait can use."""

    leg: str
    """Name of the leg, or of its first joint."""
    problem: str
    """Problem of the leg."""

    def sentence(self) -> str:
        """Say what is wrong with the leg."""
        return f'{self.path}: leg {self.leg} {self.problem}'


@dataclass(eq=False, repr=False)
class JointFiguresMissing(DescriptionError):
    """A description does not say how strong or how fast joints are."""

    figure: str
    """Figure that is missing: ``effort`` or ``speed``."""
    unit: str
    """Unit of the figure."""
    joints: tuple[str, ...]
    """Names of the joints."""
    stated: float = 0.0
    """Figure that the description has in its place, which no joint can have; 0 without one."""

    def sentence(self) -> str:
        """Say which figure must be given, and how."""
        names = ', '.join(self.joints[:3]) + (' ...' if len(self.joints) > 3 else '')
        instead = '' if self.stated == 0.0 else f', but {self.stated:g} {self.unit}'
        return (
            f'{self.path} has no largest {self.figure} of the joints {names}{instead}; give it to '
            f'quadwalk robot import with --{self.figure} (one number, or three from the body '
            f'outward) [{self.unit}]'
        )


@dataclass(eq=False, repr=False)
class MassesMissing(DescriptionError):
    """A description does not say how heavy parts of the robot are."""

    parts: tuple[str, ...]
    """Names of links that have no mass, nor has what is fixed to them."""
    stated: float
    """Mass that the description states of other parts [kg]."""
    given: float = 0.0
    """Mass of the whole robot that was given, and is too little; 0 if none was [kg]."""
    of_parts: float = 0.0
    """Largest mass that is stated of one of these parts, too small to count; 0 if none is [kg]."""
    least: float = 0.0
    """Least mass of a part [kg]."""

    def sentence(self) -> str:
        """Say which parts have no mass, and how to give the robot's."""
        names = ', '.join(self.parts[:3]) + (' ...' if len(self.parts) > 3 else '')
        missing = f'{self.path} has no mass of {clipped(names)}'
        if self.of_parts:
            missing = (
                f'{self.path} has too small a mass of {clipped(names)}, {self.of_parts:.3g} kg at '
                f'most, where a part needs {self.least:g} kg'
            )
        if self.given:
            return (
                f'{missing}; --mass {self.given:g} leaves too little for them, beside the '
                f'{self.stated:.3g} kg that it states'
            )
        return (
            f"{missing}; give the whole robot's to quadwalk robot import with --mass [kg], and it "
            'is spread by the sizes of shapes'
        )


@dataclass(eq=False, repr=False)
class DescriptionNotCached(QuadError):
    """A description that the package ``robot_descriptions`` knows is not in its cache."""

    name: str
    """Name of the description."""
    folder: str
    """Folder of the cache."""

    def sentence(self) -> str:
        """Say how the description can be fetched."""
        return (
            f'the description {quoted(self.name)} is not in {self.folder}; fetch it with: '
            f'python -m robot_descriptions pull {clipped(self.name)}'
        )


@dataclass(eq=False, repr=False)
class DescriptionPackageUnusable(QuadError):
    """A package of descriptions is damaged, or of a version that is not known."""

    package: str
    """Name of the package."""
    reason: str
    """Error that it raises."""

    def sentence(self) -> str:
        """Say what the package raises."""
        return f'the package {quoted(self.package)} cannot be used: {clipped(self.reason)}'
