"""
A data file's own URDF holds what the file names, or is refused in a sentence.
"""

import re

import pytest
import yaml

from quad_common.errors import RobotModelError
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')

from quad_common.importing.options import ImportOptions
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot


@pytest.fixture
def files(tmp_path):
    description = tmp_path / 'description.urdf'
    description.write_text(urdf_from_robot(load_robot('genibo')))
    return write_robot(import_robot(description, ImportOptions()), tmp_path / 'mine.yaml')


def changed(pattern, by):
    return lambda text: re.sub(pattern, by, text, count=1, flags=re.DOTALL)


@pytest.mark.parametrize(
    ('change', 'problem'),
    [
        (lambda text: '', 'is no XML'),
        (lambda text: text[: len(text) // 2], 'is no XML'),
        (lambda text: '<sdf/>', "is no URDF: it begins with 'sdf'"),
        (lambda text: '<!DOCTYPE robot>' + text[text.index('<robot') :], 'document type'),
        (changed('<joint name="lf_hip_roll_joint"', '<joint name="moved"'), 'has no joint'),
        (changed('<link name="lf_foot"', '<link name="moved"'), "'lf_foot_fixed' between links"),
        (changed('<parent link="lf_hip"', '<parent link="moon"'), 'links that are not there'),
        (changed('<child link="lf_thigh"', '<child link="lf_calf"'), 'two joints above the link'),
        (changed('type="revolute"', 'type="fixed"'), 'that is not revolute'),
        (changed('(<link name="lf_thigh">)', r'<link name="lf_thigh"/>\1'), 'has 2 links'),
        (changed('(name="lf_hip_roll_joint".*?parent link=")base_link', r'\1lf_calf'), 'a loop'),
        (changed('</robot>', '<link name="apart"/></robot>'), '2 links that hang from no other'),
    ],
)
def test_a_urdf_that_is_not_what_the_file_says_is_refused(files, change, problem):
    data_file, urdf = files
    assert load_robot(data_file).own_urdf
    urdf.write_text(change(urdf.read_text()))
    with pytest.raises(RobotModelError, match=problem):
        load_robot(data_file)


def test_a_file_with_legs_has_a_urdf(files):
    data_file, _ = files
    document = yaml.safe_load(data_file.read_text())
    del document['urdf']
    data_file.write_text(yaml.safe_dump(document))
    with pytest.raises(RobotModelError, match="'urdf' is None"):
        load_robot(data_file)


def test_a_file_without_legs_has_none(tmp_path):
    path = tmp_path / 'genibo.yaml'
    document = yaml.safe_load(robot_text('genibo'))
    path.write_text(yaml.safe_dump({**document, 'urdf': 'genibo.urdf'}))
    with pytest.raises(RobotModelError, match='urdf'):
        load_robot(path)


def robot_text(name):
    from quad_common.robot_files.robot_file import ROBOTS_FOLDER

    return (ROBOTS_FOLDER / f'{name}.yaml').read_text()
