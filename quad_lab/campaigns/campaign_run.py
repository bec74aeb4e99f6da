"""
Runs a campaign: walks that are not there yet, one generation after the other where it tunes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from quad_lab.campaigns.campaign_spec import CampaignSpec
from quad_lab.campaigns.jobs import jobs_of
from quad_lab.campaigns.result_store import ResultStore
from quad_lab.campaigns.tuning import Candidate, Tuned, Tuner
from quad_lab.campaigns.walk_pool import WalkPool
from quad_lab.seeded_walks.walk_task import Job, Result, key_of


class Watcher(Protocol):
    """What is told how a campaign goes on."""

    def begin(self, total: int, known: int) -> None:
        """Take how many walks there are, and how many of them were walked before."""
        ...

    def advance(self, results: list[Result]) -> None:
        """Take walks that were just walked."""
        ...


class Unwatched:
    """Nobody looks."""

    def begin(self, total: int, known: int) -> None:
        """Do nothing."""

    def advance(self, results: list[Result]) -> None:
        """Do nothing."""


@dataclass(frozen=True)
class Outcome:
    """A campaign that has ended."""

    results: tuple[Result, ...]
    """Results of its walks, in the order of the campaign; lost ones are left out."""
    walked: int
    """Number of walks that were walked now; the others were known."""
    tuned: Tuned | None = None
    """What came of the tuning, if there was one."""


def run_campaign(
    spec: CampaignSpec, store: ResultStore, pool: WalkPool, watcher: Watcher | None = None
) -> Outcome:
    """
    Run a campaign to its end.

    Parameters
    ----------
    spec : CampaignSpec
        The campaign.
    store : ResultStore
        What was walked before, and where what is walked goes at once.
    pool : WalkPool
        What computes.
    watcher : Watcher, optional
        What is told how it goes on.

    Returns
    -------
    Outcome
        The same results whatever the pool, and however often it was interrupted before.
    """
    watcher = watcher or Unwatched()
    before = len(store.results)
    if spec.tuning is None:
        jobs = jobs_of(spec)
        watcher.begin(len(jobs), _known(jobs, store))
        results = tuple(_walked(jobs, store, pool, watcher))
        return Outcome(results, len(store.results) - before)
    tuner = Tuner(spec, spec.tuning)
    most = tuner.most_jobs
    watcher.begin(most, 0)
    tuner.take_baseline(_walked(tuner.baseline.jobs, store, pool, watcher))
    everything = list(tuner.baseline.results)
    while (candidates := tuner.ask()) is not None:
        jobs = _of_all(candidates)
        found = {key_of(result.job): result for result in _walked(jobs, store, pool, watcher)}
        everything += found.values()
        tuner.tell(found)
    return Outcome(tuple(everything), len(store.results) - before, tuner.outcome())


def _of_all(candidates: Iterable[Candidate]) -> list[Job]:
    return list({key_of(job): job for candidate in candidates for job in candidate.jobs}.values())


def _known(jobs: Iterable[Job], store: ResultStore) -> int:
    return sum(key_of(job) in store.results for job in jobs)


def _walked(
    jobs: Iterable[Job], store: ResultStore, pool: WalkPool, watcher: Watcher
) -> list[Result]:
    """Walk what is not known, and return all results in order, without lost walks."""
    keys = {key_of(job): job for job in jobs}
    missing = [job for key, job in keys.items() if key not in store.results]
    known = [store.results[key] for key in keys if key in store.results]
    if known:
        watcher.advance(known)
    for results in pool.run(missing):
        store.add(results)
        watcher.advance(results)
    return [store.results[key] for key in keys if key in store.results]
