"""
What the parts of ``quadwalk bench balance`` share: results, workers, and how much is tried.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from typing import Any, TypeVar

from quad_lab.tools.criterion import Criterion
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import AUTO, preferred, resolved

Result = TypeVar('Result')

Bars = tuple[list[Criterion], dict[str, object]]
"""Bars of a part, and its details."""

QUICK = ('a1', 0.3)
"""Robot and period [s] of the quick sample."""

SPEEDS = (0.0, 0.5, 1.0)
"""Speeds, as fractions of the most."""

DIRECTIONS, PHASES = 8, 8
"""Numbers of directions from which robots are pushed, and of phases of a cycle."""

NEEDED = 0.9
"""Part of the pushes that is to be survived."""


def in_workers(work: Callable[..., Result], jobs: Sequence[tuple[Any, ...]]) -> list[Result]:
    """Do all jobs in worker processes, in the engine that runs here."""
    with worker_pool() as pool:
        return _mapped(pool, work, jobs)


def _mapped(
    pool: Executor, work: Callable[..., Result], jobs: Sequence[tuple[Any, ...]]
) -> list[Result]:
    backend = resolved(AUTO)
    return [f.result() for f in [pool.submit(_in_engine, backend, work, *job) for job in jobs]]


def _in_engine(backend: str, work: Callable[..., Result], *given: Any) -> Result:
    with preferred(backend):
        return work(*given)
