"""
What was measured of papers' figures, kept in a file between runs.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from quad_common.errors import FileUnusable
from quad_common.files.bounded_file import is_file, read_text
from quad_lab.papers.comparison import VERDICTS, Exhibit, Row

_WHAT = 'file of results'

_LARGEST = 2**22
"""Largest file that is read [bytes]."""


@dataclass(frozen=True)
class Shown:
    """An exhibit as it is shown, wherever its rows were measured."""

    exhibit: Exhibit
    """Exhibit without what draws it."""
    has_picture: bool
    """Whether there is a picture of it."""


@dataclass(frozen=True)
class Results:
    """Exhibits by the part that measured them: ``paper, name`` as one text."""

    parts: Mapping[str, tuple[Shown, ...]]
    """Exhibits of each part."""

    def exhibits(self, paper: str, order: Iterable[str]) -> list[Shown]:
        """
        Join what several parts have of one exhibit.

        Parameters
        ----------
        paper : str
            Key of the paper.
        order : iterable of str
            Labels of its exhibits, in order; others are left out.

        Returns
        -------
        list of Shown
            One for each label of which anything was measured.
        """
        every = [shown for part in self.parts.values() for shown in part]
        joined = []
        for label in order:
            pieces = [s for s in every if (s.exhibit.paper, s.exhibit.label) == (paper, label)]
            if pieces:
                joined.append(_joined(pieces))
        return joined

    def text(self) -> str:
        """Write it all as JSON, one row a line, to be read by :func:`read_results`."""
        parts = {name: [_document(shown) for shown in part] for name, part in self.parts.items()}
        return json.dumps(parts, indent=1) + '\n'


def counted(exhibits: Iterable[Shown]) -> dict[str, int]:
    """Count rows by verdict."""
    counts = Counter(row.verdict for shown in exhibits for row in shown.exhibit.rows)
    return {verdict: counts[verdict] for verdict in VERDICTS}


def read_results(path: Path) -> Results:
    """
    Read what an earlier run has left.

    Parameters
    ----------
    path : Path
        A file of :meth:`Results.text`.

    Returns
    -------
    Results
        Nothing where there is no file.

    Raises
    ------
    FileUnusable
        If it is no such file.
    """
    if not is_file(path):
        return Results({})
    try:
        parts = json.loads(read_text(path, _WHAT, _LARGEST))
        return Results({name: tuple(map(_shown, part)) for name, part in parts.items()})
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise FileUnusable(
            _WHAT, path, 'is not what quadwalk reproduce has written; remove it, or give a folder'
        ) from error


def _joined(pieces: list[Shown]) -> Shown:
    first = pieces[0].exhibit
    notes = [shown.exhibit.note for shown in pieces if shown.exhibit.note]
    return Shown(
        Exhibit(
            first.paper,
            first.label,
            first.title,
            tuple(row for shown in pieces for row in shown.exhibit.rows),
            ' '.join(dict.fromkeys(notes)),
        ),
        any(shown.has_picture for shown in pieces),
    )


def _document(shown: Shown) -> dict[str, Any]:
    exhibit = shown.exhibit
    return {
        'paper': exhibit.paper,
        'label': exhibit.label,
        'title': exhibit.title,
        'note': exhibit.note,
        'has_picture': shown.has_picture,
        'rows': [
            {**asdict(row), 'difference': row.difference, 'verdict': row.verdict}
            for row in exhibit.rows
        ],
    }


def _shown(document: dict[str, Any]) -> Shown:
    rows = tuple(_row(row) for row in document['rows'])
    names = ('paper', 'label', 'title', 'note')
    paper, label, title, note = (_text(document, name) for name in names)
    return Shown(Exhibit(paper, label, title, rows, note), bool(document['has_picture']))


def _row(document: dict[str, Any]) -> Row:
    """Make a row; one that could not be shown raises now, not when the page is written."""
    for name in ('what', 'unit', 'rule', 'reason'):
        _text(document, name)
    row = Row(**{item.name: document[item.name] for item in fields(Row)})
    if (row.difference, row.verdict) != (document['difference'], document['verdict']):
        raise ValueError(row.what)
    return row


def _text(document: dict[str, Any], name: str) -> str:
    text = document[name]
    if not isinstance(text, str):
        raise TypeError(name)
    return text
