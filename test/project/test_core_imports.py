"""The core needs neither ROS nor PyBullet, and imports point one way."""

import ast
import functools
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = sorted(path.name for path in ROOT.glob('quad_*') if path.is_dir())
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob('*.py'))

MIDDLE = {'quad_planner', 'quad_gait', 'quad_sim', 'quad_perception', 'quad_view'}

MOST_MODULES = 16
"""In one folder, without ``__init__``."""

SHELLS = {
    'ros_node', 'managed_life', 'node_parameters', 'run_node', 'map_frame_listener',
    'transform_publisher', 'clock_check', 'clock_reader',
    'bullet_simulator', 'mujoco_simulator', 'mujoco_model', 'mujoco_robot', 'mujoco_scene',
    'mujoco_window', 'mujoco_world', 'bullet_world',
    'composed_nodes', 'mjcf', 'mjcf_shapes',
}  # fmt: skip
"""Modules whose work it is to talk to ROS or an engine, besides those of :data:`_SHELL_NAMES`."""

_SHELL_NAMES = ('_node', '_conversions', '_topics', '_actions', '_services')

ROS_COMMANDS = {
    'quad_lab.topic_walk.walk',
    'quad_lab.topic_walk.fleet',
    'quad_lab.topic_walk.walk_observer',
    'quad_lab.topic_walk.walk_notes',
    'quad_lab.topic_walk.navigation_client',
    'quad_lab.topic_walk.navigated_robot',
    'quad_lab.benchmarks.bench_fleet',
    'quad_lab.benchmarks.recordings.recorded_demo',
    'quad_lab.benchmarks.recordings.playback',
    'quad_lab.benchmarks.recordings.witness',
    'quad_lab.topic_walk.recorded_walk',
    'quad_lab.recordings.recorded_robot',
    'quad_lab.recordings.recorder',
    'quad_lab.recordings.subscription',
    'quad_lab.recordings.recorded_messages',
    'quad_lab.recordings.replay',
    'quad_lab.recordings.topic_listener',
    'quad_lab.recordings.transform_pattern',
    'quad_lab.recordings.shared_transforms',
    'quad_lab.recordings.film',
    'quad_lab.doctor.echo',
    'quad_lab.recordings.robot_recording',
    'quad_lab.recordings.robot_transforms',
    'quad_cli.output.progress',
    'quad_lab.benchmarks.bench_walk',
    'quad_lab.benchmarks.ground.uneven_topic_walks',
    'quad_lab.benchmarks.bench_localisation',
    'quad_lab.benchmarks.viewing.bench_view',
    'quad_lab.benchmarks.viewing.walk_costs',
    'quad_lab.benchmarks.planning.bench_planner_node',
    'quad_lab.attacks.bench_matrix',
    'quad_lab.attacks.stage.examples',
    'quad_lab.attacks.stage.listener',
    'quad_lab.attacks.stage.stage',
    'quad_lab.attacks.messages.attacker',
    'quad_lab.attacks.messages.message_attack',
    'quad_lab.attacks.stage.scenes',
    'quad_lab.attacks.walks.drift',
    'quad_lab.attacks.stage.goal_topic',
    'quad_lab.attacks.walks.kills',
    'quad_lab.attacks.walks.soak',
    'quad_lab.attacks.messages.nonsense',
    'quad_lab.robots.topic_walks',
    'quad_lab.balance.pushed_walks',
}
"""Of the command line: what walks over topics."""

