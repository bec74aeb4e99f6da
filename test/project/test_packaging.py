"""
The packaging says what is true: versions, dependencies, files and entry points agree.
"""

from __future__ import annotations

import ast
import fnmatch
import importlib.util
import json
import os
import runpy
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]

# Imported module: (rosdep key in package.xml, requirement in setup.py). Modules that are not
# listed are ROS packages, with one name everywhere.
LIBRARIES = {
    'PIL': ('python3-pil', 'pillow'),
    'cv2': ('python3-opencv', 'opencv-python-headless'),
    'matplotlib': ('python3-matplotlib', 'matplotlib'),
    'lxml': ('python3-lxml', 'lxml'),
    'xacro': ('xacro', 'xacro'),
    'numba': ('python3-numba', 'numba'),
    'numpy': ('python3-numpy', 'numpy'),
    'mujoco': ('python3-mujoco-pip', 'mujoco'),
    # MuJoCo's window depends on it.
    'glfw': ('python3-mujoco-pip', 'mujoco'),
    'pybullet': ('python3-pybullet-pip', 'pybullet'),
    'pybullet_data': ('python3-pybullet-pip', 'pybullet'),
    'pybullet_utils': ('python3-pybullet-pip', 'pybullet'),
    'rich': ('python3-rich', 'rich'),
    'rosbags': ('python3-rosbags-pip', 'rosbags'),
    'scipy': ('python3-scipy', 'scipy'),
    'yaml': ('python3-yaml', 'pyyaml'),
}

# Imported only where they are installed, for comparison; rosdep does not know them.
COMPARED_WITH = {
    'ikpy': 'ikpy',
    'mcap': 'mcap',
    'pyastar2d': 'pyastar2d',
    'skimage': 'scikit-image',
    'tcod': 'tcod',
}


# Imported by optional parts that say how to install them; rosdep does not know them.
FROM_PIP = {
    'trimesh': 'trimesh',
    'yourdfpy': 'yourdfpy',
    'imageio_ffmpeg': 'imageio-ffmpeg',
}

# Of campaigns, which are nothing without them: imported when a campaign is run.
OF_CAMPAIGNS = {'distributed': 'dask', 'pyarrow': 'pyarrow', 'cma': 'cma'}

# Of the viewer, which is nothing without viser: for that there is no rosdep key.
OF_THE_VIEWER = ('viser', 'trimesh', 'msgspec', 'websockets', 'zstandard')


@pytest.fixture(scope='module')
def metadata() -> dict[str, Any]:
    """What ``setup.py`` hands to setuptools."""
    if importlib.util.find_spec('setuptools') is None:
        pytest.skip('setuptools is not installed')
    # In a process of its own: setuptools wants to be imported before any distutils.
    code = (
        'import json, runpy, setuptools;'
        'setuptools.setup = lambda **metadata: print(json.dumps(metadata));'
        'runpy.run_path("setup.py")'
    )
    result = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


@pytest.fixture(scope='module')
def manifest() -> ElementTree.Element:
    """The root element of ``package.xml``."""
    return ElementTree.parse(ROOT / 'package.xml').getroot()


def sources() -> list[Path]:
    """Every module of the project's packages, and the launch files."""
    return sorted([*ROOT.glob('quad_*/**/*.py'), *ROOT.glob('launch/*.py')])


def imported_modules(path: Path) -> Iterator[str]:
    """Yield the top-level modules outside the standard library and the project."""
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'), str(path))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module is not None:
            names = [node.module]
        for name in names:
            module = name.split('.')[0]
            if module not in sys.stdlib_module_names and not module.startswith('quad_'):
                yield module


def requirement_names(requirements: list[str]) -> set[str]:
    """Names in a list of requirements, without extras, versions and markers."""
    parse = pytest.importorskip('packaging.requirements').Requirement
    return {parse(requirement).name.lower() for requirement in requirements}


def test_the_version_is_the_same_in_setup_py_and_package_xml(metadata, manifest):
    assert metadata['version'] == manifest.findtext('version')
    assert metadata['name'] == manifest.findtext('name') == 'quadwalk'
    assert metadata['license'] == manifest.findtext('license') == 'Apache-2.0'


