"""
Start several simulated robots in one world, each with its planner and its gait.

Each robot has the namespace of its name, which its frames begin with, too. Publish
``left/goal_pose`` and the robot ``left`` walks there. Arguments that are left empty
keep the value of the parameter files.
"""

from __future__ import annotations

from pathlib import Path

from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    IncludeLaunchDescription,
    OpaqueFunction,
    Shutdown,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchContext, LaunchDescription, LaunchDescriptionEntity
from quad_sim.fleet_text import robots_from_text

# Launch argument: how its text is read, and its description. Each is sim_node's parameter.
SIM_ARGUMENTS = {
    'robots': (str, 'kinds, names and places: "left=cuhk@1,2,0; right=a1@4,2,3.14"'),
    'map_file': (str, 'path of a Nav2 map file'),
    'real_time_factor': (float, 'simulated over real time; 0 runs as fast as possible'),
    'backend': (str, "'auto', 'bullet', 'mujoco' or 'kinematic'"),
    'room_seed': (int, 'of a room of obstacles at random, in place of a map'),
    'odom_drift': (
        float,
        'of odom: fraction of the distance and of the angle turned, and radians a metre',
    ),
    'localiser_rate': (float, 'how often a localiser publishes map -> odom [Hz]; 0: there is none'),
}

# Launch argument of robot.launch.py, the same for every robot: its default and its description.
ROBOT_ARGUMENTS = {
    'method': ('', 'how the planners search'),
    'gait': ('', 'name of a gait, or path of a gait file'),
    'turning': ('', 'how the robots turn at the turning points of their plans'),
    'balance': ('', 'trot with a decision at every measurement: true or false'),
    'respawn': ('false', 'start a planner or a gait again when it has ended'),
    'robot_state_publisher': ('auto', "publish the legs' frames; 'auto': where it is installed"),
}


def start_fleet(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Start one simulator, and a planner and a gait for each robot; its end ends the launch."""
    given = {name: LaunchConfiguration(name).perform(context) for name in SIM_ARGUMENTS}
    parameters = {}
    for name, (read, _) in SIM_ARGUMENTS.items():
        if given[name] != '':
            try:
                parameters[name] = read(given[name])
            except ValueError as error:
                raise ValueError(f'argument {name}: {error}') from error
    simulator = Node(
        package='quadwalk',
        executable='sim_node',
        output='screen',
        parameters=[
            PathJoinSubstitution([LaunchConfiguration('config_directory'), 'sim_node.yaml']),
            parameters,
        ],
        on_exit=Shutdown(reason='the simulator has ended'),
    )
    is_shown = LaunchConfiguration('view').perform(context)
    groups = []
    for name, robot in robots_from_text(given['robots']).items():
        own = {'namespace': name, 'frame_prefix': f'{name}/', 'robot': robot.kind}
        # One viewer shows them all.
        own |= {'use_sim_time': 'true', 'view': 'false' if groups else is_shown}
        shared = {key: LaunchConfiguration(key) for key in (*ROBOT_ARGUMENTS, 'config_directory')}
        robot_file = str(Path(__file__).with_name('robot.launch.py'))
        included = IncludeLaunchDescription(
            PythonLaunchDescriptionSource(robot_file),
            launch_arguments=[*own.items(), *shared.items()],
        )
        # A robot's arguments are not those of the next one.
        groups.append(GroupAction([included]))
    return [simulator, *groups]


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, and start the nodes once their values are known."""
    defaults = {
        **{name: ('', description) for name, (_, description) in SIM_ARGUMENTS.items()},
        **ROBOT_ARGUMENTS,
        'view': ('false', 'show the robots on a page in the browser'),
        'config_directory': (
            PathJoinSubstitution([FindPackageShare('quadwalk'), 'config']),
            'folder with planner_node.yaml, gait_node.yaml and sim_node.yaml',
        ),
    }
    defaults['robots'] = ('titan_viii, cuhk, a1', defaults['robots'][1])
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in defaults.items()
            ),
            OpaqueFunction(function=start_fleet),
        ]
    )
