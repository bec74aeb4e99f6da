"""
A net under callbacks: whatever one of them raises is said, and ends nothing.
"""

from __future__ import annotations

import contextlib
import sys
import traceback
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Protocol, TypeVar

from quad_common.errors import QuadError, without_frames
from quad_common.errors.quoting import quoted

Result = TypeVar('Result')


class Voice(Protocol):
    """Says what was caught."""

    def report_error(self, error: QuadError) -> None:
        """Report what was refused on purpose."""

    def report_unexpected(self, sentence: str, kind: str, stack: str | None) -> None:
        """Report an unforeseen error; the stack comes with the first of its kind."""


class CallbackNet:
    """
    Calls callbacks, and reports what they raise.

    `QuadError` is what quadwalk raises on purpose. Any other exception is a defect, of
    quadwalk or of what it builds on: its stack is handed out once a kind, which is its type
    and the place where it was raised. What ends Python (KeyboardInterrupt, SystemExit) passes.

    Parameters
    ----------
    voice : Voice
        Whom it tells.
    """

    def __init__(self, voice: Voice) -> None:
        self._voice = voice
        self._kinds: set[tuple[str, str]] = set()
        self.calls = 0
        """Number of callbacks that were called."""

    def call(
        self, what: str, callback: Callable[[], Result], failed: Callable[[str], Result]
    ) -> Result:
        """
        Call a callback.

        Parameters
        ----------
        what : str
            What it works on, as the beginning of a sentence.
        callback : callable
            Called.
        failed : callable
            Called in its place if it raises, with a sentence that says why.

        Returns
        -------
        object
            What either of the two returns.
        """
        self.calls += 1
        try:
            return callback()
        except QuadError as error:
            sentence = _text_of(error)
            self._say(partial(self._voice.report_error, without_frames(error)))
        except Exception as error:
            sentence = self._describe(what, error)
        return failed(sentence)

    def _describe(self, what: str, error: Exception) -> str:
        """Say what happened and where; return the sentence."""
        kind, place = type(error).__name__, _place_of(error)
        sentence = (
            f'{what} led to an unexpected {kind} at {place}: {quoted(_text_of(error))}; '
            'it is dropped, and the last good state stays'
        )
        is_new = (kind, place) not in self._kinds
        self._kinds.add((kind, place))
        stack = _stack_of(error) if is_new else None
        self._say(lambda: self._voice.report_unexpected(sentence, kind, stack))
        return sentence

    def _say(self, report: Callable[[], None]) -> None:
        """Report; where even that fails, its stack goes to the console, once a kind."""
        try:
            report()
        except Exception as error:
            kind = (type(error).__name__, f'report: {_place_of(error)}')
            if kind in self._kinds:
                return
            self._kinds.add(kind)
            # The console may be closed: then there is nowhere to report it.
            with contextlib.suppress(OSError, ValueError):
                print(_stack_of(error), file=sys.stderr)


def _place_of(error: Exception) -> str:
    """Return file, line and function where an exception was raised."""
    frames = traceback.extract_tb(error.__traceback__)
    if not frames:
        return 'an unknown place'
    last = frames[-1]
    return f'{Path(last.filename).name}:{last.lineno} ({last.name})'


def _stack_of(error: Exception) -> str:
    """Write where an exception came from; of its own text not more than is quoted."""
    lines = traceback.format_tb(error.__traceback__)
    head = 'Traceback (most recent call last):\n'
    return f'{head}{"".join(lines)}{type(error).__name__}: {quoted(_text_of(error))}'


def _text_of(error: Exception) -> str:
    """Return an exception's own text; its kind where it cannot write one."""
    try:
        return str(error)
    except Exception:
        return type(error).__name__