def test_what_modules_import_is_declared_in_package_xml(manifest):
    declared = {element.text for element in manifest if element.tag in ('depend', 'exec_depend')}
    left_out = {*COMPARED_WITH, *FROM_PIP, *OF_CAMPAIGNS, *OF_THE_VIEWER}
    # A case for each module would take longer to collect than to run.
    missing = {}
    for path in sources():
        used = (name for name in imported_modules(path) if name not in left_out)
        needed = {LIBRARIES.get(name, (name, ''))[0] for name in used}
        if not needed <= declared:
            missing[str(path.relative_to(ROOT))] = needed - declared
    assert missing == {}


def test_what_the_code_imports_from_pypi_is_required_in_setup_py(metadata):
    extras = metadata['extras_require']
    optional = extras['sim'] + extras['record'] + extras['robots']
    required = requirement_names(metadata['install_requires'] + optional)
    assert set(OF_THE_VIEWER) <= requirement_names(extras['view'])
    assert set(OF_CAMPAIGNS.values()) <= requirement_names(extras['campaign'])
    imported = {module for path in sources() for module in imported_modules(path)}
    assert {LIBRARIES[name][1] for name in imported if name in LIBRARIES} <= required


def test_what_is_only_compared_with_is_an_extra_of_its_own(metadata):
    bench = requirement_names(metadata['extras_require']['bench'])
    others = requirement_names(metadata['install_requires'] + metadata['extras_require']['all'])
    assert bench == set(COMPARED_WITH.values())
    assert not bench & others


def test_ros_packages_are_no_hard_requirement_of_pip(metadata):
    names = requirement_names(metadata['install_requires'])
    assert not {name for name in names if name.startswith('ros') or name == 'rclpy'}


def test_package_xml_is_valid():
    catkin_package = pytest.importorskip('catkin_pkg.package')
    package = catkin_package.parse_package(str(ROOT))
    warnings: list[str] = []
    package.validate(warnings=warnings)
    assert warnings == []
    assert package.package_format == 3
    assert package.get_build_type() == 'ament_python'


def test_a_rosdep_key_is_declared_once(manifest):
    keys = [element.text for element in manifest if element.tag.endswith('depend')]
    assert sorted(keys) == sorted(set(keys))


def test_rosdep_leaves_out_what_only_pip_has_where_pip_may_not_install():
    catkin_package = pytest.importorskip('catkin_pkg.package')
    package = catkin_package.parse_package(str(ROOT))
    package.evaluate_conditions({})
    installed = {key.name for key in package.exec_depends if key.evaluated_condition}
    assert 'python3-numpy' in installed
    assert not {name for name in installed if name.endswith('-pip')}


def test_the_changelog_covers_this_version(manifest):
    changelog = pytest.importorskip('catkin_pkg.changelog')
    log = changelog.get_changelog_from_path(str(ROOT), 'quadwalk')
    released = [version for version, _, _ in log.foreach_version()]
    assert manifest.findtext('version') in released or '\nForthcoming\n----' in log.rst


def test_every_entry_point_is_a_function_of_an_existing_module(metadata):
    for entry in metadata['entry_points']['console_scripts']:
        module, function = entry.split('=')[1].strip().split(':')
        path = ROOT.joinpath(*module.split('.')).with_suffix('.py')
        assert path.is_file(), entry
        tree = ast.parse(path.read_text(encoding='utf-8'))
        functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
        assert function in functions, entry


def test_every_node_has_an_executable_file_for_ros2_run(metadata):
    scripts = metadata['entry_points']['console_scripts']
    commands = {entry.split('=')[0].strip() for entry in scripts}
    installed = {
        Path(path)
        for target, paths in metadata['data_files']
        if target == 'lib/quadwalk'
        for path in paths
    }
    assert {path.name for path in installed} == {
        command for command in commands if command.endswith('_node')
    }
    assert all(os.access(ROOT / path, os.X_OK) for path in installed)


def test_data_files_exist_and_hold_what_ros_looks_for(metadata):
    files = {
        f'{target}/{Path(path).name}' for target, paths in metadata['data_files'] for path in paths
    }
    assert all((ROOT / path).is_file() for _, paths in metadata['data_files'] for path in paths)
    assert {
        'share/ament_index/resource_index/packages/quadwalk',
        'share/quadwalk/package.xml',
        'share/quadwalk/launch/walk.launch.py',
        'share/quadwalk/launch/robot.launch.py',
        'share/quadwalk/launch/camera.launch.py',
        'share/quadwalk/launch/fleet.launch.py',
        'share/quadwalk/maps/room.yaml',
        'share/quadwalk/config/campaigns/reliability.yaml',
    } <= files


