"""
Whatever a description's names, orders, axes, zero poses and frames: the same robot is found.
"""

import json
from copy import deepcopy
from itertools import product
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from quad_common.robot.leg_kinematics import stack_legs
from quad_common.robot.robot_build import LEGS
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')

from quad_common.errors import (
    DescriptionEntryInvalid,
    DescriptionError,
    JointFiguresMissing,
    MassesMissing,
    NotAQuadruped,
)
from quad_common.importing.options import ImportOptions
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot

SHIPPED = {name: load_robot(name) for name in ('genibo', 'pukyong', 'cuhk', 'titan_viii')}


class Variant:
    """A shipped robot's URDF, and what was done to its joints."""

    def __init__(self, robot):
        self.robot = robot
        self.root = ElementTree.fromstring(urdf_from_robot(robot))
        # Own joint angle = sign * (robot's - zero), by the robot's joint names.
        self.names = {name: name for name in robot.joint_names}
        self.signs = dict.fromkeys(robot.joint_names, 1.0)
        self.zeros = dict.fromkeys(robot.joint_names, 0.0)

    def write(self, folder):
        path = folder / 'variant.urdf'
        path.write_text(ElementTree.tostring(self.root, encoding='unicode'))
        return path

    def joints(self):
        return {joint.get('name'): joint for joint in self.root.iter('joint')}

    def own_angles(self, imported, angles):
        """Angles (4, 3) of the shipped robot in the imported one's order and sense."""
        by_name = {
            self.names[name]: self.signs[name] * (angle - self.zeros[name])
            for name, angle in zip(self.robot.joint_names, np.ravel(angles))
        }
        own = [by_name[joint.name] for chain in imported.chains for joint in chain.joints]
        return np.reshape(own, (4, 3))


def renamed(variant, rng):
    """Names that say nothing."""
    for index, (old, joint) in enumerate(
        sorted(variant.joints().items(), key=lambda _: rng.random())
    ):
        joint.set('name', f'joint {index}')
        if old in variant.names:
            variant.names[old] = f'joint {index}'
    links = {link.get('name'): f'part {k}' for k, link in enumerate(variant.root.iter('link'))}
    for link in variant.root.iter('link'):
        link.set('name', links[link.get('name')])
    for end in (*variant.root.iter('parent'), *variant.root.iter('child')):
        end.set('link', links[end.get('link')])


def shuffled(variant, rng):
    """Links and joints in any order."""
    children = list(variant.root)
    for child in children:
        variant.root.remove(child)
    variant.root.extend(children[k] for k in rng.permutation(len(children)))


def flipped(variant, rng):
    """Axes the other way round, ranges with them."""
    for name, joint in variant.joints().items():
        if name not in variant.names or rng.random() < 0.5:
            continue
        axis, limit = joint.find('axis'), joint.find('limit')
        axis.set('xyz', ' '.join(str(-float(x)) for x in axis.get('xyz').split()))
        lower, upper = float(limit.get('lower')), float(limit.get('upper'))
        limit.set('lower', str(-upper))
        limit.set('upper', str(-lower))
        variant.signs[name] = -1.0


def bent(variant, rng):
    """Another zero pose: each joint's origin is turned, its range moved."""
    for name, joint in variant.joints().items():
        if name not in variant.names:
            continue
        zero = rng.uniform(-0.6, 0.6)
        origin, limit = joint.find('origin'), joint.find('limit')
        axis = np.array([float(x) for x in joint.find('axis').get('xyz').split()])
        turn = Rotation.from_euler('xyz', [float(x) for x in origin.get('rpy').split()])
        turned = turn * Rotation.from_rotvec(zero * axis)
        origin.set('rpy', ' '.join(map(repr, turned.as_euler('xyz').tolist())))
        for end in ('lower', 'upper'):
            limit.set(end, repr(float(limit.get(end)) - zero))
        variant.zeros[name] = zero


