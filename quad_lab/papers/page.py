"""
The page that shows papers' figures beside those of this code.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from quad_lab.papers.comparison import Exhibit
from quad_lab.papers.results import Results, Shown, counted

TITLES = {
    'S0': 'Nguyen2017',
    'S1': 'Hoang2013',
    'S2': 'Liu',
    'S3': 'Marin',
    'S4': 'Yi',
}
"""How the documents call each paper."""

FOLDER = 'reproduction'
"""Name of the folder of the pictures, beside the page."""

_HEAD = """\
# The papers, reproduced

    quadwalk reproduce all --output docs

Every figure and table of the [five papers](references.md) that shows a result, drawn and measured
by this code, beside the paper's values. This page, its pictures and
[its numbers as JSON](reproduction.json) are written by that command, whole. Where a figure's
numbers are lost, the property that its text states is measured.

*Equal* is what differs by no more than one in the last digit that the paper prints, or a stated
property that holds. *Better* and *worse* say in which direction it differs.
"""


def page_text(results: Results, orders: Mapping[str, tuple[str, ...]]) -> str:
    """
    Write the page.

    Parameters
    ----------
    results : Results
        What was measured.
    orders : mapping
        For each paper the labels of its exhibits, in order.

    Returns
    -------
    str
        Markdown.
    """
    shown = {paper: results.exhibits(paper, order) for paper, order in orders.items()}
    shown = {paper: exhibits for paper, exhibits in shown.items() if exhibits}
    return '\n'.join([_HEAD, *_summary(shown), *_worse(shown), *_sections(shown)])


def _summary(shown: Mapping[str, list[Shown]]) -> Iterator[str]:
    yield '| paper | figures and tables | rows | better | equal | worse |'
    yield '| --- | --- | --- | --- | --- | --- |'
    for paper, exhibits in shown.items():
        counts = counted(exhibits)
        cells = (len(exhibits), sum(counts.values()), *counts.values())
        name = f'[{TITLES[paper]}](#{TITLES[paper].lower()}-{paper.lower()})'
        yield f'| {name} | {" | ".join(map(str, cells))} |'
    yield ''


def _worse(shown: Mapping[str, list[Shown]]) -> Iterator[str]:
    rows = [
        (f'{TITLES[paper]}, {one.exhibit.label}', row.what, *row.texts, row.explanation)
        for paper, exhibits in shown.items()
        for one in exhibits
        for row in one.exhibit.rows
        if row.verdict == 'worse'
    ]
    if rows:
        yield 'What is worse, and why:\n'
        yield '| where | what | the paper | here | why |'
        yield '| --- | --- | --- | --- | --- |'
        yield from (f'| {" | ".join(cells)} |' for cells in rows)
        yield ''


def _sections(shown: Mapping[str, list[Shown]]) -> Iterator[str]:
    for paper, exhibits in shown.items():
        yield f'## {TITLES[paper]} ({paper})\n'
        for one in exhibits:
            yield from _exhibit(one.exhibit, one.has_picture)


def _exhibit(exhibit: Exhibit, has_picture: bool) -> Iterator[str]:
    yield f'### {exhibit.label}: {exhibit.title}\n'
    if exhibit.note:
        yield f'{exhibit.note}\n'
    if has_picture:
        yield f'![{exhibit.title}]({FOLDER}/{exhibit.stem}.png)\n'
    yield '| what | the paper | here | difference | verdict |'
    yield '| --- | --- | --- | --- | --- |'
    for row in exhibit.rows:
        verdict = ': '.join(filter(None, (row.verdict, row.explanation)))
        yield f'| {" | ".join((row.what, *row.texts, row.difference, verdict))} |'
    yield ''