def test_every_data_file_of_a_package_is_installed(metadata):
    for package in metadata['packages']:
        folder = ROOT.joinpath(*package.split('.'))
        patterns = metadata['package_data'][''] + metadata['package_data'].get(package, [])
        for path in folder.rglob('*'):
            name = path.relative_to(folder).as_posix()
            if path.is_file() and path.suffix != '.py' and '__pycache__' not in path.parts:
                matching = [pattern for pattern in patterns if fnmatch.fnmatch(name, pattern)]
                assert matching, f'package_data in setup.py lacks {package}/{name}'


def test_every_package_says_that_it_is_typed(metadata):
    for package in metadata['packages']:
        if '.' not in package:
            assert (ROOT / package / 'py.typed').is_file()


def test_every_requirement_is_in_the_lock_file_in_a_version_that_it_allows(metadata):
    parse = pytest.importorskip('packaging.requirements').Requirement
    locked = {}
    for line in (ROOT / 'requirements.lock').read_text(encoding='utf-8').splitlines():
        if line and not line.startswith('#'):
            assert '==' in line
            assert '://' not in line
            requirement = parse(line)
            locked.setdefault(requirement.name, []).append(
                str(requirement.specifier).removeprefix('==')
            )
    for text in metadata['install_requires'] + metadata['extras_require']['all']:
        requirement = parse(text)
        versions = locked.get(requirement.name.lower().replace('_', '-'), [])
        assert versions, f'{text} is not in requirements.lock: make lock'
        assert all(version in requirement.specifier for version in versions), text


@pytest.mark.parametrize('path', sorted(ROOT.glob('launch/*.py')), ids=lambda path: path.name)
def test_a_launch_file_compiles_and_describes_a_launch(path):
    module = ast.parse(path.read_text(encoding='utf-8'))
    functions = [node.name for node in module.body if isinstance(node, ast.FunctionDef)]
    assert 'generate_launch_description' in functions


def arguments_of(launch_file: str, table: str) -> set[str]:
    """Names in a launch file's table of arguments, without running it."""
    tree = ast.parse((ROOT / 'launch' / f'{launch_file}.launch.py').read_text(encoding='utf-8'))
    [dictionary] = [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Dict)
        and isinstance(node.targets[0], ast.Name)
        and node.targets[0].id == table
    ]
    return {key.value for key in dictionary.keys if isinstance(key, ast.Constant)}


@pytest.mark.parametrize(
    ('launch_file', 'table', 'module', 'parameters'),
    [
        ('robot', 'PLANNER_ARGUMENTS', 'quad_planner.parameters', 'PlannerParameters'),
        ('robot', 'GAIT_ARGUMENTS', 'quad_gait.parameters', 'GaitParameters'),
        ('walk', 'SIM_ARGUMENTS', 'quad_sim.parameters', 'SimParameters'),
        ('camera', 'CAMERA_ARGUMENTS', 'quad_perception.parameters', 'CeilingCameraParameters'),
        ('fleet', 'SIM_ARGUMENTS', 'quad_sim.parameters', 'SimParameters'),
    ],
)
def test_every_launch_argument_is_a_parameter_of_its_node(launch_file, table, module, parameters):
    declared = vars(pytest.importorskip(module))[parameters].__dataclass_fields__
    assert arguments_of(launch_file, table) <= set(declared)


def test_a_launch_argument_reaches_the_planner_and_the_gait_where_both_have_it():
    planner, gait = (
        arguments_of('robot', table) for table in ('PLANNER_ARGUMENTS', 'GAIT_ARGUMENTS')
    )
    planners = set(pytest.importorskip('quad_planner.parameters').PlannerParameters().__dict__)
    gaits = set(pytest.importorskip('quad_gait.parameters').GaitParameters().__dict__)
    assert planner & gaits == gait & planners == planner & gait
    assert {'gait', 'turning'} <= planner


@pytest.mark.parametrize('name', ['walk', 'robot', 'camera'])
def test_a_launch_file_declares_its_arguments(name):
    pytest.importorskip('launch_ros')
    launch = pytest.importorskip('launch')
    description = runpy.run_path(str(ROOT / 'launch' / f'{name}.launch.py'))
    arguments = [
        entity.name
        for entity in description['generate_launch_description']().entities
        if isinstance(entity, launch.actions.DeclareLaunchArgument)
    ]
    assert {'robot', 'namespace', 'use_sim_time', 'config_directory'} <= set(arguments)


