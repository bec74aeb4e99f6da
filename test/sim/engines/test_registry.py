"""Engines are chosen by name, and what one of them lacks another is named for."""

import importlib.util
import os
import sys
from dataclasses import replace

import pytest

from quad_common.errors import MissingOptionalDependency, NotSimulated, ParameterError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import (
    AUTO,
    ENGINES,
    PREFERRED,
    engines_with,
    in_window,
    make_simulator,
    preferred,
    resolved,
)
from quad_sim.engines.simulator import SolidSimulator, VisibleSimulator
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import world_from_map

ROBOT = load_robot('titan_viii')


@pytest.fixture
def installed(monkeypatch):
    """Pretend that just some packages are installed."""

    def only(*packages):
        monkeypatch.setattr(importlib.util, 'find_spec', lambda name: name in packages or None)

    return only


def test_auto_is_the_first_physics_engine_that_is_installed(installed):
    installed('pybullet', 'mujoco')
    assert resolved(AUTO) == 'bullet'
    installed('mujoco')
    assert resolved(AUTO) == 'mujoco'
    installed()
    # Its own error says how to install it.
    assert resolved(AUTO) == 'bullet'


@pytest.mark.parametrize('name', ENGINES)
def test_an_engine_that_is_named_is_meant(installed, name):
    installed()
    assert resolved(name) == name


def test_an_unknown_engine_is_answered_with_those_that_there_are():
    with pytest.raises(ParameterError, match='one of auto, bullet, mujoco, kinematic'):
        resolved('gazebo')


@pytest.mark.parametrize('name', ENGINES)
def test_an_engine_does_what_the_registry_says(name):
    engine = ENGINES[name]
    if engine.package:
        pytest.importorskip(engine.package)
    simulator = make_simulator(name, ROBOT, None)
    try:
        assert isinstance(simulator, SolidSimulator) == engine.has_world
        assert isinstance(simulator, VisibleSimulator) == engine.has_pictures
    finally:
        simulator.close()


@pytest.mark.parametrize('name', [name for name, engine in ENGINES.items() if engine.package])
def test_an_engine_that_is_not_installed_says_how_to_install_it(monkeypatch, name):
    engine = ENGINES[name]
    monkeypatch.setitem(sys.modules, engine.package, None)
    for module in list(sys.modules):
        if module.startswith(f'quad_sim.engines.{name}'):
            monkeypatch.delitem(sys.modules, module)
    with pytest.raises(MissingOptionalDependency, match=f"needs the package '{engine.package}'"):
        make_simulator(name, ROBOT, None)


def test_what_an_engine_lacks_is_said_with_those_that_have_it(monkeypatch):
    start = Pose2D(0.0, 0.0, 0.0)
    terrain = make_terrain(specs_from_text('bumps'), (-2.0, -2.0, 2.0, 2.0), start)
    world = replace(world_from_map(None), terrain=terrain)
    with pytest.raises(NotSimulated, match=r"uneven ground; .* 'bullet' or 'mujoco'") as caught:
        make_simulator('kinematic', ROBOT, world)
    assert caught.value.backends == engines_with('has_world')
    monkeypatch.setitem(ENGINES, 'mujoco', replace(ENGINES['mujoco'], has_window=False))
    with pytest.raises(NotSimulated, match=r"does not support a window; .* 'bullet'"):
        make_simulator('mujoco', ROBOT, None, gui=True)


def test_the_environment_says_what_auto_means(monkeypatch):
    with preferred('kinematic'):
        assert resolved(AUTO) == 'kinematic'
        assert os.environ[PREFERRED] == 'kinematic'
        with preferred('mujoco'):
            assert resolved(AUTO) == 'mujoco'
        assert resolved(AUTO) == 'kinematic'
        assert resolved('bullet') == 'bullet'
    monkeypatch.setenv(PREFERRED, 'havok')
    with pytest.raises(ParameterError, match=r"QUADWALK_BACKEND.* 'havok'.*bullet, mujoco"):
        resolved(AUTO)


def test_a_window_is_shown_where_one_is_wanted_from_outside(monkeypatch):
    made = []

    def simulator(robot, world, time_step, gui, appearance):
        made.append(gui)

    engine = replace(ENGINES['bullet'], module=__name__, name='SIMULATOR', package='')
    monkeypatch.setitem(ENGINES, 'bullet', engine)
    monkeypatch.setattr(sys.modules[__name__], 'SIMULATOR', simulator, raising=False)
    with in_window():
        make_simulator('bullet', ROBOT, None)
    make_simulator('bullet', ROBOT, None)
    assert made == [True, False]
