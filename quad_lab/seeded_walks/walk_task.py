"""
One walk as a task: a pure function of a case and a seed, and the key of its result.
"""

from __future__ import annotations

import hashlib
import json
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from importlib import metadata
from pathlib import Path

from quad_common.errors import QuadError
from quad_common.errors.quoting import clipped
from quad_common.files.bounded_file import is_file
from quad_common.maps.map_file import load_map
from quad_common.resources import share_directory
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.seeded_walks.goal_walk import walk_to_goal
from quad_lab.seeded_walks.steering import walk_steered
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_settings import Case, walk_of

_CODE = ('quad_common', 'quad_gait', 'quad_planner', 'quad_sim', 'quad_lab/closed_loop',
         'quad_lab/seeded_walks')  # fmt: skip
"""Folders on whose files the figures of a walk depend."""

_DATA = ('.py', '.yaml')

_PACKAGES = ('numpy', 'scipy', 'numba', 'opencv-python-headless', 'pybullet', 'mujoco')

_KEY = 24
"""Characters of a key: 96 bits."""


@dataclass(frozen=True)
class Job:
    """A walk that is to be walked."""

    case: Case
    """What it is, see :mod:`~quad_lab.seeded_walks.walk_settings`."""
    seed: int
    """Seed of its scene and its noise."""


@dataclass(frozen=True)
class Result:
    """A walk that was walked."""

    job: Job
    """The walk."""
    figures: WalkFigures
    """What was measured: the same for the same job, bit for bit."""
    seconds: float
    """Time that it took to compute [s]."""


def run_walk(job: Job, watch: Callable[[ClosedLoop], None] = lambda loop: None) -> Result:
    """
    Walk once; whatever goes wrong becomes a figure.

    Parameters
    ----------
    job : Job
        What to walk.
    watch : callable
        Called with the loop before the robot walks.

    Returns
    -------
    Result
        The same figures for the same job, in whatever process and order.
    """
    began = time.perf_counter()
    try:
        walk = walk_of(job.case)
        walked = walk_to_goal if walk.settings.task == 'goal' else walk_steered
        figures = walked(walk, job.seed, watch)
    except QuadError as error:
        figures = WalkFigures(problem=clipped(str(error)))
    except Exception as error:  # a thousand other walks must not end with this one
        figures = WalkFigures(problem=clipped(f'{type(error).__name__}: {error}'))
    return Result(job, figures, time.perf_counter() - began)


def key_of(job: Job) -> str:
    """
    Return the key of a walk's result.

    Returns
    -------
    str
        A hash of all that the figures follow from: case, seed, the files that the case names,
        quadwalk's own code and data, the versions of the engines and the kind of processor.
    """
    files = [_content(name, str(value)) for name, value in sorted(job.case.items())]
    said = json.dumps([code_digest(), dict(job.case), job.seed, files], sort_keys=True)
    return hashlib.sha256(said.encode()).hexdigest()[:_KEY]


@lru_cache(maxsize=1)
def code_digest() -> str:
    """Return a hash of the code and data of walks, the engines and the kind of processor."""
    root = Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for folder in _CODE:
        for path in sorted((root / folder).rglob('*')):
            if path.suffix in _DATA and path.is_file():
                digest.update(path.relative_to(root).as_posix().encode() + b'\0')
                digest.update(path.read_bytes())
    for path in sorted((share_directory() / 'maps').iterdir()):
        digest.update(path.name.encode() + b'\0' + path.read_bytes())
    versions = [f'{name} {_version(name)}' for name in _PACKAGES]
    digest.update('\0'.join([*versions, platform.machine()]).encode())
    return digest.hexdigest()[:_KEY]


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return 'not installed'


@lru_cache(maxsize=256)
def _content(name: str, value: str) -> str:
    """Hash the file that a value names; empty if it names none."""
    if name not in ('robot', 'gait', 'map') or not is_file(Path(value).expanduser()):
        return ''
    path = Path(value).expanduser()
    digest = hashlib.sha256(path.read_bytes())
    if name == 'robot':
        digest.update(load_robot(value).own_urdf.encode())
    elif name == 'map':
        digest.update(load_map(path).cells.tobytes())
    return digest.hexdigest()
