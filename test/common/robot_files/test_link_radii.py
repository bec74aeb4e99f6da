"""Links are no thicker than legs of their length are."""

import pytest
import yaml

pytest.importorskip('yourdfpy')

from quad_common.errors import LinkTooThick
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import ROBOTS_FOLDER, available_robots, load_robot


@pytest.fixture
def data_file(tmp_path):
    """Genibo as it is imported."""
    path = tmp_path / 'genibo.urdf'
    path.write_text(urdf_from_robot(load_robot('genibo')))
    return write_robot(import_robot(path), tmp_path / 'imported.yaml')[0]


def changed(path, target, change):
    document = yaml.safe_load(path.read_text())
    change(document)
    target.write_text(yaml.safe_dump(document))
    return target


@pytest.mark.parametrize('kind', ['hip', 'thigh', 'calf', 'foot'])
@pytest.mark.parametrize('is_imported', [True, False])
def test_links_that_are_thicker_than_half_the_leg_is_long_are_refused(
    data_file, kind, is_imported, tmp_path
):
    path = data_file if is_imported else ROBOTS_FOLDER / 'genibo.yaml'

    def thick(radius):
        return changed(
            path, tmp_path / 'thick.yaml', lambda d: d['leg'][f'{kind}_radius'].update(value=radius)
        )

    said = rf'leg\.{kind}_radius is 2 m; links of legs that are 0\.13 m long .* 0\.065 m at most'
    with pytest.raises(LinkTooThick, match=said) as caught:
        load_robot(thick(2.0))
    assert caught.value.radius == 2.0
    assert caught.value.most == pytest.approx(0.065)
    assert load_robot(thick(0.064)).links[kind].radius == 0.064


@pytest.mark.parametrize('name', available_robots())
def test_robots_that_ship_have_room_to_that(name):
    robot = load_robot(name)
    thickest = max(link.radius for link in robot.links.values())
    assert thickest < 0.15 * min(leg.thigh_length + leg.calf_length for leg in robot.legs)
