"""The moments of moving legs are what MuJoCo makes of the same robot's angular momentum."""

from dataclasses import replace

import numpy as np
import pytest

from quad_common.robot.leg_moments import LegCycle, leg_moments
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')
pytest.importorskip('mujoco')

import mujoco

from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot

GRAVITY = 9.80665
PERIOD, HEIGHT = 0.7, 0.4


@pytest.fixture(scope='module', params=['genibo', 'titan_viii'])
def robot(request, tmp_path_factory):
    """A robot with the inertias of its links, as its data file has them, and its URDF."""
    folder = tmp_path_factory.mktemp(request.param)
    description = folder / 'described.urdf'
    description.write_text(urdf_from_robot(load_robot(request.param)))
    data_file, urdf = write_robot(import_robot(description), folder / 'imported.yaml')
    return load_robot(data_file), urdf


def waves(robot, count, seed=0):
    """Joint angles about the initial posture, a few waves each, and their speeds."""
    rng = np.random.default_rng(seed)
    times = PERIOD * np.arange(count) / count
    angles = np.broadcast_to(robot.initial_joint_angles, (count, 4, 3)).copy()
    speeds = np.zeros_like(angles)
    for wave in (1, 2):
        height, phase = 0.1 * rng.standard_normal((2, 4, 3))
        rate = 2.0 * np.pi * wave / PERIOD
        angles += height * np.sin(rate * times[:, None, None] + phase)
        speeds += height * rate * np.cos(rate * times[:, None, None] + phase)
    return angles, speeds


def moments_of(robot, angles):
    cycle = LegCycle(angles, np.full(len(angles), HEIGHT), PERIOD)
    return leg_moments(robot.stacked_legs, robot.exact_masses, cycle)


def test_legs_that_stand_still_weigh_where_their_masses_are(robot):
    robot, _ = robot
    still = np.broadcast_to(robot.initial_joint_angles, (8, 4, 3))
    masses = robot.exact_masses
    center = robot.center_of_mass(robot.initial_joint_angles) * masses.total
    expected = GRAVITY * (center - masses.body * masses.body_center)[:2]
    assert moments_of(robot, still) == pytest.approx(np.tile(expected, (8, 1)), abs=1e-9)


def test_moments_are_gravitys_less_the_change_of_angular_momentum(robot):
    robot, urdf = robot
    model = mujoco.MjModel.from_xml_path(str(urdf))
    data = mujoco.MjData(model)
    at = [model.joint(name).qposadr[0] for name in robot.joint_names]
    angles, speeds = waves(robot, 64)
    momentum, weight = np.empty((64, 3)), np.empty((64, 2))
    moving = [k for k in range(1, model.nbody) if model.body_mass[k] > 0.0]
    for k, (angle, speed) in enumerate(zip(angles, speeds)):
        data.qpos[at], data.qvel[at] = angle.ravel(), speed.ravel()
        mujoco.mj_forward(model, data)
        mujoco.mj_subtreeVel(model, data)
        # Of the world's subtree; the body is fixed to it, and does not move.
        mass = model.body_mass[moving]
        center = mass @ data.xipos[moving] / mass.sum()
        arm = center + (0.0, 0.0, HEIGHT)
        momentum[k] = data.subtree_angmom[0] + np.cross(arm, mass.sum() * data.subtree_linvel[0])
        weight[k] = GRAVITY * mass.sum() * center[:2]
    rates = 2j * np.pi * np.fft.rfftfreq(64, PERIOD / 64)
    change = np.fft.irfft(np.fft.rfft(momentum, axis=0) * rates[:, None], axis=0)
    expected = weight + np.stack([-change[:, 1], change[:, 0]], axis=1)
    found = moments_of(robot, angles)
    assert np.ptp(found, axis=0).min() > 0.1 * np.abs(weight).max()
    assert found == pytest.approx(expected, abs=2e-3 * np.abs(expected).max())


def test_without_inertias_nothing_is_told(robot):
    robot, _ = robot
    unknown = replace(robot.exact_masses, inertias=None)
    cycle = LegCycle(np.zeros((4, 4, 3)), np.zeros(4), PERIOD)
    with pytest.raises(ValueError, match='not known'):
        leg_moments(robot.stacked_legs, unknown, cycle)
