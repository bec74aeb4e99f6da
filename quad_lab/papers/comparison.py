"""
What a paper says beside what comes out here, and which of both is better.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from matplotlib.figure import Figure

RULES = ('same', 'less', 'more', 'at most', 'at least')
"""How both values compare: see :attr:`Row.rule`."""

VERDICTS = ('better', 'equal', 'worse')
"""What comes out of a comparison."""

UNEXPLAINED = 'not explained'
"""The reason of a row that is worse and has none."""


@dataclass(frozen=True)
class Row:
    """One value of a paper, and the same here."""

    what: str
    """Quantity."""
    there: float | str
    """Value in the paper; for 'at most' and 'at least' the property that its text states."""
    here: float | str | None
    """Value that comes out here; None if it could not be measured."""
    unit: str
    """Unit of both, empty for counts and texts."""
    rule: str
    """One of :data:`RULES`: aim at the paper's value, 'less' or 'more' is better, or a bound."""
    limit: float
    """Difference within which both are equal; the bound for 'at most' and 'at least'."""
    digits: int
    """Number of decimals shown."""
    reason: str = ''
    """Reason why it is worse, or what a reader has to know of it."""

    def because(self, reason: str) -> Row:
        """Return the row with a reason why it is worse, or a remark."""
        return replace(self, reason=reason)

    @property
    def is_stated(self) -> bool:
        """Whether the paper states a property in words, and no value."""
        return self.rule in RULES[3:]

    @property
    def verdict(self) -> str:
        """One of :data:`VERDICTS`; what was not measured is worse."""
        here, there = self.here, self.there
        if here is None:
            return 'worse'
        if self.is_stated and not isinstance(here, str):
            holds = here <= self.limit if self.rule == 'at most' else here >= self.limit
            return 'equal' if holds else 'worse'
        if isinstance(here, str) or isinstance(there, str):
            return 'equal' if here == there else 'worse'
        difference = here - there
        if abs(difference) <= self.limit:
            return 'equal'
        if self.rule == 'same' or (difference < 0.0) != (self.rule == 'less'):
            return 'worse'
        return 'better'

    @property
    def explanation(self) -> str:
        """Why it is worse, never empty then; otherwise a remark, if there is one."""
        if self.verdict != 'worse':
            return self.reason
        if self.here is None:
            return 'not measured'
        return self.reason or UNEXPLAINED

    @property
    def difference(self) -> str:
        """Value here minus value there, as text."""
        if self.here is None:
            return ''
        if self.is_stated:
            return 'holds' if self.verdict == 'equal' else 'does not hold'
        if isinstance(self.here, str) or isinstance(self.there, str):
            return 'none' if self.verdict == 'equal' else 'differs'
        text = shown(self.here - self.there, self.digits)
        return f'+{text}' if float(text) > 0.0 else text

    @property
    def texts(self) -> tuple[str, str]:
        """Values there and here as text, with their unit."""
        here = 'not measured' if self.here is None else self._text(self.here)
        return self._text(self.there), here

    def _text(self, value: float | str) -> str:
        if isinstance(value, str):
            return value
        text = shown(value, self.digits)
        return f'{text} {self.unit}' if self.unit else text


def shown(value: float, digits: int) -> str:
    """Write a number with so many decimals; zero has no sign."""
    return f'{round(value, digits) + 0.0:.{digits}f}'


def same(what: str, there: float, here: float, unit: str, limit: float, digits: int = 1) -> Row:
    """Compare with a value that is to come out again, within a limit."""
    return Row(what, there, _number(here), unit, 'same', limit, digits)


def less(what: str, there: float, here: float, unit: str, digits: int = 1) -> Row:
    """Compare where less is better; equal is what differs by half of the last digit."""
    return Row(what, there, _number(here), unit, 'less', 0.5 * 10.0**-digits, digits)


def more(what: str, there: float, here: float, unit: str, digits: int = 1) -> Row:
    """Compare where more is better; equal is what differs by half of the last digit."""
    return Row(what, there, _number(here), unit, 'more', 0.5 * 10.0**-digits, digits)


def at_most(what: str, stated: str, here: float, unit: str, limit: float, digits: int = 1) -> Row:
    """Measure a property that a text states: a value must not exceed a limit."""
    return Row(what, stated, _number(here), unit, 'at most', limit, digits)


def at_least(what: str, stated: str, here: float, unit: str, limit: float, digits: int = 1) -> Row:
    """Measure a property that a text states: a value must reach a limit."""
    return Row(what, stated, _number(here), unit, 'at least', limit, digits)


def words(what: str, there: str, here: str) -> Row:
    """Compare two texts."""
    return Row(what, there, here, '', 'same', 0.0, 0)


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


@dataclass(frozen=True)
class Exhibit:
    """A figure or a table of a paper."""

    paper: str
    """Key of the paper, S0 to S4."""
    label: str
    """Label in the paper, for example ``Fig. 16``."""
    title: str
    """Title: what it shows."""
    rows: tuple[Row, ...]
    """Comparisons."""
    note: str = ''
    """Remark: what of it is lost, and what was chosen instead."""
    draw: Callable[[Figure], None] | None = field(default=None, compare=False)
    """Function that draws it on an empty figure; None for a table."""

    @property
    def stem(self) -> str:
        """Name of its picture's file, without the ending: ``s0_fig_16``."""
        return f'{self.paper} {self.label}'.lower().replace('.', '').replace(' ', '_')


@dataclass(frozen=True)
class Part:
    """Exhibits that are measured together."""

    paper: str
    """Key of the paper, S0 to S4."""
    name: str
    """Name of what is measured, for progress."""
    measure: Callable[[], list[Exhibit]]
    """Function that measures it: of a module, so that a worker process finds it."""
    needs_physics: bool = False
    """Whether something walks in a simulator, which takes longer than seconds."""
