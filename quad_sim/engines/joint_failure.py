"""
Joints that fail: what a simulator can let happen to a drive.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors import ParameterError

FAILURES = ('free', 'stuck')
"""
Kinds of failure. A ``free`` motor gives no torque, and the joint has its gear's friction alone;
a ``stuck`` joint keeps the angle it had, whatever is commanded, with its drive's largest torque.
"""

FRICTION_FRACTION = 0.01
"""Friction of a free joint by its drive's largest torque; chosen: a gear gives way."""


@dataclass(frozen=True)
class JointFailure:
    """One joint fails."""

    joint: str
    """Name of the joint."""
    kind: str
    """One of :data:`FAILURES`."""
    time: float = 0.0
    """When, in simulated time; at once if that is over [s]."""

    def __post_init__(self) -> None:
        if self.kind not in FAILURES:
            raise ParameterError('failure', self.kind, f'one of {", ".join(FAILURES)}')
