"""
Errors of files: they cannot be read or written, or hold an entry that is not valid.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import TypeVar

from quad_common.errors.base import QuadError
from quad_common.errors.quoting import clipped

_Kind = TypeVar('_Kind', bound='FileUnusable')


@dataclass(eq=False, repr=False)
class FileUnusable(QuadError):
    """A file cannot be read, or cannot be written."""

    what: str
    """Kind of the file, for example ``map file``."""
    path: str | PathLike[str]
    """Path of the file."""
    reason: str
    """Reason, as the end of the sentence "the file ..."."""

    def __post_init__(self) -> None:
        """Clip a reason that may come from the file."""
        self.reason = clipped(self.reason)

    def sentence(self) -> str:
        """Say what is wrong with the file."""
        return f'{self.what} {clipped(str(self.path))} {self.reason}'

    def of_kind(self, kind: type[_Kind]) -> _Kind:
        """Return the same error as one of a category."""
        return kind(self.what, self.path, self.reason)


@dataclass(eq=False, repr=False)
class FileEntryInvalid(QuadError):
    """An entry of a file is not valid."""

    what: str
    """Kind of the file, for example ``map file``."""
    path: str | PathLike[str]
    """Path of the file."""
    problem: QuadError
    """Error of the entry."""

    def sentence(self) -> str:
        """Say what is wrong with the entry, and in which file."""
        return f'{self.what} {self.path}: {self.problem}'


@dataclass(eq=False, repr=False)
class FilmTooLong(QuadError):
    """A film would have more pictures than one may have."""

    span: float
    """Recorded time that it would show [s]."""
    pictures: int
    """Number of pictures that it would have."""
    most: int
    """Number that a film of its kind and size may have."""

    def sentence(self) -> str:
        """Say how long it would be, and what makes it shorter."""
        return (
            f'the film would show {self.span:.6g} s of the recording in {self.pictures} pictures; '
            f'{self.most} are the most: choose a part by --first and --last, or a higher --speed'
        )
