"""
Descriptions are read whichever format they have, and what is wrong with them is said.
"""

import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
from functools import partial
from itertools import pairwise

import pytest

from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot

pytest.importorskip('yourdfpy')

from quad_common.description import bounded_call, reading, xacro_expansion
from quad_common.description.bounded_call import Bounds
from quad_common.description.meshes import mesh_path
from quad_common.description.reading import read_description
from quad_common.description.tree import KinematicTree
from quad_common.errors import DescriptionEntryInvalid, DescriptionError

XACRO = """<?xml version="1.0"?>
<robot name="mine" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="mass" default="2.0"/>
  <xacro:include filename="$(find my_parts)/xacro/leg.xacro"/>
  <link name="base_link">
    <inertial>
      <mass value="$(arg mass)"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>
    <visual><geometry><mesh filename="file://$(find my_parts)/body.stl"/></geometry></visual>
  </link>
  <xacro:leg side="left"/>
</robot>
"""

LEG = """<?xml version="1.0"?>
<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="leg" params="side">
    <link name="${side}_leg"/>
    <joint name="${side}_hip" type="fixed">
      <parent link="base_link"/><child link="${side}_leg"/><axis xyz="0 0 0"/>
    </joint>
  </xacro:macro>
</robot>
"""


@pytest.fixture
def xacro_file(tmp_path, monkeypatch):
    """A robot in one package that is made of parts in another; neither is installed."""
    pytest.importorskip('xacro')
    pytest.importorskip('ament_index_python')
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    for package in ('my_robot', 'my_parts'):
        (tmp_path / package / 'xacro').mkdir(parents=True)
        (tmp_path / package / 'package.xml').write_text('<package/>')
    (tmp_path / 'my_parts' / 'xacro' / 'leg.xacro').write_text(LEG)
    path = tmp_path / 'my_robot' / 'xacro' / 'robot.xacro'
    path.write_text(XACRO)
    return path


def test_xacro_finds_the_packages_around(xacro_file, tmp_path):
    robot = read_description(xacro_file)
    assert [link.name for link in robot.links] == ['base_link', 'left_leg']
    # A fixed joint's axis means nothing.
    assert KinematicTree(robot, xacro_file).root == 'base_link'
    mesh = robot.links[0].visuals[0].geometry.mesh.filename
    assert mesh == f'file://{tmp_path}/my_parts/body.stl'
    assert 'AMENT_PREFIX_PATH' not in os.environ


def test_xacro_takes_arguments(xacro_file):
    assert read_description(xacro_file).links[0].inertial.mass == 2.0
    assert read_description(xacro_file, {'mass': '3.5'}).links[0].inertial.mass == 3.5


def test_arguments_that_no_file_asks_for_are_refused_with_those_that_it_does(xacro_file):
    with pytest.raises(DescriptionError, match="no argument 'mas'; it asks for 'mass'"):
        read_description(xacro_file, {'mas': '3.5'})


def test_arguments_that_are_missing_are_asked_for(xacro_file):
    xacro_file.write_text(XACRO.replace('<xacro:arg name="mass" default="2.0"/>', ''))
    with pytest.raises(DescriptionError, match='--argument NAME=VALUE'):
        read_description(xacro_file)
    assert read_description(xacro_file, {'mass': '3.5'}).links[0].inertial.mass == 3.5


def test_packages_have_the_names_that_they_give_themselves(xacro_file, tmp_path):
    cloned = tmp_path / 'my_parts-main'
    (tmp_path / 'my_parts').rename(cloned)
    (cloned / 'package.xml').write_text('<package><name> my_parts </name></package>')
    robot = read_description(xacro_file)
    assert robot.links[0].visuals[0].geometry.mesh.filename == f'file://{cloned}/body.stl'
    name = 'package://my_parts/xacro/leg.xacro'
    assert mesh_path(name, cloned / 'xacro' / 'leg.xacro') == cloned / 'xacro' / 'leg.xacro'


@pytest.mark.parametrize('name', ['../..', '/tmp', 'a/b', '..', ''])
def test_no_package_name_leads_out_of_the_index(name, xacro_file, tmp_path):
    (tmp_path / 'my_robot' / 'package.xml').write_text(f'<package><name>{name}</name></package>')
    assert read_description(xacro_file).links[0].name == 'base_link'


