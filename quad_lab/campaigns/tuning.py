"""
Tunes numbers by the covariance matrix adaptation evolution strategy (CMA-ES).

Hansen 2016, "The CMA Evolution Strategy: A Tutorial", in its author's package. A generation is
told as a whole, whatever order its walks come in: so it goes the same on one worker and on many,
and an interrupted one goes on where it was. Ranks alone count: limits that are missed, and falls,
may cost any amount. Numbers are scaled to 0 to 1 over their ranges, and rounded to be read.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from quad_common.errors import MissingOptionalDependency, QuadError
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import load_gait
from quad_lab.campaigns.campaign_spec import CampaignSpec, Tuning
from quad_lab.campaigns.jobs import combinations, seed_of
from quad_lab.seeded_walks.gait_changes import numbers_of
from quad_lab.seeded_walks.walk_settings import WalkSettings
from quad_lab.seeded_walks.walk_task import Job, Result, key_of

_STEP = 0.25
"""First standard deviation of the candidates, of the ranges."""

_DIGITS = 4
"""Significant digits of a candidate's numbers."""

_IDLE = 0.5
"""Where a second coordinate begins that means nothing: the search needs two."""

_MISSED, _FAILED = 10.0, 1000.0
"""What a candidate costs that misses a limit, and one that falls: more than any other."""


@dataclass(eq=False, repr=False)
class BaselineFails(QuadError):
    """What is to be tuned does not walk as it is, or has no figure to better."""

    what: str
    """Walk or figure, and what is wrong with it."""

    def sentence(self) -> str:
        """Say what is wrong."""
        return f'there is nothing to compare candidates with: {self.what}'


@dataclass
class Candidate:
    """Numbers, and the walks with them."""

    numbers: Mapping[str, float]
    """Values by the names of what is tuned."""
    jobs: list[Job]
    """Walks, one for each combination and repetition."""
    results: list[Result] = field(default_factory=list)
    """Results of the walks, in the same order."""
    cost: float = math.inf
    """Weighted mean of the figures over what they are untuned: 1 for no change."""


@dataclass(frozen=True)
class Tuned:
    """What came of a tuning."""

    before: Mapping[str, float]
    """Values of the numbers untuned; nan where the cases differ or they have none."""
    numbers: Mapping[str, float]
    """Values of the best candidate."""
    cost: float
    """Weighted mean of its figures over what they were before."""
    figures: Mapping[str, tuple[float, float]]
    """Means of the figures of the objective and the limits, before and after."""
    history: tuple[tuple[float, ...], ...]
    """Costs of each generation's candidates."""


