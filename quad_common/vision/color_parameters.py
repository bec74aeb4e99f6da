"""
Colors as parameters: what the simulator paints, and what the camera's node looks for.

Both nodes have the same ones, so that a picture of the one suits the other.
"""

from __future__ import annotations

from typing import Any

from quad_common.errors import ParameterError
from quad_common.parameters import parameter
from quad_common.robot.robot import Robot
from quad_common.vision.markers import OBSTACLE_COLOR, Color, GoalMarker, RobotMarker

_USUAL: dict[str, tuple[Color, str]] = {
    'obstacle_color': (OBSTACLE_COLOR, 'walls and obstacles, 0 to 255'),
    'front_color': (RobotMarker.front_color, "the front disc on the robot's back"),
    'rear_color': (RobotMarker.rear_color, "the rear disc on the robot's back"),
    'goal_color': (GoalMarker.color, "the goal's disc"),
    'goal_heading_color': (GoalMarker.heading_color, "the disc that shows the goal's heading"),
}
"""Default of each parameter, and what has the color."""


def color_parameter(name: str) -> Any:
    """Make the field of a parameter dataclass for one of the colors; see :func:`parameter`."""
    color, what = _USUAL[name]
    return parameter([float(part) for part in color], f'Red, green and blue of {what}.')


def color_from(parameters: object, name: str) -> Color:
    """
    Read a color from a parameter of a node.

    Raises
    ------
    ParameterError
        If it is none.
    """
    values = getattr(parameters, name)
    if not all(0.0 <= value <= 255.0 for value in values):
        raise ParameterError(name, values, 'red, green and blue, from 0 to 255')
    red, green, blue = (round(value) for value in values)
    return red, green, blue


def markers_from(parameters: object, robot: Robot) -> tuple[RobotMarker, GoalMarker]:
    """Return the markers that the parameters of a node describe; see :func:`color_from`."""
    front, rear, goal, heading = (
        color_from(parameters, name)
        for name in ('front_color', 'rear_color', 'goal_color', 'goal_heading_color')
    )
    return RobotMarker.on(robot, front, rear), GoalMarker(color=goal, heading_color=heading)