def turned(variant, rng):
    """A root whose y is up, and whose origin is somewhere else."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler('xyz', [np.pi / 2, 0.0, np.pi / 2]).as_matrix()
    pose[:3, 3] = [0.03, -0.02, 0.01]
    base = next(link for link in variant.root.iter('link') if link.get('name') == 'base_link')
    origins = [element.find('origin') for element in base if element.find('origin') is not None]
    origins += [
        joint.find('origin')
        for joint in variant.root.iter('joint')
        if joint.find('parent').get('link') == 'base_link'
    ]
    for origin in origins:
        rpy = [float(x) for x in origin.get('rpy').split()]
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_euler('xyz', rpy).as_matrix()
        matrix[:3, 3] = [float(x) for x in origin.get('xyz').split()]
        moved = pose @ matrix
        euler = Rotation.from_matrix(moved[:3, :3]).as_euler('xyz')
        origin.set('rpy', ' '.join(map(repr, euler.tolist())))
        origin.set('xyz', ' '.join(map(repr, moved[:3, 3].tolist())))


def with_arm(variant, rng):
    """An arm of four joints with two fingers on the back, and a camera."""
    parent = 'base_link'
    for index in range(4):
        link = ElementTree.SubElement(variant.root, 'link', name=f'arm_{index}')
        inertial = ElementTree.SubElement(link, 'inertial')
        ElementTree.SubElement(inertial, 'mass', value='0.01')
        ElementTree.SubElement(
            inertial, 'inertia', ixx='1e-6', iyy='1e-6', izz='1e-6', ixy='0', ixz='0', iyz='0'
        )
        add_joint(variant.root, f'arm_joint_{index}', 'revolute', parent, f'arm_{index}')
        parent = f'arm_{index}'
    for finger in ('left', 'right'):
        ElementTree.SubElement(variant.root, 'link', name=f'{finger}_finger')
        add_joint(variant.root, f'{finger}_finger_joint', 'prismatic', parent, f'{finger}_finger')
    ElementTree.SubElement(variant.root, 'link', name='camera')
    add_joint(variant.root, 'camera_joint', 'fixed', 'base_link', 'camera')


def add_joint(root, name, kind, parent, child):
    joint = ElementTree.SubElement(root, 'joint', name=name, type=kind)
    ElementTree.SubElement(joint, 'origin', xyz='0 0 0.05', rpy='0 0 0')
    ElementTree.SubElement(joint, 'parent', link=parent)
    ElementTree.SubElement(joint, 'child', link=child)
    ElementTree.SubElement(joint, 'axis', xyz='0 1 0')
    ElementTree.SubElement(joint, 'limit', lower='-1', upper='1', effort='1', velocity='1')


CHANGES = {
    'as it is': (),
    'renamed': (renamed,),
    'in any order': (shuffled,),
    'axes flipped': (flipped,),
    'another zero pose': (bent,),
    'turned root': (turned,),
    'with an arm': (with_arm,),
    'all of it': (with_arm, bent, flipped, turned, shuffled),
}


@pytest.mark.parametrize('name', SHIPPED)
@pytest.mark.parametrize('change', CHANGES)
def test_the_same_robot_is_found(name, change, tmp_path):
    rng = np.random.default_rng(7)
    robot = SHIPPED[name]
    variant = Variant(robot)
    for step in CHANGES[change]:
        step(variant, rng)
    # Nothing tells the front of a robot whose names say nothing and whose axes are upright.
    imported = import_robot(variant.write(tmp_path), forward_of(name, change))
    legs = stack_legs([ranged.leg for ranged in imported.legs])
    angles = rng.uniform(robot.lower, robot.upper, (20, 4, 3))
    own = np.array([variant.own_angles(imported, posture) for posture in angles])
    # base_link's origin is in the middle of the hips, level with their pitch axes.
    off = legs.forward(own) - robot.foot_positions(angles)
    shift = off.mean(axis=(0, 1))
    assert np.abs(off - shift).max() < 1e-6
    assert np.abs(shift[:2]).max() < 1e-6
    within = (own >= [r.lower - 1e-9 for r in imported.legs]) & (
        own <= [r.upper + 1e-9 for r in imported.legs]
    )
    assert within.all()
    carried = 0.04 if with_arm in CHANGES[change] else 0.0
    assert imported.masses.total == pytest.approx(robot.mass + carried, rel=1e-6)
    if not carried:
        center = imported.masses.center(legs, own, legs.chain(own))
        assert np.abs(center - shift - robot.center_of_mass(angles)).max() < 1e-6


def forward_of(name, change):
    if 'turned root' in change or change == 'all of it':
        return ImportOptions(forward='+y')
    return ImportOptions(forward='+x')


@pytest.mark.parametrize('name', SHIPPED)
def test_inverse_kinematics_stay_within_the_ranges(name, tmp_path):
    variant = Variant(SHIPPED[name])
    rng = np.random.default_rng(3)
    bent(variant, rng)
    flipped(variant, rng)
    data_file, _ = write_robot(
        import_robot(variant.write(tmp_path)), tmp_path / 'robots' / 'mine.yaml'
    )
    robot = load_robot(data_file)
    near = robot.initial_joint_angles + rng.uniform(-0.2, 0.2, (50, 4, 3))
    near = np.clip(near, robot.lower, robot.upper)
    again = robot.joint_angles(robot.foot_positions(near))
    assert np.abs(again - near).max() < 1e-6
    feet = robot.foot_positions(near)
    step = 1e-6
    speeds = rng.uniform(-1.0, 1.0, near.shape)
    moved = robot.foot_positions(near + step * speeds)
    jacobians = robot.foot_jacobians(near)
    assert np.abs((moved - feet) / step - np.einsum('...ij,...j', jacobians, speeds)).max() < 1e-4
    back = robot.joint_velocities(near, np.einsum('...ij,...j', jacobians, speeds))
    assert np.abs(back - speeds).max() < 1e-6


@pytest.mark.parametrize('name', SHIPPED)
def test_the_data_file_holds_the_robot(name, tmp_path):
    imported = import_robot(Variant(SHIPPED[name]).write(tmp_path))
    data_file, urdf = write_robot(imported, tmp_path / 'mine.yaml')
    robot = load_robot(data_file)
    assert robot.joint_names == SHIPPED[name].joint_names
    assert robot.part_names.feet == tuple(f'{leg}_foot' for leg in LEGS)
    assert robot.mass == pytest.approx(imported.masses.total, rel=1e-6)
    assert np.allclose(robot.initial_joint_angles, imported.initial, atol=1e-8)
    assert robot.own_urdf == urdf.read_text()
    # What stands is level, over its feet, within the ranges.
    feet, center = robot.neutral_feet, robot.center_of_mass(robot.initial_joint_angles)
    assert np.ptp(feet[:, 2]) < 1e-6
    assert np.linalg.norm(feet[:, :2].mean(axis=0) - center[:2]) < 0.1 * robot.hip_height
    # Imported again, its own URDF is the same robot.
    again = import_robot(urdf)
    assert again.masses.total == pytest.approx(imported.masses.total, rel=1e-6)
    for one, other in zip(again.legs, imported.legs):
        angles = one.lower + 0.3 * (one.upper - one.lower)
        assert np.abs(one.leg.forward(angles) - other.leg.forward(angles)).max() < 1e-6


def test_names_tell_the_front(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    backward = {'lf': 'rh', 'rf': 'lh', 'lh': 'rf', 'rh': 'lf'}
    text = ElementTree.tostring(variant.root, encoding='unicode')
    for old in backward:
        text = text.replace(f'"{old}_', f'"@{backward[old]}_')
    path = tmp_path / 'backward.urdf'
    path.write_text(text.replace('@', ''))
    imported = import_robot(path)
    assert imported.to_base[0, 0] == pytest.approx(-1.0)
    assert any('names' in sentence for sentence in imported.notes.found)
    assert imported.chains[0].joints[0].name == 'lf_hip_roll_joint'


def test_efforts_and_speeds_are_asked_for(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    for limit in variant.root.iter('limit'):
        del limit.attrib['effort']
    path = variant.write(tmp_path)
    with pytest.raises(JointFiguresMissing, match='--effort') as error:
        import_robot(path)
    assert len(error.value.joints) == 12
    robot = import_robot(path, ImportOptions(effort=(1.0, 2.0, 3.0)))
    assert robot.effort.tolist() == [[1.0, 2.0, 3.0]] * 4


def test_figures_that_stand_for_none_are_asked_for(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    for limit in variant.root.iter('limit'):
        limit.set('velocity', '1000')
    path = variant.write(tmp_path)
    with pytest.raises(JointFiguresMissing, match=r'--speed') as error:
        import_robot(path)
    assert error.value.stated == 1000.0
    assert 'but 1000 rad/s' in str(error.value)
    assert import_robot(path, ImportOptions(speed=(9.0,))).velocity.max() == 9.0


def without_masses(variant, links):
    for link in variant.root.iter('link'):
        if any(link.get('name').endswith(end) for end in links):
            link.remove(link.find('inertial'))


def test_masses_that_are_missing_are_asked_for_and_spread_by_size(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    without_masses(variant, ('_hip', '_thigh', '_calf', '_foot', 'base_link'))
    path = variant.write(tmp_path)
    with pytest.raises(MassesMissing, match=r'no mass of base_link, lf_hip, lf_thigh \.\.\.; give'):
        import_robot(path)
    imported = import_robot(path, ImportOptions(mass=7.0))
    masses = imported.masses
    assert masses.body + masses.parts.sum() == pytest.approx(7.0)
    # The body is the largest, and what is alike is as heavy.
    assert masses.body > masses.parts.max()
    assert masses.parts == pytest.approx(np.broadcast_to(masses.parts[0], (4, 3)))
    assert masses.body_center == pytest.approx(imported.sizes.body_center)
    assert any('7 kg are spread' in sentence for sentence in imported.notes.assumed)
    assert load_robot(write_robot(imported, tmp_path / 'own.yaml')[0]).mass == pytest.approx(7.0)


def test_a_mass_is_for_the_parts_that_have_none(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    whole = ImportOptions(mass=SHIPPED['genibo'].mass)
    with pytest.raises(DescriptionEntryInvalid, match=r'states all masses, 1\.5 kg'):
        import_robot(variant.write(tmp_path), whole)
    without_masses(variant, ('base_link',))
    path = variant.write(tmp_path)
    body = import_robot(path, whole).masses.body
    assert body == pytest.approx(SHIPPED['genibo'].body_mass)
    with pytest.raises(MassesMissing, match=r'--mass 0\.1 leaves too little for them'):
        import_robot(path, ImportOptions(mass=0.1))


def test_a_part_without_mass_and_shape_gets_a_little_of_the_mass(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    without_masses(variant, ('_hip', 'base_link'))
    for link in variant.root.iter('link'):
        for shape in [e for e in link if e.tag in ('visual', 'collision')]:
            if link.get('name').endswith('_hip'):
                link.remove(shape)
    path = variant.write(tmp_path)
    masses = import_robot(path, ImportOptions(mass=3.0)).masses
    missing = 3.0 - masses.parts[:, 1:].sum()
    assert masses.parts[:, 0] == pytest.approx(np.full(4, missing / 104.0))


@pytest.mark.parametrize('joints', [1, 3, 4, 7])
def test_arms_of_any_number_of_joints_are_carried(joints, tmp_path):
    variant = Variant(SHIPPED['genibo'])
    parent = 'base_link'
    for index in range(joints):
        ElementTree.SubElement(variant.root, 'link', name=f'arm_{index}')
        add_joint(variant.root, f'arm_joint_{index}', 'revolute', parent, f'arm_{index}')
        parent = f'arm_{index}'
    imported = import_robot(variant.write(tmp_path))
    assert {joint.name for chain in imported.chains for joint in chain.joints} == set(variant.names)
    assert any(f'{joints} other joint' in sentence for sentence in imported.notes.assumed)


@pytest.mark.parametrize('legs', [2, 3])
def test_other_numbers_of_legs_are_refused(legs, tmp_path):
    variant = Variant(SHIPPED['genibo'])
    for name in LEGS[legs:]:
        for element in list(variant.root):
            if element.get('name').startswith(f'{name}_'):
                variant.root.remove(element)
    with pytest.raises(NotAQuadruped) as error:
        import_robot(variant.write(tmp_path))
    assert ('two', 'three')[legs - 2] in error.value.found


def test_six_legs_are_refused(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    for element in list(variant.root):
        if not element.get('name').startswith(('lf_', 'rf_')):
            continue
        copied = deepcopy(element)
        for part in copied.iter():
            for key in ('name', 'link'):
                if part.get(key, '').startswith(('lf_', 'rf_')):
                    part.set(key, f'middle_{part.get(key)}')
        variant.root.append(copied)
    with pytest.raises(NotAQuadruped, match='six chains of three joints'):
        import_robot(variant.write(tmp_path))


def test_wheels_are_refused(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    for leg in LEGS:
        ElementTree.SubElement(variant.root, 'link', name=f'{leg}_wheel')
        add_joint(variant.root, f'{leg}_wheel_joint', 'continuous', f'{leg}_foot', f'{leg}_wheel')
    with pytest.raises(NotAQuadruped, match='wheels'):
        import_robot(variant.write(tmp_path))


def with_feet(variant, shape, **sizes):
    """Give the feet another shape, lying across the robot."""
    for link in variant.root.iter('link'):
        if link.get('name').endswith('_foot'):
            for use in ('visual', 'collision'):
                geometry = link.find(f'{use}/geometry')
                geometry.clear()
                ElementTree.SubElement(geometry, shape, **sizes)
                link.find(f'{use}/origin').set('rpy', f'{np.pi / 2} 0 0')


def test_a_round_end_of_a_leg_is_found_without_a_ball(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    with_ball = import_robot(variant.write(tmp_path))
    with_feet(variant, 'cylinder', radius=repr(with_ball.foot_radius), length='0.01')
    imported = import_robot(variant.write(tmp_path))
    assert imported.foot_radius == pytest.approx(with_ball.foot_radius, rel=0.01)
    for foot, wanted in zip(imported.feet, with_ball.feet):
        assert foot.center == pytest.approx(wanted.center, abs=1e-4)
    assert any('they are round' in sentence for sentence in imported.notes.assumed)


def test_an_end_that_is_not_round_stands_on_what_is_lowest_in_the_stance(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    with_feet(variant, 'box', size='0.012 0.012 0.012')
    imported = import_robot(variant.write(tmp_path))
    assert any('stands for them' in sentence for sentence in imported.notes.assumed)
    robot = load_robot(write_robot(imported, tmp_path / 'own.yaml')[0])
    # The lowest corners of the four boxes are as deep as the feet's circles are.
    names = [joint.name for chain in imported.chains for joint in chain.joints]
    angles = dict(zip(names, imported.initial.ravel().tolist()))
    for foot, wanted in zip(imported.feet, robot.stacked_legs.forward(robot.initial_joint_angles)):
        pose = imported.to_base @ imported.tree.pose(foot.link, angles)
        corners = 0.006 * np.array(list(product((-1.0, 1.0), repeat=3)))
        lowest = (corners @ pose[:3, :3].T + pose[:3, 3])[:, 2].min()
        assert wanted[2] - imported.foot_radius == pytest.approx(lowest, abs=1e-3)


def test_impossible_inertias_are_replaced_and_said(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    next(variant.root.iter('inertia')).set('ixx', '5.0')
    imported = import_robot(variant.write(tmp_path))
    assert any('inertias' in sentence for sentence in imported.notes.assumed)
    assert imported.parts.body.mass.is_possible


def test_meshes_are_found_in_their_package(tmp_path):
    package = tmp_path / 'my_robot'
    (package / 'meshes').mkdir(parents=True)
    (package / 'urdf').mkdir()
    corners = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.05, 0.05) for z in (-0.02, 0.04)]
    faces = 'f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n'
    mesh = package / 'meshes' / 'trunk.obj'
    mesh.write_text(''.join(f'v {x} {y} {z}\n' for x, y, z in corners) + faces)
    variant = Variant(SHIPPED['genibo'])
    base = next(link for link in variant.root.iter('link') if link.get('name') == 'base_link')
    for use in ('visual', 'collision'):
        geometry = base.find(f'{use}/geometry')
        geometry.clear()
        ElementTree.SubElement(geometry, 'mesh', filename='package://my_robot/meshes/trunk.obj')
        base.find(f'{use}/origin').set('xyz', '0 0 0')
    path = variant.write(package / 'urdf')
    imported = import_robot(path)
    assert np.allclose(imported.sizes.body_size, [0.2, 0.1, 0.06], atol=1e-9)
    assert np.allclose(imported.sizes.body_center, [0.0, 0.0, 0.01], atol=1e-9)
    _, urdf = write_robot(imported, tmp_path / 'out' / 'mine.yaml')
    assert f'filename="{mesh.resolve()}"' in urdf.read_text()
    mesh.unlink()
    with pytest.raises(DescriptionError, match=r'trunk\.obj'):
        import_robot(path)


def add_shape(link, use, mesh):
    shape = ElementTree.SubElement(link, use)
    ElementTree.SubElement(shape, 'origin', xyz='0 0 0', rpy='0 0 0')
    ElementTree.SubElement(ElementTree.SubElement(shape, 'geometry'), 'mesh', filename=mesh)


def test_what_the_body_carries_may_be_without_its_mesh_but_not_a_leg(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    links = {link.get('name'): link for link in variant.root.iter('link')}
    add_shape(links['base_link'], 'collision', 'package://cameras/camera.stl')
    imported = import_robot(variant.write(tmp_path))
    assert imported.sizes.body_size == pytest.approx(SHIPPED['genibo'].body_size)
    assert [s for s in imported.notes.assumed if 'package://cameras/camera.stl' in s]
    write_robot(imported, tmp_path / 'own.yaml')
    add_shape(links['lf_calf'], 'collision', 'package://shins/shin.stl')
    with pytest.raises(DescriptionError, match=r'shin\.stl'):
        import_robot(variant.write(tmp_path))


def test_meshes_of_copied_descriptions_are_found_by_the_end_of_their_path(tmp_path):
    trimesh = pytest.importorskip('trimesh')
    (tmp_path / 'mine' / 'meshes').mkdir(parents=True)
    (tmp_path / 'mine' / 'urdf').mkdir()
    mesh = tmp_path / 'mine' / 'meshes' / 'trunk.stl'
    trimesh.creation.box(extents=(0.2, 0.1, 0.06)).export(mesh)
    variant = Variant(SHIPPED['genibo'])
    geometry = variant.root.find('link/visual/geometry')
    geometry.clear()
    away = 'file:///opt/maker/ws/install/share/robot/meshes/trunk.stl'
    ElementTree.SubElement(geometry, 'mesh', filename=away)
    imported = import_robot(variant.write(tmp_path / 'mine' / 'urdf'))
    _, urdf = write_robot(imported, tmp_path / 'out' / 'mine.yaml')
    assert f'filename="{mesh}"' in urdf.read_text()
    assert any('paths end alike' in sentence for sentence in imported.notes.assumed)


def test_limits_in_degrees_and_a_leg_unlike_the_others_are_said(tmp_path):
    variant = Variant(SHIPPED['genibo'])
    sound = import_robot(variant.write(tmp_path))
    joint = next(j for j in variant.root.iter('joint') if j.get('name') == 'lf_hip_pitch_joint')
    joint.find('limit').attrib.update(lower='-90', upper='90')
    foot = next(j for j in variant.root.iter('joint') if j.get('name') == 'rh_foot_joint')
    x, y, z = foot.find('origin').get('xyz').split()
    foot.find('origin').set('xyz', f'{x} {y} {float(z) - 0.1}')
    odd = import_robot(variant.write(tmp_path))
    said = [sentence for sentence in odd.notes.assumed if sentence not in sound.notes.assumed]
    assert any("'lf_hip_pitch_joint' has no limits" in one and 'degrees' in one for one in said)
    assert any('the leg rh is' in one and 'mm longer' in one for one in said)
    assert not any('has no limits' in one or 'longer' in one for one in sound.notes.assumed)


def test_notes_are_plain_data(tmp_path):
    notes = import_robot(Variant(SHIPPED['pukyong']).write(tmp_path)).notes
    assert json.loads(json.dumps([notes.found, notes.assumed]))


def test_meshes_that_not_all_engines_read_are_converted(tmp_path):
    trimesh = pytest.importorskip('trimesh')
    pytest.importorskip('collada')
    box = trimesh.creation.box(extents=(0.2, 0.1, 0.06))
    (tmp_path / 'trunk.dae').write_bytes(trimesh.exchange.dae.export_collada(box))
    variant = Variant(SHIPPED['genibo'])
    base = next(link for link in variant.root.iter('link') if link.get('name') == 'base_link')
    for use in ('visual', 'collision'):
        geometry = base.find(f'{use}/geometry')
        geometry.clear()
        ElementTree.SubElement(geometry, 'mesh', filename='trunk.dae')
    imported = import_robot(variant.write(tmp_path))
    assert np.allclose(imported.sizes.body_size, [0.2, 0.1, 0.06], atol=1e-6)
    data_file, urdf = write_robot(imported, tmp_path / 'out' / 'mine.yaml')
    converted = list((tmp_path / 'out' / 'mine_meshes').iterdir())
    assert [path.suffix for path in converted] == ['.obj']
    assert urdf.read_text().count(str(converted[0])) == 2
    corners = trimesh.load(converted[0], force='mesh').vertices
    assert np.allclose(np.ptp(corners, axis=0), [0.2, 0.1, 0.06], atol=1e-6)
    assert load_robot(data_file).own_urdf
