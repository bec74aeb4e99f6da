"""
Measures papers' figures in worker processes, and keeps page, pictures and numbers complete.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from quad_common.files.bounded_file import check_target, make_folder
from quad_common.files.whole_file import write_bytes
from quad_common.process.end_signals import shielded
from quad_lab.papers.comparison import UNEXPLAINED, Exhibit, Part
from quad_lab.papers.drawing import picture_of
from quad_lab.papers.page import FOLDER, TITLES, page_text
from quad_lab.papers.results import Results, Shown, read_results
from quad_lab.tools.workers import worker_pool

PAPERS = tuple(TITLES)
"""Keys of the papers, which are also the names of their modules."""

PAGE, NUMBERS = 'reproduction.md', 'reproduction.json'
"""Names of the files beside the pictures' folder."""


@dataclass(frozen=True)
class Drawn:
    """What a worker process hands back of an exhibit."""

    exhibit: Exhibit
    """Exhibit without what draws it."""
    picture: bytes | None
    """Content of its picture's file."""


class _Paper(NamedTuple):
    """What the module of a paper offers."""

    PARTS: tuple[Part, ...]
    """Parts that are measured."""
    EXHIBITS: tuple[str, ...]
    """Labels of its figures and tables, in order."""


def parts_of(papers: Sequence[str], quick: bool) -> list[Part]:
    """List what is measured for papers; if quick, without what walks in a simulator."""
    parts: list[Part] = []
    for paper in papers:
        parts += _module(paper).PARTS
    return [part for part in parts if not (quick and part.needs_physics)]


def orders() -> dict[str, tuple[str, ...]]:
    """Return the labels of each paper's exhibits, in its order."""
    return {paper: _module(paper).EXHIBITS for paper in PAPERS}


def reproduce(
    papers: Sequence[str], output: Path, quick: bool, say: Callable[[str], None]
) -> Results:
    """
    Measure and draw, and write page, pictures and numbers after each part.

    What an earlier run has left of other parts stays, so that one paper can be measured again.

    Parameters
    ----------
    papers : sequence of str
        Keys of the papers.
    output : Path
        Folder for the page; the pictures' folder is beside it.
    quick : bool
        Leave out what walks in a simulator.
    say : callable
        Told of progress, a line at a time.

    Returns
    -------
    Results
        Of these papers alone.

    Raises
    ------
    FileUnusable
        If the folder cannot be made, or an earlier run's numbers cannot be read.
    """
    parts = parts_of(papers, quick)
    make_folder(output / FOLDER)
    for name in (PAGE, NUMBERS):
        check_target(output / name)
    names = [key_of(part) for part in parts_of(PAPERS, quick=False)]
    known = dict(read_results(output / NUMBERS).parts)
    measured: dict[str, tuple[Shown, ...]] = {}
    began = time.monotonic()
    say(f'measuring {len(parts)} parts of {", ".join(papers)}')
    with worker_pool() as pool:
        # What takes longest first: then the processes end together.
        waiting = sorted(parts, key=lambda part: not part.needs_physics)
        jobs = {pool.submit(measure_and_draw, part): part for part in waiting}
        for job in as_completed(jobs):
            key = key_of(jobs[job])
            drawn = job.result()
            measured[key] = known[key] = tuple(_shown(one) for one in drawn)
            with shielded():
                _write_pictures(output / FOLDER, drawn)
                _write(output, Results({n: known[n] for n in names if n in known}))
            passed = time.monotonic() - began
            say(f'{len(measured)} of {len(jobs)} after {passed:.0f} s: {key}')
    return Results({name: measured[name] for name in names if name in measured})


def measure_and_draw(part: Part) -> list[Drawn]:
    """Measure a part and draw its exhibits, in a worker process."""
    exhibits = part.measure()
    return [
        Drawn(replace(one, draw=None), None if one.draw is None else picture_of(one.draw))
        for one in exhibits
    ]


def key_of(part: Part) -> str:
    """Return the name under which a part's results are kept."""
    return f'{part.paper}, {part.name}'


def shown_exhibits(exhibits: Sequence[Exhibit]) -> tuple[Shown, ...]:
    """Return exhibits as they are shown, without drawing them."""
    return tuple(Shown(replace(one, draw=None), one.draw is not None) for one in exhibits)


def failures(results: Results) -> list[str]:
    """List the rows without a number, and those that are worse without a reason."""
    return [
        f'{shown.exhibit.paper} {shown.exhibit.label}, {row.what}: {row.explanation}'
        for part in results.parts.values()
        for shown in part
        for row in shown.exhibit.rows
        if row.here is None or row.explanation == UNEXPLAINED
    ]


def _module(paper: str) -> _Paper:
    module = importlib.import_module(f'quad_lab.papers.{paper.lower()}')
    return _Paper(tuple(module.PARTS), tuple(module.EXHIBITS))


def _shown(drawn: Drawn) -> Shown:
    return Shown(drawn.exhibit, drawn.picture is not None)


def _write_pictures(folder: Path, drawn: Sequence[Drawn]) -> None:
    for one in drawn:
        if one.picture is not None:
            write_bytes(folder / f'{one.exhibit.stem}.png', one.picture)


def _write(output: Path, results: Results) -> None:
    write_bytes(output / NUMBERS, results.text().encode())
    write_bytes(output / PAGE, page_text(results, orders()).encode())
