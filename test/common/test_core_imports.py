"""The core needs neither ROS nor PyBullet, and imports point one way."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(path.name for path in ROOT.glob('quad_*') if path.is_dir())
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob('*.py'))

MIDDLE = {'quad_planner', 'quad_gait', 'quad_sim', 'quad_perception', 'quad_view'}

SHELLS = {
    'ros_node', 'run_node', 'map_frame_listener', 'bullet_simulator'
}  # fmt: skip
"""Modules whose work it is to talk to ROS or PyBullet, besides ``*_node`` and ``*_conversions``."""

ROS_COMMANDS = {
    'quad_cli.walk',
    'quad_cli.walk_observer',
    'quad_cli.progress',
    'quad_cli.bench_walk',
    'quad_cli.bench_localisation',
    'quad_cli.bench_planner_node',
    'quad_cli.bench_matrix',
    'quad_cli.faults_examples',
    'quad_cli.faults_listener',
    'quad_cli.faults_stage',
    'quad_cli.faults_attacker',
    'quad_cli.faults_messages',
    'quad_cli.faults_scenes',
    'quad_cli.faults_localisation',
    'quad_cli.faults_goal_topic',
    'quad_cli.faults_kills',
    'quad_cli.faults_soak',
    'quad_cli.faults_nonsense',
}
"""Of the command line: what walks over topics."""

BLOCKER = """
import importlib, sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        top = name.partition('.')[0]
        if top in {'rclpy', 'pybullet', 'pybullet_utils', 'pybullet_data', 'builtin_interfaces',
                   'ament_index_python', 'rosidl_parser', 'launch', 'rosbags', 'tf2_ros',
                   'std_srvs'} or top.endswith('_msgs'):
            raise ImportError(f'{name} is blocked')

sys.meta_path.insert(0, Blocker())
failed = []
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
    except Exception as error:
        failed.append(f'{name}: {type(error).__name__}: {error}')
print('\\n'.join(failed))
"""


def module_name(path):
    return '.'.join(path.relative_to(ROOT).with_suffix('').parts).removesuffix('.__init__')


def is_shell(path):
    is_ros = path.stem.endswith(('_node', '_conversions'))
    return is_ros or path.stem in SHELLS or module_name(path) in ROS_COMMANDS


def import_blocked(modules):
    """Import modules in a fresh interpreter without ROS and PyBullet; return what failed."""
    result = subprocess.run(
        [sys.executable, '-c', BLOCKER, *modules],
        capture_output=True,
        text=True,
        check=False,
        cwd=ROOT,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout.strip().splitlines()


def imports(path):
    """List every module that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path} imports relatively'
            yield node.module


def test_every_core_module_is_imported_without_ros_and_pybullet():
    core = [module_name(path) for path in SOURCES if not is_shell(path)]
    core.remove('quad_cli.recording')
    assert len(core) > 35
    assert import_blocked(core) == []


def test_the_blocker_blocks():
    shells = [module_name(path) for path in SOURCES if path.stem in SHELLS]
    assert len(shells) >= 4
    failed = import_blocked(shells)
    assert sorted(line.partition(':')[0] for line in failed) == sorted(shells)


def test_without_pybullet_its_simulator_says_how_to_install_it():
    (failed,) = import_blocked(['quad_sim.bullet_simulator'])
    assert "MissingOptionalDependency: this needs the package 'pybullet'" in failed
    assert 'pip install pybullet' in failed


@pytest.mark.parametrize('package', PACKAGES)
def test_imports_point_one_way(package):
    allowed = {
        'quad_common': {'quad_common'},
        'quad_cli': {'quad_common', 'quad_cli', *MIDDLE},
    }.get(package, {'quad_common', package})
    for path in (path for path in SOURCES if module_name(path).startswith(f'{package}')):
        used = {name.partition('.')[0] for name in imports(path) if name.startswith('quad_')}
        assert used <= allowed, f'{path.relative_to(ROOT)} imports {sorted(used - allowed)}'


def test_every_package_has_its_place_in_the_order_of_imports():
    assert set(PACKAGES) <= {'quad_common', 'quad_cli', *MIDDLE}


def test_pybullet_is_imported_in_one_file_only():
    users = {
        path.relative_to(ROOT).as_posix()
        for path in SOURCES
        if any(name.partition('.')[0].startswith('pybullet') for name in imports(path))
    }
    assert users == {'quad_sim/bullet_simulator.py'}


def test_ros_is_imported_by_shells_only():
    for path in SOURCES:
        ros = [
            name
            for name in imports(path)
            if name.partition('.')[0] in ('rclpy', 'builtin_interfaces', 'std_srvs')
            or name.partition('.')[0].endswith('_msgs')
        ]
        assert not ros or is_shell(path), f'{path.relative_to(ROOT)} imports {ros}'
