"""An exported robot has in ros2_control the joints, ranges and posture that it has in quadwalk."""

import runpy
import sys
from unittest.mock import MagicMock
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from quad_common.errors import FileUnusable
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.robot_files.ros2_control import (
    MOCK_PLUGIN,
    ExportOptions,
    controlled_urdf,
    controllers,
    export_robot,
    joint_limits,
)

TITAN = load_robot('titan_viii')

CONTROLLER_PARAMETERS = {
    'joints',
    'command_interfaces',
    'state_interfaces',
    'interpolation_method',
    'interpolate_from_desired_state',
    'allow_partial_joints_goal',
    'allow_integration_in_goal_trajectories',
    'allow_nonzero_velocity_at_trajectory_end',
    'cmd_timeout',
    'constraints',
}
"""Parameters of joint_trajectory_controller that are set, as Jazzy documents them."""


def system_of(urdf):
    return ElementTree.fromstring(urdf).find('ros2_control')


def figures(joint, path, name):
    return float(joint.find(f"{path}/param[@name='{name}']").text)


def parameters_of(document, node):
    return document[f'/**/{node}']['ros__parameters']


@pytest.mark.parametrize('name', available_robots())
def test_each_joint_takes_positions_within_its_range_and_begins_in_the_posture(name):
    robot = load_robot(name)
    system = system_of(controlled_urdf(robot))
    joints = system.findall('joint')
    assert [joint.get('name') for joint in joints] == list(robot.joint_names)
    command = "command_interface[@name='position']"
    for column, wanted in (('min', robot.lower), ('max', robot.upper)):
        found = [figures(joint, command, column) for joint in joints]
        np.testing.assert_allclose(found, wanted.reshape(-1), atol=1e-8)
    initial = [
        figures(joint, "state_interface[@name='position']", 'initial_value') for joint in joints
    ]
    np.testing.assert_allclose(initial, robot.initial_joint_angles.reshape(-1), atol=1e-8)
    for joint in joints:
        states = [state.get('name') for state in joint.findall('state_interface')]
        assert states == ['position', 'velocity', 'effort']
        assert len(joint.findall('command_interface')) == 1


def test_the_hardware_is_mocked_with_speeds_or_the_plugin_that_was_asked_for():
    mocked = system_of(controlled_urdf(TITAN)).find('hardware')
    assert mocked.find('plugin').text == MOCK_PLUGIN
    assert mocked.find("param[@name='calculate_dynamics']").text == 'true'
    real = system_of(controlled_urdf(TITAN, 'my_hardware/System'))
    assert (real.get('type'), real.get('name')) == ('system', 'titan_viii')
    assert real.find('hardware/plugin').text == 'my_hardware/System'
    assert real.findall('hardware/param') == []


def test_the_urdf_is_one_that_others_read():
    yourdfpy = pytest.importorskip('yourdfpy')
    root = ElementTree.fromstring(controlled_urdf(TITAN))
    model = yourdfpy.URDF._parse_robot(yourdfpy.urdf.etree.fromstring(ElementTree.tostring(root)))
    turning = [joint.name for joint in model.joints if joint.type == 'revolute']
    assert turning == list(TITAN.joint_names)
    assert model.links[0].name == 'base_link'


def test_the_controller_has_the_joints_in_the_order_of_quadwalk_and_documented_names_only():
    document = controllers(TITAN)
    controller = parameters_of(document, 'joint_trajectory_controller')
    assert controller['joints'] == list(TITAN.joint_names)
    assert set(controller) == CONTROLLER_PARAMETERS
    assert controller['command_interfaces'] == ['position']
    assert controller['state_interfaces'] == ['position', 'velocity']
    manager = parameters_of(document, 'controller_manager')
    assert {name: entry['type'] for name, entry in manager.items() if name != 'update_rate'} == {
        'joint_state_broadcaster': 'joint_state_broadcaster/JointStateBroadcaster',
        'joint_trajectory_controller': 'joint_trajectory_controller/JointTrajectoryController',
    }


@pytest.mark.ros
@pytest.mark.parametrize('namespace', ['', '/robot_1', '/fleet/robot_1'])
def test_ros_gives_the_parameters_to_the_controller_in_any_namespace(tmp_path, namespace):
    rclpy = pytest.importorskip('rclpy')
    export_robot(TITAN, tmp_path, ExportOptions('titan_viii'))
    context = rclpy.Context()
    file = tmp_path / 'controllers.yaml'
    rclpy.init(args=['--ros-args', '--params-file', str(file)], context=context, domain_id=87)
    node = rclpy.create_node(
        'joint_trajectory_controller',
        namespace=namespace,
        context=context,
        automatically_declare_parameters_from_overrides=True,
    )
    try:
        value = {name: node.get_parameter(name).value for name in node._parameters}
        assert value['joints'] == list(TITAN.joint_names)
        # ROS does not take an integer for a number.
        assert isinstance(value['constraints.goal_time'], float)
        assert isinstance(value['cmd_timeout'], float)
        assert value['interpolate_from_desired_state'] is True
    finally:
        node.destroy_node()
        context.try_shutdown()


