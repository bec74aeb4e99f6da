"""
Start the planner and the gait for a robot that is driven by something else.

A real robot, or another simulator, takes ``joint_trajectory`` and publishes
``odom`` and ``map``. Arguments that are left empty keep the value of the
parameter files.
"""

from __future__ import annotations

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription

# Launch argument: its description. Each is the node's parameter of the same name.
PLANNER_ARGUMENTS = {
    'robot': 'name of a robot, or path of a robot data file',
    'method': 'how the planner searches',
    'safety_distance': "kept free around the robot's feet [m]",
    'odom_topic': "where the robot's pose comes from",
}
GAIT_ARGUMENTS = {
    'robot': PLANNER_ARGUMENTS['robot'],
    'gait': 'name of a gait, or path of a gait file',
    'turning': 'how the robot turns at the turning points of its plan',
    'ground': "'flat', or 'uneven' to feel for the ground with each foot",
    'odom_topic': PLANNER_ARGUMENTS['odom_topic'],
    'leg_odometry_start': "'origin' lets a camera place the odometry of the legs",
}
NUMBERS = ('safety_distance',)


def start_nodes(context: LaunchContext) -> list[Node]:
    """Start the nodes with the arguments that were given."""
    use_sim_time = LaunchConfiguration('use_sim_time').perform(context).lower()
    if use_sim_time not in ('true', 'false'):
        raise ValueError(f"use_sim_time is '{use_sim_time}'; it must be true or false")
    nodes = []
    for node, arguments in (('planner_node', PLANNER_ARGUMENTS), ('gait_node', GAIT_ARGUMENTS)):
        given = {name: LaunchConfiguration(name).perform(context) for name in arguments}
        parameters = {
            name: float(value) if name in NUMBERS else value
            for name, value in given.items()
            if value != ''
        }
        nodes.append(
            Node(
                package='quadwalk',
                executable=node,
                namespace=LaunchConfiguration('namespace'),
                output='screen',
                parameters=[
                    PathJoinSubstitution([LaunchConfiguration('config_directory'), f'{node}.yaml']),
                    {'use_sim_time': use_sim_time == 'true', **parameters},
                ],
            )
        )
    if LaunchConfiguration('view').perform(context).lower() == 'true':
        # Outside the namespace: it shows the robots of all.
        nodes.append(
            Node(
                package='quadwalk',
                executable='viewer_node',
                output='screen',
                parameters=[
                    PathJoinSubstitution(
                        [LaunchConfiguration('config_directory'), 'viewer_node.yaml']
                    ),
                ],
            )
        )
    return nodes


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
