"""The URDF says what the robot's data say."""

import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from quad_common.robot.robot_build import LEGS
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot


class Model:
    """A robot, and the links and joints of its URDF."""

    def __init__(self, robot):
        self.robot = robot
        self.text = urdf_from_robot(robot)
        root = ElementTree.fromstring(self.text)
        self.links = {link.get('name'): link for link in root.iter('link')}
        self.joints = {joint.get('name'): joint for joint in root.iter('joint')}

    def angles(self, posture):
        return dict(zip(self.robot.joint_names, np.reshape(posture, -1)))

    def random_postures(self, count):
        robot = self.robot
        return np.random.default_rng(1).uniform(robot.lower, robot.upper, (count, 4, 3))

    def place(self, link, angles):
        """Homogeneous matrix of a link in base_link, from the XML alone."""
        for name, joint in self.joints.items():
            if joint.find('child').get('link') == link:
                moved = np.eye(4)
                if joint.get('type') == 'revolute':
                    moved[:3, :3] = rotation(vector(joint.find('axis')), angles[name])
                parent = self.place(joint.find('parent').get('link'), angles)
                return parent @ origin(joint.find('origin')) @ moved
        assert link == 'base_link'
        return np.eye(4)


def odd_robot():
    """Make a roll robot with every offset and a sign of its own for each leg's joints."""
    robot = load_robot('cuhk')
    signs = ((1, -1, 1), (-1, 1, 1), (1, 1, -1), (-1, -1, -1))
    legs = tuple(
        replace(leg, axial_offset=0.01, lateral_offset=0.02 - 0.01 * k, signs=signs[k])
        for k, leg in enumerate(robot.legs)
    )
    posture = robot.initial_joint_angles * signs
    return replace(robot, name='odd', legs=legs, initial_joint_angles=posture)


def bare_robot():
    """Make a robot whose pitch axes go through its hip points."""
    robot = load_robot('genibo')
    return replace(
        robot, name='bare', legs=tuple(replace(leg, lateral_offset=0.0) for leg in robot.legs)
    )


ROBOTS = [
    *(load_robot(name) for name in ('titan_viii', 'pukyong', 'cuhk', 'genibo')),
    odd_robot(),
    bare_robot(),
]
MODELS = {robot.name: Model(robot) for robot in ROBOTS}

each_model = pytest.mark.parametrize('model', MODELS.values(), ids=MODELS)


def vector(element, name='xyz'):
    return np.array([float(number) for number in element.get(name).split()])


def rotation(axis, angle):
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k


def origin(element):
    """Homogeneous matrix of an <origin>: fixed axes roll, pitch, yaw."""
    roll, pitch, yaw = vector(element, 'rpy')
    matrix = np.eye(4)
    matrix[:3, :3] = (
        rotation((0, 0, 1), yaw) @ rotation((0, 1, 0), pitch) @ rotation((1, 0, 0), roll)
    )
    matrix[:3, 3] = vector(element)
    return matrix


@each_model
def test_the_links_weigh_what_the_robot_does(model):
    masses = [float(link.find('inertial/mass').get('value')) for link in model.links.values()]
    assert sum(masses) == pytest.approx(model.robot.mass, abs=1e-9)
    assert min(masses) > 0.0


@each_model
def test_every_leg_has_hip_thigh_calf_and_foot(model):
    parts = ('hip', 'thigh', 'calf', 'foot')
    assert set(model.links) == {'base_link'} | {f'{leg}_{part}' for leg in LEGS for part in parts}


@each_model
def test_every_link_but_the_base_hangs_on_one_joint(model):
    children = [joint.find('child').get('link') for joint in model.joints.values()]
    assert sorted(children) == sorted(set(model.links) - {'base_link'})
    parents = {joint.find('parent').get('link') for joint in model.joints.values()}
    assert parents <= set(model.links)


@each_model
def test_moving_joints_are_the_robots_in_its_order(model):
    moving = [name for name, joint in model.joints.items() if joint.get('type') == 'revolute']
    assert tuple(moving) == model.robot.joint_names
    fixed = [name for name, joint in model.joints.items() if joint.get('type') == 'fixed']
    assert fixed == [f'{leg}_foot_joint' for leg in LEGS]
    assert len(model.joints) == 16


@each_model
@pytest.mark.parametrize('quantity', ['lower', 'upper', 'velocity', 'effort'])
def test_limits_are_the_robots(model, quantity):
    limits = [model.joints[name].find('limit') for name in model.robot.joint_names]
    in_urdf = [float(limit.get(quantity)) for limit in limits]
    assert in_urdf == pytest.approx(getattr(model.robot, quantity).reshape(-1), abs=1e-8)


@each_model
def test_the_feet_of_the_urdf_are_where_the_kinematics_put_them(model):
    for posture in model.random_postures(25):
        angles = model.angles(posture)
        feet = [model.place(f'{leg}_foot', angles)[:3, 3] for leg in LEGS]
        assert model.robot.foot_positions(posture) == pytest.approx(np.array(feet), abs=1e-8)


