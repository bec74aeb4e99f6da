"""Progress of a walk, where there is no terminal."""

import io
from types import SimpleNamespace

from rich.console import Console

from quad_cli.output import progress


def test_it_says_what_it_waits_for_and_then_how_far_it_is(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, 'monotonic', lambda: now[0])
    output = io.StringIO()
    walk = SimpleNamespace(
        plan=None, distance_left=0.0, walking_time=30.0, record=SimpleNamespace(wall_time=10.0)
    )
    with progress.walk_progress(Console(file=output, width=100)) as show:
        for now[0] in (1.0, 6.0, 7.0):
            show(walk)
        walk.plan, walk.distance_left = SimpleNamespace(length=3.0), 2.5
        for now[0] in (8.0, 12.0):
            show(walk)
    first, second = output.getvalue().splitlines()
    assert first.startswith('no plan yet')
    assert second == ' 2.50 m left,    30 s simulated,  3.0 x real time'