@pytest.mark.parametrize('name', ['R&D <1>', 'the "first"', "the 'first'"])
def test_folders_may_have_names_that_xml_does_not_hold(name, xacro_file, tmp_path):
    odd = tmp_path / name
    odd.mkdir()
    for package in ('my_robot', 'my_parts'):
        (tmp_path / package).rename(odd / package)
    robot = read_description(odd / 'my_robot' / 'xacro' / 'robot.xacro')
    assert robot.links[0].visuals[0].geometry.mesh.filename == f'file://{odd}/my_parts/body.stl'


def test_the_folder_for_temporary_files_may_have_such_a_name(xacro_file, tmp_path, monkeypatch):
    odd = tmp_path / 'R&D'
    odd.mkdir()
    monkeypatch.setattr(tempfile, 'tempdir', str(odd))
    robot = read_description(xacro_file)
    assert (
        robot.links[0].visuals[0].geometry.mesh.filename == f'file://{tmp_path}/my_parts/body.stl'
    )


def test_names_of_packages_may_begin_with_those_of_others(xacro_file, tmp_path):
    for folder, name in (('my_robot', 'my'), ('my_parts', 'my_parts')):
        text = f'<package><name>{name}</name></package>'
        (tmp_path / folder / 'package.xml').write_text(text)
        (tmp_path / folder).rename(tmp_path / f'{folder}-main')
    path = tmp_path / 'my_robot-main' / 'xacro' / 'robot.xacro'
    mesh = read_description(path).links[0].visuals[0].geometry.mesh.filename
    assert mesh == f'file://{tmp_path}/my_parts-main/body.stl'
    missing = tmp_path / 'my_parts-main' / 'xacro' / 'leg.xacro'
    missing.unlink()
    with pytest.raises(DescriptionError) as error:
        read_description(path)
    assert str(error.value).count(str(missing)) == 1


def test_packages_that_are_missing_are_named_once(xacro_file, tmp_path):
    (tmp_path / 'my_parts').rename(tmp_path / 'others')
    with pytest.raises(DescriptionError) as error:
        read_description(xacro_file)
    assert str(error.value).count('my_parts') == 1
    assert 'ament' not in str(error.value)


def test_files_that_xacro_misses_are_named_where_they_would_be(xacro_file, tmp_path):
    missing = tmp_path / 'my_parts' / 'xacro' / 'leg.xacro'
    missing.unlink()
    with pytest.raises(DescriptionError) as error:
        read_description(xacro_file)
    assert str(error.value).count(str(missing)) == 1


def test_parts_of_descriptions_are_told_from_robots(xacro_file, tmp_path):
    with pytest.raises(DescriptionError, match='describes no links; is it a part'):
        read_description(tmp_path / 'my_parts' / 'xacro' / 'leg.xacro')


def test_robots_need_no_name_of_their_own(tmp_path):
    path = tmp_path / 'mine.urdf'
    path.write_text('<robot><link name="body"/></robot>')
    assert read_description(path).name == 'mine'


def test_files_that_are_not_there_are_said(tmp_path):
    with pytest.raises(DescriptionError, match=r'missing\.urdf'):
        read_description(tmp_path / 'missing.urdf')


@pytest.mark.parametrize(
    'declared', ['', '<?xml version="0.0" ?>', '\ufeff<?xml version="1.0"?>\n']
)
def test_what_files_say_of_themselves_does_not_matter(declared, tmp_path):
    path = tmp_path / 'genibo.urdf'
    path.write_text(declared + urdf_from_robot(load_robot('genibo')), encoding='utf-8')
    assert len(read_description(path).joints) == 16


def test_capsules_are_cylinders(tmp_path):
    path = tmp_path / 'genibo.urdf'
    path.write_text(urdf_from_robot(load_robot('genibo')).replace('<cylinder', '<capsule'))
    shapes = [link.collisions[0].geometry for link in read_description(path).links]
    assert sum(shape.cylinder is not None for shape in shapes) == 12


