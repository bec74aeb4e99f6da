"""Of the names of joints and links the one that is none is told."""

import pytest
import yaml

pytest.importorskip('yourdfpy')

from quad_common.errors import RobotModelError
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot


@pytest.fixture
def data_file(tmp_path):
    """Genibo as it is imported."""
    path = tmp_path / 'genibo.urdf'
    path.write_text(urdf_from_robot(load_robot('genibo')))
    return write_robot(import_robot(path), tmp_path / 'imported.yaml')[0]


@pytest.mark.parametrize(
    ('name', 'said'),
    [
        ('lf\nknee', r"'names\.joints\[2\]' is 'lf\\nknee'; it must be a text of 1 to 200 print"),
        (201 * 'k', r"'names\.joints\[2\]' is 'k*' .* it must be a text of 1 to 200 printable"),
        ('rf_knee_pitch_joint', r"'names\.joints\[5\]' is .* another name than those before it"),
        (7, r"'names\.joints' is .*; it must be a list of 12 names"),
    ],
    ids=['two lines', 'too long', 'twice', 'a number'],
)
def test_the_name_that_is_none_is_told(data_file, name, said):
    document = yaml.safe_load(data_file.read_text())
    document['names']['joints'][2] = name
    data_file.write_text(yaml.safe_dump(document))
    with pytest.raises(RobotModelError, match=said):
        load_robot(data_file)
