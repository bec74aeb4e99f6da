"""
Writes what ros2_control needs to move a robot by quadwalk's ``joint_trajectory``.

Parameters are named as in ROS 2 Jazzy; ``docs/hardware.md`` says where each is documented.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import yaml
from numpy.typing import NDArray

from quad_common.files.bounded_file import check_target, make_folder
from quad_common.files.whole_file import write_text
from quad_common.robot.robot import Robot
from quad_common.robot.urdf import published_urdf
from quad_common.robot_files.bringup import bringup_text

Array = NDArray[np.float64]

MOCK_PLUGIN = 'mock_components/GenericSystem'
"""Hardware that is not there: its joints are where they are commanded."""

UPDATE_RATE = 200
"""Rate of the controllers' loop: at least twice as fast as quadwalk's points [Hz]."""

BROADCASTER, CONTROLLER = 'joint_state_broadcaster', 'joint_trajectory_controller'
"""Names of the two controllers."""

_ANYWHERE = '/**/'
"""Before a node's name in a parameter file: in whatever namespace it is."""


@dataclass(frozen=True)
class ExportOptions:
    """How a robot is handed to ros2_control."""

    robot: str
    """Name or path by which quadwalk's nodes find the robot."""
    plugin: str = MOCK_PLUGIN
    """Hardware plugin, ``package/Class``."""
    update_rate: int = UPDATE_RATE
    """Rate of the controllers' loop [Hz]."""


def export_robot(robot: Robot, folder: Path, options: ExportOptions) -> list[Path]:
    """
    Write the files with which ros2_control moves a robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    folder : Path
        Where the files are written; it is made if it is not there, files that are there are
        replaced.
    options : ExportOptions
        Hardware and rate.

    Returns
    -------
    list of Path
        URDF, controllers, joint limits and launch file.

    Raises
    ------
    FileUnusable
        If a file cannot be written; then none is.
    """
    name = re.sub(r'[^\w.+-]', '_', robot.name).lstrip('.') or 'robot'
    files = {
        f'{name}.urdf': controlled_urdf(robot, options.plugin),
        'controllers.yaml': _document(controllers(robot, options.update_rate), _CONTROLLERS_HEADER),
        'joint_limits.yaml': _document(joint_limits(robot), _LIMITS_HEADER),
        'bringup.launch.py': bringup_text(f'{name}.urdf', options.robot, (BROADCASTER, CONTROLLER)),
    }
    for file in files:
        check_target(folder / file)
    make_folder(folder)
    for file, text in files.items():
        write_text(folder / file, text)
    return [folder / file for file in files]


def controlled_urdf(robot: Robot, plugin: str = MOCK_PLUGIN) -> str:
    """
    Return a robot's URDF with what ros2_control reads of it.

    Parameters
    ----------
    robot : Robot
        The robot.
    plugin : str
        Hardware plugin, ``package/Class``.

    Returns
    -------
    str
        As :func:`~quad_common.robot.urdf.published_urdf`, with a ``ros2_control`` tag: each joint
        takes positions within its range, measures position, velocity and effort, and begins in the
        initial posture. Meshes are named by ``file://`` addresses, which RViz needs.
    """
    root = ElementTree.fromstring(published_urdf(robot))
    for mesh in root.iter('mesh'):
        if mesh.get('filename', '').startswith('/'):
            mesh.set('filename', f'file://{mesh.get("filename")}')
    system = ElementTree.SubElement(root, 'ros2_control', name=robot.name, type='system')
    hardware = ElementTree.SubElement(system, 'hardware')
    ElementTree.SubElement(hardware, 'plugin').text = plugin
    if plugin == MOCK_PLUGIN:
        # Without it the mock's joints never have a velocity.
        _parameter(hardware, 'calculate_dynamics', 'true')
    for name, lower, upper, _, _, initial in _joints(robot):
        joint = ElementTree.SubElement(system, 'joint', name=name)
        command = ElementTree.SubElement(joint, 'command_interface', name='position')
        _parameter(command, 'min', _text(lower))
        _parameter(command, 'max', _text(upper))
        for interface, value in (('position', initial), ('velocity', 0.0), ('effort', 0.0)):
            state = ElementTree.SubElement(joint, 'state_interface', name=interface)
            _parameter(state, 'initial_value', _text(value))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding='unicode') + '\n'


