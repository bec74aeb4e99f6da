"""A robot is data: TITAN-VIII's numbers, and what follows from them."""

import copy
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

import quad_common.robot.robot
from quad_common.errors import (
    FootTargetUnreachable,
    JointLimitExceeded,
    JointNotFound,
    RobotModelError,
    SingularPosture,
)
from quad_common.robot.robot_build import LEGS, GaitSettings
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import available_robots, load_robot

DATA = Path(quad_common.__file__).parent / 'robots' / 'titan_viii.yaml'
DOCUMENT = yaml.safe_load(DATA.read_text(encoding='utf-8'))
NAMES = ('titan_viii', 'pukyong', 'cuhk', 'genibo')
ROBOTS = {name: load_robot(name) for name in NAMES}
DOCUMENTS = {
    name: yaml.safe_load((DATA.parent / f'{name}.yaml').read_text(encoding='utf-8'))
    for name in NAMES
}
ROBOT = ROBOTS['titan_viii']

each_name = pytest.mark.parametrize('name', NAMES)
each_robot = pytest.mark.parametrize('robot', ROBOTS.values(), ids=NAMES)
dogs = pytest.mark.parametrize('robot', [ROBOTS['cuhk'], ROBOTS['genibo']], ids=['cuhk', 'genibo'])


def random_joints(rng, count, robot=ROBOT):
    return rng.uniform(robot.lower, robot.upper, (count, 4, 3))


def numbers_in(node, name=''):
    """List (dotted name, entry) of every {value, source} in a document."""
    if isinstance(node, dict) and 'value' in node:
        yield name.lstrip('.'), node
    elif isinstance(node, dict):
        for key, child in node.items():
            yield from numbers_in(child, f'{name}.{key}')


def changed(tmp_path, name, entry, robot='titan_viii'):
    """Write a robot's file with the entry of a dotted name replaced; None removes it."""
    document = copy.deepcopy(DOCUMENTS[robot])
    node = document
    *folders, last = name.split('.')
    for key in folders:
        node = node.setdefault(key, {})
    if entry is None:
        del node[last]
    else:
        node[last] = entry
    path = tmp_path / 'robot.yaml'
    path.write_text(yaml.safe_dump(document), encoding='utf-8')
    return path


def refusal(path):
    with pytest.raises(RobotModelError) as caught:
        load_robot(path)
    sentence = str(caught.value)
    assert '\n' not in sentence
    return sentence


@pytest.mark.parametrize(
    ('name', 'mass'), [('titan_viii', 40.0), ('pukyong', 2.0), ('cuhk', 1.4), ('genibo', 1.5)]
)
def test_links_and_body_sum_to_the_robots_mass(name, mass):
    robot = ROBOTS[name]
    assert robot.mass == pytest.approx(mass, abs=1e-12)
    links = sum(link.mass for link in robot.links.values())
    assert robot.mass == pytest.approx(robot.body_mass + 4.0 * links)


@each_name
def test_every_number_of_a_file_has_a_value_and_a_source(name):
    entries = dict(numbers_in(DOCUMENTS[name]))
    assert len(entries) > 35
    for entry_name, entry in entries.items():
        numbers = np.atleast_1d(entry['value'])
        assert numbers.dtype.kind in 'bif', entry_name
        assert re.match(r'S[0-4] |chosen', entry['source']), entry_name


@each_name
def test_no_number_stands_in_a_file_without_a_source(name):
    def bare(node):
        if isinstance(node, dict):
            return [] if 'source' in node else [b for child in node.values() for b in bare(child)]
        return [node] if isinstance(node, (int, float)) else []

    assert bare(DOCUMENTS[name]) == []


@each_name
def test_every_number_of_a_file_is_used_except_what_is_only_stated(name):
    names = {entry for entry, _ in numbers_in(DOCUMENTS[name])}
    assert set(ROBOTS[name].sources) == {n for n in names if not n.startswith('stated.')}


