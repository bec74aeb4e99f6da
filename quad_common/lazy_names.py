"""
Names that a package offers at its top and imports when they are first used.

Executables begin with ``import quad_gait``, before signals have a handler: what a package
offers must not be imported by then. A package says what it offers twice, to type checkers
as imports and to Python as a table; a test compares the two. ``typing`` alone would take
longer to import than all of this::

    TYPE_CHECKING = False
    if TYPE_CHECKING:
        from quad_planner.methods.planner import make_planner as make_planner
    else:
        __getattr__, __dir__, __all__ = lazy_names(
            __name__, {'quad_planner.methods.planner': ('make_planner',)}
        )
"""

from __future__ import annotations

import sys
from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


def lazy_names(
    package: str, modules: Mapping[str, tuple[str, ...]]
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """
    Return what makes names of modules names of a package (PEP 562).

    Parameters
    ----------
    package : str
        The package's ``__name__``.
    modules : mapping of str to tuple of str
        Each module, and the names in it that the package offers.

    Returns
    -------
    tuple
        The package's ``__getattr__``, ``__dir__`` and ``__all__``.
    """
    places = {name: module for module, names in modules.items() for name in names}

    def get(name: str) -> object:
        if name not in places:
            raise AttributeError(f'module {package!r} has no attribute {name!r}')
        value: object = getattr(import_module(places[name]), name)
        setattr(sys.modules[package], name, value)  # found without this function from now on
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *places})

    return get, names, list(places)
