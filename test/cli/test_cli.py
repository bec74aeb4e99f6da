"""The quadwalk command says what it did, or in one sentence why it could not."""

import argparse
import json
import math
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip('rich')

import itertools

from quad_cli.arguments import map_argument, pose_argument
from quad_cli.main import COMMANDS, main
from quad_cli.parameters import TABLES
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_file import save_height_map
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot, robot_file
from quad_lab.tools.criterion import at_least, at_most, figure

ROOT = Path(__file__).parents[2]
PLAN = ['plan', '--start', '1.2,1.2,0', '--goal', '6.8,4.8,90deg']


@pytest.mark.parametrize(
    ('text', 'pose'),
    [
        ('1.5,2,0', (1.5, 2.0, 0.0)),
        ('-1,-2.5,-3.1', (-1.0, -2.5, -3.1)),
        (' 1 , 2 , 3 ', (1.0, 2.0, 3.0)),
        ('0,0,90deg', (0.0, 0.0, math.pi / 2)),
        ('1e-1,0,-45deg', (0.1, 0.0, -math.pi / 4)),
    ],
)
def test_a_pose_is_three_numbers_and_its_yaw_may_be_in_degrees(text, pose):
    read = pose_argument(text)
    assert (read.x, read.y, read.yaw) == pytest.approx(pose)


@pytest.mark.parametrize('text', ['', '1,2', '1,2,3,4', 'a,b,c', '1,2,deg', '1;2;3'])
def test_what_is_no_pose_is_answered_with_an_example(text):
    with pytest.raises(argparse.ArgumentTypeError, match=r'is not x,y,yaw, for example 1\.5,2,0'):
        pose_argument(text)


@pytest.mark.parametrize('text', ['nan,0,0', '0,inf,0', '0,0,nan', '0,0,infdeg'])
def test_a_pose_that_is_not_finite_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match='holds a number that is not finite'):
        pose_argument(text)


