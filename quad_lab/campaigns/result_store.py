"""
Results of walks on disk: Parquet files in a folder, written as results come.

Each file is written beside its place and put there at once: whatever ends the process, the
folder holds whole files. Small ones are merged now and then; a walk that is then there twice
counts once.
"""

from __future__ import annotations

import contextlib
import json
import uuid
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from quad_common.errors import FileUnusable, MissingOptionalDependency
from quad_common.files.bounded_file import check_folder_target, make_folder, reason_of
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_task import Job, Result, key_of

_WHAT = 'results'

_MERGED_AT = 64
"""Number of small files that become one."""

_MOVE = 'once it is moved out of the folder the campaign goes on, and walks its walks again'

_LARGE = 2000
"""Rows of a file that is not merged any more."""

_FIGURES = tuple(item for item in fields(WalkFigures) if item.init)

_SUCCEEDED = 'succeeded'


class ResultStore:
    """
    A folder of results.

    Parameters
    ----------
    folder : Path
        The folder; it is made if it is not there.

    Raises
    ------
    MissingOptionalDependency
        If pyarrow is not installed.
    FileUnusable
        If the folder cannot be made or written, or a file in it is no result of walks.
    """

    def __init__(self, folder: Path) -> None:
        self._arrow, self._parquet = _arrow()
        check_folder_target(folder, _WHAT)
        make_folder(folder, _WHAT)
        self._folder = folder
        self._small: list[Path] = []
        self.results: dict[str, Result] = {}
        """All results, by their keys."""
        for path in sorted(folder.glob('*.parquet')):
            self._read(path)

    def add(self, results: Iterable[Result]) -> None:
        """Keep results; they are on disk when this returns."""
        new = {key_of(result.job): result for result in results}
        if not new:
            return
        self._write(new)
        self.results.update(new)
        if len(self._small) >= _MERGED_AT:
            self._merge()

    def _read(self, path: Path) -> None:
        try:
            rows = self._parquet.read_table(path).to_pylist()
            found = {row['key']: _result(row) for row in rows}
        except (self._arrow.ArrowException, KeyError, TypeError, ValueError) as error:
            reason = f'holds no results of walks: {_MOVE}'
            raise FileUnusable(_WHAT, path, reason) from error
        except OSError as error:
            raise FileUnusable(_WHAT, path, f'cannot be read: {error.strerror}') from error
        self.results.update(found)
        if len(found) < _LARGE:
            self._small.append(path)

    def _write(self, results: Mapping[str, Result]) -> None:
        path = self._folder / f'walks-{uuid.uuid4().hex}.parquet'
        beside = path.with_suffix('.part')
        try:
            self._parquet.write_table(_table(self._arrow, results), beside)
            beside.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                beside.unlink(missing_ok=True)
            raise FileUnusable(_WHAT, path, f'cannot be written: {reason_of(error)}') from error
        if len(results) < _LARGE:
            self._small.append(path)

    def _merge(self) -> None:
        """Make one file of the small ones."""
        merged = list(self._small)
        keys = {
            key
            for path in merged
            for key in self._parquet.read_table(path, columns=['key'])['key'].to_pylist()
        }
        self._small = []
        self._write({key: self.results[key] for key in sorted(keys)})
        for path in merged:
            path.unlink(missing_ok=True)


def _arrow() -> tuple[Any, Any]:
    """Import pyarrow, and its part for Parquet."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise MissingOptionalDependency('pyarrow', "pip install 'quadwalk[campaign]'") from error
    return pyarrow, pyarrow.parquet


def _table(pa: Any, results: Mapping[str, Result]) -> Any:
    """Make a table: key, seed, case, one column for each value of the cases, the figures."""
    listed = list(results.values())
    types = {'bool': pa.bool_(), 'float': pa.float64(), 'str': pa.string()}
    columns: dict[str, Any] = {
        'key': pa.array(list(results), pa.string()),
        'seed': pa.array([result.job.seed for result in listed], pa.int64()),
        'case': pa.array([json.dumps(dict(result.job.case)) for result in listed], pa.string()),
        'seconds': pa.array([result.seconds for result in listed], pa.float64()),
        _SUCCEEDED: pa.array([result.figures.succeeded for result in listed], pa.bool_()),
    }
    for item in _FIGURES:
        values = [getattr(result.figures, item.name) for result in listed]
        columns[item.name] = pa.array(values, types[str(item.type)])
    for name in sorted({name for result in listed for name in result.job.case}):
        columns[f'case.{name}'] = pa.array([result.job.case.get(name) for result in listed])
    return pa.table(columns)


def _result(row: Mapping[str, Any]) -> Result:
    figures = WalkFigures(**{item.name: row[item.name] for item in _FIGURES})
    return Result(Job(json.loads(row['case']), row['seed']), figures, row['seconds'])
