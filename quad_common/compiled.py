"""
Decorators that compile inner loops of searches.

Each loop is plain Python, and works uncompiled too. What Python calls is `compiled`, or a
`compiled_loop` where it makes no arrays; what only such functions call is a `compiled_part` of
them.
Compiled code is kept beside the sources, or in the user's cache: only the first call after an
installation compiles. Where nothing can be kept (a full disk, a home that may not be written)
each process compiles for itself, and where what was kept is damaged it is compiled anew.

That call is to be short, so loops fill arrays that are made outside, and copy element by
element: slices that are assigned, copies and conversions within would have more of Numba's
own code compiled than there is of ours. A function is compiled again for each kind of its
arguments, so whole numbers are of 64 bits unless memory matters.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core import event
from numba.core.caching import FunctionCache
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
    return _kept(numba.njit(**_OPTIONS)(function), function)


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
    return _kept(numba.njit(_nrt=False, **_OPTIONS)(function), function)


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


class _CompilationCounter(event.Listener):  # type: ignore[misc]
    """Counts how often something was compiled."""

    def __init__(self) -> None:
        self.count = 0

    def on_start(self, event: object) -> None:
        """Take that something is compiled."""

    def on_end(self, event: object) -> None:
        """Take that it has been compiled."""
        self.count += 1


_counter = _CompilationCounter()
event.register('numba:compile', _counter)


def compilation_count() -> int:
    """Return how often this process has compiled something: code that was kept does not count."""
    return _counter.count


class _CodeOnDisk(FunctionCache):  # type: ignore[misc]
    """Numba's files of compiled code, which end nothing where they cannot be read or written."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """
        Read the code for a kind of arguments.

        Parameters
        ----------
        sig : tuple of numba.types.Type
            Kind of the arguments.
        target_context : numba.core.base.BaseContext
            Target for which Numba compiles.

        Returns
        -------
        object or None
            Code, or None where none is kept or what is kept is damaged.
        """
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # A damaged pickle may raise anything.
            # Its index, where that is what is damaged, would refuse new code too.
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """
        Keep the code for a kind of arguments, if it can be kept.

        Parameters
        ----------
        sig : tuple of numba.types.Type
            Kind of the arguments.
        data : object
            Code.
        """
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)


def _kept(dispatcher: Any, function: Function) -> Function:
    # Numba's own `cache=True` lets errors of files through, from the first call, and refuses a
    # function at its definition where no folder can be written.
    if dispatcher is not function:  # As it is where NUMBA_DISABLE_JIT is set.
        with contextlib.suppress(RuntimeError):
            dispatcher._cache = _CodeOnDisk(function)
    return cast(Function, dispatcher)
