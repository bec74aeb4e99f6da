"""
Work that is done in pieces, so that whoever does it can listen in between.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import TypeVar

Result = TypeVar('Result')

Pieces = Generator[None, None, Result]
"""A generator that has done one more piece of the work whenever it yields; it returns the result.
"""


def whole(work: Pieces[Result]) -> Result:
    """
    Do all of a piece of work at once.

    Parameters
    ----------
    work : Pieces
        What is to be done.

    Returns
    -------
    Result
        What the work returns; what it raises is raised here.
    """
    while True:
        try:
            next(work)
        except StopIteration as end:
            result: Result = end.value
            return result
