"""
What is known beforehand of the things in a room that a camera looks at.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from quad_common.errors import ParameterError
from quad_common.robot.robot import Robot
from quad_common.vision.markers import OBSTACLE_COLOR, Color, GoalMarker, RobotMarker
from quad_perception.picture.color_segmentation import ColorRange
from quad_perception.picture.marker_poses import MarkerShape

OBSTACLE, FLOOR = 'obstacle', 'floor'
"""Names of ranges, besides those of the markers."""

_AROUND_FEET = 0.15
"""That the robot has to itself, beyond the circle of its feet [m]."""


def default_ranges(
    obstacle: Color = OBSTACLE_COLOR,
    robot: RobotMarker | None = None,
    goal: GoalMarker | None = None,
) -> tuple[ColorRange, ...]:
    """
    Make the ranges for a gray or white floor and things of known colors.

    Parameters
    ----------
    obstacle : tuple of int
        Red, green and blue of obstacles, 0 to 255.
    robot, goal : RobotMarker and GoalMarker, optional
        The markers; those with their usual colors if not given.

    Returns
    -------
    tuple of ColorRange
        ``obstacle``, ``floor``, ``robot_front``, ``robot_rear``, ``goal`` and ``goal_heading``.
    """
    robot = robot or RobotMarker()
    goal = goal or GoalMarker()
    return (
        ColorRange.around(OBSTACLE, obstacle),
        ColorRange(FLOOR, (0.0, 0.0, 0.15), (360.0, 0.25, 1.0)),
        ColorRange.around('robot_front', robot.front_color),
        ColorRange.around('robot_rear', robot.rear_color),
        ColorRange.around('goal', goal.color),
        ColorRange.around('goal_heading', goal.heading_color),
    )


def _usual_robot() -> MarkerShape:
    return MarkerShape.of_robot(RobotMarker(), base_height=0.24)


def _usual_goal() -> MarkerShape:
    return MarkerShape.of_goal(GoalMarker())


@dataclass(frozen=True)
class SceneModel:
    """
    Colors, markers and sizes of what a camera looks for.

    Raises
    ------
    ParameterError
        If the range of a color is missing, or the robot's radius is not valid.
    """

    ranges: Sequence[ColorRange] = field(default_factory=default_ranges)
    """Color ranges with the names of :func:`default_ranges`."""
    robot: MarkerShape = field(default_factory=_usual_robot)
    """Marker on the robot's back."""
    goal: MarkerShape = field(default_factory=_usual_goal)
    """Marker at the goal."""
    robot_radius: float = 0.6
    """Radius of the circle around base_link that the robot, with its legs, never leaves [m]."""
    largest_height: float = 1.2
    """Largest height of obstacles [m]."""
    assumed_height: float = 0.6
    """Height of obstacles whose sides are not seen [m]."""

    def __post_init__(self) -> None:
        """Check the ranges and the radius."""
        names = {color.name for color in self.ranges}
        discs = [disc.color for m in (self.robot, self.goal) for disc in (m.rear, m.front)]
        missing = {OBSTACLE, FLOOR, *discs} - names
        if missing:
            raise ParameterError(
                'ranges', sorted(names), f'with those for {", ".join(sorted(missing))} too'
            )
        if not 0.0 <= self.robot_radius < math.inf:
            raise ParameterError('robot_radius', self.robot_radius, 'a finite number of at least 0')

    @classmethod
    def of_robot(
        cls,
        robot: Robot,
        ranges: Sequence[ColorRange] | None = None,
        robot_marker: RobotMarker | None = None,
        goal_marker: GoalMarker | None = None,
    ) -> SceneModel:
        """
        Describe a room with a robot that stands at its height, and carries a marker of its size.

        Parameters
        ----------
        robot : Robot
            The robot.
        ranges : sequence of ColorRange, optional
            Those of the markers with obstacles of the usual color if not given.
        robot_marker, goal_marker : optional
            The markers; with their usual colors if not given.

        Returns
        -------
        SceneModel
            With the usual heights of obstacles.
        """
        robot_marker = robot_marker or RobotMarker.on(robot)
        goal_marker = goal_marker or GoalMarker()
        return cls(
            default_ranges(robot=robot_marker, goal=goal_marker) if ranges is None else ranges,
            MarkerShape.of_robot(robot_marker, robot.standing_height),
            MarkerShape.of_goal(goal_marker),
            robot.standing_radius + _AROUND_FEET,
        )