@each_name
def test_a_source_is_the_one_of_the_file(name):
    entries = dict(numbers_in(DOCUMENTS[name]))
    assert all(source == entries[n]['source'] for n, source in ROBOTS[name].sources.items())


STATED = {
    # What is stated: how it is derived, and within what. A paper rounds to half a millimetre.
    'mass': (lambda robot: robot.mass, 1e-9),
    'stance_reach': (lambda robot: robot.stance_reach, 2e-5),
    'hip_height': (lambda robot: robot.hip_height, 1e-9),
    'largest_stride': (lambda robot: robot.largest_stride, 5e-4),
    'mesh_size': (lambda robot: robot.mesh_size, 5e-4),
    'largest_turn': (lambda robot: robot.largest_turn, math.radians(0.5)),
    'feet_length': (lambda robot: np.ptp(robot.neutral_feet[:, 0]), 1e-12),
    'feet_width': (lambda robot: np.ptp(robot.neutral_feet[:, 1]), 1e-12),
    # The body's top is below the head's, which is not modelled.
    'height': (
        lambda robot: robot.standing_height + robot.body_center[2] + robot.body_size[2] / 2.0,
        0.04,
    ),
}


@pytest.mark.parametrize(
    ('name', 'what'), [(name, what) for name in NAMES for what in DOCUMENTS[name]['stated']]
)
def test_what_the_paper_states_follows_from_the_numbers_within_its_rounding(name, what):
    figure, within = STATED[what]
    stated = DOCUMENTS[name]['stated'][what]['value']
    assert figure(ROBOTS[name]) == pytest.approx(stated, abs=within)


def test_left_and_right_fore_and_hind_are_where_their_names_say():
    hips = np.array([leg.hip for leg in ROBOT.legs])
    assert tuple(leg.name for leg in ROBOT.legs) == LEGS
    assert hips == pytest.approx(
        np.array([[0.201, 0.101, 0], [0.201, -0.101, 0], [-0.201, 0.101, 0], [-0.201, -0.101, 0]])
    )
    assert (np.sign(ROBOT.neutral_feet[:, 1]) == [1, -1, 1, -1]).all()
    assert np.abs(ROBOT.neutral_feet[:, 1]) == pytest.approx(0.301)


@each_robot
def test_standing_height_puts_the_feet_on_the_ground(robot):
    soles = robot.neutral_feet[:, 2] + robot.standing_height - robot.foot_radius
    assert soles == pytest.approx(np.zeros(4), abs=1e-12)


def test_the_footprint_holds_feet_and_body():
    radius = ROBOT.footprint_radius
    assert radius == pytest.approx(math.hypot(0.201, 0.301) + 0.015)
    assert radius > math.hypot(0.23, 0.13)


@each_robot
def test_robots_that_ship_stand_within_a_tenth_of_their_footprint(robot):
    assert robot.standing_radius == robot.footprint_radius


def test_knees_that_reach_out_of_the_footprint_are_kept_clear():
    robot = load_robot('a1')
    ends, radii = robot.shape.part_ends(robot.initial_joint_angles)
    assert robot.standing_radius > 1.3 * robot.footprint_radius
    assert robot.standing_radius == pytest.approx(np.max(np.hypot(*ends.T[:2]) + radii))


def test_joints_are_named_leg_by_leg():
    assert ROBOT.joint_names[:3] == (
        'lf_hip_yaw_joint',
        'lf_hip_pitch_joint',
        'lf_knee_pitch_joint',
    )
    assert [name[:2] for name in ROBOT.joint_names] == [leg for leg in LEGS for _ in range(3)]
    for index, name in enumerate(ROBOT.joint_names):
        assert ROBOT.joint_index(name) == index
    with pytest.raises(JointNotFound, match=r"no joint 'tail'; available: lf_hip_pitch_joint, "):
        ROBOT.joint_index('tail')


