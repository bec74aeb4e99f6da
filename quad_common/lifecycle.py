"""
The life of a managed node, as ROS 2's design has it ("Managed nodes", design.ros2.org).

A node that is managed starts unconfigured, and does its work only while it is active. Whoever
manages it (Nav2's lifecycle manager, ``ros2 lifecycle``) takes it from state to state.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass

from quad_common.errors import QuadError


class LifeState(enum.IntEnum):
    """Primary states, with the numbers of lifecycle_msgs."""

    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3
    FINALIZED = 4

    @property
    def label(self) -> str:
        """Name of the state on topics."""
        return self.name.lower()


@dataclass(frozen=True)
class LifeTransition:
    """One transition, with the number and the label of lifecycle_msgs."""

    number: int
    """Number of the transition."""
    label: str
    """Name of the transition on topics."""
    start: LifeState
    """State in which it may be requested."""
    goal: LifeState
    """State to which it leads."""


TRANSITIONS = (
    LifeTransition(1, 'configure', LifeState.UNCONFIGURED, LifeState.INACTIVE),
    LifeTransition(2, 'cleanup', LifeState.INACTIVE, LifeState.UNCONFIGURED),
    LifeTransition(3, 'activate', LifeState.INACTIVE, LifeState.ACTIVE),
    LifeTransition(4, 'deactivate', LifeState.ACTIVE, LifeState.INACTIVE),
    LifeTransition(5, 'shutdown', LifeState.UNCONFIGURED, LifeState.FINALIZED),
    LifeTransition(6, 'shutdown', LifeState.INACTIVE, LifeState.FINALIZED),
    LifeTransition(7, 'shutdown', LifeState.ACTIVE, LifeState.FINALIZED),
)
"""Every transition that may be requested."""


@dataclass(eq=False, repr=False)
class NotActive(QuadError):
    """Something was wanted of a managed node that is not active."""

    node: str
    """Name of the node."""
    state: str
    """State of the node."""

    def sentence(self) -> str:
        """Say what to do about it."""
        if self.state == LifeState.FINALIZED.label:
            return f'{self.node} is {self.state}: it does nothing any more; start it again'
        return (
            f'{self.node} is {self.state}: as managed is true, it does nothing until its lifecycle '
            f'manager activates it (ros2 lifecycle set /{self.node} configure, then activate)'
        )


class Lifecycle:
    """
    The state of a managed node.

    Parameters
    ----------
    on_rest : callable
        Is called when the node is active no longer.
    """

    def __init__(self, on_rest: Callable[[], object]) -> None:
        self._on_rest = on_rest
        self.state = LifeState.UNCONFIGURED
        """State of the node."""

    @property
    def transitions(self) -> list[LifeTransition]:
        """Transitions that may be requested now."""
        return [transition for transition in TRANSITIONS if transition.start is self.state]

    def change(self, number: int, label: str = '') -> LifeTransition | None:
        """
        Go to another state.

        Parameters
        ----------
        number : int
            Number of the transition.
        label : str
            Its label; where it is given, the number does not count.

        Returns
        -------
        LifeTransition or None
            What was done; None if that cannot be requested now.
        """
        for transition in self.transitions:
            if transition.label == label if label else transition.number == number:
                self.state = transition.goal
                if transition.start is LifeState.ACTIVE:
                    self._on_rest()
                return transition
        return None
