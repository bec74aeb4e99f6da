"""The command exports robots for ros2_control, and imports them from MJCF."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

pytest.importorskip('rich')

from quad_cli.main import main
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files.robot_file import load_robot, robot_file

FILES = ['titan_viii.urdf', 'controllers.yaml', 'joint_limits.yaml', 'bringup.launch.py']


def test_export_names_what_it_wrote_and_what_comes_next(tmp_path, capsys):
    folder = tmp_path / 'titan'
    assert main(['robot', 'export', 'titan_viii', '--output', str(folder)]) == 0
    told = capsys.readouterr().out
    assert told.splitlines() == [
        f'written: {", ".join(str(folder / name) for name in FILES)}',
        f'next: ros2 launch {folder / "bringup.launch.py"}',
    ]
    assert sorted(path.name for path in folder.iterdir()) == sorted(FILES)
    assert "'robot': ('titan_viii'," in (folder / 'bringup.launch.py').read_text()


def test_without_a_folder_it_writes_beside_where_it_is_called(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(['robot', 'export', 'titan_viii', '--plugin', 'my_hardware/Sys', '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['plugin'] == 'my_hardware/Sys'
    assert told['written'] == [str(Path('titan_viii_bringup') / name) for name in FILES]
    plugin = ElementTree.parse('titan_viii_bringup/titan_viii.urdf').find('.//plugin')
    assert plugin.text == 'my_hardware/Sys'


def test_nodes_find_an_exported_robot_from_any_folder(tmp_path, capsys, monkeypatch):
    (tmp_path / 'mine.yaml').write_text(robot_file('genibo').read_text())
    monkeypatch.chdir(tmp_path)
    assert main(['robot', 'export', 'mine.yaml', '--output', 'out']) == 0
    assert capsys.readouterr().out.startswith('written: ')
    launched = (tmp_path / 'out' / 'bringup.launch.py').read_text()
    assert repr(str((tmp_path / 'mine.yaml').resolve())) in launched


def test_a_folder_that_cannot_be_is_refused_in_one_sentence(tmp_path, capsys):
    (tmp_path / 'file').write_text('')
    with pytest.raises(SystemExit) as caught:
        main(['robot', 'export', 'titan_viii', '--output', str(tmp_path / 'file' / 'folder')])
    assert caught.value.code == 2
    assert 'is not a folder' in capsys.readouterr().err


def test_a_robot_is_imported_from_mjcf_and_can_be_exported(tmp_path, capsys, monkeypatch):
    pytest.importorskip('mujoco')
    pytest.importorskip('yourdfpy')
    from mjcf_robots import with_classes

    scene = with_classes(tmp_path / 'mjcf')
    monkeypatch.chdir(tmp_path)
    importing = ['robot', 'import', str(scene), '--speed', '20', '--no-picture', '--json']
    assert main(importing) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['name'] == 'classy'
    assert told['mass_kg'] == pytest.approx(12.72)
    assert main(['robot', 'export', 'classy.yaml', '--output', 'out', '--json']) == 0
    root = ElementTree.parse('out/classy.urdf').getroot()
    meshes = [mesh.get('filename') for mesh in root.iter('mesh')]
    assert meshes
    # RViz reads addresses, not paths.
    assert all(name.startswith('file:///') for name in meshes)
    assert all(Path(name.removeprefix('file://')).is_file() for name in meshes)
    joints = [joint.get('name') for joint in root.findall('ros2_control/joint')]
    assert tuple(joints) == load_robot('classy.yaml').joint_names


def test_of_joints_that_are_too_slow_to_trot_the_speed_is_said_that_gives_one(tmp_path, capsys):
    pytest.importorskip('yourdfpy')
    description = tmp_path / 'slow robot.urdf'
    description.write_text(urdf_from_robot(load_robot('genibo')))
    importing = ['robot', 'import', str(description), '--no-picture']
    importing += ['--output', str(tmp_path / 'slow.yaml')]
    assert main([*importing, '--speed', '1']) == 0
    said = [line for line in capsys.readouterr().out.splitlines() if 'too slow to trot' in line]
    # The speed as it was printed, and it is not said again.
    assert main([*importing, *re.search(r'--speed \S+$', said[0])[0].split()]) == 0
    assert 'too slow to trot' not in capsys.readouterr().out


def test_of_joints_that_are_too_weak_to_crawl_the_efforts_are_said_that_suffice(tmp_path, capsys):
    pytest.importorskip('yourdfpy')
    description = tmp_path / 'weak robot.urdf'
    description.write_text(urdf_from_robot(load_robot('genibo')))
    importing = ['robot', 'import', str(description), '--no-picture']
    importing += ['--output', str(tmp_path / 'weak.yaml')]
    assert main([*importing, '--effort', '0.3']) == 0
    said = [line for line in capsys.readouterr().out.splitlines() if 'too weak to crawl' in line]
    assert 'whose limit is 0.3 N m' in said[0]
    # The efforts as they were printed, and it is not said again.
    efforts = re.search(r'--effort (\S+ \S+ \S+)$', said[0])[1].split()
    assert main([*importing, '--effort', *efforts]) == 0
    assert 'too weak' not in capsys.readouterr().out
    assert main(['robot', 'check', str(tmp_path / 'weak.yaml'), '--json']) == 0
    torques = json.loads(capsys.readouterr().out)['torques_on_the_spot']
    assert torques['crawl']['torque'] <= 0.9 * torques['crawl']['effort']
