"""The URDF says what the robot's data say."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from quad_common.robot import LEGS, load_robot
from quad_common.urdf import urdf_from_robot

ROBOT = load_robot('titan_viii')
ROOT = ElementTree.fromstring(urdf_from_robot(ROBOT))
LINKS = {link.get('name'): link for link in ROOT.iter('link')}
JOINTS = {joint.get('name'): joint for joint in ROOT.iter('joint')}


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


def place(link, angles):
    """Homogeneous matrix of a link in base_link, from the XML alone."""
    for name, joint in JOINTS.items():
        if joint.find('child').get('link') == link:
            moved = np.eye(4)
            if joint.get('type') == 'revolute':
                moved[:3, :3] = rotation(vector(joint.find('axis')), angles[name])
            parent = place(joint.find('parent').get('link'), angles)
            return parent @ origin(joint.find('origin')) @ moved
    assert link == 'base_link'
    return np.eye(4)


def test_the_links_weigh_40_kg():
    masses = [float(link.find('inertial/mass').get('value')) for link in LINKS.values()]
    assert sum(masses) == pytest.approx(40.0, abs=1e-9)
    assert min(masses) > 0.0


def test_every_leg_has_hip_thigh_calf_and_foot():
    parts = ('hip', 'thigh', 'calf', 'foot')
    assert set(LINKS) == {'base_link'} | {f'{leg}_{part}' for leg in LEGS for part in parts}


def test_every_link_but_the_base_hangs_on_one_joint():
    children = [joint.find('child').get('link') for joint in JOINTS.values()]
    assert sorted(children) == sorted(set(LINKS) - {'base_link'})
    parents = {joint.find('parent').get('link') for joint in JOINTS.values()}
    assert parents <= set(LINKS)


def test_moving_joints_are_the_robots_in_its_order():
    moving = [name for name, joint in JOINTS.items() if joint.get('type') == 'revolute']
    assert tuple(moving) == ROBOT.joint_names
    fixed = [name for name, joint in JOINTS.items() if joint.get('type') == 'fixed']
    assert fixed == [f'{leg}_foot_joint' for leg in LEGS]
    assert len(JOINTS) == 16


@pytest.mark.parametrize('quantity', ['lower', 'upper', 'velocity', 'effort'])
def test_limits_are_the_robots(quantity):
    in_urdf = [float(JOINTS[name].find('limit').get(quantity)) for name in ROBOT.joint_names]
    assert in_urdf == pytest.approx(np.tile(getattr(ROBOT, quantity), 4), abs=1e-9)


def test_the_feet_of_the_urdf_are_where_the_kinematics_put_them():
    for posture in np.random.default_rng(1).uniform(ROBOT.lower, ROBOT.upper, (25, 4, 3)):
        angles = dict(zip(ROBOT.joint_names, posture.reshape(-1)))
        feet = [place(f'{leg}_foot', angles)[:3, 3] for leg in LEGS]
        assert ROBOT.foot_positions(posture) == pytest.approx(np.array(feet), abs=1e-8)


def test_every_inertia_is_that_of_a_body_that_can_exist():
    for name, link in LINKS.items():
        inertia = link.find('inertial/inertia')
        xx, yy, zz, xy, xz, yz = (
            float(inertia.get(f'i{axes}')) for axes in ('xx', 'yy', 'zz', 'xy', 'xz', 'yz')
        )
        principal = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert principal[0] > 0.0, name
        assert principal[0] + principal[1] >= principal[2] * (1.0 - 1e-9), name


def test_inertia_and_shape_share_one_place():
    for link in LINKS.values():
        inertial = origin(link.find('inertial/origin'))
        for use in ('visual', 'collision'):
            assert origin(link.find(f'{use}/origin')) == pytest.approx(inertial)


def test_inertias_are_those_of_the_solid_shapes():
    for link in LINKS.values():
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


@pytest.mark.parametrize('leg', LEGS)
def test_rods_run_from_their_joint_to_the_next(leg):
    for part, next_joint in (
        ('hip', f'{leg}_hip_pitch_joint'),
        ('thigh', f'{leg}_knee_pitch_joint'),
        ('calf', f'{leg}_foot_joint'),
    ):
        collision = LINKS[f'{leg}_{part}'].find('collision')
        length = float(collision.find('geometry/cylinder').get('length'))
        ends = [
            (origin(collision.find('origin')) @ [0.0, 0.0, half * length, 1.0])[:3]
            for half in (-0.5, 0.5)
        ]
        assert ends[0] == pytest.approx(np.zeros(3), abs=1e-8)
        assert ends[1] == pytest.approx(vector(JOINTS[next_joint].find('origin')), abs=1e-8)


def test_the_foot_is_the_lowest_part_of_the_standing_robot():
    angles = dict(zip(ROBOT.joint_names, ROBOT.initial_joint_angles.reshape(-1)))
    sole = place('lf_foot', angles)[2, 3] - ROBOT.foot_radius
    assert sole == pytest.approx(-ROBOT.standing_height)
    assert -ROBOT.body_size[2] / 2.0 + ROBOT.body_center[2] > sole + 0.2