@each_robot
def test_the_initial_posture_is_the_one_that_inverse_kinematics_finds(robot):
    angles = robot.joint_angles(robot.neutral_feet)
    assert angles == pytest.approx(robot.initial_joint_angles, abs=1e-12)


@each_robot
def test_left_feet_mirror_right_ones_and_front_feet_hind_ones(robot):
    feet = robot.neutral_feet
    assert feet[[1, 0, 3, 2]] == pytest.approx(feet * [1, -1, 1], abs=1e-12)
    assert feet[[2, 3, 0, 1]] == pytest.approx(feet * [-1, 1, 1], abs=1e-12)


@dogs
def test_a_dogs_joints_are_mirrored_by_side_and_by_knee(robot):
    for quantity in ('velocity', 'effort'):
        limits = getattr(robot, quantity)
        assert (limits == limits[0]).all()
    document = DOCUMENTS[robot.name]
    kinds = robot.joint_kinds
    assert kinds == ('hip_roll', 'hip_pitch', 'knee_pitch')
    low, high, initial = (
        np.array([entry['value'] for entry in entries])
        for entries in (
            [document['joints'][kind]['lower'] for kind in kinds],
            [document['joints'][kind]['upper'] for kind in kinds],
            [document['initial_posture'][kind] for kind in kinds],
        )
    )
    for k, signs in enumerate([(1, -1, -1), (-1, -1, -1), (1, 1, 1), (-1, 1, 1)]):
        ends = np.sort([signs * low, signs * high], axis=0)
        assert (robot.lower[k] == ends[0]).all()
        assert (robot.upper[k] == ends[1]).all()
        assert (robot.initial_joint_angles[k] == signs * initial).all()


def test_axis_signs_turn_limits_and_posture_but_not_the_feet(tmp_path):
    for name in ('titan_viii', 'cuhk'):
        signs = {'value': [-1, 1, -1], 'source': 'x'}
        path = changed(tmp_path, 'leg.axis_signs.rh', signs, robot=name)
        turned, robot = load_robot(path), ROBOTS[name]
        assert turned.neutral_feet == pytest.approx(robot.neutral_feet, abs=1e-15)
        assert (turned.initial_joint_angles[:3] == robot.initial_joint_angles[:3]).all()
        expected = robot.initial_joint_angles[3] * [-1, 1, -1]
        assert turned.initial_joint_angles[3] == pytest.approx(expected)
        assert turned.lower[3, 2] == -robot.upper[3, 2]
        assert turned.upper[3, 2] == -robot.lower[3, 2]
        assert turned.lower[3, 1] == robot.lower[3, 1]
        assert turned.joint_angles(robot.neutral_feet)[3] == pytest.approx(expected)


def test_optional_offsets_move_the_legs_plane_forward(tmp_path):
    for name, key in (('titan_viii', 'lateral_offset'), ('cuhk', 'forward_offset')):
        path = changed(tmp_path, f'leg.{key}', {'value': 0.01, 'source': 'x'}, robot=name)
        moved = load_robot(path).neutral_feet - ROBOTS[name].neutral_feet
        assert moved == pytest.approx(np.tile([0.01, 0.0, 0.0], (4, 1)), abs=1e-15)


def test_what_is_optional_may_be_left_out(tmp_path):
    assert not load_robot(changed(tmp_path, 'drive', None)).knee_is_absolute
    assert load_robot(changed(tmp_path, 'gaits', None)).gaits == {}
    robot = load_robot(changed(tmp_path, 'leg.knee_sign_front', None, robot='cuhk'))
    assert [leg.knee_sign for leg in robot.legs] == [1, 1, 1, 1]


def test_only_titan_viiis_knees_are_absolute():
    assert {name: robot.knee_is_absolute for name, robot in ROBOTS.items()} == {
        'titan_viii': True,
        'pukyong': False,
        'cuhk': False,
        'genibo': False,
    }


