"""
Start the planner and the gait for a robot that is driven by something else.

A real robot, or another simulator, takes ``joint_trajectory`` and publishes
``odom`` and ``map``. Arguments that are left empty keep the value of the
parameter files.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import mkdtemp

import yaml
from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch.actions import DeclareLaunchArgument, LogInfo, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from quad_common.robot.urdf import published_urdf
from quad_common.robot_files.robot_file import load_robot

# Launch argument: its description. Each is the node's parameter of the same name, and what both
# nodes have goes to both.
PLANNER_ARGUMENTS = {
    'robot': 'name of a robot, or path of a robot data file',
    'method': 'how the planner searches',
    'safety_distance': "kept free around the robot's feet [m]",
    'odom_topic': "where the robot's pose comes from",
    # How long a way takes, and how much room it needs, depends on how it is walked.
    'gait': 'name of a gait, or path of a gait file',
    'turning': 'how the robot turns at the turning points of its plan',
    'footsteps': 'plan foot by foot where no way else leads on uneven ground: true or false',
}
GAIT_ARGUMENTS = {
    'robot': PLANNER_ARGUMENTS['robot'],
    'gait': PLANNER_ARGUMENTS['gait'],
    'turning': PLANNER_ARGUMENTS['turning'],
    'ground': "'flat', or 'uneven' to feel for the ground with each foot",
    'footsteps': PLANNER_ARGUMENTS['footsteps'],
    'balance': 'trot with a decision at every measurement, and keep the balance: true or false',
    'lead_time': 'from giving a trajectory out to its first movement, at least [s]',
    'odom_topic': PLANNER_ARGUMENTS['odom_topic'],
    'leg_odometry_start': "'origin' lets a camera place the odometry of the legs",
}
NUMBERS = ('safety_distance', 'lead_time')
BOOLEANS = ('footsteps', 'balance')

RESPAWN_DELAY = 2.0
"""Time after which a node that has ended is started again [s]."""

RVIZ_TOPICS = (
    'map',
    'plan',
    'odom',
    'goal_pose',
    'footholds',
    'plan_markers',
    'support_polygon',
    'robot_description',
)
"""What quadwalk.rviz shows, and sends."""


def is_true(context: LaunchContext, name: str) -> bool:
    """Read an argument that is true or false."""
    text = LaunchConfiguration(name).perform(context).lower()
    if text not in ('true', 'false'):
        raise ValueError(f"{name} is '{text}'; it must be true or false")
    return text == 'true'


def read(context: LaunchContext, name: str) -> str | float | bool:
    """Read an argument that is not left empty as its parameter's type."""
    if name in BOOLEANS:
        return is_true(context, name)
    text = LaunchConfiguration(name).perform(context)
    try:
        return float(text) if name in NUMBERS else text
    except ValueError:
        raise ValueError(f"{name} is '{text}'; it must be a number") from None


def is_installed(package: str) -> bool:
    """Return whether a ROS package is there."""
    try:
        get_package_prefix(package)
    except PackageNotFoundError:
        return False
    return True


def config_file(name: str) -> PathJoinSubstitution:
    """Return the path of a file in the folder of configurations."""
    return PathJoinSubstitution([LaunchConfiguration('config_directory'), name])


def prefix_of_namespace() -> PythonExpression:
    """Name the robot's frames after its namespace: 'left' makes 'left/', none makes nothing."""
    name = ("'", LaunchConfiguration('namespace'), "'.strip('/')")
    return PythonExpression([*name, ' and ', *name, " + '/'"])


