"""A robot is data: TITAN-VIII's numbers, and what follows from them."""

import copy
import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

import quad_common.robot
from quad_common.errors import (
    FootTargetUnreachable,
    JointLimitExceeded,
    JointNotFound,
    RobotModelError,
)
from quad_common.robot import LEGS, available_robots, load_robot
from quad_common.urdf import urdf_from_robot

DATA = Path(quad_common.robot.__file__).parent / 'robots' / 'titan_viii.yaml'
DOCUMENT = yaml.safe_load(DATA.read_text(encoding='utf-8'))
ROBOT = load_robot('titan_viii')


def random_joints(rng, count):
    return rng.uniform(ROBOT.lower, ROBOT.upper, (count, 4, 3))


def numbers_in(node, name=''):
    """List (dotted name, entry) of every {value, source} in a document."""
    if isinstance(node, dict) and 'value' in node:
        yield name.lstrip('.'), node
    elif isinstance(node, dict):
        for key, child in node.items():
            yield from numbers_in(child, f'{name}.{key}')


def changed(tmp_path, name, entry):
    """Write TITAN-VIII's file with the entry of a dotted name replaced; None removes it."""
    document = copy.deepcopy(DOCUMENT)
    node = document
    *folders, last = name.split('.')
    for key in folders:
        node = node[key]
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


def test_titan_viii_weighs_40_kg():
    assert ROBOT.mass == pytest.approx(40.0, abs=1e-12)
    links = sum(link.mass for link in ROBOT.links.values())
    assert ROBOT.mass == pytest.approx(ROBOT.body_mass + 4.0 * links)


def test_every_number_of_the_file_has_a_value_and_a_source():
    entries = dict(numbers_in(DOCUMENT))
    assert len(entries) > 40
    for name, entry in entries.items():
        assert isinstance(entry['value'], (int, float)), name
        assert entry['source'].startswith(('S0 ', 'chosen')), name


def test_no_number_stands_in_the_file_without_a_source():
    def bare(node):
        if isinstance(node, dict):
            return [] if 'source' in node else [b for child in node.values() for b in bare(child)]
        return [node] if isinstance(node, (int, float)) else []

    assert bare(DOCUMENT) == []


def test_every_number_of_the_file_is_used_except_what_is_only_stated():
    names = {name for name, _ in numbers_in(DOCUMENT)}
    assert set(ROBOT.sources) == {name for name in names if not name.startswith('stated.')}
    assert ROBOT.sources['leg.hip_offset'].startswith('S0 sec. 6: e = 45 mm')


def test_what_the_paper_states_follows_from_the_numbers_within_its_rounding():
    stated = {name: entry['value'] for name, entry in DOCUMENT['stated'].items()}
    half_a_millimetre = 5e-4
    assert stated.pop('mass') == pytest.approx(ROBOT.mass, abs=1e-9)
    assert stated.pop('stance_reach') == pytest.approx(ROBOT.stance_reach, abs=1e-9)
    assert stated.pop('hip_height') == pytest.approx(ROBOT.hip_height, abs=1e-9)
    assert stated.pop('largest_stride') == pytest.approx(
        ROBOT.largest_stride, abs=half_a_millimetre
    )
    assert stated.pop('mesh_size') == pytest.approx(ROBOT.mesh_size, abs=half_a_millimetre)
    assert stated.pop('largest_turn') == pytest.approx(ROBOT.largest_turn, abs=math.radians(0.5))
    assert stated == {}


def test_left_and_right_fore_and_hind_are_where_their_names_say():
    hips = np.array([leg.hip for leg in ROBOT.legs])
    assert tuple(leg.name for leg in ROBOT.legs) == LEGS
    assert hips == pytest.approx(
        np.array([[0.201, 0.101, 0], [0.201, -0.101, 0], [-0.201, 0.101, 0], [-0.201, -0.101, 0]])
    )
    assert (np.sign(ROBOT.neutral_feet[:, 1]) == [1, -1, 1, -1]).all()
    assert np.abs(ROBOT.neutral_feet[:, 1]) == pytest.approx(0.301)


def test_standing_height_puts_the_feet_on_the_ground():
    soles = ROBOT.neutral_feet[:, 2] + ROBOT.standing_height - ROBOT.foot_radius
    assert soles == pytest.approx(np.zeros(4), abs=1e-12)


def test_the_footprint_holds_feet_and_body():
    radius = ROBOT.footprint_radius
    assert radius == pytest.approx(math.hypot(0.201, 0.301) + 0.015)
    assert radius > math.hypot(0.23, 0.13)


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


def test_joint_angles_undo_foot_positions_within_the_limits():
    joints = random_joints(np.random.default_rng(1), 1000)
    feet = ROBOT.foot_positions(joints)
    pitch = joints[..., 1]
    out = 0.045 + 0.155 * np.cos(pitch) + 0.2 * np.cos(pitch + joints[..., 2])
    usual = (out > 1e-3).all(axis=1)
    assert usual.sum() > 200
    assert ROBOT.joint_angles(feet[usual]) == pytest.approx(joints[usual], abs=1e-7)