@each_robot
def test_every_robot_has_settings_for_the_six_gaits(robot):
    assert set(robot.gaits) == {'crawl', 'turn', 'crab', 'wave', 'trot', 'walk'}


def test_gait_settings_are_those_of_the_file():
    assert ROBOT.gaits['crawl'] == GaitSettings(None, None)
    assert ROBOT.gaits['wave'] == GaitSettings(cycle_period=5.0)
    assert ROBOT.gaits['trot'] == GaitSettings(0.5, 0.05, (0.9, 1.0, 1.0))
    assert ROBOTS['pukyong'].gaits['walk'] == GaitSettings(0.6, None, (0.95, 1.0, 1.0))
    assert ROBOTS['cuhk'].gaits['trot'] == GaitSettings(0.45, 0.008, (1.0, 1.0, 0.85))
    assert ROBOTS['genibo'].gaits['wave'] == GaitSettings(4.0)


@pytest.mark.parametrize('gaits', [None, {}, {'crawl': None}, {'crawl': {}}])
def test_gaits_and_their_settings_may_be_empty(tmp_path, gaits):
    path = changed(tmp_path, 'name', 'other')
    document = yaml.safe_load(path.read_text(encoding='utf-8'))
    document['gaits'] = gaits
    path.write_text(yaml.safe_dump(document), encoding='utf-8')
    expected = {} if not gaits else {'crawl': GaitSettings()}
    assert load_robot(path).gaits == expected


@each_robot
def test_feet_jacobians_and_turning_calves_are_those_of_each_leg(robot):
    rng = np.random.default_rng(5)
    joints = random_joints(rng, 6, robot).reshape(2, 3, 4, 3)
    speeds = rng.normal(size=joints.shape)
    jacobians = robot.foot_jacobians(joints)
    turning = robot.calf_angular_velocities(joints, speeds)
    assert jacobians.shape == (2, 3, 4, 3, 3)
    for k, leg in enumerate(robot.legs):
        own = joints[..., k, :]
        assert jacobians[..., k, :, :] == pytest.approx(leg.jacobian(own), abs=1e-15)
        expected = leg.angular_velocity(own, speeds[..., k, :])
        assert turning[..., k, :] == pytest.approx(expected, abs=1e-13)


def in_plane(robot, joints):
    """Say how far each foot is from its first axis, in its leg's plane [m]."""
    legs = robot.stacked_legs
    arms = robot.foot_positions(joints) - robot.stacked_legs.hip
    along = np.sum(arms * legs.first_axis, axis=-1)
    squared = np.sum(arms**2, axis=-1) - along**2 - legs.lateral_offset**2
    normal = np.cross(legs.first_axis, legs.radial_direction)
    q1 = joints[..., :1]
    rho = np.cos(q1) * legs.radial_direction + np.sin(q1) * normal
    return np.copysign(np.sqrt(np.maximum(squared, 0.0)), np.sum(arms * rho, axis=-1))


@each_robot
def test_joint_angles_undo_foot_positions_within_the_limits(robot):
    joints = random_joints(np.random.default_rng(1), 1000, robot)
    usual = (in_plane(robot, joints) > 0.01 * robot.legs[0].reach()[1]).all(axis=1)
    assert usual.sum() > 200
    feet = robot.foot_positions(joints[usual])
    assert robot.joint_angles(feet) == pytest.approx(joints[usual], abs=1e-7)


@each_robot
def test_joint_velocities_move_the_feet_as_wanted(robot):
    rng = np.random.default_rng(2)
    joints = random_joints(rng, 200, robot)
    size = robot.legs[0].reach()[1]
    wanted = size * rng.uniform(-1.0, 1.0, (200, 4, 3))
    usual = (np.abs(in_plane(robot, joints)) > 0.15 * size).all(axis=1)
    usual &= (np.abs(joints[..., 2]) > 0.3).all(axis=1)
    assert usual.sum() > 10
    speeds = robot.joint_velocities(joints[usual], wanted[usual])
    h = 1e-7
    moved = robot.foot_positions(joints[usual] + h * speeds)
    moved -= robot.foot_positions(joints[usual] - h * speeds)
    assert moved / (2.0 * h) == pytest.approx(wanted[usual], abs=1e-5 * size / 0.355)


