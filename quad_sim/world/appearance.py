"""
What the simulated world looks like.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from quad_common.errors import ParameterError
from quad_common.vision.markers import (
    OBSTACLE_COLOR,
    Color,
    GoalMarker,
    RobotMarker,
    check_color,
)

LIGHT_FROM = (2.0, -1.0, 4.0)
"""Direction to the light, in the world. The shadows that it would cast are left out."""

AMBIENT = 0.6
"""Light that comes from everywhere: the brightness of faces that the lamp does not reach."""

SQUARE_SHADE = 0.85
"""Brightness of the darker squares of a pattern on the floor, of the lighter ones'."""


@dataclass(frozen=True)
class Appearance:
    """
    Colors and markers.

    Raises
    ------
    ParameterError
        If a color is none.
    """

    floor_color: Color = (205, 205, 200)
    obstacle_color: Color = OBSTACLE_COLOR
    """Color of walls and of obstacles that have none of their own."""
    robot_color: Color = (70, 72, 76)
    """Color of body and legs."""
    checker_size: float = 0.0
    """Side of the squares of a pattern on the floor; 0: the floor is plain [m]."""
    robot_marker: RobotMarker | None = None
    """The one that suits the robot's body if None."""
    goal_marker: GoalMarker = field(default_factory=GoalMarker)

    def __post_init__(self) -> None:
        """Check the colors."""
        for name in ('floor_color', 'obstacle_color', 'robot_color'):
            check_color(name, getattr(self, name))
        if not 0.0 <= self.checker_size < 100.0:
            raise ParameterError('checker_size', self.checker_size, 'from 0 to 100 m')