def start_nodes(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Start the nodes with the arguments that were given."""
    use_sim_time, respawn = is_true(context, 'use_sim_time'), is_true(context, 'respawn')
    nodes: list[LaunchDescriptionEntity] = []
    for node, arguments in (('planner_node', PLANNER_ARGUMENTS), ('gait_node', GAIT_ARGUMENTS)):
        parameters = {
            name: read(context, name)
            for name in arguments
            if LaunchConfiguration(name).perform(context) != ''
        }
        nodes.append(
            Node(
                package='quadwalk',
                executable=node,
                namespace=LaunchConfiguration('namespace'),
                output='screen',
                parameters=[
                    config_file(f'{node}.yaml'),
                    {'use_sim_time': use_sim_time, **parameters},
                ],
                respawn=respawn,
                respawn_delay=RESPAWN_DELAY,
            )
        )
    nodes += start_state_publisher(context, use_sim_time)
    if is_true(context, 'view'):
        # Outside the namespace: it shows the robots of all.
        odom_topic = LaunchConfiguration('odom_topic').perform(context)
        shown = [{'odom_topic': odom_topic}] if odom_topic else []
        viewer = Node(
            package='quadwalk',
            executable='viewer_node',
            output='screen',
            parameters=[config_file('viewer_node.yaml'), *shown],
        )
        nodes.append(viewer)
    if is_true(context, 'rviz'):
        nodes.append(start_rviz(context, use_sim_time))
    return nodes


def start_state_publisher(
    context: LaunchContext, use_sim_time: bool
) -> list[LaunchDescriptionEntity]:
    """Start what publishes the frames of the legs, if it is wanted and there."""
    wanted = LaunchConfiguration('robot_state_publisher').perform(context)
    if wanted == 'false':
        return []
    if not is_installed('robot_state_publisher'):
        missing = "robot_state_publisher is not installed, and RViz lacks the legs' frames"
        if wanted == 'true':
            raise ValueError(missing)
        return [LogInfo(msg=missing)]
    robot = LaunchConfiguration('robot').perform(context)
    if robot == '':
        file = Path(config_file('gait_node.yaml').perform(context))
        for node in yaml.safe_load(file.read_text(encoding='utf-8')).values():
            robot = node.get('ros__parameters', {}).get('robot', robot)
    return [
        Node(
            package='robot_state_publisher',
            executable='robot_state_publisher',
            namespace=LaunchConfiguration('namespace'),
            parameters=[
                {
                    'use_sim_time': use_sim_time,
                    'frame_prefix': ParameterValue(
                        LaunchConfiguration('frame_prefix'), value_type=str
                    ),
                    'robot_description': ParameterValue(
                        published_urdf(load_robot(robot or 'titan_viii')), value_type=str
                    ),
                }
            ],
        )
    ]


def rviz_file(context: LaunchContext) -> str:
    """Return the path of RViz's configuration, in which the robot's frames have its prefix."""
    file = config_file('quadwalk.rviz').perform(context)
    prefix = LaunchConfiguration('frame_prefix').perform(context)
    if prefix == '':
        return file
    text = Path(file).read_text(encoding='utf-8')
    prefixed = Path(mkdtemp(prefix='quadwalk-')) / 'quadwalk.rviz'
    # RViz itself writes the slash between prefix and name.
    text = text.replace('TF Prefix: ""', f'TF Prefix: "{prefix.removesuffix("/")}"')
    prefixed.write_text(text, encoding='utf-8')
    return str(prefixed)


def start_rviz(context: LaunchContext, use_sim_time: bool) -> Node:
    """Start RViz with what a walking robot shows."""
    if not is_installed('rviz2'):
        raise ValueError('rviz:=true, and rviz2 is not installed: view:=true needs no RViz')
    return Node(
        package='rviz2',
        executable='rviz2',
        namespace=LaunchConfiguration('namespace'),
        arguments=['-d', rviz_file(context)],
        parameters=[{'use_sim_time': use_sim_time}],
        # Its configuration has names that begin with a slash.
        remappings=[(f'/{name}', name) for name in RVIZ_TOPICS],
    )


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, and start the nodes once their values are known."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'namespace', default_value='', description='of all topics; a second robot needs one'
            ),
            DeclareLaunchArgument(
                'use_sim_time',
                default_value='false',
                choices=['true', 'false'],
                description='take the time from /clock',
            ),
            DeclareLaunchArgument(
                'config_directory',
                default_value=PathJoinSubstitution([FindPackageShare('quadwalk'), 'config']),
                description='folder with planner_node.yaml and gait_node.yaml',
            ),
            DeclareLaunchArgument(
                'respawn',
                default_value='false',
                choices=['true', 'false'],
                description='start a node again when it has ended',
            ),
            DeclareLaunchArgument(
                'frame_prefix',
                default_value=prefix_of_namespace(),
                description="what the frames of the legs begin with; the namespace and '/'",
            ),
            DeclareLaunchArgument(
                'robot_state_publisher',
                default_value='auto',
                choices=['auto', 'true', 'false'],
                description="publish the frames of the legs; 'auto': where it is installed",
            ),
            DeclareLaunchArgument(
                'rviz',
                default_value='false',
                choices=['true', 'false'],
                description='show the robot in RViz, with config/quadwalk.rviz',
            ),
            DeclareLaunchArgument(
                'view',
                default_value='false',
                choices=['true', 'false'],
                description='show the robot on a page in the browser',
            ),
            *(
                DeclareLaunchArgument(name, default_value='', description=description)
                for name, description in (PLANNER_ARGUMENTS | GAIT_ARGUMENTS).items()
            ),
            OpaqueFunction(function=start_nodes),
        ]
    )
