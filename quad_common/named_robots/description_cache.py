"""
Robots of the package ``robot_descriptions``, of those descriptions that its cache already holds.

The package (https://github.com/robot-descriptions/robot_descriptions.py) is a list of repositories
and of paths in them; each of its modules clones its repository when it is imported. Nothing is
cloned here: modules are imported with a function that only looks where the clone would be.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from quad_common.errors import DescriptionNotCached, MissingOptionalDependency
from quad_common.importing.options import ImportOptions

_PACKAGE = 'robot_descriptions'

_END = '_description'
"""End of the names of descriptions."""

_PATHS = ('URDF_PATH', 'XACRO_PATH', 'MJCF_PATH')
"""Names that a module gives to its description, the richest format first: MJCF has no speeds."""


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
    return importlib.util.find_spec(_PACKAGE) is not None


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
    MissingOptionalDependency
        If the name ends with ``_description`` and the package or one that it needs is missing.
    """
    if not name.isidentifier():
        return None
    if not is_installed():
        if name.endswith(_END):
            raise MissingOptionalDependency(_PACKAGE, f'pip install {_PACKAGE}')
        return None
    names = [name] if name.endswith(_END) else [f'{name}{_END}', f'{name}_mj{_END}']
    known = [own for own in names if importlib.util.find_spec(f'{_PACKAGE}.{own}') is not None]
    for own in known:
        found = _found(own)
        if found is not None:
            return found
    if known:
        raise DescriptionNotCached(known[0], str(_cache_folder()))
    return None


def cached_names() -> tuple[str, ...]:
    """Return the names of the quadrupeds that are in the cache."""
    if not is_installed() or not _cache_folder().is_dir():
        return ()
    try:
        described = importlib.import_module(_PACKAGE).DESCRIPTIONS
        quadrupeds = [n for n, own in described.items() if 'quadruped' in getattr(own, 'tags', ())]
        return tuple(name for name in quadrupeds if _found(name) is not None)
    # Of another version, or without what it needs: nothing that could be offered.
    except (ImportError, AttributeError, MissingOptionalDependency):
        return ()


def _cache_folder() -> Path:
    given = os.environ.get('ROBOT_DESCRIPTIONS_CACHE', '~/.cache/robot_descriptions')
    return Path(given).expanduser()


def _found(name: str) -> CachedDescription | None:
    """Return a description by its full name; None if the cache does not hold it."""
    module_name = f'{_PACKAGE}.{name}'
    try:
        with _without_cloning():
            before = sys.modules.pop(module_name, None)
            try:
                module: Any = importlib.import_module(module_name)
            finally:
                # Programs that import it themselves get the package's own.
                sys.modules.pop(module_name, None)
                if before is not None:
                    sys.modules[module_name] = before
    except _NotThere:
        return None
    except ImportError as error:
        missing = str(error.name or _PACKAGE).partition('.')[0]
        raise MissingOptionalDependency(missing, f'pip install {_PACKAGE}') from error
    for attribute in _PATHS:
        path = getattr(module, attribute, None)
        if isinstance(path, str) and Path(path).is_file():
            is_xacro = attribute == 'XACRO_PATH'
            given = getattr(module, 'XACRO_ARGS', {}) if is_xacro else {}
            arguments = tuple((str(key), str(value)) for key, value in given.items())
            return CachedDescription(Path(path), ImportOptions(arguments=arguments))
    return None


@contextmanager
def _without_cloning() -> Iterator[None]:
    """Let the package's modules find their repositories in the cache, or not at all."""
    cache: Any = importlib.import_module(f'{_PACKAGE}._cache')
    repositories = importlib.import_module(f'{_PACKAGE}._repositories').REPOSITORIES

    def folder_of(repository: str, commit: str | None = None) -> str:
        own = repositories[repository].cache_path
        folder = _cache_folder() / (own if commit is None else f'{own}-{commit}/{own}')
        if not folder.is_dir():
            raise _NotThere
        return str(folder)

    before = cache.clone_to_cache
    cache.clone_to_cache = folder_of
    try:
        yield
    finally:
        cache.clone_to_cache = before