@each_robot
def test_a_straight_leg_has_no_joint_velocities(robot):
    joints = robot.initial_joint_angles.copy()
    joints[2, 2] = 0.0
    with pytest.raises(SingularPosture, match='leg lh '):
        robot.joint_velocities(joints, np.ones((4, 3)))


@pytest.mark.parametrize('leg', range(4), ids=LEGS)
@pytest.mark.parametrize(('kind', 'low', 'high'), [(0, -1.4, 1.4), (1, -1.45, 1.45), (2, 0.1, 2.8)])
@pytest.mark.parametrize('side', [-1, 1])
def test_a_joint_outside_its_range_is_named_with_the_range(leg, kind, low, high, side):
    joints = ROBOT.initial_joint_angles.copy()
    limit = low if side < 0 else high
    joints[leg, kind] = limit
    ROBOT.check_joint_limits(joints)
    joints[leg, kind] += 0.01 * side
    name = ROBOT.joint_names[3 * leg + kind]
    with pytest.raises(JointLimitExceeded) as caught:
        ROBOT.check_joint_limits(joints)
    assert caught.value.joint == name
    assert str(caught.value) == (
        f'joint {name} would go to {joints[leg, kind]:.3f} rad; '
        f'its range is {low:.3f} to {high:.3f} rad'
    )


def test_of_many_joints_outside_their_range_the_farthest_is_named():
    joints = np.repeat(ROBOT.initial_joint_angles[None], 5, axis=0)
    joints[1, 0, 0] = 1.5
    joints[3, 2, 1] = -1.7
    joints[4, 3, 2] = 0.0
    with pytest.raises(JointLimitExceeded, match=r'lh_hip_pitch_joint would go to -1\.700'):
        ROBOT.check_joint_limits(joints)


def test_feet_out_of_reach_or_range_are_refused():
    feet = ROBOT.neutral_feet.copy()
    feet[2, 1] += 0.3
    with pytest.raises(FootTargetUnreachable, match='foot lh'):
        ROBOT.joint_angles(feet)
    straight = ROBOT.foot_positions(np.tile([0.0, 0.5, 0.05], (4, 1)))
    with pytest.raises(JointLimitExceeded, match='knee_pitch_joint'):
        ROBOT.joint_angles(straight)


@each_robot
def test_the_centre_of_mass_of_the_initial_posture_is_on_both_planes_of_symmetry(robot):
    center = robot.center_of_mass(robot.initial_joint_angles)
    assert center[:2] == pytest.approx([0.0, 0.0], abs=1e-12)


@each_robot
def test_the_centre_of_mass_mirrors_when_the_legs_do(robot):
    joints = random_joints(np.random.default_rng(3), 100, robot)
    mirrored = joints[:, [1, 0, 3, 2]] * [-1.0, 1.0, 1.0]
    center = robot.center_of_mass(joints)
    assert robot.center_of_mass(mirrored) == pytest.approx(center * [1, -1, 1], abs=1e-12)