BLOCKER = """
import importlib, sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        top = name.partition('.')[0]
        if top in {'rclpy', 'mujoco', 'pybullet', 'pybullet_utils', 'pybullet_data',
                   'builtin_interfaces', 'ament_index_python', 'rosidl_parser', 'launch',
                   'rosbags', 'tf2_ros', 'simulation_interfaces',
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


KNOWN = {module_name(path) for path in SOURCES}


def is_shell(path):
    is_ros = path.stem.endswith(_SHELL_NAMES)
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


@functools.cache
def import_statements(path):
    """List the statements that import something, anywhere in a file."""
    tree = ast.parse(path.read_text(encoding='utf-8'))
    return [node for node in ast.walk(tree) if isinstance(node, (ast.Import, ast.ImportFrom))]


def imports(path):
    """List every module that a file imports, anywhere in it."""
    for node in import_statements(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        else:
            assert node.level == 0, f'{path} imports relatively'
            yield node.module


def test_every_core_module_is_imported_without_ros_and_pybullet():
    core = [module_name(path) for path in SOURCES if not is_shell(path)]
    core.remove('quad_lab.recordings.recording')
    core.remove('quad_lab.recordings.recording_reader')
    assert len(core) > 35
    assert import_blocked(core) == []


def test_the_blocker_blocks():
    shells = [module_name(path) for path in SOURCES if path.stem in SHELLS]
    assert len(shells) >= 4
    failed = import_blocked(shells)
    assert sorted(line.partition(':')[0] for line in failed) == sorted(shells)


def test_without_pybullet_its_simulator_says_how_to_install_it():
    (failed,) = import_blocked(['quad_sim.engines.bullet_simulator'])
    assert "MissingOptionalDependency: this needs the package 'pybullet'" in failed
    assert 'pip install pybullet' in failed


@pytest.mark.parametrize('package', PACKAGES)
def test_imports_point_one_way(package):
    allowed = {
        'quad_common': {'quad_common'},
        'quad_lab': {'quad_common', 'quad_lab', *MIDDLE},
        'quad_cli': {'quad_common', 'quad_cli', 'quad_lab', *MIDDLE},
    }.get(package, {'quad_common', package})
    for path in (path for path in SOURCES if module_name(path).startswith(f'{package}')):
        used = {name.partition('.')[0] for name in imports(path) if name.startswith('quad_')}
        assert used <= allowed, f'{path.relative_to(ROOT)} imports {sorted(used - allowed)}'


def test_rooms_import_one_another_one_way():
    """A room is a folder; what lies directly in a package is a room as well."""
    rooms = {module_name(path): module_name(path.parent) for path in SOURCES}
    uses = {room: set() for room in rooms.values()}
    for path in SOURCES:
        if path.name != '__init__.py':
            room = rooms[module_name(path)]
            uses[room] |= {rooms[name] for name in imported_modules(path)} - {room}
    # Without a circle, rooms can be taken away one by one whose own needs are all gone.
    while uses:
        free = {room for room, needs in uses.items() if not needs & uses.keys()}
        assert free, f'these rooms import one another: {uses}'
        uses = {room: needs for room, needs in uses.items() if room not in free}


def imported_modules(path):
    """List the modules of quadwalk that a file imports, as names of files."""
    for node in import_statements(path):
        if isinstance(node, ast.ImportFrom):
            names = [f'{node.module}.{alias.name}' for alias in node.names]
            yield from (
                name if name in KNOWN else node.module for name in names if node.module in KNOWN
            )
        else:
            yield from (alias.name for alias in node.names if alias.name in KNOWN)


def test_no_room_is_crowded():
    for folder in {path.parent for path in SOURCES}:
        modules = [path for path in folder.glob('*.py') if path.name != '__init__.py']
        assert len(modules) <= MOST_MODULES, f'{folder.relative_to(ROOT)} has {len(modules)}'


def test_every_package_has_its_place_in_the_order_of_imports():
    assert set(PACKAGES) <= {'quad_common', 'quad_lab', 'quad_cli', *MIDDLE}


def test_pybullet_is_imported_in_one_file_only():
    users = {
        path.relative_to(ROOT).as_posix()
        for path in SOURCES
        if any(name.partition('.')[0].startswith('pybullet') for name in imports(path))
    }
    assert users == {'quad_sim/engines/bullet_simulator.py'}


def test_mujoco_is_imported_by_its_engine_and_the_reader_of_its_format_only():
    users = {
        path.relative_to(ROOT).as_posix()
        for path in SOURCES
        if any(name.partition('.')[0] == 'mujoco' for name in imports(path))
    }
    parts = ('model', 'robot', 'scene', 'simulator', 'window')
    readers = {f'quad_common/description/{name}.py' for name in ('mjcf', 'mjcf_shapes')}
    # Imports are compared with what engines make of the same file.
    readers.add('quad_lab/robots/import_check.py')
    readers.add('quad_sim/fleet/mujoco_world.py')
    assert users == readers | {f'quad_sim/engines/mujoco_{part}.py' for part in parts}


def test_ros_is_imported_by_shells_only():
    for path in SOURCES:
        ros = [
            name
            for name in imports(path)
            if name.partition('.')[0] in ('rclpy', 'builtin_interfaces', 'std_srvs')
            or name.partition('.')[0].endswith('_msgs')
        ]
        assert not ros or is_shell(path), f'{path.relative_to(ROOT)} imports {ros}'
