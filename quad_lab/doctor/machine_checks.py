"""
Checks of Python, its packages, files and ports.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
import shutil
import socket
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from quad_common.named_robots.robot_cache import cache_folder
from quad_lab.doctor.finding import Finding, good, missing, wrong
from quad_view.parameters import ViewerParameters

_NEEDED = ('numpy', 'scipy', 'numba', 'cv2', 'PIL', 'yaml', 'matplotlib', 'rich')
"""Packages without which nothing works, by the names they are imported by."""

_EXTRAS = (
    ('yourdfpy', 'robots from URDF files', 'robots'),
    ('xacro', 'robots from xacro files', 'robots'),
    ('rosbags', 'recordings', 'record'),
    ('viser', 'viewer', 'view'),
)
"""Packages for some: name, purpose, and the extra that has them."""

_VERSIONS = ((3, 10), (3, 13))
"""First and last version of Python that is tested."""

_LITTLE_ROOM = 0.5
"""Room on a disk below which recordings and caches run out of it soon [GB]."""


def check_python() -> Iterator[Finding]:
    """Look at Python itself, and at the packages that are needed."""
    version = platform.python_version()
    first, last = (f'{major}.{minor}' for major, minor in _VERSIONS)
    if _VERSIONS[0] <= sys.version_info[:2] <= _VERSIONS[1]:
        yield good('Python', f'{version} in {sys.prefix}')
    else:
        said = f'{version}; tested are {first} to {last}'
        yield wrong('Python', said, f'make venv PYTHON=python{first}')
    absent = [name for name in _NEEDED if importlib.util.find_spec(name) is None]
    if absent:
        yield wrong('packages', f'absent: {", ".join(absent)}', "pip install '.'")
    else:
        yield good('packages', ', '.join(_NEEDED))
    for name, purpose, extra in _EXTRAS:
        if importlib.util.find_spec(name) is None:
            yield missing(name, f'absent: no {purpose}', f"pip install 'quadwalk[{extra}]'")
        else:
            yield good(name, f'{_version(name)}: {purpose}')


def _version(name: str) -> str:
    """Return a package's version; of one that the system brings it may not be known."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return 'of the system'


def check_files() -> Iterator[Finding]:
    """Look at the places where something is written."""
    for subject, folder in (
        ('this folder', Path.cwd()),
        ('temporary files', Path(tempfile.gettempdir())),
        ('imported robots', cache_folder()),
    ):
        there = next(at for at in (folder, *folder.parents) if at.exists())
        try:
            with tempfile.TemporaryFile(dir=there):
                pass
        except OSError:
            mend = 'set XDG_CACHE_HOME to a folder of your own'
            if subject != 'imported robots':
                mend = 'go to a folder of your own, or set TMPDIR to one'
            yield wrong(subject, f'{there} cannot be written', mend)
            continue
        free = shutil.disk_usage(there).free / 1e9
        if free < _LITTLE_ROOM:
            yield wrong(subject, f'{free:.2f} GB free in {there}', 'remove what is not needed')
        else:
            yield good(subject, f'{free:.0f} GB free in {there}')


def check_port() -> Iterator[Finding]:
    """Look whether the viewer's page can have its port."""
    page = ViewerParameters()
    with socket.socket() as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((page.host, page.port))
        except OSError as error:
            said = f'{page.port} on {page.host}: {error.strerror}'
            yield missing('port', said, 'the next free one is taken, or --port')
        else:
            yield good('port', f"{page.port} on {page.host} is free for the viewer's page")


def check_processors() -> Iterator[Finding]:
    """Look at how busy the machine is."""
    count = os.cpu_count() or 1
    load = os.getloadavg()[0]
    said = f'{count} processors, {load:.1f} of them busy'
    if load > 0.8 * count:
        mend = 'walk in real time or slower: --real-time-factor 1'
        yield missing('processors', f'{said}: walks over topics are slower', mend)
    else:
        yield good('processors', said)
