"""
Robots of the package ``robot_descriptions``, of those descriptions that its cache already holds.

The package (https://github.com/robot-descriptions/robot_descriptions.py) is a list of repositories
and of paths in them; each of its modules clones its repository when it is imported. Nothing is
cloned here: modules are imported as those of another package, apart from the one that is installed,
with a function in place of its cache that only looks where the clone would be.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.machinery import PathFinder
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

from quad_common.errors import (
    DescriptionNotCached,
    DescriptionPackageUnusable,
    FileUnusable,
    MissingOptionalDependency,
)
from quad_common.files.bounded_file import is_file, is_folder, user_path
from quad_common.importing.options import ImportOptions

_PACKAGE = 'robot_descriptions'

_APART = f'_{_PACKAGE}_without_cloning'
"""Name of the package as whose modules those of the installed one are imported."""

_LOCK = RLock()
"""Held while there is such a package: one at a time."""

_END = '_description'
"""End of the names of descriptions."""

_PATHS = ('URDF_PATH', 'XACRO_PATH', 'MJCF_PATH')
"""Names that a module gives to its description, the richest format first: MJCF has no speeds."""


_REFUSALS = (DescriptionPackageUnusable, FileUnusable, MissingOptionalDependency)
"""Errors of a package or a cache that is not usable."""


class _NotThere(Exception):
    """A repository is not in the cache."""


@dataclass(frozen=True)
class CachedDescription:
    """A description in the cache of ``robot_descriptions``."""

    path: Path
    """Path of the URDF, xacro or MJCF file."""
    options: ImportOptions
    """What the package says of it: arguments of a xacro file."""


def is_installed() -> bool:
    """Return whether ``robot_descriptions`` is installed."""
    try:
        return importlib.util.find_spec(_PACKAGE) is not None
    # A module of that name that a program made itself.
    except ValueError:
        return False


def cached_description(name: str) -> CachedDescription | None:
    """
    Find a robot's description by the name that ``robot_descriptions`` gives it.

    Parameters
    ----------
    name : str
        For example ``go2_description``, ``go2_mj_description``, or ``go2`` for whichever of
        these is in the cache.

    Returns
    -------
    CachedDescription or None
        None if the package knows no such robot, or is not installed and the name is not one that
        only it could know.

    Raises
    ------
    DescriptionNotCached
        If the package knows it, but has not fetched it yet.
    DescriptionPackageUnusable
        If the package is not as its versions are that are known.
    FileUnusable
        If its cache is in the home of a user who does not exist.
    MissingOptionalDependency
        If the name ends with ``_description`` and the package or one that it needs is missing.
    """
    # Names that begin with an underscore are the package's own modules.
    if not name.isidentifier() or name.startswith('_'):
        return None
    if not is_installed():
        if name.endswith(_END):
            raise MissingOptionalDependency(_PACKAGE, f'pip install {_PACKAGE}')
        return None
    names = [name] if name.endswith(_END) else [f'{name}{_END}', f'{name}_mj{_END}']
    # Looked for without importing the package: what is no robot's name does not need it to work.
    folders = _folders()
    known = [own for own in names if PathFinder.find_spec(f'{_PACKAGE}.{own}', folders) is not None]
    if not known:
        return None
    cache = _cache_folder()
    with _package_apart(cache):
        for own in known:
            found = _found(own)
            if found is not None:
                return found
    raise DescriptionNotCached(known[0], str(cache))


def cached_names() -> tuple[str, ...]:
    """Return the names of the quadrupeds that are in the cache."""
    try:
        if not is_installed() or not is_folder(cache := _cache_folder()):
            return ()
        with _package_apart(cache):
            described = _imported('_descriptions').DESCRIPTIONS
            quadrupeds = [
                str(name)
                for name, own in described.items()
                if 'quadruped' in getattr(own, 'tags', ())
            ]
            return tuple(name for name in quadrupeds if _is_held(name))
    # Of another version, or without what it needs: nothing that could be offered.
    except (AttributeError, TypeError, *_REFUSALS):
        return ()


def _is_held(name: str) -> bool:
    """Return whether a description can be had; one that is damaged hides no others."""
    try:
        return _found(name) is not None
    except _REFUSALS:
        return False


def _cache_folder() -> Path:
    given = os.environ.get('ROBOT_DESCRIPTIONS_CACHE', '~/.cache/robot_descriptions')
    return user_path(given, f'cache of {_PACKAGE}')


def _folders() -> list[str]:
    """List the folders of the package's modules; none of a single module of that name."""
    found = importlib.util.find_spec(_PACKAGE)
    return [] if found is None else list(found.submodule_search_locations or ())


def _found(name: str) -> CachedDescription | None:
    """Return a description by its full name; None if the cache does not hold it."""
    try:
        module = _imported(name)
    except _NotThere:
        return None
    for attribute in _PATHS:
        path = getattr(module, attribute, None)
        if isinstance(path, str) and is_file(path):
            given = getattr(module, 'XACRO_ARGS', None) if attribute == 'XACRO_PATH' else None
            if not isinstance(given, Mapping):
                given = {}
            arguments = tuple((str(key), str(value)) for key, value in given.items())
            return CachedDescription(Path(path), ImportOptions(arguments=arguments))
    return None


def _imported(name: str) -> Any:
    """
    Import one of the package's modules, apart from it.

    Raises
    ------
    _NotThere
        If it wants a repository that is not in the cache.
    MissingOptionalDependency
        If it needs a package that is not installed.
    DescriptionPackageUnusable
        If it fails otherwise.
    """
    try:
        return importlib.import_module(f'{_APART}.{name}')
    except _NotThere:
        raise
    # Modules of another version, or damaged ones, raise what they like.
    except Exception as error:
        if isinstance(error, ModuleNotFoundError) and error.name is not None:
            missing = error.name.partition('.')[0]
            if missing not in (_APART, _PACKAGE):
                raise MissingOptionalDependency(missing, f'pip install {_PACKAGE}') from error
        reason = f'{type(error).__name__}: {error}'.replace(_APART, _PACKAGE)
        raise DescriptionPackageUnusable(_PACKAGE, reason) from error


@contextmanager
def _package_apart(cache: Path) -> Iterator[None]:
    """
    Make a package of the same modules, which finds its repositories in the cache or not at all.

    The installed one stays as it is, also for other threads, and what it clones with is not needed.
    """
    with _LOCK:
        package, own_cache = ModuleType(_APART), ModuleType(f'{_APART}._cache')
        package.__path__ = _folders()
        sys.modules[_APART], sys.modules[own_cache.__name__] = package, own_cache
        try:
            repositories = getattr(_imported('_repositories'), 'REPOSITORIES', {})
            vars(own_cache)['clone_to_cache'] = _finder(repositories, cache)
            yield
        finally:
            for name in [name for name in sys.modules if name.partition('.')[0] == _APART]:
                del sys.modules[name]


def _finder(repositories: Any, cache: Path) -> Callable[..., str]:
    """Return what modules call in place of the function that clones."""

    def folder_of(repository: str, commit: str | None = None) -> str:
        own = repositories[repository].cache_path
        folder = cache / (own if commit is None else f'{own}-{commit}/{own}')
        if not is_folder(folder):
            raise _NotThere
        return str(folder)

    return folder_of
