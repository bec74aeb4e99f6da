"""
Sums up the walks of a campaign: successes with intervals by what varied, and what failed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from quad_lab.campaigns.campaign_run import Outcome
from quad_lab.campaigns.campaign_spec import CampaignSpec, Span
from quad_lab.campaigns.intervals import wilson_interval
from quad_lab.campaigns.tuning import Tuned
from quad_lab.seeded_walks.walk_task import Result, key_of

_BINS = 4
"""Parts of a range that are counted by themselves."""

_MOST_FAILURES = 200
"""Failed walks that are listed."""

_SAID = ('duration', 'speed', 'position_error', 'off_plan', 'speed_error', 'tilt_rms',
         'transport_cost')  # fmt: skip
"""Figures whose means and extremes are told."""


@dataclass(frozen=True)
class Group:
    """Walks that have something in common."""

    name: str
    """Name of what varies; empty for all walks."""
    value: str
    """Its value, or range."""
    walks: int
    """Number of walks."""
    succeeded: int
    """Number that arrived without a fall or a contact."""
    arrived: int
    """Number that arrived."""
    fell: int
    """Number that fell."""
    touched: int
    """Number with contacts."""

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the probability that a walk succeeds."""
        return wilson_interval(self.succeeded, self.walks)


@dataclass(frozen=True)
class Failure:
    """A walk that failed."""

    seed: int
    """Seed of the walk."""
    key: str
    """Key of its result."""
    case: str
    """What varied."""
    problem: str
    """Reason, contacts included."""


@dataclass(frozen=True)
class Summary:
    """A campaign in figures."""

    spec: CampaignSpec
    """The campaign."""
    groups: tuple[Group, ...]
    """All walks, then those of each value of what varies."""
    figures: tuple[tuple[str, float, float, float, float], ...]
    """Name, mean, least, median and largest of figures that were measured."""
    failures: tuple[Failure, ...]
    """Walks that failed."""
    computed: float
    """Time that the walks took to compute, all together [s]."""
    tuned: Tuned | None = None
    """What came of a tuning."""

    def as_dict(self) -> dict[str, Any]:
        """Return it as values of JSON."""
        names = ('name', 'mean', 'least', 'median', 'largest')
        return {
            'name': self.spec.name,
            'groups': [{**asdict(group), 'interval': group.interval} for group in self.groups],
            'figures': [dict(zip(names, row)) for row in self.figures],
            'failures': [asdict(failure) for failure in self.failures],
            'computed': self.computed,
            'tuned': None if self.tuned is None else _finite(asdict(self.tuned)),
        }


def summarise(spec: CampaignSpec, outcome: Outcome) -> Summary:
    """
    Sum up a campaign.

    Parameters
    ----------
    spec : CampaignSpec
        The campaign.
    outcome : Outcome
        Its walks.

    Returns
    -------
    Summary
        The same for the same walks.
    """
    results = outcome.results
    groups = [_group('', 'all', results)] + [
        _group(name, text, [result for result in results if belongs(result)])
        for name, values in spec.vary.items()
        for text, belongs in _parts(name, values)
    ]
    return Summary(
        spec,
        tuple(groups),
        tuple(row for name in _SAID if (row := _row(name, results)) is not None),
        tuple(_failure(spec, result) for result in results if not result.figures.succeeded),
        sum(result.seconds for result in results),
        outcome.tuned,
    )


def markdown(summary: Summary) -> str:
    """Write a summary as Markdown: tables of groups and figures, and every failed walk."""
    spec = summary.spec
    lines = [f'# {spec.name}', '', spec.description, ''] if spec.description else []
    lines = lines or [f'# {spec.name}', '']
    lines += [
        '| what varies | value | walks | succeeded | 95 % interval | arrived | fell | contacts |',
        '| --- | --- | --- | --- | --- | --- | --- | --- |',
    ]
    for group in summary.groups:
        low, high = group.interval
        name = f'`{group.name}`' if group.name else ''
        lines.append(
            f'| {name} | {group.value} | {group.walks} | {group.succeeded} | '
            f'{100.0 * low:.2f} to {100.0 * high:.2f} % | {group.arrived} | {group.fell} | '
            f'{group.touched} |'
        )
    lines += ['', '| figure | mean | least | median | largest |', '| --- | --- | --- | --- | --- |']
    for name, *values in summary.figures:
        lines.append(f'| `{name}` | ' + ' | '.join(f'{value:.4g}' for value in values) + ' |')
    if summary.tuned is not None:
        lines += ['', *_tuned_lines(summary.tuned)]
    else:
        lines += ['', *_failure_lines(summary.failures)]
    return '\n'.join(lines) + '\n'


