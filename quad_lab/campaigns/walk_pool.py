"""
Where walks are computed: a cluster of Dask, or this process.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol

from quad_common.errors import MissingOptionalDependency, QuadError
from quad_lab.seeded_walks.walk_task import Job, Result, code_digest, run_walk

_AHEAD = 50
"""Walks for each worker that the scheduler knows ahead."""

_PATIENCE = 15.0
"""Time for a scheduler to answer [s]."""

_PAGE = '127.0.0.1:8787'
"""Where the dashboard of a local cluster is, if no other program is there."""


class WalkPool(Protocol):
    """What computes walks."""

    lost: list[Job]
    """Walks whose worker ended again and again."""

    def run(self, jobs: Iterable[Job]) -> Iterator[list[Result]]:
        """Compute walks; yield results as they come, in any order."""
        ...


class InProcess:
    """Computes walks in this process, one after the other."""

    def __init__(self) -> None:
        self.lost: list[Job] = []

    def run(self, jobs: Iterable[Job]) -> Iterator[list[Result]]:
        """Compute walks; yield them one by one."""
        for job in jobs:
            yield [run_walk(job)]


@dataclass(eq=False, repr=False)
class SchedulerNotReached(QuadError):
    """A scheduler of Dask does not answer, or not any more."""

    address: str
    """Address of the scheduler."""
    reason: str
    """What Dask says."""

    def sentence(self) -> str:
        """Say where it should be."""
        return (
            f'the scheduler {self.address} does not answer ({self.reason}); results so far are '
            f'kept: start the same command again'
        )


@dataclass(eq=False, repr=False)
class NoWorkers(QuadError):
    """A scheduler has no workers."""

    address: str
    """Address of the scheduler."""

    def sentence(self) -> str:
        """Say how to start one."""
        return f'the scheduler {self.address} has no workers: start some with dask worker ADDRESS'


@dataclass(eq=False, repr=False)
class WorkersDiffer(QuadError):
    """Workers have other code, data or engines than the command."""

    workers: tuple[str, ...]
    """Addresses of those workers."""

    def sentence(self) -> str:
        """Say which workers."""
        return (
            f'other code, engines or processors than here would give other figures, on '
            f'{", ".join(self.workers)}: install the same versions there'
        )


class DaskPool:
    """
    Computes walks on a cluster of Dask.

    Parameters
    ----------
    client : distributed.Client
        The cluster's client.
    """

    def __init__(self, client: Any) -> None:
        self._client = client
        self.lost: list[Job] = []

    @property
    def dashboard(self) -> str:
        """Address of the dashboard; empty if there is none."""
        return str(self._client.dashboard_link or '')

    @property
    def workers(self) -> int:
        """Number of threads that compute."""
        return sum(self._client.nthreads().values())

    def check_workers(self) -> None:
        """Raise NoWorkers or WorkersDiffer if figures would not be those of this machine."""
        address = str(self._client.scheduler.address)
        if not self._client.nthreads():
            raise NoWorkers(address)
        try:
            digests = self.on_every_worker(code_digest)
        except ModuleNotFoundError as error:
            raise WorkersDiffer(tuple(sorted(self._client.nthreads()))) from error
        other = sorted(worker for worker, found in digests.items() if found != code_digest())
        if other:
            raise WorkersDiffer(tuple(other))

    def on_every_worker(self, function: Callable[..., Any], *arguments: Any) -> dict[str, Any]:
        """Call a function on each worker; return what it returns, by the workers' addresses."""
        results: dict[str, Any] = self._client.run(function, *arguments)
        return results

    def run(self, jobs: Iterable[Job]) -> Iterator[list[Result]]:
        """
        Compute walks; yield results as they come, in any order.

        A worker that ends is no loss: what it computed is computed again elsewhere. A walk whose
        workers end again and again is in :attr:`lost`.

        Raises
        ------
        SchedulerNotReached
            If the scheduler is gone.
        """
        from distributed import KilledWorker, as_completed

        waiting = iter(jobs)
        submitted = {
            future: job for job in islice(waiting, _AHEAD * max(1, self.workers))
            for future in [self._submitted(job)]
        }  # fmt: skip
        if not submitted:
            return
        ended = as_completed(list(submitted), loop=self._client.loop)
        for batch in ended.batches():
            results = []
            for future in batch:
                job = submitted.pop(future)
                try:
                    results.append(future.result())
                except KilledWorker:
                    self.lost.append(job)
                except Exception as error:
                    raise SchedulerNotReached(
                        str(self._client.scheduler.address), type(error).__name__
                    ) from error
            for job in islice(waiting, len(batch)):
                future = self._submitted(job)
                submitted[future] = job
                ended.add(future)
            yield results

    def _submitted(self, job: Job) -> Any:
        return self._client.submit(run_walk, job, pure=False)


@contextmanager
def dask_pool(scheduler: str = '', workers: int | None = None) -> Iterator[DaskPool]:
    """
    Join a cluster, or start one on this machine.

    Parameters
    ----------
    scheduler : str
        Address of a scheduler, ``tcp://host:port``; empty for a cluster of this machine.
    workers : int, optional
        Processes of a cluster of this machine; one for each processor if not given.

    Yields
    ------
    DaskPool
        Its workers have the code of this process.

    Raises
    ------
    MissingOptionalDependency
        If Dask is not installed.
    SchedulerNotReached, NoWorkers, WorkersDiffer
        If the cluster cannot be used.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        command = "pip install 'quadwalk[campaign]'"
        raise MissingOptionalDependency('distributed', command) from error
    if scheduler:
        try:
            client = Client(scheduler, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise SchedulerNotReached(scheduler, type(error).__name__) from error
        with client:
            yield _checked(client)
        return
    with (
        _quiet(),
        LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host='127.0.0.1',
            dashboard_address=_PAGE,
            memory_limit=0,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield _checked(client)


def _checked(client: Any) -> DaskPool:
    pool = DaskPool(client)
    pool.check_workers()
    return pool


@contextmanager
def _quiet() -> Iterator[None]:
    """Let Dask not warn of what is as it should be: another program at the dashboard's port."""
    import warnings

    with warnings.catch_warnings():
        warnings.filterwarnings('ignore', message='Port .* is already in use')
        yield