def controllers(robot: Robot, update_rate: int = UPDATE_RATE) -> dict[str, Any]:
    """
    Return the parameters of controller manager, joint state broadcaster and trajectory controller.

    Parameters
    ----------
    robot : Robot
        The robot.
    update_rate : int
        Rate of the controllers' loop [Hz].

    Returns
    -------
    dict
        Of a ROS parameter file, valid in any namespace.
    """
    return {
        f'{_ANYWHERE}controller_manager': {
            'ros__parameters': {
                'update_rate': update_rate,
                BROADCASTER: {'type': f'{BROADCASTER}/JointStateBroadcaster'},
                CONTROLLER: {'type': f'{CONTROLLER}/JointTrajectoryController'},
            }
        },
        f'{_ANYWHERE}{BROADCASTER}': {'ros__parameters': {'use_local_topics': False}},
        f'{_ANYWHERE}{CONTROLLER}': {
            'ros__parameters': {
                'joints': list(robot.joint_names),
                'command_interfaces': ['position'],
                'state_interfaces': ['position', 'velocity'],
                'interpolation_method': 'splines',
                'interpolate_from_desired_state': True,
                'allow_partial_joints_goal': False,
                'allow_integration_in_goal_trajectories': False,
                'allow_nonzero_velocity_at_trajectory_end': False,
                'cmd_timeout': 0.0,
                'constraints': {'stopped_velocity_tolerance': 0.0, 'goal_time': 0.0},
            }
        },
    }


def joint_limits(robot: Robot) -> dict[str, Any]:
    """
    Return the limits of a robot's joints, in the form of ``joint_limits`` and MoveIt.

    Parameters
    ----------
    robot : Robot
        The robot.
    """
    return {
        'joint_limits': {
            name: {
                'has_position_limits': True,
                'min_position': lower,
                'max_position': upper,
                'has_velocity_limits': True,
                'max_velocity': velocity,
                'has_acceleration_limits': False,
                'has_jerk_limits': False,
                'has_effort_limits': True,
                'max_effort': effort,
            }
            for name, lower, upper, velocity, effort, _ in _joints(robot)
        }
    }


def _joints(robot: Robot) -> Iterator[tuple[str, float, float, float, float, float]]:
    """Yield name, range, speed, torque and initial angle of each joint, in quadwalk's order."""
    columns = (robot.lower, robot.upper, robot.velocity, robot.effort, robot.initial_joint_angles)
    for name, *figures in zip(robot.joint_names, *(np.ravel(column) for column in columns)):
        lower, upper, velocity, effort, initial = (float(figure) for figure in figures)
        yield name, lower, upper, velocity, effort, initial


def _parameter(element: ElementTree.Element, name: str, text: str) -> None:
    ElementTree.SubElement(element, 'param', name=name).text = text


def _text(value: float) -> str:
    # No minus before a zero.
    return f'{value + 0.0:.9g}'


def _document(document: dict[str, Any], header: str) -> str:
    return header + yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=100)


_CONTROLLERS_HEADER = """\
# Parameters of ros2_control's nodes, written by "quadwalk robot export". The trajectories of
# gait_node replace one another before they end, each with its own time stamp, and end at rest:
# - interpolate_from_desired_state: the way to the first point begins where the joints are commanded
#   to be, not where they are under their load, so that trajectories join without a jerk.
# - constraints of 0 are none: a tolerance that is exceeded would hold the joints in the middle of a
#   step. gait_node watches the joints, and brings the robot to rest with the feet on the ground.
# - cmd_timeout 0: after its last point, which is at rest, a trajectory is held.
"""

_LIMITS_HEADER = """\
# Limits of the joints [rad, rad/s, N m], written by "quadwalk robot export". gait_node keeps them;
# they are for whatever else moves the joints, as MoveIt does.
"""