def _tuned_lines(tuned: Tuned) -> list[str]:
    lines = ['| number | derived | tuned |', '| --- | --- | --- |']
    for name, value in tuned.numbers.items():
        before = tuned.before[name]
        said = f'{before:.4g}' if math.isfinite(before) else ''
        lines.append(f'| `{name}` | {said} | {value:.4g} |')
    lines += ['', '| figure | derived | tuned | change |', '| --- | --- | --- | --- |']
    for name, (before, after) in tuned.figures.items():
        change = f'{100.0 * (after / before - 1.0):+.1f} %' if before else ''
        lines.append(f'| `{name}` | {before:.4g} | {after:.4g} | {change} |')
    lines.append(f'| weighted | 1 | {tuned.cost:.4g} | {100.0 * (tuned.cost - 1.0):+.1f} % |')
    return lines


def _failure_lines(failures: tuple[Failure, ...]) -> list[str]:
    if not failures:
        return ['No walk failed.']
    lines = ['| seed | walk | problem |', '| --- | --- | --- |']
    lines += [f'| {one.seed} | {one.case} | {one.problem} |' for one in failures[:_MOST_FAILURES]]
    if len(failures) > _MOST_FAILURES:
        lines.append(f'| | and {len(failures) - _MOST_FAILURES} more | |')
    return lines


def _parts(
    name: str, values: tuple[Any, ...] | Span
) -> Iterable[tuple[str, Callable[[Result], bool]]]:
    """Return the values of what varies, or parts of its range, each with what belongs to it."""
    if isinstance(values, Span) and values.steps:
        values = values.values
    if not isinstance(values, Span):
        return [(_text(value), _is(name, value)) for value in values]
    edges = np.linspace(values.lower, values.upper, _BINS + 1).tolist()
    return [
        (f'{low:.4g} to {high:.4g}', _is_within(name, low, high, high == edges[-1]))
        for low, high in pairwise(edges)
    ]


def _is(name: str, value: object) -> Callable[[Result], bool]:
    return lambda result: result.job.case[name] == value


def _is_within(name: str, low: float, high: float, is_last: bool) -> Callable[[Result], bool]:
    def belongs(result: Result) -> bool:
        value = float(result.job.case[name])  # type: ignore[arg-type]
        return low <= value < high or (is_last and value == high)

    return belongs


def _group(name: str, value: str, results: Iterable[Result]) -> Group:
    figures = [result.figures for result in results]
    return Group(
        name,
        value,
        walks=len(figures),
        succeeded=sum(one.succeeded for one in figures),
        arrived=sum(one.arrived for one in figures),
        fell=sum(one.has_fallen for one in figures),
        touched=sum(bool(one.contacts) for one in figures),
    )


def _row(name: str, results: Iterable[Result]) -> tuple[str, float, float, float, float] | None:
    values = np.array([getattr(result.figures, name) for result in results], dtype=float)
    values = values[np.isfinite(values)]
    if values.size == 0:
        return None
    return (
        name, float(values.mean()), float(values.min()), float(np.median(values)),
        float(values.max()),
    )  # fmt: skip


def _failure(spec: CampaignSpec, result: Result) -> Failure:
    figures, case = result.figures, result.job.case
    varied = [name for name in case if name in spec.vary]
    said = [figures.problem, figures.contacts and f'contacts: {figures.contacts}']
    if figures.has_fallen:
        said.insert(0, 'it fell')
    return Failure(
        result.job.seed,
        key_of(result.job),
        ', '.join(_text(case[name]) for name in varied),
        '; '.join(filter(None, said)),
    )


def _text(value: object) -> str:
    return f'{value:.4g}' if isinstance(value, float) else str(value)


def _finite(value: Any) -> Any:
    """Return values that JSON has: None for what is not finite."""
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
