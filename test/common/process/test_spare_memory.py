"""What was free in the process is free on the machine."""

from __future__ import annotations

import ctypes
import gc
import weakref

import pytest

from quad_common.errors import QuadError, without_frames
from quad_common.process import spare_memory
from quad_common.process.spare_memory import (
    SpareMemory,
    give_back_spare_memory,
    resident_memory,
)
from quad_common.ros.callback_net import CallbackNet


class _Large:
    """Something that a callback works on."""


class _Keeper:
    """A voice that keeps the last error, as nodes do while it is true."""

    def report_error(self, error: QuadError) -> None:
        self.error = error

    def report_unexpected(self, sentence: str, kind: str, stack: str | None) -> None:
        self.sentence = sentence


def test_giving_back_twice_is_harmless() -> None:
    give_back_spare_memory()
    assert give_back_spare_memory() in (False, True)


def test_a_c_library_without_the_function_gives_nothing_back(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    spare_memory._trim.cache_clear()
    monkeypatch.setattr(ctypes, 'CDLL', lambda name: object())
    try:
        assert not give_back_spare_memory()
    finally:
        spare_memory._trim.cache_clear()


@pytest.mark.parametrize('kind', [QuadError, ValueError])
def test_what_was_refused_is_let_go_without_the_garbage_collector(
    kind: type[Exception],
) -> None:
    def refuse(message: _Large) -> None:
        try:
            raise KeyError(id(message))
        except KeyError as error:
            raise kind('refused') from error

    net = CallbackNet(_Keeper())
    messages = [_Large()]
    seen = weakref.ref(messages[0])
    gc.disable()
    try:
        net.call('a message', lambda: refuse(messages[0]), lambda sentence: None)
        messages.clear()
        assert seen() is None
    finally:
        gc.enable()


def test_an_error_that_is_kept_keeps_nothing_else() -> None:
    def fail() -> None:
        large = _Large()
        seen.append(weakref.ref(large))
        raise QuadError('no')

    seen: list[weakref.ref[_Large]] = []
    gc.disable()
    try:
        try:
            fail()
        except QuadError as error:
            kept = without_frames(error)
        assert seen[0]() is None
        assert str(kept) == 'no'
    finally:
        gc.enable()


@pytest.mark.parametrize(
    ('held', 'expected'),
    [
        ([100.0, 107.0], [False]),
        ([100.0, 160.0, 102.0, 104.0], [True, False]),
        # What is needed is not asked for again and again.
        ([100.0, 160.0, 160.0, 163.0, 169.0, 169.0], [True, False, True]),
        # What was let go counts as growth when it comes back.
        ([100.0, 50.0, 90.0, 50.0], [False, True]),
        ([None, 500.0], [False]),
        ([100.0, None, 500.0, 120.0], [False, True]),
    ],
)
def test_a_process_that_has_grown_gives_back_what_is_free(
    monkeypatch: pytest.MonkeyPatch, held: list[float | None], expected: list[bool]
) -> None:
    given_back: list[None] = []
    values = iter(held)
    monkeypatch.setattr(spare_memory, 'resident_memory', lambda: next(values))
    monkeypatch.setattr(spare_memory, 'give_back_spare_memory', lambda: given_back.append(None))
    spare = SpareMemory()
    assert [spare.look() for _ in expected] == expected
    assert len(given_back) == sum(expected)


def test_the_memory_of_this_process_is_told_where_the_system_tells_it() -> None:
    held = resident_memory()
    assert held is None or held > 10.0


def test_a_large_message_below_a_small_block_is_given_back() -> None:
    if spare_memory._trim() is None or resident_memory() is None:
        pytest.skip('the C library has no malloc_trim')
    library = ctypes.CDLL(None)
    library.malloc.restype, library.malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
    library.free.argtypes = [ctypes.c_void_p]
    spare = SpareMemory()
    before = resident_memory()
    blocks = [library.malloc(60_000) for _ in range(1000)]
    for block in blocks:
        ctypes.memset(block, 1, 60_000)
    for block in blocks[:-1]:
        library.free(block)
    try:
        assert spare.look()
        held = resident_memory()
        assert before is not None
        assert held is not None
        assert held < before + 10.0
    finally:
        library.free(blocks[-1])
