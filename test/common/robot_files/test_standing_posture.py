"""A robot that could not stand in its initial posture is refused."""

import pytest
import yaml

from quad_common.errors import CenterOfMassBelowGround
from quad_common.robot_files.robot_file import ROBOTS_FOLDER, load_robot


@pytest.mark.parametrize('entry', ['body.center_height', 'leg.hip_drop'])
def test_a_center_of_mass_below_the_feet_is_refused(tmp_path, entry):
    document = yaml.safe_load((ROBOTS_FOLDER / 'titan_viii.yaml').read_text())
    document.pop('stated', None)
    room, name = entry.split('.')
    document[room][name] = {'value': -2.0, 'source': 'a slip of the pen'}
    path = tmp_path / 'robot.yaml'
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(CenterOfMassBelowGround, match='center of mass in the initial posture is -'):
        load_robot(path)
