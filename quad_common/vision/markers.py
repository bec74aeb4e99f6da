"""
What the ceiling camera tells things apart by: markers on the robot and at the goal.

The camera shows where things are by their colors (S1): a plate on the robot's back carries
two discs, and two more lie at the goal. In each pair the line between the centers shows
position and heading, and both can be measured to a fraction of a pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors import ParameterError
from quad_common.robot.robot import Robot

Color = tuple[int, int, int]
"""Red, green and blue, each from 0 to 255."""

OBSTACLE_COLOR: Color = (205, 50, 35)
"""Color of walls and obstacles, unless another is given."""

_OVERHANG = 0.02
"""Length by which the plate is longer than the body, at each end [m]."""

_ABOVE_BODY = 0.015
"""Distance from the top of the body to that of the plate [m]."""

_FRACTION = 0.9
"""Fraction of the space for it that a disc takes: the rest keeps discs and edges apart."""


def check_color(name: str, color: Color) -> None:
    """Raise ParameterError unless a color is three whole numbers from 0 to 255."""
    if len(color) != 3 or not all(isinstance(c, int) and 0 <= c <= 255 for c in color):
        raise ParameterError(name, list(color), 'red, green and blue, whole numbers from 0 to 255')


@dataclass(frozen=True)
class RobotMarker:
    """
    A level plate on top of the body, with a disc at the front and one behind.

    Raises
    ------
    ParameterError
        If a color is none.
    """

    length: float = 0.50
    """Length of the plate, along base_link's x axis [m]."""
    width: float = 0.26
    """Width of the plate [m]."""
    height: float = 0.10
    """Height of the discs above base_link [m]."""
    disc_radius: float = 0.112
    """Radius of the discs [m]."""
    disc_distance: float = 0.25
    """Distance between the centers of the discs; base_link is below the middle [m]."""
    front_color: Color = (30, 80, 230)
    """Color of the disc in front."""
    rear_color: Color = (250, 210, 0)
    """Color of the disc behind."""
    plate_color: Color = (250, 250, 250)
    """Color of the plate."""

    def __post_init__(self) -> None:
        """Check the colors."""
        for name in ('front_color', 'rear_color', 'plate_color'):
            check_color(name, getattr(self, name))

    @classmethod
    def on(
        cls,
        robot: Robot,
        front_color: Color = front_color,
        rear_color: Color = rear_color,
        plate_color: Color = plate_color,
    ) -> RobotMarker:
        """
        Make the largest marker that a robot's body carries.

        Parameters
        ----------
        robot : Robot
            The robot.
        front_color, rear_color, plate_color : Color
            Of the discs and the plate.

        Returns
        -------
        RobotMarker
            As wide as the body, and a little longer.
        """
        body_length, width, body_height = robot.body_size
        length = body_length + 2.0 * _OVERHANG
        return cls(
            length=length,
            width=width,
            height=float(robot.body_center[2]) + body_height / 2.0 + _ABOVE_BODY,
            disc_radius=_FRACTION * min(width, length / 2.0) / 2.0,
            disc_distance=length / 2.0,
            front_color=front_color,
            rear_color=rear_color,
            plate_color=plate_color,
        )


@dataclass(frozen=True)
class GoalMarker:
    """
    A large disc on the floor at the goal, and a small one ahead of it.

    Raises
    ------
    ParameterError
        If a color is none.
    """

    radius: float = 0.15
    """Radius of the disc whose center is the goal [m]."""
    heading_radius: float = 0.10
    """Radius of the disc that shows the heading [m]."""
    heading_distance: float = 0.30
    """Distance from the goal to the center of the disc that shows the heading [m]."""
    height: float = 0.005
    """Height of both discs above the floor [m]."""
    color: Color = (20, 170, 60)
    """Color of the disc at the goal."""
    heading_color: Color = (215, 40, 200)
    """Color of the disc that shows the heading."""

    def __post_init__(self) -> None:
        """Check the colors."""
        for name in ('color', 'heading_color'):
            check_color(name, getattr(self, name))
