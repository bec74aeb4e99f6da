"""
Robots by name and by description are imported once, and again when the description changes.
"""

import concurrent.futures
import importlib.util
from xml.etree import ElementTree

import pytest

from quad_common.errors import DescriptionError, RobotModelError
from quad_common.files.bounded_file import user_path
from quad_common.robot.urdf import published_urdf, urdf_from_robot
from quad_common.robot_files.robot_file import load_robot, robot_file

pytest.importorskip('yourdfpy')

from quad_common.description.meshes import mesh_path
from quad_common.named_robots.known_robots import KNOWN_ROBOTS, known_names
from quad_common.named_robots.robot_cache import is_kept

needs_descriptions = pytest.mark.skipif(
    importlib.util.find_spec('pybullet_data') is None, reason='pybullet_data is not installed'
)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    folder = tmp_path / 'cache'
    monkeypatch.setenv('XDG_CACHE_HOME', str(folder))
    return folder / 'quadwalk' / 'robots'


@pytest.fixture
def description(tmp_path):
    path = tmp_path / 'mine.urdf'
    path.write_text(urdf_from_robot(load_robot('genibo')))
    return path


def test_a_description_is_a_robot(cache, description):
    robot = load_robot(description)
    assert robot.name == 'mine'
    assert robot.mass == pytest.approx(load_robot('genibo').mass)
    assert [path.suffix for path in sorted(cache.iterdir())] == ['.urdf', '.yaml']


def test_data_files_that_were_imported_are_told_from_others(cache, description):
    assert is_kept(robot_file(description))
    assert not is_kept(robot_file('genibo'))


def test_it_is_imported_once(cache, description, monkeypatch):
    first = robot_file(description)
    monkeypatch.setattr(
        'quad_common.importing.robot_import.import_robot', lambda *_: pytest.fail('imported again')
    )
    assert robot_file(description) == first


def test_a_changed_description_is_imported_again(cache, description):
    first = robot_file(description)
    description.write_text(description.read_text().replace('effort="2"', 'effort="3"'))
    second = robot_file(description)
    assert second != first
    assert load_robot(second).effort.max() == 3.0


def test_a_changed_part_of_a_description_is_noticed(cache, tmp_path):
    pytest.importorskip('xacro')
    folder = tmp_path / 'my_robot' / 'xacro'
    folder.mkdir(parents=True)
    text = urdf_from_robot(load_robot('genibo'))
    body = text[text.index('<link') : text.rindex('</robot>')]
    opening = '<robot name="mine" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    (folder / 'body.xacro').write_text(f'{opening}{body}</robot>')
    main = folder / 'mine.xacro'
    main.write_text(f'{opening}<xacro:include filename="body.xacro"/></robot>')
    first = robot_file(main)
    assert robot_file(main) == first
    (folder / 'body.xacro').write_text(
        f'{opening}{body}</robot>'.replace('effort="2"', 'effort="4"')
    )
    assert load_robot(robot_file(main)).effort.max() == 4.0


def test_many_at_once_do_not_disturb_each_other(cache, description):
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        files = list(pool.map(robot_file, [description] * 8))
    assert len(set(files)) == 1
    assert load_robot(files[0]).name == 'mine'
    assert len(list(cache.iterdir())) == 2


def test_what_cannot_be_imported_is_said(cache, tmp_path):
    path = tmp_path / 'broken.urdf'
    path.write_text('<robot name="x"><link name="a"/></robot>')
    with pytest.raises(DescriptionError, match='no joint that moves'):
        load_robot(path)
    assert not cache.exists()


def test_a_package_holds_a_robot(cache, tmp_path, monkeypatch):
    share = tmp_path / 'install' / 'share' / 'my_robot' / 'urdf'
    share.mkdir(parents=True)
    (share / 'mine.urdf').write_text(urdf_from_robot(load_robot('pukyong')))
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path / 'install'))
    assert load_robot('package://my_robot/urdf/mine.urdf').leg_type == 'yaw_pitch_pitch'
    with pytest.raises(RobotModelError, match='there is no robot'):
        load_robot('package://my_robot/urdf/other.urdf')
    # Gaits, maps and cameras are named in the same manner.
    gait = share.parent / 'gaits' / 'mine.yaml'
    gait.parent.mkdir()
    gait.write_text('name: mine')
    assert user_path('package://my_robot/gaits/mine.yaml') == gait


@pytest.mark.sweep(kept=3)
@needs_descriptions
@pytest.mark.parametrize('name', KNOWN_ROBOTS)
def test_known_robots_stand_within_their_limits(name, cache):
    robot = load_robot(name)
    assert robot.name == name
    angles = robot.joint_angles(robot.neutral_feet)
    assert abs(angles - robot.initial_joint_angles).max() < 1e-6
    assert robot.largest_stride > 0.2 * robot.hip_height


@needs_descriptions
def test_frames_of_others_begin_at_base_link(cache):
    text = published_urdf(load_robot('a1'))
    assert '<parent link="base_link" />' in text
    assert '<child link="trunk" />' in text


@needs_descriptions
def test_others_find_the_meshes(cache):
    root = ElementTree.fromstring(published_urdf(load_robot('a1')))
    names = {mesh.get('filename') for mesh in root.iter('mesh')}
    assert names
    for name in names:
        assert name.startswith('file:///')
        assert mesh_path(name, cache).is_file()


def test_a_folder_that_cannot_be_written_is_said(tmp_path, description, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', '/proc/no_such_folder')
    with pytest.raises(RobotModelError, match='cannot be made'):
        load_robot(description)


def test_a_robot_with_a_very_long_name_is_kept(cache, tmp_path):
    path = tmp_path / f'{"x" * 240}.urdf'
    path.write_text(urdf_from_robot(load_robot('genibo')))
    assert load_robot(path).name == 'x' * 64


def test_a_name_is_no_path(cache, tmp_path):
    path = tmp_path / 'robot.urdf'
    text = urdf_from_robot(load_robot('genibo'))
    path.write_text(text.replace('<robot name="genibo"', '<robot name="../../elsewhere"'))
    robot = load_robot(path)
    assert '/' not in robot.name
    assert robot_file(path).parent == cache


def test_only_its_package_is_looked_through(cache, tmp_path):
    pytest.importorskip('xacro')
    package = tmp_path / 'my_robot'
    for folder in ('urdf', 'parts'):
        (package / folder).mkdir(parents=True)
    (package / 'package.xml').write_text('<package/>')
    text = urdf_from_robot(load_robot('genibo'))
    body = text[text.index('<link') : text.rindex('</robot>')]
    opening = '<robot name="mine" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    part, main = package / 'parts' / 'body.xacro', package / 'urdf' / 'mine.xacro'
    part.write_text(f'{opening}{body}</robot>')
    main.write_text(f'{opening}<xacro:include filename="../parts/body.xacro"/></robot>')
    first = robot_file(main)
    (tmp_path / 'other.xacro').write_text('nothing of this robot')
    assert robot_file(main) == first
    part.write_text(part.read_text().replace('effort="2"', 'effort="4"'))
    assert robot_file(main) != first


def test_names_of_robots_that_are_not_installed_are_not_offered(monkeypatch):
    monkeypatch.setattr('importlib.util.find_spec', lambda name: None)
    assert known_names() == ()
