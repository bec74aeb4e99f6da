"""
Errors of requests that put robots into a simulation, remove them or ask for them.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors.quoting import quoted
from quad_common.errors.simulation import SimulatorError


@dataclass(eq=False, repr=False)
class EntityNameInvalid(SimulatorError):
    """A robot cannot have that name."""

    name: str
    """Name that was given."""

    def sentence(self) -> str:
        """Say what a name is."""
        return (
            f'{quoted(self.name)} is no name for a robot: it must begin with a letter and have up '
            'to 61 letters, digits and underscores; or set allow_renaming'
        )


@dataclass(eq=False, repr=False)
class EntityNamespaceInvalid(SimulatorError):
    """A robot cannot have that namespace."""

    namespace: str
    """Namespace that was given."""
    name: str
    """Name of the robot; empty for none."""

    def sentence(self) -> str:
        """Say what a namespace is."""
        other = f' or {quoted(self.name)}' if self.name else ''
        return (
            f"{quoted(self.namespace)} cannot be the robot's namespace: a robot's name is its "
            f'namespace here; leave entity_namespace empty, give a name without slashes{other}, '
            'or set allow_renaming'
        )


@dataclass(eq=False, repr=False)
class ResourceMissing(SimulatorError):
    """It is not said which robot is to be spawned."""

    def sentence(self) -> str:
        """Say what to give."""
        return (
            "no robot is given: set uri to a robot's name, or to a file; get_spawnables lists names"
        )


@dataclass(eq=False, repr=False)
class ResourceStringGiven(SimulatorError):
    """A robot is given as the content of a file."""

    def sentence(self) -> str:
        """Say why a file is needed."""
        return (
            "resource_string is not supported: the robot's planner and gait need its file too; "
            'write it to one, and set uri'
        )


@dataclass(eq=False, repr=False)
class ResourcePathUnwritable(SimulatorError):
    """A robot's file has a path that the parameter ``robots`` cannot hold."""

    uri: str
    """URI that was given."""

    def sentence(self) -> str:
        """Say which paths can be held."""
        return (
            f"{quoted(self.uri)} cannot be written into the parameter 'robots': give a path "
            "without ';', ',' and '@', and without spaces at its ends"
        )


@dataclass(eq=False, repr=False)
class ResourceFormatUnknown(SimulatorError):
    """A robot is given in a format that is not read."""

    uri: str
    """URI that was given."""
    suffixes: tuple[str, ...]
    """Suffixes of files that are read."""

    def sentence(self) -> str:
        """Say what is read."""
        return (
            f'{quoted(self.uri)} is no robot that can be read: uri must be a name, a path, file:// '
            f'or package://, and a file must end with {", ".join(self.suffixes)}'
        )


@dataclass(eq=False, repr=False)
class RobotIsAlone(SimulatorError):
    """Robots are to come or go, and the simulation has one robot for good."""

    def sentence(self) -> str:
        """Say how to begin a simulation in which they may."""
        return (
            "this simulation has one robot for good; begin it with the parameter 'robots' to spawn "
            'and delete robots: robots:=none is a world without any'
        )


@dataclass(eq=False, repr=False)
class FilterUnsupported(SimulatorError):
    """Robots are asked for by something that they do not have here."""

    part: str
    """Part of the filter."""

    def sentence(self) -> str:
        """Say what they can be asked for by."""
        return f'filters.{self.part} is not supported; leave it empty, and use filters.filter'


@dataclass(eq=False, repr=False)
class NamePatternInvalid(SimulatorError):
    """A pattern of names cannot be used."""

    pattern: str
    """Pattern that was given."""
    reason: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say what is wrong with it."""
        return f'the pattern {quoted(self.pattern)} cannot be used: {self.reason}'