@each_robot
def test_the_centre_of_mass_is_that_of_the_urdf(robot):
    # Each link's mass at its inertial origin, placed by the joints, nothing of our own.
    root = ElementTree.fromstring(urdf_from_robot(robot))
    joints = {joint.find('child').get('link'): joint for joint in root.iter('joint')}

    def vector(element, name='xyz'):
        return np.array([float(x) for x in element.get(name).split()])

    def frame(link, angles):
        if link not in joints:
            return np.eye(4)
        joint = joints[link]
        origin = joint.find('origin')
        roll, pitch, yaw = vector(origin, 'rpy')
        assert roll == 0.0
        matrix = np.eye(4)
        matrix[:3, :3] = about_z(yaw) @ about_y(pitch)
        matrix[:3, 3] = vector(origin)
        if joint.get('type') == 'revolute':
            angle = angles[joint.get('name')]
            axis = joint.find('axis').get('xyz')
            matrix[:3, :3] @= about_z(angle) if axis == '0 0 1' else about_y(angle)
        return frame(joint.find('parent').get('link'), angles) @ matrix

    for posture in random_joints(np.random.default_rng(4), 20, robot):
        angles = dict(zip(robot.joint_names, posture.reshape(-1)))
        total, moment = 0.0, np.zeros(3)
        for link in root.iter('link'):
            mass = float(link.find('inertial/mass').get('value'))
            at = np.append(vector(link.find('inertial/origin')), 1.0)
            moment += mass * (frame(link.get('name'), angles) @ at)[:3]
            total += mass
        assert robot.center_of_mass(posture) == pytest.approx(moment / total, abs=1e-7)