def test_a_map_is_a_file_or_the_name_of_a_sample_map(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.touch()
    assert map_argument(str(path)) == path
    assert map_argument('office') == sample_map('office')
    with pytest.raises(argparse.ArgumentTypeError, match=r"no map file 'no'; .* office, room"):
        map_argument('no')


def test_plan_prints_the_turning_points_and_the_length(capsys):
    assert main(PLAN) == 0
    first, *rest = capsys.readouterr().out.splitlines()
    length, count = float(first.split()[0]), int(first.split()[2])
    assert first.endswith(' s of walking:')
    assert 'turning points' in first
    rows = [[float(row.split()[k]) for k in (0, 1, 3)] for row in rest[:count]]
    assert rows[0][:2] == pytest.approx([1.2, 1.2], abs=5e-4)
    assert rows[-1] == pytest.approx([6.8, 4.8, 90.0], abs=5e-4)
    walked = sum(math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(rows))
    assert walked == pytest.approx(length, abs=0.01)


def test_plan_as_json_is_one_object_that_adds_up(capsys):
    assert main([*PLAN, '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    poses = told['poses']
    assert told['method'] == 'mesh'
    assert poses[-1] == pytest.approx([6.8, 4.8, math.pi / 2])
    walked = sum(math.dist(a[:2], b[:2]) for a, b in itertools.pairwise(poses))
    assert told['length'] == pytest.approx(walked)
    for a, b in itertools.pairwise(poses):
        assert a[2] == pytest.approx(math.atan2(b[1] - a[1], b[0] - a[0]))


def test_plan_compares_methods(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    picture = tmp_path / 'plans.png'
    several = [*PLAN, '--method', 'mesh', 'shortest', 'quickest', '--any-angle']
    assert main([*several, '--json', '--picture', str(picture)]) == 0
    mesh, shortest, quickest = json.loads(capsys.readouterr().out)['plans']
    assert [plan['method'] for plan in (mesh, shortest, quickest)] == [*several[6:9]]
    assert shortest['length'] <= mesh['length']
    assert quickest['walking_time'] <= min(mesh['walking_time'], shortest['walking_time'])
    assert quickest['walking_time'] == 5.0 * quickest['cycles']
    assert picture.read_bytes()[:8] == b'\x89PNG\r\n\x1a\n'
    assert main(several) == 0
    assert 'gait cycles' in capsys.readouterr().out


def test_a_method_that_finds_no_plan_is_a_line_of_the_comparison(capsys):
    # The mesh is too coarse for so wide a robot.
    wide = ['--safety-distance', '0.5', '--method', 'mesh', 'shortest']
    assert main([*PLAN, *wide, '--json']) == 1
    mesh, shortest = json.loads(capsys.readouterr().out)['plans']
    assert 'the mesh of 0.63 m may be too coarse' in mesh['error']
    assert shortest['length'] > 10.0
    assert main([*PLAN, *wide]) == 1
    assert 'too coarse' in capsys.readouterr().out


def test_plan_says_which_potential_led_to_the_goal(capsys):
    potential = [*PLAN, '--method', 'potential']
    assert main([*potential, '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['remark'].startswith("a navigation function leads to the goal; S1's comes to rest")
    assert main([*potential, '--potential', 'navigation', '--path-deviation', '0.01']) == 0
    first, *_, remark, _ = capsys.readouterr().out.splitlines()
    assert int(first.split()[2]) > len(told['poses'])
    assert remark == 'a navigation function leads to the goal'
    assert main([*potential, '--potential', 'paper']) == 2
    assert 'a local minimum: attraction and repulsion are equal' in capsys.readouterr().err


def test_quickest_needs_a_pace(tmp_path, capsys):
    robot = tmp_path / 'mine.yaml'
    robot.write_text(robot_file('titan_viii').read_text())
    assert main([*PLAN, '--robot', str(robot)]) == 0
    assert 'walking' not in capsys.readouterr().out
    assert main([*PLAN, '--robot', str(robot), '--method', 'quickest']) == 2
    assert f'quadwalk gait pace crawl --robot {robot}' in capsys.readouterr().err
    assert main(['gait', 'pace', 'crawl', '--robot', str(robot)]) == 0
    assert main([*PLAN, '--robot', str(robot), '--method', 'quickest']) == 0


def test_plan_draws_a_picture(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    picture = tmp_path / 'plan.png'
    assert main([*PLAN, '--picture', str(picture)]) == 0
    assert picture.read_bytes()[:8] == b'\x89PNG\r\n\x1a\n'
    assert 'turning points' in capsys.readouterr().out


def test_plan_walks_around_what_is_high_on_a_height_map_and_draws_the_ground(tmp_path, capsys):
    pytest.importorskip('matplotlib')
    level = HeightMap.level((0.0, 0.0, 8.0, 6.0), 0.05)
    lengths = {}
    for name, height in (('low', 0.07), ('high', 0.12)):
        heights = np.array(level.heights)
        # On the straight path.
        heights[78:82, 38:44] = height
        save_height_map(level.with_heights(heights), tmp_path / f'{name}.yaml')
        picture = tmp_path / f'{name}_plan.png'
        files = ['--height-map', str(tmp_path / f'{name}.yaml'), '--picture', str(picture)]
        request = ['plan', '--method', 'shortest', '--start', '1.2,3.8,0', '--goal', '4.4,4.3,0']
        assert main([*request, '--json', *files]) == 0
        lengths[name] = json.loads(capsys.readouterr().out)['length']
        assert picture.stat().st_size > 10_000
    assert lengths['high'] > lengths['low'] + 0.05
    assert main([*request, '--json', *files, '--step-height', '0.13']) == 0
    assert json.loads(capsys.readouterr().out)['length'] == lengths['low']


@pytest.mark.parametrize(
    ('arguments', 'told'),
    [
        (
            ['plan', '--start', '1.2,1.2,0', '--goal', '60,4,0'],
            'the goal (60.00, 4.00) m is outside',
        ),
        (['plan', '--start', '0,0,0', '--goal', '6.8,4.8,0'], 'the start (0.00, 0.00) m is'),
        ([*PLAN, '--robot', 'spot'], "there is no robot 'spot'; available: "),
        (['robot', 'check', 'spot'], "there is no robot 'spot'; available: "),
        (['robot', 'urdf', '/nowhere.yaml'], "there is no robot '/nowhere.yaml'"),
        (['view', '--port', '70000'], "'--port' is 70000; it must be"),
        (['view', '--robots', '9'], "'--robots' is 9; it must be"),
        (['demo', '--robots', ''], "'--robots' is ''; it must be 2 to 16 names"),
        (['demo', '--robots', 'none'], "'--robots' is 'none'; it must be 2 to 16 names"),
        (['view', '--start', '60,1,0'], 'the start (60.00, 1.00) m is outside'),
        (['view', '--gait', 'gallop'], 'gallop'),
    ],
)
def test_what_cannot_be_done_ends_with_code_2_and_one_sentence(capsys, arguments, told):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('error: ')
    assert told in err
    assert err.count('\n') == 1


@pytest.mark.parametrize(
    'arguments',
    [
        [],
        ['dance'],
        ['plan'],
        ['plan', '--start', 'here', '--goal', '1,1,0'],
        [*PLAN, '--map', 'nowhere'],
        [*PLAN, '--method', 'guess'],
        ['plan', '--start=--', '--goal', '1,1,0'],
        ['plan', '--start', '1,1,0', '--goal=--'],
        ['parameters', 'other_node'],
        ['robot', 'paint', 'titan_viii'],
        ['robot', 'export', 'titan_viii', '--plugin', 'no plugin'],
        ['robot', 'export', 'titan_viii', '--output', ''],
        ['bench', 'nothing'],
    ],
)
def test_arguments_that_are_not_understood_end_with_code_2(capsys, arguments):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert 'usage: quadwalk' in capsys.readouterr().err


def test_robots_are_for_the_benchmark_of_robots(capsys):
    assert main(['bench', 'walk', '--robot', 'cuhk']) == 2
    assert "only 'quadwalk bench robots' takes it" in capsys.readouterr().err


def imported_by(arguments):
    """Run a command in an interpreter of its own; return the names of all its modules."""
    code = (
        'import sys; from quad_cli.main import main; code = main(sys.argv[1:]); '
        'print(*sys.modules); sys.exit(code)'
    )
    command = [sys.executable, '-c', code, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    return set(done.stdout.splitlines()[-1].split())


def test_the_version_is_that_of_the_package(capsys):
    told = ElementTree.parse(ROOT / 'package.xml').getroot().findtext('version')
    with pytest.raises(SystemExit) as ended:
        main(['--version'])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f'quadwalk {told}\n'


def test_a_command_imports_what_it_needs_and_no_more():
    plan = imported_by([*PLAN, '--method', 'shortest', '--json'])
    assert 'quad_planner.search.jump_points' in plan
    slow = {'quad_gait', 'quad_sim', 'scipy.interpolate', 'matplotlib', 'cv2', 'rich.console'}
    assert plan & slow == set()
    # It asks which torques a step on the spot takes, and plans nothing.
    check = imported_by(['robot', 'check', 'titan_viii', '--json'])
    assert check & {*slow - {'quad_gait'}, 'quad_planner', 'numba'} == set()


@pytest.mark.parametrize('command', COMMANDS)
def test_every_command_explains_itself_with_examples(capsys, command):
    with pytest.raises(SystemExit) as caught:
        main([command, '--help'])
    assert caught.value.code == 0
    told = capsys.readouterr().out
    assert 'examples:' in told
    assert f'quadwalk {command}' in told


def test_robot_check_as_json_gives_the_papers_figures(capsys):
    assert main(['robot', 'check', 'titan_viii', '--json']) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures['mass_kg'] == 40.0
    assert (figures['stance_reach_mm'], figures['hip_height_mm']) == (200.0, 243.0)
    assert round(figures['largest_stride_mm']) == 226
    assert round(figures['largest_turn_deg']) == 44
    assert round(figures['mesh_size_mm']) == 628
    assert figures['kinematics_error_mm'] < 1e-6


def test_robot_check_for_people_names_every_figure(capsys):
    assert main(['robot', 'check', 'titan_viii']) == 0
    told = capsys.readouterr().out
    assert told.startswith('titan_viii: ')
    assert 'largest stride mm' in told


def test_robot_urdf_is_the_robots(capsys):
    assert main(['robot', 'urdf', 'titan_viii']) == 0
    root = ElementTree.fromstring(capsys.readouterr().out)
    joints = [j.get('name') for j in root.iter('joint') if j.get('type') == 'revolute']
    assert tuple(joints) == load_robot('titan_viii').joint_names


@pytest.mark.parametrize('node', TABLES)
def test_parameters_prints_what_lies_in_config(capsys, node):
    assert main(['parameters', node]) == 0
    config = ROOT / 'config' / f'{node}.yaml'
    assert capsys.readouterr().out == config.read_text(encoding='utf-8')


def test_a_bar_holds_if_its_value_was_measured_and_is_good_enough():
    assert at_most('error', 0.05, 'm', 0.05).holds is True
    assert at_most('error', 0.051, 'm', 0.05).holds is False
    assert at_least('margin', 0.01, 'm', 0.01).holds is True
    assert at_least('margin', 0.009, 'm', 0.01).holds is False
    for make in (at_most, at_least):
        assert make('error', None, 'm', 0.05).holds is False
    assert (figure('cycles', 3, '').holds, figure('cycles', 3, '').bar) == (None, '')


def test_without_ros_the_demo_says_what_to_install():
    code = (
        'import sys; sys.modules["rclpy"] = None\n'
        'from quad_cli.main import main\n'
        'raise SystemExit(main(["demo", "--no-recording"]))'
    )
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert result.returncode == 2
    assert result.stderr.startswith('error: this needs the package rclpy: ')
    assert "pip install 'quadwalk[ros]'" in result.stderr


def test_a_pose_argument_is_a_pose():
    assert pose_argument('1,2,3') == Pose2D(1.0, 2.0, 3.0)


def test_too_little_memory_ends_in_a_sentence(capsys, monkeypatch):
    def plans(*arguments, **options):
        raise MemoryError

    monkeypatch.setattr('quad_cli.plan._attempt', plans)
    assert main(PLAN) == 2
    assert capsys.readouterr().err.endswith('error: there is not enough memory for that\n')
