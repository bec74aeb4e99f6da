"""
What the ceiling camera tells things apart by: markers on the robot and at the goal.

The camera shows where things are by their colours (S1): a plate on the robot's back carries
two discs, and two more lie at the goal. In each pair the line between the centres shows
position and heading, and both can be measured to a fraction of a pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors import ParameterError
from quad_common.robot.robot import Robot

Colour = tuple[int, int, int]
"""Red, green and blue, each from 0 to 255."""

_OVERHANG = 0.02
"""Of the plate over the body, at each end [m]."""

_ABOVE_BODY = 0.015
"""From the top of the body to that of the plate [m]."""

_SHARE = 0.9
"""Of the room for it that a disc takes: the rest keeps discs and edges apart."""


def check_colour(name: str, colour: Colour) -> None:
    """Raise ParameterError unless a colour is three whole numbers from 0 to 255."""
    if len(colour) != 3 or not all(isinstance(c, int) and 0 <= c <= 255 for c in colour):
        raise ParameterError(name, list(colour), 'red, green and blue, whole numbers from 0 to 255')


@dataclass(frozen=True)
class RobotMarker:
    """
    A level plate on top of the body, with a disc at the front and one behind.

    Raises
    ------
    ParameterError
        If a colour is none.
    """

    length: float = 0.50
    """Of the plate, along base_link's x axis [m]."""
    width: float = 0.26
    """Of the plate [m]."""
    height: float = 0.10
    """Of the discs above base_link [m]."""
    disc_radius: float = 0.112
    """[m]"""
    disc_distance: float = 0.25
    """Between the centres of the discs; base_link is below the middle [m]."""
    front_colour: Colour = (30, 80, 230)
    rear_colour: Colour = (250, 210, 0)
    plate_colour: Colour = (250, 250, 250)

    def __post_init__(self) -> None:
        """Check the colours."""
        for name in ('front_colour', 'rear_colour', 'plate_colour'):
            check_colour(name, getattr(self, name))

    @classmethod
    def on(
        cls,
        robot: Robot,
        front_colour: Colour = front_colour,
        rear_colour: Colour = rear_colour,
        plate_colour: Colour = plate_colour,
    ) -> RobotMarker:
        """
        Make the largest marker that a robot's body carries.

        Parameters
        ----------
        robot : Robot
            The robot.
        front_colour, rear_colour, plate_colour : Colour
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
            disc_radius=_SHARE * min(width, length / 2.0) / 2.0,
            disc_distance=length / 2.0,
            front_colour=front_colour,
            rear_colour=rear_colour,
            plate_colour=plate_colour,
        )


@dataclass(frozen=True)
class GoalMarker:
    """
    A large disc on the floor at the goal, and a small one ahead of it.

    Raises
    ------
    ParameterError
        If a colour is none.
    """

    radius: float = 0.15
    """Of the disc whose centre is the goal [m]."""
    heading_radius: float = 0.10
    """Of the disc that shows the heading [m]."""
    heading_distance: float = 0.30
    """From the goal to the centre of the disc that shows the heading [m]."""
    height: float = 0.005
    """Of both above the floor [m]."""
    colour: Colour = (20, 170, 60)
    heading_colour: Colour = (215, 40, 200)

    def __post_init__(self) -> None:
        """Check the colours."""
        for name in ('colour', 'heading_colour'):
            check_colour(name, getattr(self, name))
