"""
Decorators that compile inner loops of searches.

Each loop is plain Python, and works uncompiled too. What Python calls is `compiled`, or a
`compiled_loop` where it makes no arrays; what only such functions call is a `compiled_part` of
them.
Compiled code is kept beside the sources, or in the user's cache: only the first call after an
installation compiles.

That call is to be short, so loops fill arrays that are made outside, and copy element by
element: slices that are assigned, copies and conversions within would have more of Numba's
own code compiled than there is of ours. A function is compiled again for each kind of its
arguments, so whole numbers are of 64 bits unless memory matters.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.extending import register_jitable

Function = TypeVar('Function', bound=Callable[..., Any])

_OPTIONS = {
    'nogil': True,
    # Divisions are not checked, and nothing calls from C.
    'error_model': 'numpy',
    'no_cfunc_wrapper': True,
}


def compiled(function: Function) -> Function:
    """
    Compile a function that works on NumPy arrays and numbers only.

    Parameters
    ----------
    function : callable
        Function at a module's top level, so that its code can be kept.

    Returns
    -------
    callable
        The same function, compiled when it is first called with arguments of a kind.
    """
    return cast(Function, numba.njit(cache=True, **_OPTIONS)(function))


def compiled_loop(function: Function) -> Function:
    """
    Compile a function that makes no array and returns none, without counts of references.

    Numba counts, at each call within, who uses an array: with many arrays in small functions that
    takes several times as long as the work. Nothing needs it where the caller holds all arrays
    meanwhile, as Python does. Numba refuses to compile functions that make arrays so.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`.

    Returns
    -------
    callable
        The same function, compiled when it is first called with arguments of a kind.
    """
    # Numba has the option in all versions, by this name only.
    return cast(Function, numba.njit(cache=True, _nrt=False, **_OPTIONS)(function))


def compiled_part(function: Function) -> Function:
    """
    Have a function compiled as a part of those that call it.

    It takes half the time of `compiled`: nothing is made that Python could call.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`.

    Returns
    -------
    callable
        The same function, which Python calls as it is, uncompiled.
    """
    return cast(Function, register_jitable(**_OPTIONS)(function))


def inlined_part(function: Function) -> Function:
    """
    Have a function compiled into each place from which it is called.

    It makes small functions of many arrays several times as fast: no array is counted as used by
    one more. It takes longer to compile, the more often the function is called.

    Parameters
    ----------
    function : callable
        As for :func:`compiled`.

    Returns
    -------
    callable
        The same function, which Python calls as it is, uncompiled.
    """
    return cast(Function, register_jitable(forceinline=True, **_OPTIONS)(function))