class Tuner:
    """
    Asks for candidates, generation by generation, until all are told.

    Parameters
    ----------
    spec : CampaignSpec
        The campaign.
    tuning : Tuning
        What is tuned in it.

    Raises
    ------
    MissingOptionalDependency
        If the package cma is not installed.
    """

    def __init__(self, spec: CampaignSpec, tuning: Tuning) -> None:
        try:
            import cma
        except ImportError as error:
            raise MissingOptionalDependency('cma', "pip install 'quadwalk[campaign]'") from error
        self._spec, self._tuning = spec, tuning
        self._names = sorted(tuning.spans)
        self._cases = combinations(spec)
        self.baseline = Candidate({}, self._jobs({}))
        """Nothing changed."""
        self.best = self.baseline
        """The best candidate so far."""
        self._before = _derived(self._cases, self._names)
        options = {
            'seed': spec.seed + 1,  # 0 stands for the clock
            'bounds': [0.0, 1.0],
            'popsize': tuning.population,
            'verbose': -9,
        }
        self._strategy: Any = cma.CMAEvolutionStrategy(self._first(), _STEP, options)
        self._asked: tuple[Any, list[Candidate]] | None = None
        self._history: list[tuple[float, ...]] = []

    @property
    def most_jobs(self) -> int:
        """Number of walks, candidates that come twice counted twice."""
        tuning = self._tuning
        return len(self.baseline.jobs) * (1 + tuning.population * tuning.generations)

    def take_baseline(self, results: list[Result]) -> None:
        """Take the walks with nothing changed; raise BaselineFails if they cannot be bettered."""
        self.baseline.results = results
        for result in results:
            if not result.figures.succeeded:
                said = result.figures.problem or result.figures.contacts or 'it fell'
                raise BaselineFails(f'the walk of seed {result.job.seed} fails untuned: {said}')
            for name in self._tuning.objective:
                value = getattr(result.figures, name)
                if not value > 0.0:
                    raise BaselineFails(f'{name} is {value:g} untuned')
        if len(results) < len(self.baseline.jobs):
            raise BaselineFails('walks were lost with their workers')
        self.baseline.cost = 1.0

    def ask(self) -> list[Candidate] | None:
        """Return the candidates of the next generation; None when all are told."""
        if len(self._history) == self._tuning.generations:
            return None
        drawn = self._strategy.ask()
        candidates = []
        for place in drawn:
            numbers = self._numbers(place)
            candidates.append(Candidate(numbers, self._jobs(numbers)))
        self._asked = drawn, candidates
        return candidates

    def tell(self, results: Mapping[str, Result]) -> None:
        """Take the results of the candidates that were asked for, by their keys."""
        assert self._asked is not None
        drawn, candidates = self._asked
        for candidate in candidates:
            keys = [key_of(job) for job in candidate.jobs]
            candidate.results = [results[key] for key in keys if key in results]
            candidate.cost = self._cost(candidate)
            if candidate.cost < self.best.cost:
                self.best = candidate
        costs = [candidate.cost for candidate in candidates]
        self._strategy.tell(drawn, costs)
        self._history.append(tuple(costs))

    def outcome(self) -> Tuned:
        """Return what came of it."""
        named = dict.fromkeys([*self._tuning.objective, *self._tuning.limits])
        figures = {
            name: (_mean(self.baseline.results, name), _mean(self.best.results, name))
            for name in named
        }
        numbers = self.best.numbers or self._before
        return Tuned(self._before, numbers, self.best.cost, figures, tuple(self._history))

    def _jobs(self, numbers: Mapping[str, float]) -> list[Job]:
        # The same scenes and noise for all candidates: what differs is their numbers.
        return [
            Job(dict(sorted({**case, **numbers}.items())), seed_of(self._spec, case, number))
            for number in range(self._spec.walks)
            for case in self._cases
        ]

    def _first(self) -> list[float]:
        """
        Return where the search begins: as untuned as can be, in units of the ranges.

        In one dimension cma fails where all costs are equal, and at times at a bound: beside a
        single number it gets a coordinate that nothing depends on.
        """
        places = []
        for name in self._names:
            span = self._tuning.spans[name]
            place = (self._before[name] - span.lower) / (span.upper - span.lower)
            places.append(min(max(place, 0.0), 1.0) if math.isfinite(place) else 0.5)
        return places if len(places) > 1 else [*places, _IDLE]

    def _numbers(self, place: Any) -> dict[str, float]:
        numbers = {}
        # Beside a single number there is a coordinate without a name.
        for name, part in zip(self._names, np.asarray(place).tolist()):
            span = self._tuning.spans[name]
            value = float(f'{span.lower + part * (span.upper - span.lower):.{_DIGITS}g}')
            numbers[name] = min(max(value, span.lower), span.upper)
        return numbers

    def _cost(self, candidate: Candidate) -> float:
        pairs = list(zip(candidate.results, self.baseline.results))
        failed = len(candidate.jobs) - sum(one.figures.succeeded for one, _ in pairs)
        if failed:
            return _FAILED * (1.0 + failed)
        excess = 0.0
        for name, limit in self._tuning.limits.items():
            worst = max(getattr(one.figures, name) for one, _ in pairs)
            excess += max(0.0, worst - limit) / max(abs(limit), 1e-9) if worst == worst else 1.0
        if excess > 0.0:
            return _MISSED * (1.0 + min(excess, 10.0))
        weights = self._tuning.objective
        ratios = [
            weight * getattr(one.figures, name) / getattr(base.figures, name)
            for one, base in pairs
            for name, weight in weights.items()
        ]
        cost = sum(ratios) / (len(pairs) * sum(weights.values()))
        return cost if math.isfinite(cost) else _FAILED


def _derived(cases: list[dict[str, Any]], names: list[str]) -> dict[str, float]:
    """Return the numbers untuned, where all cases have the same one; nan elsewhere."""
    default = WalkSettings()
    pairs = {
        (str(case.get('robot', default.robot)), str(case.get('gait', default.gait)))
        for case in cases
    }
    known = []
    for robot, gait in sorted(pairs):
        own = numbers_of(load_gait(gait, load_robot(robot)))
        known.append({f'gait.{name}': value for name, value in own.items()})
    return {
        name: known[0].get(name, math.nan) if len({k.get(name) for k in known}) == 1 else math.nan
        for name in names
    }


def _mean(results: list[Result], name: str) -> float:
    return float(np.mean([getattr(result.figures, name) for result in results]))
