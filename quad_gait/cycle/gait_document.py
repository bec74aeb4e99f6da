"""
What a gait file says: its keys, their ranges, and the values as fields of a gait.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from quad_common.errors import ParameterError
from quad_common.files.yaml_document import check_keys
from quad_common.quantity import CYCLE_PERIOD, Quantity, list_of

_TIME = Quantity(0.0, CYCLE_PERIOD.upper, 's')
_FRACTION = Quantity(0.0, 1.0)

QUANTITIES = {
    'cycle_period': CYCLE_PERIOD,
    'swing_height': Quantity(1e-4, 5.0, 'm'),
    'support_depth': _FRACTION,
    'sway_start': _TIME,
    'sway_weight': _FRACTION,
    'swings': _TIME,
    'phase_offsets': _FRACTION,
    'duty_factor': _FRACTION,
    'body_progress': _TIME,
}
"""Ranges of a gait file's numbers; of the body's progress it is that of the times."""

KEYS = (*QUANTITIES, 'name', 'footholds', 'swing_path', 'is_static')
"""Keys that a gait file may have."""

_MOST_KNOTS = 100
"""Largest number of knots of the body's progress."""

_LONGEST_NAME = 64
"""Characters of a gait's name."""

Swings = list[tuple[str, float, float]]
"""Leg, liftoff and touchdown [s] of each swing."""


def gait_fields(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """
    Read the fields of a gait.

    Parameters
    ----------
    document : mapping
        What the file holds.
    name : str
        Of the gait, if the file says none.

    Returns
    -------
    dict of str to object
        Values of a gait's fields by their names, without what is left out; the swings are
        tuples of leg, liftoff and touchdown [s], in the order of liftoff.

    Raises
    ------
    ParameterError
        If a key is missing or means nothing, or a value is not of its kind and range.
    """
    check_keys(document, KEYS)
    given: dict[str, Any] = {
        key: QUANTITIES[key].check(key, document[key])
        for key in ('support_depth', 'sway_start')
        if key in document
    }
    period = _required(document, 'cycle_period')
    static = document.get('is_static', True)
    if not isinstance(static, bool):
        raise ParameterError('is_static', static, 'true or false')
    for key in ('footholds', 'swing_path'):
        if key in document:
            given[key] = _text(document, key)
    return {
        'name': _text(document, 'name') if 'name' in document else name[:_LONGEST_NAME],
        'cycle_period': period,
        'swings': sorted(_swings(document, period), key=lambda swing: swing[1]),
        'swing_height': _required(document, 'swing_height'),
        'body_progress': _progress(document.get('body_progress')),
        'sway_weight': _sway_weight(document.get('sway_weight', 0.0)),
        'is_static': static,
        **given,
    }


def _required(document: Mapping[str, Any], key: str) -> float:
    if key not in document:
        raise ParameterError(key, None, 'in a complete gait file, see docs/gaits.md')
    return QUANTITIES[key].check(key, document[key])


def _text(document: Mapping[str, Any], key: str) -> str:
    value = document[key]
    if not isinstance(value, str) or not value.isprintable() or len(value) > _LONGEST_NAME:
        valid = f'a text of up to {_LONGEST_NAME} printable characters'
        raise ParameterError(key, value, valid)
    return value


def _sway_weight(value: object) -> tuple[float, float]:
    """Read one weight for both directions, or one for each."""
    quantity = QUANTITIES['sway_weight']
    if not isinstance(value, list):
        weight = quantity.check('sway_weight', value)
        return weight, weight
    forward, left = quantity.check_each('sway_weight', value, ('forward', 'left'))
    return forward, left


def _progress(value: object) -> tuple[tuple[float, float], ...] | None:
    """Read the knots of the body's progress; None for a body that moves on steadily."""
    if value is None:
        return None
    if not isinstance(value, list) or len(value) > _MOST_KNOTS:
        valid = f'a list of up to {_MOST_KNOTS} pairs, each [time, fraction]'
        raise ParameterError('body_progress', value, valid)
    knots = []
    for index, knot in enumerate(value):
        name = f'body_progress[{index}]'
        time, fraction = list_of(name, knot, ('time', 'fraction'))
        knots.append(
            (
                QUANTITIES['body_progress'].check(f'{name}.time', time),
                _FRACTION.check(f'{name}.fraction', fraction),
            )
        )
    return tuple(knots)


def _swings(document: Mapping[str, Any], period: float) -> Swings:
    """Read the swings as times, or as phase offsets and a duty factor."""
    given = {'swings', 'phase_offsets', 'duty_factor'} & set(document)
    if ('swings' in given) == bool(given - {'swings'}):
        raise ParameterError(
            'gait',
            sorted(given),
            'given its swings as times (swings), or by phase_offsets and duty_factor',
        )
    if 'swings' in document:
        return [
            (leg, *_times(f'swings.{leg}', times))
            for leg, times in _by_leg(document, 'swings').items()
        ]
    duration = (1.0 - _required(document, 'duty_factor')) * period
    if 'phase_offsets' not in document:
        raise ParameterError('phase_offsets', None, 'given beside duty_factor')
    quantity = QUANTITIES['phase_offsets']
    offsets = {
        leg: quantity.check(f'phase_offsets.{leg}', phase)
        for leg, phase in _by_leg(document, 'phase_offsets').items()
    }
    return [(leg, phase * period, phase * period + duration) for leg, phase in offsets.items()]


def _by_leg(document: Mapping[str, Any], key: str) -> dict[str, Any]:
    value = document[key]
    if not isinstance(value, dict):
        raise ParameterError(key, value, 'given for each leg, in a complete gait file')
    return value


def _times(name: str, value: object) -> tuple[float, float]:
    liftoff, touchdown = QUANTITIES['swings'].check_each(name, value, ('liftoff', 'touchdown'))
    return liftoff, touchdown