def test_joint_limits_are_those_of_the_robot():
    limits = joint_limits(TITAN)['joint_limits']
    assert list(limits) == list(TITAN.joint_names)
    for key, wanted in (
        ('min_position', TITAN.lower),
        ('max_position', TITAN.upper),
        ('max_velocity', TITAN.velocity),
        ('max_effort', TITAN.effort),
    ):
        np.testing.assert_allclose([limit[key] for limit in limits.values()], np.ravel(wanted))


def test_the_files_are_written_and_load(tmp_path):
    folder = tmp_path / 'new' / 'folder'
    written = export_robot(TITAN, folder, ExportOptions('titan_viii', 'my_hardware/System'))
    assert [path.name for path in written] == [
        'titan_viii.urdf',
        'controllers.yaml',
        'joint_limits.yaml',
        'bringup.launch.py',
    ]
    assert all(path.is_file() for path in written)
    assert yaml.safe_load((folder / 'controllers.yaml').read_text()) == controllers(TITAN)
    assert yaml.safe_load((folder / 'joint_limits.yaml').read_text()) == joint_limits(TITAN)
    assert (folder / 'titan_viii.urdf').read_text() == controlled_urdf(TITAN, 'my_hardware/System')


def test_where_one_file_cannot_be_written_none_is(tmp_path):
    (tmp_path / 'controllers.yaml').mkdir()
    with pytest.raises(FileUnusable, match='is a directory'):
        export_robot(TITAN, tmp_path, ExportOptions('titan_viii'))
    assert [path.name for path in tmp_path.iterdir()] == ['controllers.yaml']


def launched(folder, monkeypatch):
    """Run the launch file with classes that only note what they are given."""
    names = (
        'launch', 'launch.actions', 'launch.conditions', 'launch.launch_description_sources',
        'launch.substitutions', 'launch_ros', 'launch_ros.actions',
        'launch_ros.parameter_descriptions', 'launch_ros.substitutions',
    )  # fmt: skip
    modules = {name: MagicMock(name=name) for name in names}
    modules['launch.substitutions'].LaunchConfiguration = lambda name: f'<{name}>'
    modules['launch_ros.parameter_descriptions'].ParameterValue = lambda value, value_type: value
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    runpy.run_path(str(folder / 'bringup.launch.py'))['generate_launch_description']()
    return modules


def test_the_launch_file_starts_the_nodes_and_leads_trajectories_to_the_controller(
    tmp_path, monkeypatch
):
    export_robot(TITAN, tmp_path, ExportOptions('/robots/it\'s "mine".yaml'))
    modules = launched(tmp_path, monkeypatch)
    actions = modules['launch_ros.actions']
    nodes = {call.kwargs['executable']: call.kwargs for call in actions.Node.call_args_list}
    assert set(nodes) == {'robot_state_publisher', 'ros2_control_node', 'spawner'}
    described = nodes['robot_state_publisher']['parameters'][0]['robot_description']
    assert described == (tmp_path / 'titan_viii.urdf').read_text()
    controllers_file = str(tmp_path / 'controllers.yaml')
    assert nodes['ros2_control_node']['parameters'][0] == controllers_file
    arguments = nodes['spawner']['arguments']
    assert arguments[:2] == ['joint_state_broadcaster', 'joint_trajectory_controller']
    assert arguments[arguments.index('--param-file') + 1] == controllers_file
    actions.SetRemap.assert_called_once_with(
        'joint_trajectory', 'joint_trajectory_controller/joint_trajectory'
    )
    included = modules['launch.actions'].IncludeLaunchDescription.call_args.kwargs
    assert dict(included['launch_arguments']) == {
        **{name: f'<{name}>' for name in ('robot', 'gait', 'odom_topic', 'namespace')},
        **{name: f'<{name}>' for name in ('frame_prefix', 'use_sim_time')},
        'robot_state_publisher': 'false',
    }
    publisher = nodes['robot_state_publisher']
    assert publisher['parameters'][0]['frame_prefix'] == '<frame_prefix>'
    assert 'remappings' not in publisher
    defaults = {
        call.args[0]: call.kwargs['default_value']
        for call in modules['launch.actions'].DeclareLaunchArgument.call_args_list
    }
    assert defaults['robot'] == '/robots/it\'s "mine".yaml'
    assert defaults['odom_topic'] == 'odom/legs'


def test_a_robot_of_any_name_becomes_a_file_of_the_folder(tmp_path):
    from dataclasses import replace

    written = export_robot(replace(TITAN, name='../my robot'), tmp_path, ExportOptions('x'))
    assert all(path.parent == tmp_path for path in written)
    assert written[0].suffix == '.urdf'
    assert written[0].is_file()
