"""Compiled code is kept where it can be, and runs where it cannot."""

from __future__ import annotations

import importlib.util

import numba
import numpy as np
import pytest

SOURCE = """
from quad_common.compiled import compiled, compiled_loop

@compiled
def total(numbers):
    return numbers.copy().sum()

@compiled_loop
def largest(numbers):
    most = numbers[0]
    for number in numbers:
        most = max(most, number)
    return most
"""
NUMBERS = np.arange(5.0)


@pytest.fixture
def loops(tmp_path, monkeypatch):
    """Import the loops above anew, as another process would."""
    path = tmp_path / 'loops.py'
    path.write_text(SOURCE)
    monkeypatch.setattr(numba.config, 'CACHE_DIR', str(tmp_path / 'kept'))

    def import_again():
        specification = importlib.util.spec_from_file_location('loops', path)
        module = importlib.util.module_from_spec(specification)
        specification.loader.exec_module(module)
        return module

    return import_again


def assert_right(module):
    assert module.total(NUMBERS) == 10.0
    assert module.largest(NUMBERS) == 4.0


def kept(tmp_path):
    return [path for path in (tmp_path / 'kept').rglob('*') if path.is_file()]


def is_read(function):
    """Return whether a function's code was read, not compiled."""
    return bool(function.stats.cache_hits) and not function.stats.cache_misses


def test_code_is_kept_for_other_processes(loops, tmp_path):
    first = loops()
    assert_right(first)
    assert not is_read(first.total)
    assert len(kept(tmp_path)) == 4
    second = loops()
    assert_right(second)
    assert is_read(second.total)
    assert is_read(second.largest)


@pytest.mark.parametrize('room', [0, 1000])
def test_a_full_disk_ends_nothing(loops, tmp_path, most_bytes, room):
    first = loops()
    with most_bytes(room):
        assert_right(first)
    assert not list((tmp_path / 'kept').rglob('*.nbc*'))
    # Once there is room, code is kept as ever.
    assert_right(loops())
    second = loops()
    assert_right(second)
    assert is_read(second.total)


@pytest.mark.parametrize('ending', ['.nbi', '.nbc'])
@pytest.mark.parametrize('left', [0, 40])
def test_damaged_files_are_written_anew(loops, tmp_path, ending, left):
    assert_right(loops())
    for path in kept(tmp_path):
        if path.suffix == ending:
            path.write_bytes(path.read_bytes()[:left])
    second = loops()
    assert_right(second)
    assert not is_read(second.total)
    third = loops()
    assert_right(third)
    assert is_read(third.total)


def test_code_runs_where_no_folder_can_be_written(loops, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, 'Permission denied')

    monkeypatch.setattr('numba.core.caching.os.makedirs', refuse)
    module = loops()
    assert_right(module)
    assert not is_read(module.total)


def test_loops_are_plain_python_where_numba_is_told_not_to_compile(loops, monkeypatch):
    monkeypatch.setattr(numba.config, 'DISABLE_JIT', True)
    module = loops()
    assert_right(module)
    assert not hasattr(module.total, 'stats')