def launch_file(name: str) -> dict[str, Any]:
    """Run a launch file; skip where launch_ros is not installed."""
    pytest.importorskip('launch_ros')
    return runpy.run_path(str(ROOT / 'launch' / f'{name}.launch.py'))


def context_of(**arguments: object) -> Any:
    """Return a launch that was given these arguments."""
    launch = pytest.importorskip('launch')
    context = launch.LaunchContext()
    context.launch_configurations.update(
        {'namespace': '', **{name: str(value) for name, value in arguments.items()}}
    )
    return context


def test_all_arguments_of_what_a_launch_file_includes_are_shown():
    camera = launch_file('camera')['generate_launch_description']()
    shown = {argument.name for argument in camera.get_launch_arguments()}
    # Of the simulator, of the planner and the gait, and of what is shown.
    assert {'start_pose', 'backend', 'publish_clock'} <= shown
    assert {'method', 'gait', 'turning', 'respawn', 'rviz', 'robot_state_publisher'} <= shown


@pytest.mark.parametrize(('wanted', 'is_there'), [('auto', True), ('auto', False), ('false', True)])
def test_the_frames_of_the_legs_are_published_where_they_can_be(wanted, is_there):
    start = launch_file('robot')['start_state_publisher']
    start.__globals__['is_installed'] = lambda package: is_there
    context = context_of(robot_state_publisher=wanted, robot='', config_directory=ROOT / 'config')
    started = [type(entity).__name__ for entity in start(context, True)]
    expected = {('auto', True): ['Node'], ('auto', False): ['LogInfo'], ('false', True): []}
    assert started == expected[wanted, is_there]


def started_with(file: dict[str, Any], **given: object) -> Any:
    """Return the launch of a file with these arguments; the others are empty, or switches off."""
    shown = file['generate_launch_description']().get_launch_arguments()
    switches = ('respawn', 'view', 'rviz', 'robot_state_publisher')
    arguments = dict.fromkeys((argument.name for argument in shown), '')
    arguments |= dict.fromkeys(switches, 'false')
    arguments |= {'use_sim_time': 'true', 'config_directory': str(ROOT / 'config')}
    return context_of(**{**arguments, **given})


def parameters_of(node: Any, context: Any) -> dict[str, Any]:
    """Parameters that a launch gives a node after those of the file."""
    evaluate = pytest.importorskip('launch_ros.utilities').evaluate_parameters
    given: dict[str, Any] = {}
    for part in evaluate(context, node._Node__parameters):
        given |= part if isinstance(part, dict) else {}
    return given


def test_the_planner_plans_for_the_gait_that_the_launch_file_was_given():
    robot = launch_file('robot')
    context = started_with(robot, gait='trot', turning='arc')
    planner, gait = (parameters_of(node, context) for node in robot['start_nodes'](context))
    assert planner == gait == {'use_sim_time': True, 'gait': 'trot', 'turning': 'arc'}


@pytest.mark.parametrize('topic', ['', 'odom/legs'])
def test_the_viewer_shows_the_pose_that_planner_and_gait_go_by(topic):
    robot = launch_file('robot')
    context = started_with(robot, view='true', odom_topic=topic)
    *_, viewer = robot['start_nodes'](context)
    assert parameters_of(viewer, context) == ({'odom_topic': topic} if topic else {})


def test_the_simulator_drifts_and_localises_as_the_launch_file_was_told():
    walk = launch_file('walk')
    context = started_with(walk, odom_drift='0.05', localiser_rate='1', backend='kinematic')
    [simulator] = walk['start_simulator'](context)
    assert parameters_of(simulator, context) == {
        'use_sim_time': True,
        'backend': 'kinematic',
        'odom_drift': 0.05,
        'localiser_rate': 1.0,
    }


@pytest.mark.parametrize('name', ['robot', 'walk'])
@pytest.mark.parametrize(
    ('namespace', 'prefix'), [('', ''), ('left', 'left/'), ('/left/', 'left/')]
)
def test_frames_begin_with_the_namespace(name, namespace, prefix):
    expression = launch_file(name)['prefix_of_namespace']()
    assert expression.perform(context_of(namespace=namespace)) == prefix


