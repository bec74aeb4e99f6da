"""
What descriptions say of shapes, motors, masses and names is taken as it stands, or it is said.
"""

import re
from xml.etree import ElementTree

import pytest

pytest.importorskip('yourdfpy')

from quad_common.errors import DescriptionEntryInvalid, LegNotFeasible, MassesMissing
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

FLAT = 'v 0 0 0\nv .1 0 0\nv 0 .1 0\nf 1 2 3\n'
SOLID = 'v 0 0 0\nv .1 0 0\nv 0 .1 0\nv 0 0 .05\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n'


class Described:
    """A robot's description, which is changed and imported."""

    def __init__(self, folder):
        self.folder = folder
        self.root = ElementTree.fromstring(urdf_from_robot(load_robot('genibo')))

    def named(self, kind, name):
        return next(each for each in self.root.iter(kind) if each.get('name') == name)

    def add(self, link, use, kind, **sizes):
        made = ElementTree.SubElement(self.named('link', link), use)
        ElementTree.SubElement(ElementTree.SubElement(made, 'geometry'), kind, **sizes)

    def imported(self):
        path = self.folder / 'odd.urdf'
        path.write_text(ElementTree.tostring(self.root, encoding='unicode'))
        return import_robot(path)

    def written(self):
        """Return what import said it assumed, and the shapes of the body in what it wrote."""
        robot = self.imported()
        data_file, urdf = write_robot(robot, self.folder / 'out' / 'odd.yaml')
        assert load_robot(data_file).own_urdf
        body = ElementTree.fromstring(urdf.read_text()).find("link[@name='base_link']")
        shapes = {
            use: [shape[0] for shape in body.findall(f'{use}/geometry')]
            for use in ('visual', 'collision')
        }
        return robot.notes.assumed, shapes


@pytest.fixture
def described(tmp_path):
    return Described(tmp_path)


def test_a_leg_with_a_joint_that_follows_another_is_refused(described):
    for joint in described.root.iter('joint'):
        if joint.get('name').endswith('knee_pitch_joint'):
            driver = joint.get('name').replace('knee', 'hip')
            ElementTree.SubElement(joint, 'mimic', joint=driver, multiplier='-2')
    said = (
        "its joint 'lf_knee_pitch_joint' follows 'lf_hip_pitch_joint' (mimic), and only two of its "
        'joints have motors'
    )
    with pytest.raises(LegNotFeasible, match=re.escape(said)):
        described.imported()


def test_joints_beside_the_legs_that_follow_others_are_held_and_said(described):
    for side, parent in (('left', 'base_link'), ('right', 'base_link')):
        ElementTree.SubElement(described.root, 'link', name=side)
        joint = ElementTree.SubElement(described.root, 'joint', name=f'{side}_j', type='revolute')
        ElementTree.SubElement(joint, 'parent', link=parent)
        ElementTree.SubElement(joint, 'child', link=side)
        ElementTree.SubElement(joint, 'limit', lower='-1', upper='1', effort='1', velocity='1')
    ElementTree.SubElement(joint, 'mimic', joint='left_j')
    assumed = described.imported().notes.assumed
    assert '2 other joints are held at 0 (left_j, right_j)' in assumed
    assert any("held at 0, too ('right_j' follows 'left_j')" in each for each in assumed)


@pytest.mark.parametrize('sizes', [{}, {'scale': '1 1 0'}, {'scale': '0 0 0'}])
def test_what_is_seen_and_has_no_volume_is_left_out_and_said(described, sizes):
    (described.folder / 'mesh.obj').write_text(SOLID if sizes else FLAT)
    described.add('base_link', 'visual', 'mesh', filename='mesh.obj', **sizes)
    assumed, shapes = described.written()
    assert [shape.tag for shape in shapes['visual']] == ['box']
    assert 'meshes that are only looked at and have no volume are left out' in assumed


def test_what_collides_and_is_flat_becomes_a_thin_box_and_is_said(described):
    (described.folder / 'flat.obj').write_text(FLAT)
    described.add('base_link', 'collision', 'mesh', filename='flat.obj', scale='1 2 1')
    assumed, shapes = described.written()
    assert [shape.tag for shape in shapes['collision']] == ['box', 'box']
    size = sorted(float(side) for side in shapes['collision'][1].get('size').split())
    assert size[0] == pytest.approx(0.001)
    assert size[1:] == pytest.approx([0.1, 0.2], abs=1e-6)
    assert any("1 mm thick stands for the flat mesh 'flat.obj'" in each for each in assumed)


def test_meshes_with_a_volume_stay(described):
    (described.folder / 'mesh.obj').write_text(SOLID)
    for use in ('visual', 'collision'):
        described.add('base_link', use, 'mesh', filename='mesh.obj', scale='1 -1 1')
    assumed, shapes = described.written()
    assert assumed == []
    assert [shapes[use][1].get('scale') for use in shapes] == ['1.0 -1.0 1.0'] * 2


def test_dummies_are_left_out_and_thin_shapes_are_said_to_be(described):
    described.add('base_link', 'collision', 'sphere', radius='0')
    described.add('base_link', 'collision', 'box', size='0 0 0')
    assumed, shapes = described.written()
    assert [shape.tag for shape in shapes['collision']] == ['box']
    assert assumed == []
    described.add('base_link', 'collision', 'box', size='0.1 0.1 1e-6')
    assumed, shapes = described.written()
    assert [shape.tag for shape in shapes['collision']] == ['box']
    assert assumed == ['shapes that are thinner than 0.01 mm are left out']


def test_a_box_of_one_number_is_a_cube_for_engines_too(described):
    described.add('base_link', 'collision', 'box', size='0.05')
    _, shapes = described.written()
    assert shapes['collision'][1].get('size').split() == ['0.05'] * 3


def test_materials_may_have_textures_without_a_file(described):
    visual = described.named('link', 'base_link').find('visual')
    ElementTree.SubElement(ElementTree.SubElement(visual, 'material', name='m'), 'texture')
    assert described.written()[0] == []


def test_a_mass_that_is_too_small_is_not_said_to_be_none(described):
    described.named('link', 'base_link').find('inertial/mass').set('value', '0.0001')
    said = r'too small a mass of base_link, 0\.0001 kg at most, where a part needs 0\.001 kg; give'
    with pytest.raises(MassesMissing, match=said) as caught:
        described.imported()
    assert (caught.value.of_parts, caught.value.least) == (0.0001, 0.001)


@pytest.mark.parametrize(
    ('name', 'said'),
    [
        ('lf\nknee', r"joint 'lf\\nknee' has a name with a line break"),
        (201 * 'k', r"joint 'k*' has a name of 201 characters; 200 are the most"),
    ],
    ids=['two lines', 'too long'],
)
def test_names_that_no_robot_file_can_have_are_refused_for_what_they_are(described, name, said):
    described.named('joint', 'lf_knee_pitch_joint').set('name', name)
    with pytest.raises(DescriptionEntryInvalid, match=said):
        described.imported()


def test_shapes_that_are_none_are_refused_for_what_they_are(described):
    described.named('link', 'lf_calf').find('visual/geometry/cylinder').set('length', '-0.06')
    said = r"link 'lf_calf' has a cylinder length of -0\.06; it must be from 0 to 1000"
    with pytest.raises(DescriptionEntryInvalid, match=said):
        described.imported()
