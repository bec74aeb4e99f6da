"""
Checks of the physics engines, and of what draws their pictures.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np

from quad_common.robot_files.robot_file import load_robot
from quad_lab.doctor.finding import Finding, State, good, missing, wrong
from quad_sim.engines.registry import AUTO, ENGINES, make_simulator, resolved

_STEPS = 200

_PATIENCE = 30.0
"""Time in which an engine must have drawn a picture [s]."""

_PICTURE = """
import sys
import numpy as np
from quad_common.robot_files.robot_file import load_robot
from quad_common.vision.camera import CameraModel
from quad_sim.engines.registry import make_simulator
from quad_sim.world.simulated_camera import SimulatedCamera
simulator = make_simulator(sys.argv[1], load_robot('titan_viii'), None)
simulator.prepare_pictures()
camera = SimulatedCamera(CameraModel.looking_down((0.0, 0.0, 3.0), 0.0, 1.0, (64, 48)))
picture = camera.take(simulator, np.random.default_rng(0))
sys.exit(0 if picture.std() > 0.0 else 'the picture is empty')
"""


def check_engines() -> Iterator[Finding]:
    """Let a robot stand in every engine that is installed, and have it drawn."""
    stands = False
    for name in ENGINES:
        for found in _engine(name) if ENGINES[name].package else ():
            stands = stands or found.state is State.GOOD
            yield found
    if stands:
        yield good('engine by default', resolved(AUTO))
    else:
        yield wrong('engine by default', 'there is none', "pip install 'quadwalk[sim]'")


def _engine(name: str) -> Iterator[Finding]:
    package = ENGINES[name].package
    if not ENGINES[name].is_installed:
        yield missing(package, 'absent', f'pip install {package}')
        return
    robot = load_robot('titan_viii')
    try:
        simulator = make_simulator(name, robot, None)
        began = time.perf_counter()
        for _ in range(_STEPS):
            simulator.step(robot.initial_joint_angles.reshape(-1), np.zeros(12))
        spent = (time.perf_counter() - began) / _STEPS
        simulator.close()
    # Whatever is wrong with an engine's libraries is what is to be told.
    except Exception as error:
        yield wrong(package, str(error), f'pip install --force-reinstall {package}')
        return
    yield good(
        package, f'a robot stands; a step of {simulator.time_step:g} s in {spent * 1e6:.0f} us'
    )
    yield _pictures(name)


def _pictures(name: str) -> Finding:
    """Draw in a process of its own: drivers of graphics may end theirs."""
    subject = f'pictures by {ENGINES[name].package}'
    try:
        done = subprocess.run(
            [sys.executable, '-c', _PICTURE, name],
            capture_output=True, text=True, timeout=_PATIENCE, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return missing(subject, f'none within {_PATIENCE:.0f} s', 'use another backend for cameras')
    if done.returncode == 0:
        return good(subject, 'drawn')
    reason = (done.stderr.strip() or f'exit code {done.returncode}').rpartition('\n')[2]
    return missing(subject, reason[:200], 'sudo apt install libegl1 (or libosmesa6)')
