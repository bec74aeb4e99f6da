"""
``quadwalk bench campaign``: the same figures whatever computes them and whatever ends, and costs.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import yaml
from rich.console import Console

from quad_lab.campaigns.campaign_run import run_campaign
from quad_lab.campaigns.campaign_spec import CampaignSpec
from quad_lab.campaigns.jobs import jobs_of
from quad_lab.campaigns.replayed_walk import differing
from quad_lab.campaigns.result_store import ResultStore
from quad_lab.campaigns.spec_file import load_campaign
from quad_lab.campaigns.summary import summarise
from quad_lab.campaigns.walk_pool import DaskPool, InProcess, dask_pool
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_task import Result, run_walk
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure

PARTS = ('same', 'kills', 'costs', 'tuning', 'reliability')
"""Parts for ``--only``."""

_WALKS = {'quick': 2, 'full': 12}
"""Walks of each of the four combinations of the small campaign."""

_TRIALS = {
    'name': 'trials',
    'fixed': {'shortest': 0.2, 'longest': 0.5, 'map': 'random'},
    'vary': {'robot': ['cuhk', 'genibo'], 'gait': ['trot'], 'engine': ['bullet', 'mujoco']},
}
"""A campaign of short walks."""

_WAIT = 300.0
"""Time for a process to have its first results [s]."""

_LEAST_SAVED = 0.2
"""Part of the weighted figures that a tuning is to save."""


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = ()
) -> tuple[list[Criterion], dict[str, Any]]:
    """
    Run campaigns, interrupt them, and compare.

    Parameters
    ----------
    console : Console
        Where progress is shown.
    quick : bool
        A few short walks.
    seed : int
        Of the campaigns.
    only : tuple of str
        Parts to run; all if empty, in a quick sample without tuning and reliability.

    Returns
    -------
    bars : list of Criterion
        What was measured.
    details : dict
        Numbers of walks, and what was tuned.
    """
    parts = only or (PARTS[:3] if quick else PARTS)
    bars: list[Criterion] = []
    details: dict[str, Any] = {}
    with tempfile.TemporaryDirectory(prefix='quadwalk_campaign_') as name:
        folder = Path(name)
        file = folder / 'trials.yaml'
        walks = _WALKS['quick' if quick else 'full']
        file.write_text(yaml.safe_dump({**_TRIALS, 'seed': seed, 'walks': walks}))
        spec = load_campaign(file)
        if {'same', 'kills', 'costs'} & set(parts):
            expected = _figures(run_campaign(spec, ResultStore(folder / 'here'), InProcess()))
            console.print(f'{len(expected)} walks in this process')
            bars += _worker_bars(console, spec, folder, expected, parts, quick)
        if 'kills' in parts:
            bars += _client_bars(console, spec, file, folder, expected)
        if 'tuning' in parts:
            bars += _tuning_bars(console, folder, quick, details)
        if 'reliability' in parts:
            bars += _reliability_bars(console, folder, quick, details)
    return bars, details


def _figures(outcome: Any) -> dict[int, WalkFigures]:
    return {result.job.seed: result.figures for result in outcome.results}


def _different(found: dict[int, WalkFigures], expected: dict[int, WalkFigures]) -> int:
    """Count the walks whose figures are not the same, bit for bit, or that are missing."""
    return sum(
        seed not in found or bool(differing(found[seed], figures))
        for seed, figures in expected.items()
    )


def _worker_bars(
    console: Console,
    spec: CampaignSpec,
    folder: Path,
    expected: dict[int, WalkFigures],
    parts: tuple[str, ...],
    quick: bool,
) -> list[Criterion]:
    """Walk on clusters of several sizes, and kill a worker of one."""
    bars, seconds = [], {}
    for workers in (1, 2, 4):
        with dask_pool(workers=workers) as pool:
            _warm_up(pool, spec)
            began = time.perf_counter()
            store = ResultStore(folder / f'on_{workers}')
            outcome = run_campaign(spec, store, pool)
            seconds[workers] = time.perf_counter() - began
            busy = sum(result.seconds for result in outcome.results)
            off = _different(_figures(outcome), expected)
            console.print(f'{workers} workers: {seconds[workers]:.1f} s, {off} walks differ')
            if 'same' in parts:
                name = f'walks that differ on {workers} worker{"s" if workers > 1 else ""}'
                bars.append(at_most(name, off, f'of {len(expected)}', 0))
            if workers == 1 and 'costs' in parts:
                cost = (seconds[1] - busy) / len(outcome.results)
                bars.append(at_most('overhead for each walk', cost, 's', 0.05))
            if workers == 2 and 'kills' in parts:
                found = _with_a_kill(pool, spec, folder / 'kill')
                off = _different(found, expected)
                name = 'walks that differ or are lost when a worker is killed'
                bars.append(at_most(name, off, f'of {len(expected)}', 0))
    if 'costs' in parts and not quick:
        bars.append(at_least('two workers over one', seconds[1] / seconds[2], 'x', 1.8))
    elif 'costs' in parts:
        bars.append(figure('two workers over one, few walks', seconds[1] / seconds[2], 'x'))
    return bars


def _warm_up(pool: DaskPool, spec: CampaignSpec) -> None:
    """Have every worker import what it needs: what a long campaign does once."""
    jobs = [replace(job, seed=job.seed + 1) for job in jobs_of(spec)[:2]]
    pool.on_every_worker(_walk_all, jobs)


def _walk_all(jobs: list[Any]) -> int:
    return len([run_walk(job) for job in jobs])


def _with_a_kill(pool: DaskPool, spec: CampaignSpec, folder: Path) -> dict[int, WalkFigures]:
    """Walk, and kill the process of a worker after the first results."""
    victim = next(iter(pool.on_every_worker(os.getpid).values()))
    return _figures(run_campaign(spec, ResultStore(folder), pool, _Killer(victim)))


class _Killer:
    """Kills a process when the first results come."""

    def __init__(self, victim: int) -> None:
        self._victims = [victim]

    def begin(self, total: int, known: int) -> None:
        """Do nothing."""

    def advance(self, results: list[Result]) -> None:
        """Kill it, once."""
        while self._victims:
            os.kill(self._victims.pop(), signal.SIGKILL)


def _client_bars(
    console: Console,
    spec: CampaignSpec,
    file: Path,
    folder: Path,
    expected: dict[int, WalkFigures],
) -> list[Criterion]:
    """Kill the command in the middle, and go on."""
    output = folder / 'killed'
    command = [sys.executable, '-m', 'quad_cli', 'campaign', str(file), '--output', str(output)]
    process = subprocess.Popen(
        [*command, '--workers', '1'], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        first = _first_results(process, output / 'results', len(expected) // 4)
    finally:
        process.kill()
        process.wait()
    store = ResultStore(output / 'results')
    known = len(store.results)
    outcome = run_campaign(spec, store, InProcess())
    off = _different(_figures(outcome), expected)
    console.print(f'killed after {first} results; {known} were kept, {outcome.walked} walked')
    replayed = outcome.results[-1]
    again = differing(run_walk(replayed.job).figures, replayed.figures)
    return [
        at_least('results kept when the command is killed', known, '', max(first, 1)),
        at_most('walks walked again after it', outcome.walked + known - len(expected), '', 0),
        at_most('walks that differ after it', off, f'of {len(expected)}', 0),
        at_most('figures that differ when a walk is replayed', len(again), '', 0),
    ]


def _first_results(process: subprocess.Popen[bytes], folder: Path, wanted: int) -> int:
    """Wait for the first files of results; return their number."""
    deadline = time.monotonic() + _WAIT
    while time.monotonic() < deadline and process.poll() is None:
        count = len(list(folder.glob('*.parquet')))
        if count >= wanted:
            return count
        time.sleep(0.02)
    return 0


def _tuning_bars(
    console: Console, folder: Path, quick: bool, details: dict[str, Any]
) -> list[Criterion]:
    """Run the tuning that ships."""
    spec = load_campaign('tune_trot')
    assert spec.tuning is not None
    if quick:
        spec = replace(spec, tuning=replace(spec.tuning, population=4, generations=2))
    with dask_pool() as pool:
        outcome = run_campaign(spec, ResultStore(folder / 'tuning'), pool)
    tuned = outcome.tuned
    assert tuned is not None
    details['tuned'] = asdict(tuned)
    for name, value in tuned.numbers.items():
        console.print(f'{name}: {tuned.before[name]:.4g} -> {value:.4g}', highlight=False)
    bars = [
        figure(f'A1 trot: {name}, {when}', value, '')
        for name, pair in tuned.figures.items()
        for when, value in zip(('derived', 'tuned'), pair)
    ]
    saved = 1.0 - tuned.cost
    if quick:
        return [*bars, figure('A1 trot: weighted figures saved, few candidates', saved, '')]
    return [*bars, at_least('A1 trot: weighted figures saved', saved, '', _LEAST_SAVED)]


def _reliability_bars(
    console: Console, folder: Path, quick: bool, details: dict[str, Any]
) -> list[Criterion]:
    """Run the reliability campaign that ships."""
    spec = load_campaign('reliability')
    if quick:
        few = {'map': ('room',), 'gait': ('trot',)}
        spec = replace(spec, walks=1, vary={**spec.vary, **few})
    with dask_pool() as pool:
        outcome = run_campaign(spec, ResultStore(folder / 'reliability'), pool, _Lines(console))
    summary = summarise(spec, outcome)
    details['reliability'] = summary.as_dict()
    total = summary.groups[0]
    low, _ = total.interval
    return [
        at_least(f'goals reached, of {total.walks}', total.arrived, '', total.walks),
        at_most('falls', total.fell, '', 0),
        at_most('walks with contacts', total.touched, '', 0),
        figure('probability of success, at least (95 %)', low, ''),
    ]


class _Lines:
    """Says now and then how many walks are over."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._total = self._done = 0

    def begin(self, total: int, known: int) -> None:
        """Take the number of walks."""
        self._total = total

    def advance(self, results: list[Result]) -> None:
        """Count walks, and name those that failed."""
        before, self._done = self._done, self._done + len(results)
        for result in results:
            if not result.figures.succeeded:
                said = result.figures.problem or result.figures.contacts
                self._console.print(f'failed: seed {result.job.seed}: {said}', highlight=False)
        if before // 50 != self._done // 50:
            self._console.print(f'{self._done} of {self._total} walks', highlight=False)