def test_the_frames_of_the_legs_are_those_of_the_simulated_robot():
    walk, robot = launch_file('walk'), launch_file('robot')
    robot['start_state_publisher'].__globals__['is_installed'] = lambda package: True
    context = started_with(
        walk, namespace='left', frame_prefix='left/', robot_state_publisher='true'
    )
    [simulator] = walk['start_simulator'](context)
    [publisher] = robot['start_state_publisher'](context, True)
    assert parameters_of(simulator, context)['frame_prefix'] == 'left/'
    assert parameters_of(publisher, context)['frame_prefix'] == 'left/'
    # Its transforms stay on the global /tf, where the simulator's are.
    assert not publisher._Node__remappings


@pytest.mark.parametrize('prefix', ['', 'left/'])
def test_rviz_shows_the_robot_whose_frames_have_a_prefix(prefix):
    robot = launch_file('robot')
    context = context_of(frame_prefix=prefix, config_directory=ROOT / 'config')
    text = Path(robot['rviz_file'](context)).read_text(encoding='utf-8')
    shown = yaml.safe_load(text)['Visualization Manager']['Displays']
    [model] = [display for display in shown if display['Class'].endswith('RobotModel')]
    assert model['TF Prefix'] == prefix.strip('/')


def test_a_fleet_is_one_simulator_and_a_launch_of_a_robot_for_each():
    fleet = launch_file('fleet')
    robots = 'left=cuhk@1,2,0; right=a1@4,2,3.14'
    context = started_with(fleet, robots=robots, gait='trot', view='true')
    simulator, *groups = fleet['start_fleet'](context)
    assert parameters_of(simulator, context) == {'robots': robots}
    given = []
    for group in groups:
        [include] = [e for e in group.get_sub_entities() if hasattr(e, 'launch_arguments')]
        given.append(
            {
                name: value if isinstance(value, str) else value.perform(context)
                for name, value in include.launch_arguments
            }
        )
    assert [one['namespace'] for one in given] == ['left', 'right']
    assert [one['frame_prefix'] for one in given] == ['left/', 'right/']
    assert [one['robot'] for one in given] == ['cuhk', 'a1']
    assert [one['view'] for one in given] == ['true', 'false']
    assert {(one['gait'], one['use_sim_time']) for one in given} == {('trot', 'true')}


def test_what_is_asked_for_and_not_installed_is_refused():
    robot = launch_file('robot')
    robot['start_rviz'].__globals__['is_installed'] = lambda package: False
    with pytest.raises(ValueError, match='rviz2 is not installed'):
        robot['start_rviz'](context_of(), True)
    with pytest.raises(ValueError, match='robot_state_publisher is not installed'):
        robot['start_state_publisher'](context_of(robot_state_publisher='true'), True)


def rviz_topics() -> dict[str, dict[str, str]]:
    """Topics of RViz's configuration, with their settings."""
    text = (ROOT / 'config' / 'quadwalk.rviz').read_text(encoding='utf-8')
    manager = yaml.safe_load(text)['Visualization Manager']
    assert manager['Global Options']['Fixed Frame'] == 'map'
    found = {}
    for part in (*manager['Displays'], *manager['Tools']):
        topic = part.get('Topic') or part.get('Description Topic')
        if topic:
            found[topic['Value'].lstrip('/')] = topic
    return found


def test_rviz_shows_topics_that_exist_as_they_are_published():
    topics = rviz_topics()
    assert {'map', 'plan', 'robot_description', 'footholds', 'odom', 'goal_pose'} <= set(topics)
    for name, topic in topics.items():
        page = (ROOT / 'msg_docs' / f'{name}.md').read_text(encoding='utf-8')
        [quality] = [line.lower() for line in page.splitlines() if line.startswith('| QoS |')]
        assert topic['Reliability Policy'].lower() in quality, name
        assert topic['Durability Policy'].lower() in quality, name


def test_rviz_is_brought_into_a_namespace_with_all_its_topics():
    tree = ast.parse((ROOT / 'launch' / 'robot.launch.py').read_text(encoding='utf-8'))
    [names] = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == 'RVIZ_TOPICS'
    ]
    assert set(names) == {*rviz_topics()}


def test_foxgloves_layout_shows_topics_that_exist():
    text = (ROOT / 'config' / 'foxglove_layout.json').read_text(encoding='utf-8')
    layout = json.loads(text)
    shown = set(layout['configById']['3D!room']['topics']) | {'/goal_pose', '/robot_description'}
    assert all((ROOT / 'msg_docs' / f'{name[1:]}.md').is_file() for name in shown)
    panels = set(layout['configById'])
    assert {name for name in panels if f'"{name}"' in json.dumps(layout['layout'])} == panels
