"""
Start a robot that walks by a camera under the ceiling alone.

The camera's node, the planner and the gait, and the simulator with its camera unless
``simulator:=false``: then a real camera publishes ``ceiling_camera/image_raw`` and
``ceiling_camera/camera_info``, and a real robot takes ``joint_trajectory``. The goal is
a marker on the floor; in simulation publish its pose on ``goal_marker``. Arguments that
are left empty keep the value of the parameter files.
"""

from __future__ import annotations

from pathlib import Path

import yaml
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
)
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node, SetRemap
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity

SHARED = ('robot', 'namespace', 'use_sim_time', 'config_directory', 'respawn')


def boolean(text: str) -> bool:
    """Read true or false."""
    if text.lower() not in ('true', 'false'):
        raise ValueError(f"'{text}' must be true or false")
    return text.lower() == 'true'


def place(text: str) -> list[float]:
    """Read [x, y, z], with or without brackets."""
    return [float(number) for number in yaml.safe_load(f'[{text.strip().strip("[]")}]')]


# Launch argument: how its text is read, and its description. Each is ceiling_camera_node's
# parameter.
CAMERA_ARGUMENTS = {
    'robot': (str, 'name of a robot, or path of a robot data file'),
    'camera_file': (str, "camera file of 'quadwalk camera calibrate'; for a real camera"),
    'camera_position': (place, 'of the camera in the map: [x, y, z] [m]'),
    'camera_yaw': (float, "direction in the map of the picture's right side [rad]"),
}


def start_camera(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Start the camera's node with the arguments that were given."""
    given = {name: LaunchConfiguration(name).perform(context) for name in CAMERA_ARGUMENTS}
    parameters = {}
    for name, (read, _) in CAMERA_ARGUMENTS.items():
        if given[name] != '':
            try:
                parameters[name] = read(given[name])
            except ValueError as error:
                raise ValueError(f'argument {name}: {error}') from error
    node = Node(
        package='quadwalk',
        executable='ceiling_camera_node',
        namespace=LaunchConfiguration('namespace'),
        output='screen',
        parameters=[
            PathJoinSubstitution(
                [LaunchConfiguration('config_directory'), 'ceiling_camera_node.yaml']
            ),
            {
                'use_sim_time': boolean(LaunchConfiguration('use_sim_time').perform(context)),
                **parameters,
            },
        ],
        respawn=boolean(LaunchConfiguration('respawn').perform(context)),
        respawn_delay=2.0,
    )
    return [node]


def what_walks() -> list[IncludeLaunchDescription]:
    """Include planner and gait, with the simulator or without."""
    # The camera says where the robot is, and the legs begin at an origin of their own.
    shared = {name: LaunchConfiguration(name) for name in SHARED}
    shared |= {'odom_topic': 'odom/camera', 'leg_odometry_start': 'origin'}
    # The legs' odometry has frames without a prefix.
    shared |= {'frame_prefix': ''}
    simulated = {'camera': 'true', 'publish_map': 'false', 'publish_tf': 'false'}
    simulated |= {name: LaunchConfiguration(name) for name in ('camera_position', 'camera_yaw')}
    has_simulator = LaunchConfiguration('simulator')
    return [
        IncludeLaunchDescription(
            PythonLaunchDescriptionSource(str(Path(__file__).with_name(file))),
            launch_arguments=arguments.items(),
            condition=condition(has_simulator),
        )
        for file, arguments, condition in (
            ('walk.launch.py', shared | simulated, IfCondition),
            ('robot.launch.py', shared, UnlessCondition),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, and start the nodes once their values are known."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'simulator',
                default_value='true',
                choices=['true', 'false'],
                description='start the simulator too: robot, room and camera',
            ),
            DeclareLaunchArgument(
                'namespace', default_value='', description='of all topics; a second robot needs one'
            ),
            DeclareLaunchArgument(
                'use_sim_time',
                default_value=LaunchConfiguration('simulator'),
                description='take the time from /clock, which the simulator publishes',
            ),
            DeclareLaunchArgument(
                'config_directory',
                default_value=PathJoinSubstitution([FindPackageShare('quadwalk'), 'config']),
                description='folder with a parameter file for each node',
            ),
            DeclareLaunchArgument(
                'respawn',
                default_value='false',
                choices=['true', 'false'],
                description='start a node again when it has ended',
            ),
            *(
                DeclareLaunchArgument(name, default_value='', description=description)
                for name, (_, description) in CAMERA_ARGUMENTS.items()
            ),
            GroupAction(
                [
                    # In a namespace the robot has a tree of its own.
                    *(SetRemap(f'/{name}', name) for name in ('tf', 'tf_static')),
                    OpaqueFunction(function=start_camera),
                    *what_walks(),
                ]
            ),
        ]
    )
