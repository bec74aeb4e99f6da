"""
What a data file says of legs of any three axes is checked when it is loaded.
"""

import pytest
import yaml

from quad_common.errors import InitialPostureSingular
from quad_common.robot_files.robot_file import load_robot
from quad_lab.robots.serial_robots import serial_urdf

pytest.importorskip('yourdfpy')

from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot


@pytest.fixture(scope='module')
def data_file(tmp_path_factory):
    folder = tmp_path_factory.mktemp('serial')
    description = folder / 'description.urdf'
    description.write_text(serial_urdf('skewed'), encoding='utf-8')
    return write_robot(import_robot(description), folder / 'mine.yaml')[0]


def all_parallel(leg):
    leg['axes']['value'] = [0.0, 1.0, 0.0] * 3


def all_at_one_point(leg):
    leg['points']['value'] = leg['points']['value'][:3] * 3
    leg['foot']['value'] = leg['points']['value'][:3]


@pytest.mark.parametrize('change', [all_parallel, all_at_one_point])
def test_a_singular_posture_is_said_with_file_and_key(change, data_file):
    document = yaml.safe_load(data_file.read_text(encoding='utf-8'))
    change(document['legs']['rf'])
    changed = data_file.with_name(f'{change.__name__}.yaml')
    changed.write_text(yaml.safe_dump(document), encoding='utf-8')
    with pytest.raises(InitialPostureSingular) as error:
        load_robot(changed)
    assert str(error.value).startswith(f'{changed}: legs.rf.initial_posture is singular: leg rf ')


def test_a_regular_one_is_loaded(data_file):
    assert load_robot(data_file).leg_type == 'serial'
