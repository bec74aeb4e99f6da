"""
Shows how a walk goes: a bar on a terminal, now and then a line elsewhere.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

from quad_lab.topic_walk.walk_observer import WalkObserver

_LINE_EVERY = 5.0
"""Where there is no terminal [s]."""

_NO_PLAN = 'no plan yet (after an installation the planner compiles its searches first)'


@contextlib.contextmanager
def walk_progress(console: Console) -> Iterator[Callable[[WalkObserver], None]]:
    """
    Show progress while the block runs.

    Parameters
    ----------
    console : Console
        Where to.

    Yields
    ------
    callable
        To be called often with the walk's observer.
    """
    columns = (TextColumn('walking'), BarColumn(), TextColumn('{task.fields[state]}'))
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task('walking', total=None, state='')
        said_at = time.monotonic()

        def show(observer: WalkObserver) -> None:
            nonlocal said_at
            is_late = time.monotonic() - said_at > _LINE_EVERY
            plan = observer.plan
            if plan is not None:
                state, left = _state(observer), observer.distance_left
                done = max(0.0, plan.length - left)
                bar.update(task, total=plan.length, completed=done, state=state)
            elif is_late:
                state = _NO_PLAN
                bar.update(task, state=state)
            if not console.is_terminal and is_late:
                said_at = time.monotonic()
                console.print(state, highlight=False)

        yield show


def _state(observer: WalkObserver) -> str:
    """Return how a walk along a plan goes, in words."""
    simulated = observer.walking_time
    wall = observer.record.wall_time
    factor = simulated / wall if wall > 0.0 else 0.0
    left = observer.distance_left
    return f'{left:5.2f} m left, {simulated:5.0f} s simulated, {factor:4.1f} x real time'
