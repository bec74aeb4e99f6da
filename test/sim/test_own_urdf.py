"""
A robot with a URDF of its own is simulated on its own links.
"""

from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import RobotNotLoaded
from quad_common.planar_pose import Pose2D
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import yaw_from_quaternion

pytest.importorskip('yourdfpy')

from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_sim.engines.registry import ENGINES, make_simulator
from quad_sim.world.world import Obstacle

ENGINES_WITH_PHYSICS = [
    name for name, engine in ENGINES.items() if engine.has_world and engine.is_installed
]


@pytest.fixture(scope='module')
def own(tmp_path_factory):
    """Genibo by its own URDF, with other names, its root turned and its mass off the middle."""
    folder = tmp_path_factory.mktemp('own')
    text = urdf_from_robot(load_robot('genibo')).replace('base_link', 'trunk')
    text = text.replace('lf_foot', 'toe one').replace('lf_calf', 'shank one')
    inertia = text.split('<inertia ', 1)[1].split('/>', 1)[0]
    text = text.replace(inertia, inertia.replace('ixy="0"', 'ixy="0.0001"'), 1)
    path = folder / 'own.urdf'
    path.write_text(text)
    data_file, _ = write_robot(import_robot(path), folder / 'own.yaml')
    return load_robot(data_file)


@pytest.fixture(params=ENGINES_WITH_PHYSICS)
def simulator(request, own):
    made = make_simulator(request.param, own, None)
    yield made
    made.close()


def stand(simulator, own, seconds):
    angles = own.initial_joint_angles.reshape(-1)
    for _ in range(round(seconds / simulator.time_step)):
        simulator.step(angles, np.zeros(12))
    return simulator.observe()


def test_it_stands_where_it_is_put(simulator, own):
    simulator.reset(Pose2D(1.0, -2.0, 0.7))
    observed = stand(simulator, own, 1.0)
    assert np.abs(observed.position[:2] - (1.0, -2.0)).max() < 2e-3
    assert observed.position[2] == pytest.approx(own.standing_height, abs=2e-3)
    assert yaw_from_quaternion(observed.orientation) == pytest.approx(0.7, abs=5e-3)
    assert not observed.has_fallen
    assert observed.contacts == ()
    assert np.abs(observed.joint_positions - own.initial_joint_angles.reshape(-1)).max() < 0.01


def test_its_feet_carry_its_weight(simulator, own):
    stand(simulator, own, 1.0)
    forces = simulator.foot_forces()
    assert forces.min() > 0.0
    assert forces.sum() == pytest.approx(9.80665 * own.mass, rel=0.02)


def test_contacts_have_its_own_names(simulator, own):
    simulator.reset(Pose2D(0.0, 0.0, 0.0))
    x, y, _ = own.stacked_legs.chain(own.initial_joint_angles)[1][0]
    knee = float(own.standing_height + own.stacked_legs.chain(own.initial_joint_angles)[1][0, 2])
    # A crate as high as the left front knee, where the shank is.
    place = Pose2D(float(x), float(y), 0.0)
    simulator.put_obstacle('crate', Obstacle('box', place, 0.03, 0.03, knee))
    simulator.step(own.initial_joint_angles.reshape(-1), np.zeros(12))
    touching = {contact.link for contact in simulator.observe().contacts}
    assert 'shank one' in touching
    assert not touching & {'base_link', 'lf_calf'}


def test_a_fall_is_told_by_its_own_links(own):
    assert own.part_names.falls >= {'trunk'}
    assert own.part_names.feet[0] == 'toe one'


FLAT = 'v 0 0 0\nv .1 0 0\nv 0 .1 0\nf 1 2 3\n'


@pytest.mark.parametrize('engine', ENGINES_WITH_PHYSICS)
@pytest.mark.parametrize('use', ['visual', 'collision'])
def test_a_robot_with_a_flat_mesh_stands_in_any_engine(engine, use, tmp_path):
    (tmp_path / 'flat.obj').write_text(FLAT)
    mesh = f'<{use}><geometry><mesh filename="flat.obj"/></geometry></{use}>'
    path = tmp_path / 'plated.urdf'
    text = urdf_from_robot(load_robot('genibo'))
    path.write_text(text.replace('</inertial>', f'</inertial>{mesh}', 1))
    data_file, _ = write_robot(import_robot(path), tmp_path / 'plated.yaml')
    robot = load_robot(data_file)
    simulator = make_simulator(engine, robot, None)
    try:
        assert not stand(simulator, robot, 0.1).has_fallen
    finally:
        simulator.close()


def test_what_mujoco_cannot_compile_is_a_robot_that_is_not_loaded(own, tmp_path):
    pytest.importorskip('mujoco')
    flat = tmp_path / 'flat.obj'
    flat.write_text(FLAT)
    mesh = f'<collision><geometry><mesh filename="{flat}"/></geometry></collision>'
    broken = replace(own, own_urdf=own.own_urdf.replace('</inertial>', f'</inertial>{mesh}', 1))
    with pytest.raises(RobotNotLoaded, match=r"MuJoCo cannot load the URDF of 'own': .*'flat'"):
        make_simulator('mujoco', broken, None)
