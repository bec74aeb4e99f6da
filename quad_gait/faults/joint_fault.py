"""
A joint that does not answer: which one, and what is known of it.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.robot.robot_build import JOINTS_PER_LEG, LEGS

_WORDS = {'free': 'does not hold', 'stuck': 'does not move', 'undriven': 'is not driven'}
"""What is said of each kind of fault."""


@dataclass(frozen=True)
class JointFault:
    """One joint that does not answer."""

    joint: int
    """Place of the joint in ``Robot.joint_names``."""
    name: str
    """Name of the joint."""
    kind: str
    """``free``: it does not hold; ``stuck``: it does not move; ``undriven``: it follows its leg,
    and its motor gives no torque."""
    measured: float
    """Angle of the joint [rad]."""
    commanded: float
    """Angle that it was commanded to have [rad]."""
    effort: float | None
    """Torque of its motor [N m]; None if that is not known."""
    time: float
    """Time at which it was noticed [s]."""
    is_slack: bool = False
    """Whether the motor gives next to no torque."""

    @property
    def leg(self) -> int:
        """Place of its leg in ``LEGS``."""
        return self.joint // JOINTS_PER_LEG

    def __str__(self) -> str:
        """Say what is wrong, with the numbers."""
        what = _WORDS[self.kind]
        torque = ''
        if self.effort is not None:
            torque = ', and carries no torque' if self.is_slack else f', with {self.effort:.3g} N m'
        return (
            f'{self.name} of leg {LEGS[self.leg]} {what}: it is at {self.measured:.2f} rad, '
            f'{abs(self.measured - self.commanded):.2f} rad from its command{torque}'
        )
