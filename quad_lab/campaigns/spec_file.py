"""
Files of campaigns: their keys, their checks, and those that ship.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from quad_common.errors import FileEntryInvalid, ParameterError, QuadError
from quad_common.files.bounded_file import is_file, user_path
from quad_common.files.yaml_document import check_keys, read_yaml
from quad_common.parameters import Value
from quad_common.quantity import Quantity
from quad_common.resources import share_directory
from quad_lab.campaigns.campaign_spec import METHODS, CampaignSpec, Span, Tuning
from quad_lab.campaigns.spec_checks import MOST_WALKS, check_campaign
from quad_lab.seeded_walks.walk_figures import NUMBERS
from quad_lab.seeded_walks.walk_settings import checked_case, checked_value

_WHAT = 'campaign file'

_KEYS = ('name', 'description', 'seed', 'walks', 'method', 'fixed', 'vary', 'tune')

_TUNE_KEYS = ('numbers', 'objective', 'limits', 'population', 'generations')

_SPAN_KEYS = ('from', 'to', 'steps')

_WEIGHT = Quantity(1e-6, 1e6)

_NUMBER = Quantity(-1e9, 1e9)

_MOST_CHOICES = 10_000


def shipped_campaigns() -> tuple[str, ...]:
    """Return the names of the campaigns that ship."""
    return tuple(sorted(path.stem for path in _folder().glob('*.yaml')))


def load_campaign(name: str | Path) -> CampaignSpec:
    """
    Load a campaign by the name of one that ships, or from a YAML file.

    Parameters
    ----------
    name : str or Path
        Name (``reliability``) or path.

    Returns
    -------
    CampaignSpec
        The campaign, checked: its names, ranges, robots, gaits, maps, grounds and engines.

    Raises
    ------
    ParameterError
        If there is no such file.
    FileUnusable, FileEntryInvalid
        If the file cannot be read, or an entry is not valid.
    """
    path = _path(name)
    document = read_yaml(path, _WHAT, 'keys such as walks, fixed and vary')
    try:
        spec = _spec(document, path.stem)
        check_campaign(spec)
    except QuadError as error:
        raise FileEntryInvalid(_WHAT, path, error) from error
    return spec


def _folder() -> Path:
    return share_directory() / 'config' / 'campaigns'


def _path(name: str | Path) -> Path:
    for path in (user_path(name, _WHAT), _folder() / f'{name}.yaml'):
        if is_file(path):
            return path
    raise ParameterError(
        'campaign', str(name), f'the path of a campaign file, or one of '
        f'{", ".join(shipped_campaigns())}',
    )  # fmt: skip


def _spec(document: Mapping[str, Any], name: str) -> CampaignSpec:
    check_keys(document, _KEYS)
    method = document.get('method', 'grid')
    if method not in METHODS:
        raise ParameterError('method', method, f'one of {", ".join(METHODS)}')
    fixed = checked_case(_mapping(document, 'fixed'))
    vary = {
        key: _choices(f'vary.{key}', key, value, method)
        for key, value in _mapping(document, 'vary').items()
    }
    tuning = None if 'tune' not in document else _tuning(_mapping(document, 'tune'))
    if tuning is not None and method != 'grid':
        raise ParameterError('method', method, 'grid where numbers are tuned')
    _check_once(fixed, vary, {} if tuning is None else tuning.spans)
    return CampaignSpec(
        name=_text(document, 'name', name),
        description=_text(document, 'description', ''),
        seed=_whole(document, 'seed', 0, (0, 2**31 - 1)),
        walks=_whole(document, 'walks', 1, (1, MOST_WALKS)),
        method=method,
        fixed=fixed,
        vary=vary,
        tuning=tuning,
    )


def _tuning(document: Mapping[str, Any]) -> Tuning:
    check_keys(document, _TUNE_KEYS, 'tune')
    spans = {}
    for key, value in _mapping(document, 'numbers', 'tune.').items():
        spans[key] = _span(f'tune.numbers.{key}', key, value)
        if spans[key].steps:
            raise ParameterError(f'tune.numbers.{key}.steps', spans[key].steps, 'left out')
    objective = _figures(document, 'objective', _WEIGHT)
    for name, given in (('numbers', spans), ('objective', objective)):
        if not given:
            raise ParameterError(f'tune.{name}', given, 'there, with one entry at least')
    return Tuning(
        spans,
        objective,
        _figures(document, 'limits', _NUMBER),
        _whole(document, 'population', Tuning.population, (4, 1000), 'tune.'),
        _whole(document, 'generations', Tuning.generations, (1, 10_000), 'tune.'),
    )


def _figures(document: Mapping[str, Any], key: str, quantity: Quantity) -> dict[str, float]:
    """Read numbers that belong to figures."""
    given = _mapping(document, key, 'tune.')
    check_keys(given, NUMBERS, f'tune.{key}')
    return {name: quantity.check(f'tune.{key}.{name}', value) for name, value in given.items()}


def _choices(name: str, key: str, value: object, method: str) -> tuple[Value, ...] | Span:
    if isinstance(value, Mapping):
        span = _span(name, key, value)
        if (span.steps == 0) != (method == 'random'):
            valid = 'left out of a campaign at random' if span.steps else 'there in a grid'
            raise ParameterError(f'{name}.steps', span.steps or None, valid)
        return span
    if not isinstance(value, list) or not 0 < len(value) <= _MOST_CHOICES:
        valid = f'a list of 1 to {_MOST_CHOICES} values, or a range with from and to'
        raise ParameterError(name, value, valid)
    values = tuple(checked_value(key, item) for item in value)
    for index, item in enumerate(values):
        if item in values[:index]:
            raise ParameterError(name, item, 'in the list once')
    return values


def _span(name: str, key: str, value: object) -> Span:
    if not isinstance(value, Mapping):
        raise ParameterError(name, value, 'a range with from and to')
    check_keys(value, _SPAN_KEYS, name)
    lower, upper = (checked_value(key, value.get(end)) for end in ('from', 'to'))
    if isinstance(lower, (bool, str, list, int)) or isinstance(upper, (bool, str, list, int)):
        raise ParameterError(name, value, 'a list: only numbers with a fraction have ranges')
    if lower >= upper:
        raise ParameterError(f'{name}.from', lower, f'below to, {upper:g}')
    steps = _whole(value, 'steps', 0, (2, _MOST_CHOICES), f'{name}.') if 'steps' in value else 0
    return Span(lower, upper, steps)


def _mapping(document: Mapping[str, Any], key: str, where: str = '') -> Mapping[str, Any]:
    value = document.get(key, {})
    if not isinstance(value, Mapping):
        raise ParameterError(f'{where}{key}', value, 'a mapping of names to values')
    return value


def _text(document: Mapping[str, Any], key: str, default: str) -> str:
    value = document.get(key, default)
    if not isinstance(value, str) or not value.isprintable() or len(value) > 1000:
        raise ParameterError(key, value, 'a text of up to 1000 printable characters')
    return value


def _whole(
    document: Mapping[str, Any], key: str, default: int, bounds: tuple[int, int], where: str = ''
) -> int:
    value = document.get(key, default)
    if (
        isinstance(value, bool)
        or not isinstance(value, int)
        or not (bounds[0] <= value <= bounds[1])
    ):
        valid = f'a whole number from {bounds[0]} to {bounds[1]}'
        raise ParameterError(f'{where}{key}', value, valid)
    return value


def _check_once(*parts: Mapping[str, object]) -> None:
    seen: set[str] = set()
    for part in parts:
        for name in part:
            if name in seen:
                raise ParameterError(name, name, 'in one of fixed, vary and tune only')
            seen.add(name)
