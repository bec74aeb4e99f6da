"""
The services and the topic by which a node's lifecycle is managed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from lifecycle_msgs.msg import State, Transition, TransitionDescription, TransitionEvent
from lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)

from quad_common.lifecycle import TRANSITIONS, Lifecycle, LifeState, LifeTransition
from quad_common.ros.guarded_node import GuardedNode

_PRIMARY = tuple(LifeState)


class ManagedLife:
    """
    Serves what ``ros2 lifecycle`` and lifecycle managers call.

    Parameters
    ----------
    node : GuardedNode
        The node.
    on_rest : callable
        Is called when the node is active no longer.
    on_change : callable
        Is called when the state has changed.
    """

    def __init__(
        self,
        node: GuardedNode,
        on_rest: Callable[[], object],
        on_change: Callable[[], object],
    ) -> None:
        self._node = node
        self._life = Lifecycle(on_rest)
        self._on_change = on_change
        self._events = node.create_publisher(*_topic('transition_event', TransitionEvent), 10)
        for name, kind, callback in (
            ('change_state', ChangeState, self._change),
            ('get_state', GetState, self._state),
            ('get_available_states', GetAvailableStates, self._states),
            ('get_available_transitions', GetAvailableTransitions, self._transitions),
            ('get_transition_graph', GetAvailableTransitions, self._graph),
        ):
            node.create_service(kind, f'~/{name}', callback)

    @property
    def state(self) -> LifeState:
        """State of the node."""
        return self._life.state

    def _change(self, request: ChangeState.Request, response: ChangeState.Response) -> Any:
        done = self._life.change(request.transition.id, request.transition.label)
        response.success = done is not None
        if done is not None:
            event = TransitionEvent(
                timestamp=self._node.get_clock().now().nanoseconds,
                transition=Transition(id=done.number, label=done.label),
                start_state=_state(done.start),
                goal_state=_state(done.goal),
            )
            self._events.publish(event)
            self._on_change()
        return response

    def _state(self, _: GetState.Request, response: GetState.Response) -> Any:
        response.current_state = _state(self._life.state)
        return response

    def _states(self, _: Any, response: GetAvailableStates.Response) -> Any:
        response.available_states = [_state(state) for state in _PRIMARY]
        return response

    def _transitions(self, _: Any, response: GetAvailableTransitions.Response) -> Any:
        response.available_transitions = [_described(t) for t in self._life.transitions]
        return response

    def _graph(self, _: Any, response: GetAvailableTransitions.Response) -> Any:
        response.available_transitions = [_described(t) for t in TRANSITIONS]
        return response


def _topic(name: str, kind: Any) -> tuple[Any, str]:
    return kind, f'~/{name}'


def _state(state: LifeState) -> State:
    return State(id=int(state), label=state.label)


def _described(transition: LifeTransition) -> TransitionDescription:
    return TransitionDescription(
        transition=Transition(id=transition.number, label=transition.label),
        start_state=_state(transition.start),
        goal_state=_state(transition.goal),
    )
