"""
One way to compile the planner's inner loops.

Each loop is plain Python, and works uncompiled too. Compiled code is kept beside the
sources, or in the user's cache: only the first call after an installation compiles.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar('Function', bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """
    Compile a function that works on NumPy arrays and numbers only.

    Parameters
    ----------
    function : callable
        At a module's top level, so that its code can be kept.

    Returns
    -------
    callable
        The same function, compiled when it is first called with arguments of a kind.
    """
    return cast(Function, numba.njit(cache=True, nogil=True)(function))
