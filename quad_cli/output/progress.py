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
            plan, record = observer.plan, observer.record
            if plan is None:
                return
            left = observer.distance_left
            simulated = observer.walking_time
            factor = simulated / max(record.wall_time, 1e-6)
            state = f'{left:5.2f} m left, {simulated:5.0f} s simulated, {factor:4.1f} x real time'
            bar.update(task, total=plan.length, completed=max(0.0, plan.length - left), state=state)
            if not console.is_terminal and time.monotonic() - said_at > _LINE_EVERY:
                said_at = time.monotonic()
                console.print(state, highlight=False)

        yield show