def about_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def about_y(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def test_a_robot_may_be_given_as_a_path(tmp_path):
    path = changed(tmp_path, 'name', 'other')
    other = load_robot(path)
    assert (other.name, other.mass) == ('other', ROBOT.mass)
    assert load_robot(str(path)).name == 'other'
    assert available_robots() == tuple(sorted(p.stem for p in DATA.parent.glob('*.yaml')))
    assert set(NAMES) <= set(available_robots())


def test_an_unknown_robot_is_answered_with_those_that_there_are():
    sentence = refusal('spot')
    assert sentence.startswith("there is no robot 'spot'; available: ")
    assert 'titan_viii' in sentence


@pytest.mark.parametrize(
    ('name', 'entry', 'told'),
    [
        ('leg_type', 'wheel', "available: 'yaw_pitch_pitch', 'roll_pitch_pitch'"),
        ('leg_type', ['wheel'], "leg_type is ['wheel']; available: 'yaw_pitch_pitch'"),
        ('leg_type', None, 'leg_type is None'),
        ('leg.thigh_length', None, "has no number 'leg.thigh_length'"),
        ('body', None, "has no number 'body.hip_half_length'"),
        ('leg', 3, "has no number 'leg.hip_offset'"),
        ('body.mass', 24.0, "'body.mass' must be given as {value: ..., source: ...}"),
        ('body.mass', {'value': 24.0}, "'body.mass' must be given as {value"),
        ('body.mass', {'value': 24.0, 'source': ''}, "'body.mass' must be given as {value"),
        (
            'body.mass',
            {'value': '24 kg', 'source': 'x'},
            "'24 kg'; it must be a finite number from 0.0001 to 10000 kg",
        ),
        (
            'body.mass',
            {'value': True, 'source': 'x'},
            'True; it must be a finite number from 0.0001 to 10000 kg',
        ),
        (
            'body.mass',
            {'value': math.nan, 'source': 'x'},
            'nan; it must be a finite number from 0.0001 to 10000 kg',
        ),
        (
            'body.mass',
            {'value': -1.0, 'source': 'x'},
            "'body.mass' is -1.0; it must be a finite number",
        ),
        (
            'leg.calf_lenght',
            {'value': 0.2, 'source': 'x'},
            "the key 'leg.calf_lenght' means nothing",
        ),
        (
            'joints.hip_yaw.effort',
            {'value': 0.0, 'source': 'x'},
            'is 0.0; it must be a finite number from 0.001 to 100000 N m',
        ),
        (
            'leg.calf_length',
            {'value': 0, 'source': 'x'},
            'is 0; it must be a finite number from 0.001',
        ),
        (
            'drive.knee_is_absolute',
            {'value': 'yes!', 'source': 'x'},
            "'yes!'; it must be true or false",
        ),
        (
            'joints.knee_pitch.lower',
            {'value': 3.0, 'source': 'x'},
            'joint knee_pitch has lower 3.0 not below upper 2.8',
        ),
        (
            'initial_posture.hip_yaw',
            {'value': 1.6, 'source': 'x'},
            'initial posture is out of range: joint lf_hip_yaw_joint would go to 1.600 rad',
        ),
        (
            'leg.forward_offset',
            {'value': 0.1, 'source': 'x'},
            "the key 'leg.forward_offset' means nothing",
        ),
        (
            'leg.knee_sign_front',
            {'value': 1, 'source': 'x'},
            "the key 'leg.knee_sign_front' means nothing",
        ),
        ('leg.axis_signs.lf', {'value': [1, 1], 'source': 'x'}, '[1, 1]; it must be three numbers'),
        ('leg.axis_signs.lf', {'value': [1, 1, 2], 'source': 'x'}, 'must be three numbers'),
        ('leg.axis_signs.lf', {'value': [1, True, 1], 'source': 'x'}, 'must be three numbers'),
        ('leg.axis_signs.lf', {'value': -1, 'source': 'x'}, 'must be three numbers'),
        (
            'leg.axis_signs.tail',
            {'value': [1, 1, 1], 'source': 'x'},
            "the key 'leg.axis_signs.tail' means nothing; valid keys of 'leg.axis_signs' are lf, ",
        ),
        ('gaits', 3, "'gaits' is 3; it must be a mapping"),
        ('gaits.trot', 3, "'gaits.trot' is 3; it must be a mapping"),
        ('gaits.trot.cycle_period', 2.0, 'must be given as {value: ..., source: ...}'),
        (
            'gaits.trot.cycle_period',
            {'value': 0, 'source': 'x'},
            'is 0; it must be a finite number from 0.05 to 120 s',
        ),
        (
            'gaits.trot.swing_height',
            {'value': -1, 'source': 'x'},
            'is -1; it must be a finite number from 0.0001 to 5 m',
        ),
        (
            'gaits.trot.stride',
            {'value': 1, 'source': 'x'},
            "'gaits.trot.stride' means nothing; valid keys of 'gaits.trot' are cycle_period, ",
        ),
    ],
)
def test_a_bad_file_is_refused_in_one_sentence_that_names_it(tmp_path, name, entry, told):
    path = changed(tmp_path, name, entry)
    sentence = refusal(path)
    assert told in sentence
    assert str(path) in sentence


@pytest.mark.parametrize(
    ('name', 'entry', 'told'),
    [
        ('leg.knee_sign_hind', {'value': 0.5, 'source': 'x'}, 'is 0.5; it must be 1 or -1'),
        (
            'leg.lateral_offset',
            {'value': 0.1, 'source': 'x'},
            "the key 'leg.lateral_offset' means nothing",
        ),
        (
            'initial_posture.hip_yaw',
            {'value': 0, 'source': 'x'},
            "the key 'initial_posture.hip_yaw' means nothing",
        ),
        ('joints.hip_roll', None, "has no number 'joints.hip_roll.lower'"),
    ],
)
def test_a_bad_file_of_a_dog_is_refused_likewise(tmp_path, name, entry, told):
    path = changed(tmp_path, name, entry, robot='cuhk')
    sentence = refusal(path)
    assert told in sentence
    assert str(path) in sentence


@pytest.mark.parametrize(
    ('content', 'told'),
    [
        (b'', "must hold a robot's numbers"),
        (b'- 1\n- 2\n', "must hold a robot's numbers"),
        (b'a: [1, 2\nb: 3\n', 'is not YAML'),
        (b'\xff\xfe\x00name: x', 'is not UTF-8 from byte 0 on'),
    ],
)
def test_what_is_no_mapping_is_refused_in_one_sentence(tmp_path, content, told):
    path = tmp_path / 'robot.yaml'
    path.write_bytes(content)
    sentence = refusal(path)
    assert told in sentence
    assert str(path) in sentence
