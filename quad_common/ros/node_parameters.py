"""
Parameters as rclpy has them: what a node declares, and which changes of them are any.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.parameter import Parameter as RosParameter

from quad_common.errors import ParameterFixed, ParameterUnknown
from quad_common.parameters import Parameter, valid_range

_NO_LIMIT = 1e308


def plain_value(parameter: RosParameter) -> object:
    """Return a parameter's value, arrays as lists."""
    value = parameter.value
    return list(value) if hasattr(value, '__len__') and not isinstance(value, str) else value


def real_changes(
    given: Iterable[RosParameter],
    table: Mapping[str, Parameter],
    present: Mapping[str, RosParameter],
) -> list[RosParameter]:
    """
    Return what is to be changed, in the types that are declared.

    ``ros2 param load`` sets all that ``ros2 param dump`` wrote, what cannot be changed among it,
    and reads numbers without a point as integers.

    Parameters
    ----------
    given : iterable of rclpy.parameter.Parameter
        The values that are wanted.
    table : mapping of str to Parameter
        The node's own parameters, by name.
    present : mapping of str to rclpy.parameter.Parameter
        All parameters that are declared, by name.

    Returns
    -------
    list of rclpy.parameter.Parameter
        Without those that have their value already.

    Raises
    ------
    ParameterError
        If a value is not valid.
    ParameterUnknown
        If the node has no such parameter.
    ParameterFixed
        If a parameter has another value that cannot be changed while the node runs.
    """
    changes = []
    for wanted in given:
        known = table.get(wanted.name)
        if known is not None:
            wanted = RosParameter(wanted.name, value=known.check(plain_value(wanted)))
        before = present.get(wanted.name)
        if before is None:
            raise ParameterUnknown(wanted.name)
        if _is_same(wanted, before):
            continue
        if known is not None and not known.is_dynamic:
            raise ParameterFixed(wanted.name, plain_value(before))
        changes.append(wanted)
    return changes


def _is_same(a: RosParameter, b: RosParameter) -> bool:
    # rclpy takes a list without elements for one of bytes.
    return plain_value(a) == plain_value(b) and (a.type_ == b.type_ or plain_value(a) == [])


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Describe a parameter for ``ros2 param describe``, whether it is fixed among it."""
    described = ParameterDescriptor(
        description=parameter.description + (f' [{parameter.unit}]' if parameter.unit else ''),
        additional_constraints=valid_range(parameter),
        read_only=not parameter.is_dynamic,
    )
    if isinstance(parameter.default, (bool, str, list)):
        return described
    low = -_NO_LIMIT if parameter.lower is None else parameter.lower
    high = _NO_LIMIT if parameter.upper is None else parameter.upper
    if isinstance(parameter.default, int):
        low, high = max(low, -(2**63)), min(high, 2**63 - 1)
        described.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=0)]
    else:
        described.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=0.0)
        ]
    return described
