"""
Start a simulated robot with its planner and its gait.

Publish a ``goal_pose`` (in RViz: "2D Goal Pose") and it walks there. Arguments
that are left empty keep the value of the parameter files.
"""

from __future__ import annotations

from pathlib import Path

import yaml
from launch.actions import (
    DeclareLaunchArgument,
    IncludeLaunchDescription,
    OpaqueFunction,
    Shutdown,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription


def boolean(text: str) -> bool:
    """Read true or false."""
    if text.lower() not in ('true', 'false'):
        raise ValueError(f"'{text}' must be true or false")
    return text.lower() == 'true'


def numbers(text: str) -> list[float]:
    """Read numbers with commas between them, with or without brackets."""
    return [float(number) for number in yaml.safe_load(f'[{text.strip().strip("[]")}]')]


# Launch argument: how its text is read, and its description. Each is sim_node's parameter.
SIM_ARGUMENTS = {
    'robot': (str, 'name of a robot, or path of a robot data file'),
    'map_file': (str, 'path of a Nav2 map file'),
    'start_pose': (numbers, 'where the robot stands at first: [x, y, yaw] in the map [m, m, rad]'),
    'real_time_factor': (float, 'simulated over real time; 0 runs as fast as possible'),
    'backend': (str, "'auto', 'bullet', 'mujoco' or 'kinematic'"),
    'gui': (boolean, "show PyBullet's own window: true or false"),
    'seed': (int, 'of the noise of the simulated sensors'),
    'odom_drift': (
        float,
        'of odom: fraction of the distance and of the angle turned, and radians a metre',
    ),
    'localiser_rate': (float, 'how often a localiser publishes map -> odom [Hz]; 0: there is none'),
    'room_seed': (int, 'of a room of obstacles at random, in place of a map'),
    'terrain': (
        str,
        "ground: 'flat', or bumps, slope, kerb, noise, boxes, ...; with ground:=uneven",
    ),
    'terrain_seed': (int, 'of the ground'),
    'camera': (boolean, 'hang a camera under the ceiling: true or false'),
    'camera_position': (numbers, 'of the camera in the map: [x, y, z] [m]'),
    'camera_yaw': (float, "direction in the map of the picture's right side [rad]"),
    'publish_map': (boolean, 'false leaves the map to a camera'),
    'publish_tf': (boolean, 'false leaves the transforms to a camera'),
    'frame_prefix': (str, "what the robot's frames begin with; the namespace and '/'"),
    'publish_clock': (
        boolean,
        'false: another simulator does; with use_sim_time:=false',
    ),
}


def prefix_of_namespace() -> PythonExpression:
    """Name the robot's frames after its namespace: 'left' makes 'left/', none makes nothing."""
    name = ("'", LaunchConfiguration('namespace'), "'.strip('/')")
    return PythonExpression([*name, ' and ', *name, " + '/'"])


def start_simulator(context: LaunchContext) -> list[Node]:
    """Start the simulator with the arguments that were given; its end ends the launch."""
    parameters = {}
    for name, (read, _) in SIM_ARGUMENTS.items():
        text = LaunchConfiguration(name).perform(context)
        if text != '':
            try:
                parameters[name] = read(text)
            except ValueError as error:
                raise ValueError(f'argument {name}: {error}') from error
    return [
        Node(
            package='quadwalk',
            executable='sim_node',
            namespace=LaunchConfiguration('namespace'),
            output='screen',
            parameters=[
                PathJoinSubstitution([LaunchConfiguration('config_directory'), 'sim_node.yaml']),
                {
                    'use_sim_time': boolean(LaunchConfiguration('use_sim_time').perform(context)),
                    **parameters,
                },
            ],
            on_exit=Shutdown(reason='the simulator has ended'),
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, and start the nodes once their values are known."""
    shared = ('robot', 'namespace', 'use_sim_time', 'config_directory', 'frame_prefix')
    defaults = {'frame_prefix': prefix_of_namespace()}
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'namespace',
                default_value='',
                description='of all topics; a second robot needs one, and publish_clock:=false',
            ),
            DeclareLaunchArgument(
                'use_sim_time',
                default_value='true',
                choices=['true', 'false'],
                description='take the time from /clock, which the simulator publishes',
            ),
            DeclareLaunchArgument(
                'config_directory',
                default_value=PathJoinSubstitution([FindPackageShare('quadwalk'), 'config']),
                description='folder with planner_node.yaml, gait_node.yaml and sim_node.yaml',
            ),
            *(
                DeclareLaunchArgument(
                    name, default_value=defaults.get(name, ''), description=description
                )
                for name, (_, description) in SIM_ARGUMENTS.items()
            ),
            OpaqueFunction(function=start_simulator),
            # It declares the arguments of the planner and the gait: method, gait, turning, ...
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(str(Path(__file__).with_name('robot.launch.py'))),
                launch_arguments={name: LaunchConfiguration(name) for name in shared}.items(),
            ),
        ]
    )
