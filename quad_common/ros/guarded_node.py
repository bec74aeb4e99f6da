"""
A node whose callbacks cannot end it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rosgraph_msgs.msg import Clock

from quad_common.errors import InvalidMessage, QuadError
from quad_common.errors.quoting import clipped, quoted
from quad_common.process.end_signals import shielded
from quad_common.ros.callback_net import CallbackNet
from quad_common.ros.pose_conversions import check_clock
from quad_common.ros.timing.clock_reader import ClockReader
from quad_common.ros.timing.lateness import Lateness, StreamCallback

_LONGEST_WAIT = 0.1
"""Time after which an idle node checks whether it is to end [s]."""

_AFTER_FAILURE = 0.02
"""Pause after something that might fail again at once [s]."""


_MOST_ITEMS = 1000
"""Largest length of a sequence of a request: names, parameters."""

_PARAMETER_TYPES = frozenset(kind.value for kind in Parameter.Type)


class Guarded:
    """
    A callback over a net: what it raises is reported, and ends nothing.

    Parameters
    ----------
    net : CallbackNet
        The node's.
    what : str
        What the callback works on, as the beginning of a sentence.
    callback : callable
        Any callback of rclpy.
    failed : callable, optional
        Makes the result in the callback's place, from a sentence that says why it failed.
    """

    def __init__(
        self,
        net: CallbackNet,
        what: str,
        callback: Callable[..., Any],
        failed: Callable[[str], Any] = lambda sentence: None,
    ) -> None:
        self._net, self._what, self._callback, self._failed = net, what, callback, failed

    def __call__(self, *arguments: Any) -> Any:
        """Call the callback."""
        return self._net.call(self._what, partial(self._callback, *arguments), self._failed)


class GuardedNode(Node):
    """
    A node with a net under everything that it has called.

    Whatever it creates (subscriptions, timers, services, parameter callbacks, rclpy's own
    among them) is `Guarded`: no message, request or parameter ends the node.

    Parameters
    ----------
    name : str
        Name of the node.
    **kwargs
        Passed on to rclpy's Node.
    """

    def __init__(self, name: str, **kwargs: Any) -> None:
        # rclpy's own constructor makes subscriptions and services already.
        self._net = CallbackNet(self)
        self._lateness = Lateness()
        self._clock_reader = ClockReader()
        self._idle: Any = None
        super().__init__(name, **kwargs)
        for service in self.services:
            # rclpy adds the one for descriptions of types behind `create_service`.
            if not isinstance(service.callback, Guarded):
                service.callback = self._guarded_service(
                    service.srv_type, service.srv_name, service.callback
                )

    @property
    def callbacks(self) -> int:
        """Number of callbacks that were called."""
        return self._net.calls

    def report_error(self, error: QuadError) -> None:
        """Report what was refused on purpose."""
        raise NotImplementedError

    def report_unexpected(self, sentence: str, kind: str, stack: str | None) -> None:
        """Report what should not have happened."""
        raise NotImplementedError

    def guarded(self, callback: Callable[..., Any], what: str = 'a callback') -> Guarded:
        """Wrap a callback that rclpy is handed by other means than ``create_...``."""
        return Guarded(self._net, what, callback)

    def call_soon(self, callback: Callable[[], Any]) -> None:
        """Have something called by the executor; from any thread."""
        if self.executor is not None:
            self.executor.create_task(self.guarded(callback, 'a result'))

    def turn(self, executor: Any, drive: Callable[[Any], float] | None = None) -> None:
        """
        Do what is due, or wait a moment for it.

        Parameters
        ----------
        executor : rclpy.executors.Executor
            It has the node.
        drive : callable, optional
            Called with the node first; returns how long it has nothing to do [s].
        """
        wait = _LONGEST_WAIT
        self._lateness.look(self.call_soon)
        if drive is not None:
            wait = self._net.call('a step', partial(drive, self), lambda _: _AFTER_FAILURE)
        if wait <= 0.0 and (self._idle is None or self._idle.done()):
            # An executor with nothing to do sleeps, for 0.1 ms at least, however long it is given.
            self._idle = executor.create_task(_do_nothing)
        # Callbacks are guarded; this is for what rclpy itself raises around them.
        self._net.call(
            'taking what was received',
            lambda: executor.spin_once(timeout_sec=wait),
            lambda _: time.sleep(_AFTER_FAILURE),
        )

    def create_subscription(
        self,
        msg_type: Any,
        topic: str,
        callback: Callable[[Any], None],
        qos_profile: QoSProfile | int,
        *args: Any,
        most_bytes: int | None = None,
        **kwargs: Any,
    ) -> Any:
        """
        Subscribe; see rclpy's Node. The callback is guarded.

        Of what is best effort only the newest counts while the node is late.

        Parameters
        ----------
        msg_type, topic, callback, qos_profile, *args, **kwargs
            As rclpy's.
        most_bytes : int, optional
            Larger messages are refused before they are taken apart, which for a sequence of
            a hundred thousand messages takes rclpy seconds. For types that hold such sequences.

        Returns
        -------
        rclpy.subscription.Subscription
            As rclpy's.
        """
        what = f"message on '{topic}'"
        is_own_clock = ClockReader.is_wanted_for(msg_type, callback)
        if msg_type is Clock:
            # rclpy's own raises, or keeps a time that cannot be written as a stamp.
            callback = partial(_checked_first, check_clock, callback)
        if most_bytes is not None:
            callback = partial(taken_apart, msg_type, what, most_bytes, callback)
        stream = None
        if is_stream(qos_profile) and not is_own_clock:
            callback = stream = StreamCallback(callback, self._lateness)
        guarded = Guarded(self._net, f'a {what}', callback)
        raw = {} if most_bytes is None else {'raw': True}
        subscription = super().create_subscription(
            msg_type, topic, guarded, qos_profile, *args, **raw, **kwargs
        )
        if stream is not None:
            stream.subscription = subscription
        if is_own_clock:
            self._clock_reader.take(subscription)
        return subscription

    def destroy_subscription(self, subscription: Any) -> bool:
        """End a subscription; see rclpy's Node."""
        self._clock_reader.forget(subscription)
        was_there: bool = super().destroy_subscription(subscription)
        return was_there

    @property
    def subscriptions(self) -> Iterator[Any]:
        """Subscriptions that an executor calls: all but that of the node's clock."""
        for subscription in super().subscriptions:
            if not self._clock_reader.is_read(subscription):
                yield subscription

    def get_clock(self) -> Any:
        """Return the node's clock, as far on as ``/clock`` has told."""
        self._clock_reader.read()
        return super().get_clock()

    def create_timer(
        self, timer_period_sec: float, callback: Callable[[], None], *args: Any, **kwargs: Any
    ) -> Any:
        """Make a timer; see rclpy's Node. The callback is guarded."""
        guarded = Guarded(self._net, 'what is done by a timer', callback)
        return super().create_timer(timer_period_sec, guarded, *args, **kwargs)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Callable[..., Any], *args: Any, **kwargs: Any
    ) -> Any:
        """Offer a service; see rclpy's Node. It answers whatever the callback raises."""
        guarded = self._guarded_service(srv_type, srv_name, callback)
        return super().create_service(srv_type, srv_name, guarded, *args, **kwargs)

    def _guarded_service(
        self, srv_type: Any, srv_name: str, callback: Callable[..., Any]
    ) -> Guarded:
        what = f"request to '{srv_name}'"
        callback = partial(_checked_first, partial(_check_request, what), callback)
        return Guarded(self._net, f'a {what}', callback, partial(_refusal, srv_type))

    def create_guard_condition(
        self, callback: Callable[[], None], *args: Any, **kwargs: Any
    ) -> Any:
        """Make a guard condition; see rclpy's Node. The callback is guarded."""
        guarded = Guarded(self._net, 'what a guard condition calls', callback)
        return super().create_guard_condition(guarded, *args, **kwargs)

    def add_on_set_parameters_callback(
        self, callback: Callable[[list[Parameter]], SetParametersResult]
    ) -> None:
        """Have changes of parameters checked; see rclpy's Node. What fails is refused."""
        guarded = Guarded(
            self._net,
            'a change of parameters',
            callback,
            lambda sentence: SetParametersResult(successful=False, reason=sentence),
        )
        super().add_on_set_parameters_callback(guarded)


