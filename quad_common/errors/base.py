"""
The base of every error, and how errors are made.

An error is a dataclass: its fields are facts that a program can act on, and its
:meth:`QuadError.sentence` says to people what was wrong, with the numbers, and what would
be valid.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

from quad_common.errors.quoting import escaped

AnyError = TypeVar('AnyError', bound=BaseException)

_LISTED = 40
"""Number of names that a sentence lists."""

_LONGEST_NAME = 60
"""Number of characters of each of them."""


class QuadError(Exception):
    """Base of every error that quadwalk raises on purpose."""

    def sentence(self) -> str:
        """Say what was wrong, in one sentence."""
        return super().__str__()

    def __str__(self) -> str:
        return self.sentence()

    def __reduce__(self) -> tuple[Any, ...]:
        # Facts given by name are none of an exception's arguments: worker processes need them.
        return _restored, (type(self), self.args), self.__dict__


def _restored(kind: type[QuadError], args: tuple[object, ...]) -> QuadError:
    """Make an error without its facts, which are set thereafter."""
    return kind.__new__(kind, *args)


def without_frames(error: AnyError) -> AnyError:
    """
    Let go of the frames that an exception came through; return it.

    An exception that is kept keeps what was being worked on: a picture, or a request of a
    hundred thousand parameters. Where a frame holds the exception too, both stay until the
    garbage collector looks through old objects, which may be minutes.

    Parameters
    ----------
    error : BaseException
        What was caught, and is not raised again.

    Returns
    -------
    BaseException
        The same, with no traceback, and so is what it came from.
    """
    known: set[int] = set()
    waiting: list[BaseException | None] = [error]
    while waiting:
        here = waiting.pop()
        if here is not None and id(here) not in known:
            known.add(id(here))
            here.__traceback__ = None
            waiting += [here.__cause__, here.__context__]
    return error


def listed(names: Iterable[str]) -> str:
    """Write names one after the other; neither their number nor their lengths are bounded."""
    known = list(names)
    text = ', '.join(sorted(escaped(name[:_LONGEST_NAME]) for name in known[:_LISTED])) or 'none'
    return text if len(known) <= _LISTED else f'{text} and {len(known) - _LISTED} more'