def write_robot(tmp_path, change):
    """A link and a joint with everything that counts its numbers, and one change."""
    text = (
        '<robot name="a"><link name="body"><inertial><origin xyz="0 0 0"/><mass value="1"/>'
        '</inertial><visual><origin xyz="1 2 3" rpy="0 0 0"/><geometry><sphere radius="1"/>'
        '</geometry><material name="m"><texture filename="a.png"/></material></visual></link>'
        '<link name="leg"/><joint name="hip" type="revolute"><origin xyz="4 5 6" rpy="0 0 1"/>'
        '<parent link="body"/><child link="leg"/><axis xyz="0 1 0"/>'
        '<limit lower="0" upper="0" effort="1" velocity="1"/></joint></robot>'
    )
    assert change[0] in text
    path = tmp_path / 'robot.urdf'
    path.write_text(text.replace(*change))
    return path


@pytest.mark.parametrize(
    ('was', 'becomes', 'said'),
    [
        ('xyz="0 0 0"', 'xyz="0.04"', "link 'body' has an origin with xyz='0.04'.* 3 numbers"),
        ('xyz="1 2 3"', 'xyz="1 2"', "link 'body' has an origin with xyz='1 2'.* 3 numbers"),
        ('xyz="4 5 6"', 'xyz="4"', "joint 'hip' has an origin with xyz='4'.* 3 numbers"),
        ('xyz="4 5 6"', 'xyz="4 5 6 7"', "joint 'hip' has an origin with xyz='4 5 6 7'"),
        ('xyz="4 5 6"', 'xyz="4 5 up"', "joint 'hip' has an origin with xyz='4 5 up'"),
        ('rpy="0 0 1"', 'rpy="0.1"', "joint 'hip' has an origin with rpy='0.1'.* 3 numbers"),
        ('rpy="0 0 1"', 'rpy="0 0 0 0 0"', "joint 'hip' has an origin with rpy="),
        ('axis xyz="0 1 0"', 'axis', "joint 'hip' has an axis without xyz"),
        ('axis xyz="0 1 0"', 'axis xyz="1"', "joint 'hip' has an axis with xyz='1'"),
        ('<limit', '<mimic/><limit', "joint 'hip' has a mimic that names no joint"),
    ],
)
def test_numbers_are_counted_and_whose_they_are_is_said(was, becomes, said, tmp_path):
    with pytest.raises(DescriptionEntryInvalid, match=said):
        read_description(write_robot(tmp_path, (was, becomes)))


def test_a_fourth_angle_is_not_read(tmp_path):
    path = write_robot(tmp_path, ('rpy="0 0 1"', 'rpy="0 0 1 0"'))
    tree = KinematicTree(read_description(path), path)
    path = write_robot(tmp_path, ('rpy="0 0 1"', 'rpy="0 0 1"'))
    assert (tree.pose('leg') == KinematicTree(read_description(path), path).pose('leg')).all()


def test_a_texture_without_a_file_is_none(tmp_path):
    path = write_robot(tmp_path, ('<texture filename="a.png"/>', '<texture/>'))
    assert read_description(path).links[0].visuals[0].material.texture is None
    path = write_robot(tmp_path, ('a.png', 'b.png'))
    assert read_description(path).links[0].visuals[0].material.texture.filename == 'b.png'


@pytest.mark.parametrize('limit', ['0.3', '-1e-3'])
def test_a_joint_that_its_limits_lock_is_not_free(limit, tmp_path):
    change = ('lower="0" upper="0"', f'lower="{limit}" upper="{limit}"')
    path = write_robot(tmp_path, change)
    said = f"joint 'hip' is fixed at {float(limit):g} rad by its limits"
    with pytest.raises(DescriptionEntryInvalid, match=said):
        KinematicTree(read_description(path), path)
    # What exporters write where nobody said anything.
    path = write_robot(tmp_path, ('lower="0"', 'lower="0"'))
    joint = KinematicTree(read_description(path), path).joints['hip']
    assert (joint.lower, joint.upper) == (-math.inf, math.inf)


