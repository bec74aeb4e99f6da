"""
What the nodes have in common: parameters and diagnostics.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.parameter import Parameter as RosParameter

from quad_common.errors import QuadError
from quad_common.errors.quoting import clipped
from quad_common.lifecycle import LifeState, NotActive
from quad_common.log_limit import LogLimit
from quad_common.parameters import checked_parameters, parameters_of
from quad_common.process.spare_memory import SpareMemory
from quad_common.ros.guarded_node import GuardedNode
from quad_common.ros.node_parameters import descriptor, plain_value, real_changes
from quad_common.ros.timing.clock_check import ClockCheck
from quad_common.status import Level, Status

if TYPE_CHECKING:
    from quad_common.ros.managed_life import ManagedLife

Table = TypeVar('Table')

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE

_OF_ROS = ('use_sim_time', 'qos_overrides.', 'start_type_description_service')
"""Parameters that rclpy itself declares."""

_GRACE = 5.0
"""Time in which nodes that start together find one another [s]; nothing is missing yet."""


class QuadNode(GuardedNode, Generic[Table]):
    """
    A node with a table of parameters, a voice on ``diagnostics`` and a net under its callbacks.

    Parameters
    ----------
    name : str
        Name of the node.
    table : type
        Its parameter dataclass (see :mod:`quad_common.parameters`).
    **kwargs
        Passed on to rclpy's Node.
    """

    def __init__(self, name: str, table: type[Table], **kwargs: Any) -> None:
        super().__init__(name, **kwargs)
        given = self._given_values(kwargs.get('parameter_overrides') or [])
        self._life: ManagedLife | None = None
        self.parameters: Table = self._declare(table, given)
        self._diagnostics = self.create_publisher(DiagnosticArray, 'diagnostics', 10)
        self._status = (OK, 'starting')
        self._values: dict[str, object] = {}
        self._said: tuple[bytes, str] | None = None
        self._subject: tuple[bytes, str] | None = None
        self._log_limit = LogLimit()
        self._began = time.monotonic()
        self._has_unlogged_warning = False
        self._last_refusal: dict[str, object] = {}
        self._spare_memory = SpareMemory()
        self.clock_check = ClockCheck(self)
        # On the wall clock: it must speak up just when simulated time stands still.
        self.create_timer(1.0, self._on_second, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def report(
        self, level: bytes, message: str, is_waiting: bool = False, **values: object
    ) -> None:
        """
        Say on ``diagnostics`` what the node does, or why it does not.

        It is published at once when level or message change, and every second; changes
        of more than figures are logged too.

        Parameters
        ----------
        level : bytes
            OK, WARN, ERROR or STALE.
        message : str
            One sentence; of one that is too long, beginning and end are said.
        is_waiting : bool
            Whether it waits for other nodes: while nodes start, that is no warning in the log.
        **values
            Numbers that go with it.
        """
        message = clipped(message)
        self._status = (level, message)
        self._values = values
        if self._said != self._status:
            self._said = self._status
            self._publish_status(level, message)
            subject = level, Status(Level(level[0]), message).subject
            if self._subject != subject:
                self._subject = subject
                self._log(level, message, subject[1], is_waiting)

    def report_status(self, status: Status | QuadError) -> None:
        """Report a status of the core, with what is wrong with the clock, or its error."""
        if isinstance(status, QuadError):
            self.report_error(status)
        else:
            status = status.with_notes(self.clock_check.note())
            level = bytes([status.level])
            self.report(level, status.message, is_waiting=status.is_waiting, **status.values)

    def update_status(self) -> None:
        """Report what is going on; called every second. Nodes override it."""

    def manage(self, on_rest: Callable[[], object]) -> None:
        """
        Begin unconfigured and serve a lifecycle, if the parameter ``managed`` says so.

        Parameters
        ----------
        on_rest : callable
            Is called when the node is active no longer.
        """
        if getattr(self.parameters, 'managed', False):
            # Messages that other nodes need not load.
            from quad_common.ros.managed_life import ManagedLife

            self._life = ManagedLife(self, on_rest, self.update_status)

    def rest_note(self) -> str:
        """Say that the node is managed and not active; empty otherwise."""
        if self._life is None or self._life.state is LifeState.ACTIVE:
            return ''
        return str(NotActive(self.get_name(), self._life.state.label))

    def check_active(self) -> None:
        """Raise NotActive if the node is managed and not active."""
        if self._life is not None and self._life.state is not LifeState.ACTIVE:
            raise NotActive(self.get_name(), self._life.state.label)

    def take_parameters(self, parameters: Table) -> None:
        """
        Go on with other values of the parameters that may be set while the node runs.

        Nodes that have such parameters override it; a QuadError refuses the change.
        """

    def report_error(self, error: QuadError) -> None:
        """Report an error, with its code if it has one; its sentence stays as last_error."""
        code = getattr(error, 'code', None)
        values = {} if code is None else {'error_code': code}
        self._last_refusal = {'last_error': clipped(str(error))}
        self.report(ERROR, str(error), error=type(error).__name__, **values)

    def report_unexpected(self, sentence: str, kind: str, stack: str | None) -> None:
        """Report what should not have happened; its stack is logged once a kind."""
        if stack is not None:
            self.get_logger().error(stack)
        self._last_refusal = {'last_error': clipped(sentence)}
        self.report(ERROR, sentence, error=kind)

    def _on_second(self) -> None:
        self._spare_memory.look()
        self.update_status()
        self._publish_status(*self._status)
        if self._has_unlogged_warning and time.monotonic() - self._began >= _GRACE:
            self._has_unlogged_warning = False
            self.get_logger().warning(self._status[1])

    def _log(self, level: bytes, message: str, subject: str, is_waiting: bool) -> None:
        """Log a message, unless its like was a moment ago: bad input may come in streams."""
        if not self._log_limit.lets(Level(level[0]).name, subject):
            return
        self._has_unlogged_warning = is_waiting and time.monotonic() - self._began < _GRACE
        if level == ERROR:
            self.get_logger().error(message)
        elif level == OK or self._has_unlogged_warning:
            self.get_logger().info(message)
        else:
            self.get_logger().warning(message)

    def _publish_status(self, level: bytes, message: str) -> None:
        left_out = self._lateness.left_out
        late = {'readings_left_out': left_out} if left_out else {}
        status = DiagnosticStatus(
            level=level,
            name=self.get_fully_qualified_name().lstrip('/'),
            message=message,
            hardware_id=str(getattr(self.parameters, 'robot', '')),
            values=[
                KeyValue(key=key, value=clipped(str(value)))
                for key, value in {**self._values, **self._last_refusal, **late}.items()
            ],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(array)

    def _given_values(self, overrides: list[RosParameter]) -> dict[str, object]:
        """Return what the command line, parameter files and the constructor set."""
        with self.handle:
            given = dict(self.handle.get_parameters(RosParameter))
        given.update({parameter.name: parameter for parameter in overrides})
        values = {name: plain_value(parameter) for name, parameter in given.items()}
        # A list without elements in a parameter file arrives as a parameter that is not set.
        return {name: [] if value is None else value for name, value in values.items()}

    def _declare(self, table: type[Table], given: dict[str, object]) -> Table:
        """Declare the parameters with checked values, so that refusals are our sentences."""
        declared = parameters_of(table)
        names = [parameter.name for parameter in declared]
        unknown = sorted(n for n in given if n not in names and not n.startswith(_OF_ROS))
        if unknown:
            self.get_logger().warning(
                f'parameters that mean nothing here are ignored: {", ".join(unknown)}; '
                f'{self.get_name()} has {", ".join(names)}'
            )
        checked = checked_parameters(table, {n: given[n] for n in names if n in given})
        for parameter in declared:
            self.declare_parameter(
                parameter.name,
                getattr(checked, parameter.name),
                descriptor(parameter),
                ignore_override=True,
            )
        if any(parameter.is_dynamic for parameter in declared):
            self.add_on_set_parameters_callback(self._on_set_parameters)
        return checked

    def set_parameters_atomically(self, parameter_list: list[RosParameter]) -> SetParametersResult:
        """
        Set parameters; see rclpy's Node, whose services for parameters call it.

        What has its value already needs no change and is never refused, an integer is taken for
        a float, and a refusal says what would be valid.

        Parameters
        ----------
        parameter_list : list of rclpy.parameter.Parameter
            As rclpy's.

        Returns
        -------
        rcl_interfaces.msg.SetParametersResult
            As rclpy's.
        """
        table = {parameter.name: parameter for parameter in parameters_of(type(self.parameters))}
        declared = [p.name for p in parameter_list if self.has_parameter(p.name)]
        present = {name: self.get_parameter(name) for name in declared}
        try:
            changes = real_changes(parameter_list, table, present)
        except QuadError as error:
            return SetParametersResult(successful=False, reason=clipped(str(error)))
        if parameter_list and not changes:
            return SetParametersResult(successful=True)
        return super().set_parameters_atomically(changes)

    def _on_set_parameters(self, changes: list[RosParameter]) -> SetParametersResult:
        """Check a change of parameters as a whole, and hand it to the node."""
        known = {parameter.name: parameter for parameter in parameters_of(type(self.parameters))}
        try:
            new = {c.name: known[c.name].check(plain_value(c)) for c in changes if c.name in known}
            if new:
                changed = replace(self.parameters, **new)  # type: ignore[type-var]
                self.take_parameters(changed)
                self.parameters = changed
        except QuadError as error:
            return SetParametersResult(successful=False, reason=clipped(str(error)))
        return SetParametersResult(successful=True)
