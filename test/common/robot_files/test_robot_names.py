"""What a robot may be asked for by, and what is said where there is none."""

import shutil

import pytest

from quad_common.errors import RobotFileMissing, RobotUnknown
from quad_common.robot_files.robot_file import ROBOTS_FOLDER, load_robot, robot_file


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A ROS package with a robot, found by ROS's path, in a folder that is called otherwise."""
    folder = tmp_path / 'checkout' / 'my_pkg'
    (folder / 'robots').mkdir(parents=True)
    (folder / 'package.xml').write_text('<package><name>my_pkg</name></package>')
    shutil.copy(ROBOTS_FOLDER / 'genibo.yaml', folder / 'robots' / 'my.yaml')
    monkeypatch.setenv('ROS_PACKAGE_PATH', str(tmp_path / 'checkout'))
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    return folder


def test_a_robot_in_a_ros_package_is_loaded_by_its_name(package):
    path = 'package://my_pkg/robots/my.yaml'
    assert robot_file(path) == package / 'robots' / 'my.yaml'
    assert load_robot(path).mass == load_robot('genibo').mass


def test_of_a_package_that_is_there_the_file_is_missing(package):
    with pytest.raises(RobotFileMissing, match="no such file in the package 'my_pkg'"):
        load_robot('package://my_pkg/robots/other.yaml')


def test_of_a_package_that_is_not_there_its_workspace_is_to_be_sourced(package):
    with pytest.raises(RobotFileMissing, match=r"package 'other' is neither in .*setup\.bash"):
        load_robot('package://other/robots/my.yaml')


@pytest.mark.parametrize('name', ['nowhere/robot', 'robot.urdf', 'robot.yaml', './robot.xml'])
def test_what_can_only_be_a_file_is_said_to_be_missing_as_one(name):
    with pytest.raises(RobotFileMissing, match=r'no such file; it may be .*\.urdf.* titan_viii'):
        load_robot(name)


def test_what_may_be_a_name_is_said_to_be_none():
    with pytest.raises(RobotUnknown, match=r"no robot 'spot'; available: .*URDF"):
        load_robot('spot')
