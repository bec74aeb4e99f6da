"""MuJoCo's pictures and window, where there is nothing to draw them with."""

import importlib
import subprocess
import sys

import pytest

pytest.importorskip('mujoco')

from quad_common.errors import NoDisplay, NoRenderer
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import make_simulator
from quad_sim.parameters import SimParameters
from quad_sim.sim_session import SimSession

ROBOT = load_robot('genibo')


def test_without_egl_and_osmesa_a_camera_is_refused_at_the_start(monkeypatch):
    usual = importlib.import_module

    def import_module(name, *arguments):
        if name in ('mujoco.egl', 'mujoco.osmesa'):
            raise ImportError(f'no library for {name}')
        return usual(name, *arguments)

    monkeypatch.setattr(importlib, 'import_module', import_module)
    parameters = SimParameters(robot='genibo', backend='mujoco', camera=True)
    with pytest.raises(
        NoRenderer, match=r'need EGL or OSMesa.* libegl1 .*no library for mujoco\.egl'
    ):
        SimSession(parameters, ROBOT, lambda: 0.0)


def test_without_pictures_nothing_is_needed_that_draws(monkeypatch):
    monkeypatch.setenv('MUJOCO_GL', 'nothing')
    simulator = make_simulator('mujoco', ROBOT, None)
    simulator.step(ROBOT.initial_joint_angles.reshape(-1), [0.0] * 12)
    simulator.close()


def test_without_a_screen_a_window_is_refused(monkeypatch):
    for name in ('DISPLAY', 'WAYLAND_DISPLAY'):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(NoDisplay, match=r'there is no screen for a window .* run it without gui'):
        make_simulator('mujoco', ROBOT, None, gui=True)


def test_a_simulator_that_draws_and_is_never_closed_ends_in_silence():
    script = (
        'from quad_common.robot_files.robot_file import load_robot\n'
        'from quad_sim.engines.registry import make_simulator\n'
        'simulator = make_simulator("mujoco", load_robot("genibo"), None)\n'
        'simulator.prepare_pictures()\n'
    )
    command = [sys.executable, '-c', script]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=100.0)
    if 'need EGL or OSMesa' in ended.stderr:
        pytest.skip("nothing draws MuJoCo's pictures here")
    assert ended.returncode == 0, ended.stderr
    # Drivers may say something of their own.
    assert 'Traceback' not in ended.stderr