def test_joint_velocities_move_the_feet_as_wanted():
    rng = np.random.default_rng(2)
    joints = random_joints(rng, 50)
    wanted = rng.uniform(-0.3, 0.3, (50, 4, 3))
    out = 0.045 + 0.155 * np.cos(joints[..., 1]) + 0.2 * np.cos(joints[..., 1] + joints[..., 2])
    usual = (np.abs(out) > 0.05).all(axis=1) & (joints[..., 2] > 0.3).all(axis=1)
    assert usual.sum() > 10
    speeds = ROBOT.joint_velocities(joints[usual], wanted[usual])
    h = 1e-7
    moved = ROBOT.foot_positions(joints[usual] + h * speeds)
    moved -= ROBOT.foot_positions(joints[usual] - h * speeds)
    assert moved / (2.0 * h) == pytest.approx(wanted[usual], abs=1e-5)


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


def test_the_centre_of_mass_of_the_initial_posture_is_on_both_planes_of_symmetry():
    center = ROBOT.center_of_mass(ROBOT.initial_joint_angles)
    assert center[:2] == pytest.approx([0.0, 0.0], abs=1e-12)


def test_the_centre_of_mass_mirrors_when_the_legs_do():
    joints = random_joints(np.random.default_rng(3), 100)
    mirrored = joints[:, [1, 0, 3, 2]] * [-1.0, 1.0, 1.0]
    center = ROBOT.center_of_mass(joints)
    assert ROBOT.center_of_mass(mirrored) == pytest.approx(center * [1, -1, 1], abs=1e-12)


def test_the_centre_of_mass_is_that_of_the_urdf():
    # Each link's mass at its inertial origin, placed by the joints, nothing of our own.
    root = ElementTree.fromstring(urdf_from_robot(ROBOT))
    joints = {joint.find('child').get('link'): joint for joint in root.iter('joint')}

    def vector(element, name='xyz'):
        return np.array([float(x) for x in element.get(name).split()])

    def frame(link, angles):
        if link not in joints:
            return np.eye(4)
        joint = joints[link]
        origin = joint.find('origin')
        assert vector(origin, 'rpy')[:2] == pytest.approx([0.0, 0.0])
        angle = angles.get(joint.get('name'), 0.0)
        matrix = np.eye(4)
        matrix[:3, :3] = about_z(vector(origin, 'rpy')[2])
        matrix[:3, 3] = vector(origin)
        if joint.get('type') == 'revolute':
            axis = joint.find('axis').get('xyz')
            matrix[:3, :3] @= about_z(angle) if axis == '0 0 1' else about_y(angle)
        return frame(joint.find('parent').get('link'), angles) @ matrix

    for posture in random_joints(np.random.default_rng(4), 20):
        angles = dict(zip(ROBOT.joint_names, posture.reshape(-1)))
        total, moment = 0.0, np.zeros(3)
        for link in root.iter('link'):
            mass = float(link.find('inertial/mass').get('value'))
            at = np.append(vector(link.find('inertial/origin')), 1.0)
            moment += mass * (frame(link.get('name'), angles) @ at)[:3]
            total += mass
        assert ROBOT.center_of_mass(posture) == pytest.approx(moment / total, abs=1e-7)


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
    assert 'titan_viii' in available_robots()


def test_an_unknown_robot_is_answered_with_those_that_there_are():
    sentence = refusal('spot')
    assert sentence.startswith("there is no robot 'spot'; available: ")
    assert 'titan_viii' in sentence


@pytest.mark.parametrize(
    ('name', 'entry', 'told'),
    [
        ('leg_type', 'wheel', "leg_type is 'wheel'; available: 'yaw_pitch_pitch'"),
        ('leg_type', None, 'leg_type is None'),
        ('leg.thigh_length', None, "has no number 'leg.thigh_length'"),
        ('body', None, "has no number 'body.hip_half_length'"),
        ('leg', 3, "has no number 'leg.hip_offset'"),
        ('body.mass', 24.0, "'body.mass' must be given as {value: ..., source: ...}"),
        ('body.mass', {'value': 24.0}, "'body.mass' must be given as {value"),
        ('body.mass', {'value': 24.0, 'source': ''}, "'body.mass' must be given as {value"),
        ('body.mass', {'value': '24 kg', 'source': 'x'}, "'24 kg'; it must be a number"),
        ('body.mass', {'value': True, 'source': 'x'}, 'True; it must be a number'),
        ('body.mass', {'value': math.nan, 'source': 'x'}, 'nan; it must be a number'),
        ('body.mass', {'value': -1.0, 'source': 'x'}, "'body.mass' is -1.0; it must be positive"),
        ('leg.calf_lenght', {'value': 0.2, 'source': 'x'}, "has 'leg.calf_lenght', which means"),
        ('joints.hip_yaw.effort', {'value': 0.0, 'source': 'x'}, 'is 0.0; it must be positive'),
        ('leg.calf_length', {'value': 0, 'source': 'x'}, 'is 0; it must be positive'),
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
    ],
)
def test_a_bad_file_is_refused_in_one_sentence_that_names_it(tmp_path, name, entry, told):
    path = changed(tmp_path, name, entry)
    sentence = refusal(path)
    assert told in sentence
    assert str(path) in sentence


@pytest.mark.parametrize(
    ('content', 'told'),
    [
        (b'', 'must hold a mapping'),
        (b'- 1\n- 2\n', 'must hold a mapping'),
        (b'a: [1, 2\nb: 3\n', 'is not YAML'),
        (b'\xff\xfe\x00name: x', 'is not YAML'),
    ],
)
def test_what_is_no_mapping_is_refused_in_one_sentence(tmp_path, content, told):
    path = tmp_path / 'robot.yaml'
    path.write_bytes(content)
    sentence = refusal(path)
    assert told in sentence
    assert str(path) in sentence
