"""
Codes of answers to requests, those of simulation_interfaces.
"""

from __future__ import annotations

from enum import IntEnum

from quad_common.errors import (
    DescriptionError,
    EntityNameInvalid,
    EntityNamespaceInvalid,
    FileUnusable,
    FilterUnsupported,
    InvalidMessage,
    InvalidPose,
    MeshNotFound,
    ParameterError,
    PlaceTaken,
    QuadError,
    ResourceFormatUnknown,
    ResourceMissing,
    ResourcePathUnwritable,
    ResourceStringGiven,
    RobotIsAlone,
    RobotModelError,
    RobotNameTaken,
    RobotNotFound,
    RobotUnknown,
)


class ResultCode(IntEnum):
    """Codes of ``Result``."""

    FEATURE_UNSUPPORTED = 0
    OK = 1
    NOT_FOUND = 2
    INCORRECT_STATE = 3
    OPERATION_FAILED = 4


class SpawnCode(IntEnum):
    """Codes that ``SpawnEntity`` adds."""

    NAME_NOT_UNIQUE = 101
    NAME_INVALID = 102
    UNSUPPORTED_FORMAT = 103
    NO_RESOURCE = 104
    NAMESPACE_INVALID = 105
    RESOURCE_PARSE_ERROR = 106
    MISSING_ASSETS = 107
    UNSUPPORTED_ASSETS = 108
    INVALID_POSE = 109


class Feature(IntEnum):
    """What the services can do, as ``SimulatorFeatures`` numbers it."""

    SPAWNING = 0
    DELETING = 1
    ENTITY_STATE_GETTING = 10
    SPAWNABLES = 14
    SIMULATION_STATE_GETTING = 24
    SIMULATION_STATE_SETTING = 25
    SIMULATION_STATE_PAUSE = 26


ALREADY_IN_TARGET_STATE = 101
"""Code of ``SetSimulationState``: there is nothing to do."""

# The first that fits: what is more special comes before what it is one of.
_CODES: tuple[tuple[type[QuadError], IntEnum], ...] = (
    (RobotIsAlone, ResultCode.FEATURE_UNSUPPORTED),
    (ResourceStringGiven, ResultCode.FEATURE_UNSUPPORTED),
    (FilterUnsupported, ResultCode.FEATURE_UNSUPPORTED),
    (RobotNotFound, ResultCode.NOT_FOUND),
    (RobotUnknown, ResultCode.NOT_FOUND),
    (RobotNameTaken, SpawnCode.NAME_NOT_UNIQUE),
    (EntityNameInvalid, SpawnCode.NAME_INVALID),
    (EntityNamespaceInvalid, SpawnCode.NAMESPACE_INVALID),
    (ResourceFormatUnknown, SpawnCode.UNSUPPORTED_FORMAT),
    (ResourceMissing, SpawnCode.NO_RESOURCE),
    (ResourcePathUnwritable, SpawnCode.RESOURCE_PARSE_ERROR),
    (MeshNotFound, SpawnCode.MISSING_ASSETS),
    (DescriptionError, SpawnCode.RESOURCE_PARSE_ERROR),
    (RobotModelError, SpawnCode.RESOURCE_PARSE_ERROR),
    (FileUnusable, SpawnCode.RESOURCE_PARSE_ERROR),
    (PlaceTaken, SpawnCode.INVALID_POSE),
    (InvalidPose, SpawnCode.INVALID_POSE),
    (InvalidMessage, SpawnCode.INVALID_POSE),
    (ParameterError, SpawnCode.INVALID_POSE),
)


def code_of(error: QuadError) -> IntEnum:
    """Return the code of an error; that of any other failure if it has none of its own."""
    for kind, code in _CODES:
        if isinstance(error, kind):
            return code
    return ResultCode.OPERATION_FAILED
