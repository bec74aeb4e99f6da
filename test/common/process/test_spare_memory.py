"""What was free in the process is free on the machine."""

from __future__ import annotations

import ctypes
import gc
import weakref

import pytest

from quad_common.errors import QuadError, without_frames
from quad_common.process import spare_memory
from quad_common.process.spare_memory import give_back_spare_memory
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


def test_the_net_counts_what_it_caught() -> None:
    def refuse() -> None:
        raise QuadError('no')

    net = CallbackNet(_Keeper())
    net.call('a message', refuse, lambda sentence: None)
    net.call('a message', lambda: None, lambda sentence: None)
    assert net.caught == 1
