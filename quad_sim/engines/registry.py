"""
The simulators there are, by the names of their backends: another one joins with a row.
"""

from __future__ import annotations

import importlib
import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from quad_common.errors import NotSimulated, ParameterError
from quad_common.robot.robot import Robot
from quad_sim.engines.simulator import Simulator
from quad_sim.world.appearance import Appearance
from quad_sim.world.world import World, world_from_map


@dataclass(frozen=True)
class Engine:
    """A simulator that can be chosen, and what it simulates."""

    module: str
    """Module that holds its class; imported when it is chosen."""
    name: str
    """Name of its class."""
    package: str = ''
    """Package that must be installed, by the name it is imported by; empty if none."""
    has_world: bool = True
    """Whether there are forces, walls, obstacles and uneven ground."""
    has_pictures: bool = False
    """Whether cameras see its world."""
    has_window: bool = False
    """Whether it can show a window of its own."""

    @property
    def is_installed(self) -> bool:
        """Whether its package is there."""
        return not self.package or importlib.util.find_spec(self.package) is not None


ENGINES = {
    'bullet': Engine(
        'quad_sim.engines.bullet_simulator',
        'BulletSimulator',
        'pybullet',
        has_pictures=True,
        has_window=True,
    ),
    'mujoco': Engine(
        'quad_sim.engines.mujoco_simulator',
        'MujocoSimulator',
        'mujoco',
        has_pictures=True,
        has_window=True,
    ),
    'kinematic': Engine(
        'quad_sim.engines.kinematic_simulator', 'KinematicSimulator', has_world=False
    ),
}
"""Each backend; of those with physics the first that is installed is taken for ``auto``."""

AUTO = 'auto'

PREFERRED = 'QUADWALK_BACKEND'
"""Environment variable with the backend that ``auto`` is to mean, here and in what is started."""

BACKENDS = (AUTO, *ENGINES)
"""What ``backend`` may be."""


def resolved(backend: str) -> str:
    """
    Return the backend that is meant.

    Parameters
    ----------
    backend : str
        One of :data:`BACKENDS`.

    Returns
    -------
    str
        One of :data:`ENGINES`. For ``auto`` what :data:`PREFERRED` says; without it the first one
        with physics that is installed; the very first if none is, so that its own error says how
        to install it.

    Raises
    ------
    ParameterError
        If there is no such backend.
    """
    if backend not in BACKENDS:
        raise ParameterError('backend', backend, f'one of {", ".join(BACKENDS)}')
    if backend != AUTO:
        return backend
    if preferred := os.environ.get(PREFERRED):
        if preferred not in ENGINES:
            raise ParameterError(PREFERRED, preferred, f'one of {", ".join(ENGINES)}')
        return preferred
    physical = [name for name, engine in ENGINES.items() if engine.has_world]
    return next((name for name in physical if ENGINES[name].is_installed), physical[0])


@contextmanager
def preferred(backend: str) -> Iterator[None]:
    """Let ``auto`` mean a backend, one of :data:`ENGINES`, in this process and those it starts."""
    before = os.environ.get(PREFERRED)
    os.environ[PREFERRED] = backend
    try:
        yield
    finally:
        if before is None:
            del os.environ[PREFERRED]
        else:
            os.environ[PREFERRED] = before


_IN_WINDOW: ContextVar[bool] = ContextVar('in_window', default=False)


@contextmanager
def in_window() -> Iterator[None]:
    """Have simulators that are made meanwhile in this thread show their own windows."""
    token = _IN_WINDOW.set(True)
    try:
        yield
    finally:
        _IN_WINDOW.reset(token)


def engines_with(feature: str) -> tuple[str, ...]:
    """Return the backends that have a feature, one of the fields of :class:`Engine`."""
    return tuple(name for name, engine in ENGINES.items() if getattr(engine, feature))


def make_simulator(
    backend: str,
    robot: Robot,
    world: World | None,
    time_step: float = 0.005,
    gui: bool = False,
    appearance: Appearance | None = None,
) -> Simulator:
    """
    Make a simulator by the name of its backend.

    Parameters
    ----------
    backend : str
        One of :data:`BACKENDS`.
    robot : Robot
        The robot.
    world : World or None
        Ground and obstacles, an empty floor if None; the kinematic one has an empty floor in
        any case.
    time_step : float
        Fixed step [s].
    gui : bool
        Show the engine's own window, where it has one.
    appearance : Appearance, optional
        Appearance of the world in pictures.

    Returns
    -------
    Simulator
        With the robot at the world's origin.

    Raises
    ------
    ParameterError
        If there is no such backend.
    NotSimulated
        If the ground is uneven and the backend has flat ground only, or a window is wanted and
        the backend has none.
    MissingOptionalDependency
        If the backend's package is not installed.
    """
    engine = ENGINES[resolved(backend)]
    gui = gui or _IN_WINDOW.get()
    if gui and engine.has_world and not engine.has_window:
        raise NotSimulated('a window', engines_with('has_window'))
    if not engine.has_world and world is not None and world.terrain is not None:
        raise NotSimulated('uneven ground', engines_with('has_world'))
    make: Any = getattr(importlib.import_module(engine.module), engine.name)
    if not engine.has_world:
        return make(robot, time_step)  # type: ignore[no-any-return]
    world = world_from_map(None) if world is None else world
    return make(robot, world, time_step, gui, appearance)  # type: ignore[no-any-return]