def test_chains_of_thousands_of_links_are_read(tmp_path):
    path = tmp_path / 'chain.urdf'
    joint = '<joint name="{1}" type="fixed"><parent link="{0}"/><child link="{1}"/></joint>'
    links = [f'link{number}' for number in range(3000)]
    joints = [joint.format(*pair) for pair in pairwise(links)]
    named = ''.join(f'<link name="{link}"/>' for link in links)
    path.write_text(f'<robot name="chain">{named}{"".join(joints)}</robot>')
    tree = KinematicTree(read_description(path), path)
    assert tree.below(links[1]) == links[1:]
    assert tree.rigid_group(links[0]) == links


@pytest.mark.parametrize('name', ['${9**9**9}', '${[0] * 10**11}'])
def test_expressions_that_xacro_would_compute_for_ever_are_given_up(name, tmp_path, monkeypatch):
    pytest.importorskip('xacro')
    # What the worker may take is passed on to it: a hard limit is never raised.
    limits = resource.getrlimit(resource.RLIMIT_CPU)
    monkeypatch.setattr(subprocess, 'run', partial(subprocess.run, preexec_fn=lambda: (
        resource.setrlimit(resource.RLIMIT_CPU, (1, 1))
    )))  # fmt: skip
    path = tmp_path / 'robot.xacro'
    path.write_text(
        f'<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="{name}"/></robot>'
    )
    with pytest.raises(DescriptionError, match='xacro cannot expand it: '):
        read_description(path)
    assert resource.getrlimit(resource.RLIMIT_CPU) == limits


def test_a_file_that_xacro_waits_for_is_given_up(tmp_path, monkeypatch):
    pytest.importorskip('xacro')
    bounds = xacro_expansion._BOUNDS
    assert bounds.patience <= 20.0
    monkeypatch.setattr(xacro_expansion, '_BOUNDS', bounds._replace(patience=1.5))
    os.mkfifo(tmp_path / 'pipe')
    path = tmp_path / 'robot.xacro'
    path.write_text(
        '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:include filename="pipe"/><link name="a"/></robot>'
    )
    with pytest.raises(DescriptionError, match='it takes, or waits, more than 2 s'):
        read_description(path)


MUJOCO = '<mujoco><asset>{}</asset><worldbody>{}</worldbody></mujoco>'
BODY = '<body><freejoint/><geom size=".1"/></body>'


@pytest.mark.parametrize(
    ('asset', 'world'),
    [
        ('', 4 * '<replicate count="1000">' + BODY + 4 * '</replicate>'),
        ('<hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/>', BODY),
    ],
)
def test_what_mujoco_would_compute_for_ever_is_given_up(asset, world, tmp_path, monkeypatch):
    pytest.importorskip('mujoco')
    monkeypatch.setattr(reading, '_BOUNDS_OF_MJCF', Bounds(seconds=2, memory=2**32))
    path = tmp_path / 'robot.xml'
    path.write_text(MUJOCO.format(asset, world))
    with pytest.raises(DescriptionError, match=r'MuJoCo cannot read it: .*(memory|must match)'):
        read_description(path)


def test_a_mesh_that_mujoco_waits_for_is_given_up(tmp_path, monkeypatch):
    pytest.importorskip('mujoco')
    bounds = reading._BOUNDS_OF_MJCF._replace(patience=1.5)
    monkeypatch.setattr(reading, '_BOUNDS_OF_MJCF', bounds)
    os.mkfifo(tmp_path / 'pipe.stl')
    path = tmp_path / 'robot.xml'
    path.write_text(MUJOCO.format('<mesh name="a" file="pipe.stl"/>', BODY))
    with pytest.raises(DescriptionError, match='MuJoCo cannot read it: it takes, or waits, '):
        read_description(path)


def test_a_call_in_bounds_ends_nothing_but_its_own_process():
    call = partial(bounded_call.call_in_bounds, bounds=Bounds(seconds=10, memory=2**32))
    # What is printed is no answer.
    assert call(os.write, 1, b'noise') == 5
    with pytest.raises(DescriptionError, match='is no XML'):
        call(reading.read_description, __file__)
    with pytest.raises(bounded_call.CallFailed, match='SystemExit: enough'):
        call(sys.exit, 'enough')
    with pytest.raises(bounded_call.BeyondBounds, match='by SIGSEGV'):
        call(signal.raise_signal, signal.SIGSEGV)
    with pytest.raises(bounded_call.BeyondBounds, match='more than 10 s, or too much memory'):
        call(os.abort)