def _do_nothing() -> None:
    """Give an executor something to do."""


def is_stream(qos: QoSProfile | int) -> bool:
    """Return whether a subscription's messages may be lost, and the newest ones are kept."""
    return (
        isinstance(qos, QoSProfile)
        and qos.reliability == ReliabilityPolicy.BEST_EFFORT
        and qos.history == HistoryPolicy.KEEP_LAST
    )


def _checked_first(
    check: Callable[[Any], None], callback: Callable[..., Any], message: Any, *rest: Any
) -> Any:
    """Hand a message or a request on if the check lets it."""
    check(message)
    return callback(message, *rest)


def _check_request(what: str, request: Any) -> None:
    """Raise InvalidMessage if a request is longer than any has to be, or rclpy would raise."""
    for field in request.get_fields_and_field_types():
        value = getattr(request, field)
        if not isinstance(value, str) and hasattr(value, '__len__') and len(value) > _MOST_ITEMS:
            raise InvalidMessage(what, f'its {field} are {len(value)}; {_MOST_ITEMS} are the most')
    if isinstance(request, (SetParameters.Request, SetParametersAtomically.Request)):
        for parameter in request.parameters:
            if not parameter.name:
                # rclpy takes it, with any value, and shows it to everybody from then on.
                raise InvalidMessage(what, 'a parameter in it has no name')
            if parameter.value.type not in _PARAMETER_TYPES:
                raise InvalidMessage(
                    what,
                    f'the type of {quoted(parameter.name)} is {parameter.value.type}; '
                    f'known are {min(_PARAMETER_TYPES)} to {max(_PARAMETER_TYPES)}',
                )


def taken_apart(
    msg_type: Any, what: str, most_bytes: int, callback: Callable[[Any], None], data: bytes
) -> None:
    """Take a message apart, and hand it on; raise InvalidMessage if it is too long, or none."""
    if len(data) > most_bytes:
        raise InvalidMessage(what, f'it has {len(data)} bytes; {most_bytes} are the most')
    # What a signal raises while the message's object is being made, rclpy turns into a TypeError.
    with shielded():
        try:
            message = deserialize_message(data, msg_type)
        except Exception as error:
            # The middleware's own kind of error, for a message that is cut off or none at all.
            # What is not taken as bytes it drops in silence.
            raise InvalidMessage(what, 'its bytes are no message of its type') from error
    callback(message)


def _refusal(srv_type: Any, sentence: str) -> Any:
    """Make a service's answer that says why there is none, where it has a field for that."""
    response = srv_type.Response()
    refused = SetParametersResult(successful=False, reason=clipped(sentence))
    if srv_type is SetParameters:
        response.results = [refused]
    elif srv_type is SetParametersAtomically:
        response.result = refused
    # simulation_interfaces has its result in a message of its own, whose default says that the
    # service is not supported.
    result: Any = getattr(response, 'result', None)
    if hasattr(result, 'error_message'):
        result.result, result.error_message = result.RESULT_OPERATION_FAILED, clipped(sentence)
    for name, value in (('success', False), ('message', clipped(sentence))):
        if hasattr(response, name):
            setattr(response, name, value)
    return response