@each_model
def test_the_joints_of_the_urdf_are_where_the_kinematics_put_them(model):
    for posture in model.random_postures(5):
        angles = model.angles(posture)
        pitch_axes, knees, _ = model.robot.stacked_legs.chain(posture)
        for k, leg in enumerate(LEGS):
            thigh, calf = (model.place(f'{leg}_{part}', angles) for part in ('thigh', 'calf'))
            assert thigh[:3, 3] == pytest.approx(pitch_axes[k], abs=1e-8)
            assert calf[:3, 3] == pytest.approx(knees[k], abs=1e-8)


@each_model
def test_the_axes_of_the_hips_are_those_of_the_kinematics(model):
    at_zero = model.angles(np.zeros((4, 3)))
    for leg in model.robot.legs:
        axes = model.place(f'{leg.name}_hip', at_zero)[:3, :3].T
        assert axes == pytest.approx(
            np.array([leg.radial_direction, leg.lateral_direction, leg.first_axis]), abs=1e-8
        )


@each_model
def test_pybullet_puts_the_links_where_the_kinematics_do(model, tmp_path):
    pybullet = pytest.importorskip('pybullet')
    path = tmp_path / 'robot.urdf'
    path.write_text(model.text, encoding='utf-8')
    client = pybullet.connect(pybullet.DIRECT)
    try:
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        body = pybullet.loadURDF(str(path), flags=flags, physicsClientId=client)
        joints, links = {}, {}
        for index in range(pybullet.getNumJoints(body, physicsClientId=client)):
            info = pybullet.getJointInfo(body, index, physicsClientId=client)
            joints[info[1].decode()] = links[info[12].decode()] = index
        for posture in model.random_postures(20):
            for name, angle in model.angles(posture).items():
                pybullet.resetJointState(body, joints[name], angle, physicsClientId=client)
            expected = dict(zip(('thigh', 'calf', 'foot'), model.robot.stacked_legs.chain(posture)))
            for part, places in expected.items():
                for leg, place in zip(LEGS, places):
                    state = pybullet.getLinkState(
                        body,
                        links[f'{leg}_{part}'],
                        computeForwardKinematics=True,
                        physicsClientId=client,
                    )
                    assert state[4] == pytest.approx(place, abs=1e-6)
    finally:
        pybullet.disconnect(client)


@each_model
def test_every_inertia_is_that_of_a_body_that_can_exist(model):
    for name, link in model.links.items():
        inertia = link.find('inertial/inertia')
        xx, yy, zz, xy, xz, yz = (
            float(inertia.get(f'i{axes}')) for axes in ('xx', 'yy', 'zz', 'xy', 'xz', 'yz')
        )
        principal = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert principal[0] > 0.0, name
        assert principal[0] + principal[1] >= principal[2] * (1.0 - 1e-9), name


@each_model
def test_inertia_and_shape_share_one_place(model):
    for link in model.links.values():
        inertial = origin(link.find('inertial/origin'))
        for use in ('visual', 'collision'):
            assert origin(link.find(f'{use}/origin')) == pytest.approx(inertial)


@each_model
def test_inertias_are_those_of_the_solid_shapes(model):
    for link in model.links.values():
        mass = float(link.find('inertial/mass').get('value'))
        shape = link.find('collision/geometry')[0]
        if shape.tag == 'box':
            x, y, z = vector(shape, 'size')
            expected = mass / 12.0 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
        elif shape.tag == 'cylinder':
            r, h = float(shape.get('radius')), float(shape.get('length'))
            across = mass * (3.0 * r * r + h * h) / 12.0
            expected = np.array([across, across, mass * r * r / 2.0])
        else:
            expected = np.full(3, 0.4 * mass * float(shape.get('radius')) ** 2)
        inertia = link.find('inertial/inertia')
        told = [float(inertia.get(name)) for name in ('ixx', 'iyy', 'izz')]
        assert told == pytest.approx(expected, rel=1e-6)


@each_model
@pytest.mark.parametrize('leg', LEGS)
def test_rods_run_from_their_joint_to_the_next(model, leg):
    for part, next_joint in (
        ('hip', f'{leg}_hip_pitch_joint'),
        ('thigh', f'{leg}_knee_pitch_joint'),
        ('calf', f'{leg}_foot_joint'),
    ):
        collision = model.links[f'{leg}_{part}'].find('collision')
        cylinder = collision.find('geometry/cylinder')
        length = 0.0 if cylinder is None else float(cylinder.get('length'))
        ends = [
            (origin(collision.find('origin')) @ [0.0, 0.0, half * length, 1.0])[:3]
            for half in (-0.5, 0.5)
        ]
        assert ends[0] == pytest.approx(np.zeros(3), abs=1e-8)
        assert ends[1] == pytest.approx(vector(model.joints[next_joint].find('origin')), abs=1e-8)


def test_a_hip_without_any_way_to_its_pitch_axis_is_a_ball_of_its_radius():
    shape = MODELS['bare'].links['lf_hip'].find('collision/geometry')[0]
    assert (shape.tag, float(shape.get('radius'))) == ('sphere', 0.012)


@each_model
def test_the_foot_is_the_lowest_part_of_the_standing_robot(model):
    robot = model.robot
    angles = model.angles(robot.initial_joint_angles)
    sole = model.place('lf_foot', angles)[2, 3] - robot.foot_radius
    assert sole == pytest.approx(-robot.standing_height)
    clear = 0.5 * robot.standing_height
    assert -robot.body_size[2] / 2.0 + robot.body_center[2] > sole + clear
