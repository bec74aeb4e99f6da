"""
The launch file of a robot that is exported for ros2_control.
"""

from __future__ import annotations

_TEMPLATE = '''\
"""
Start the robot on ros2_control, and quadwalk's planner and gait above it.

Written by "quadwalk robot export". The gait's trajectories go to joint_trajectory_controller; its
joint states come from joint_state_broadcaster. Without other odometry it walks by that of its own
legs.
"""

from __future__ import annotations

from pathlib import Path

from launch.actions import DeclareLaunchArgument, GroupAction, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution, PythonExpression
from launch_ros.actions import Node, SetRemap
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

FOLDER = Path(__file__).resolve().parent
URDF = FOLDER / @URDF@
CONTROLLERS = FOLDER / 'controllers.yaml'
BROADCASTER = @BROADCASTER@
CONTROLLER = @CONTROLLER@

NAMESPACE = ("'", LaunchConfiguration('namespace'), "'.strip('/')")

# Launch argument: its default and its description.
ARGUMENTS = {
    'robot': (@ROBOT@, "the robot of quadwalk's nodes: name, data file or description"),
    'gait': ('', 'name of a gait, or path of a gait file'),
    'odom_topic': ('odom/legs', "where the robot's pose comes from"),
    'namespace': ('', 'of all topics; a second robot needs one'),
    'frame_prefix': (
        # 'left' makes 'left/', none makes nothing.
        PythonExpression([*NAMESPACE, ' and ', *NAMESPACE, " + '/'"]),
        "what the robot's frames begin with; the namespace and '/'",
    ),
    'use_sim_time': ('false', 'take the time from /clock, as with a simulator of ros2_control'),
    'walk': ('true', "start quadwalk's planner and gait as well"),
}

# Arguments of quadwalk's own launch file.
SHARED = ('robot', 'gait', 'odom_topic', 'namespace', 'frame_prefix', 'use_sim_time')


def generate_launch_description() -> LaunchDescription:
    """Describe the nodes: state publisher, controllers, planner and gait."""
    namespace = LaunchConfiguration('namespace')
    use_sim_time = {
        'use_sim_time': ParameterValue(LaunchConfiguration('use_sim_time'), value_type=bool)
    }
    # As text, whatever YAML would make of it.
    robot_description = ParameterValue(URDF.read_text(encoding='utf-8'), value_type=str)
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, (default, description) in ARGUMENTS.items()
            ),
            Node(
                package='robot_state_publisher',
                executable='robot_state_publisher',
                namespace=namespace,
                parameters=[
                    {
                        'robot_description': robot_description,
                        'frame_prefix': ParameterValue(
                            LaunchConfiguration('frame_prefix'), value_type=str
                        ),
                    },
                    use_sim_time,
                ],
            ),
            # It takes the robot from the topic robot_description.
            Node(
                package='controller_manager',
                executable='ros2_control_node',
                namespace=namespace,
                output='screen',
                parameters=[str(CONTROLLERS), use_sim_time],
            ),
            Node(
                package='controller_manager',
                executable='spawner',
                namespace=namespace,
                output='screen',
                arguments=[
                    BROADCASTER, CONTROLLER,
                    '--controller-manager', 'controller_manager',
                    '--param-file', str(CONTROLLERS),
                ],
            ),
            GroupAction(
                [
                    # What the gait publishes is what the controller takes.
                    SetRemap('joint_trajectory', f'{CONTROLLER}/joint_trajectory'),
                    IncludeLaunchDescription(
                        PythonLaunchDescriptionSource(
                            PathJoinSubstitution(
                                [FindPackageShare('quadwalk'), 'launch', 'robot.launch.py']
                            )
                        ),
                        launch_arguments={
                            **{name: LaunchConfiguration(name) for name in SHARED},
                            # It runs already.
                            'robot_state_publisher': 'false',
                        }.items(),
                    ),
                ],
                condition=IfCondition(LaunchConfiguration('walk')),
            ),
        ]
    )
'''


def bringup_text(urdf: str, robot: str, controllers: tuple[str, str]) -> str:
    """
    Return the text of a launch file for ROS 2 Jazzy.

    Parameters
    ----------
    urdf : str
        Name of the URDF's file, which is beside the launch file.
    robot : str
        Name or path by which quadwalk's nodes find the robot.
    controllers : tuple of str
        Names of joint state broadcaster and joint trajectory controller.
    """
    broadcaster, controller = controllers
    text = _TEMPLATE
    for mark, value in (
        ('@URDF@', urdf),
        ('@ROBOT@', robot),
        ('@BROADCASTER@', broadcaster),
        ('@CONTROLLER@', controller),
    ):
        text = text.replace(mark, repr(value))
    return text
