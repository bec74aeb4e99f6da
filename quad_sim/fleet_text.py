"""
Which robots are in one world, as a user writes it: kinds, names and places.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from quad_common.errors import ParameterError, PlaceTaken, ResourcePathUnwritable
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.entities.spawn_request import ROBOT_NAME
from quad_sim.simulation import check_start, start_from

_VALID = (
    'names or files of robots, as titan_viii, cuhk, a1; or each with a name and a place, as '
    'left=cuhk@1,2,0; right=a1@4,2,3.14'
)

NO_ROBOTS = 'none'
"""Text of a world without robots, into which they may come."""

_SPACING = 0.3
"""Distance that is left between robots that are put somewhere [m]."""

_REACH = 40
"""Rings of places around the first start that are tried."""


@dataclass(frozen=True)
class NamedRobot:
    """One robot of several."""

    kind: str
    """Name of a robot, or path of a robot data file."""
    start: Pose2D | None
    """Where it is to stand; None for wherever there is room."""


def robots_from_text(text: str) -> dict[str, NamedRobot]:
    """
    Read which robots there are.

    Parameters
    ----------
    text : str
        ``kind, kind, ...``, or ``name=kind@x,y,yaw; ...``, where name and place may be missing;
        :data:`NO_ROBOTS` or nothing for none.

    Returns
    -------
    dict of str to NamedRobot
        By their names; those without one are robot1, robot2 and so on, in their order.

    Raises
    ------
    ParameterError
        If the text is nothing like it, or a name is there twice.
    """
    if text.strip() == NO_ROBOTS:
        return {}
    separator = ';' if ';' in text or '@' in text else ','
    robots: dict[str, NamedRobot] = {}
    for number, part in enumerate(filter(None, map(str.strip, text.split(separator))), 1):
        given, equals, rest = part.partition('=')
        name = given.strip() if equals else f'robot{number}'
        kind, at, place = (rest if equals else part).partition('@')
        if not ROBOT_NAME.fullmatch(name) or name in robots or not kind.strip():
            raise ParameterError('robots', text, _VALID)
        robots[name] = NamedRobot(kind.strip(), _pose(place, text) if at else None)
    return robots


def text_from_robots(robots: Mapping[str, NamedRobot]) -> str:
    """
    Write robots so that they can be read again.

    Parameters
    ----------
    robots : mapping of str to NamedRobot
        By their names.

    Raises
    ------
    ResourcePathUnwritable
        If the file of one has a path that cannot be written.
    """
    parts = []
    for name, one in robots.items():
        at = '' if one.start is None else f'@{one.start.x!r},{one.start.y!r},{one.start.yaw!r}'
        parts.append(f'{name}={one.kind}{at}')
        if any(mark in one.kind for mark in ';,@') or one.kind != one.kind.strip():
            raise ResourcePathUnwritable(one.kind)
    return '; '.join(parts) or NO_ROBOTS


def placed(
    robots: Mapping[str, tuple[Robot, Pose2D | None]],
    around: Pose2D,
    grid: OccupancyGrid | None,
    standing: Mapping[str, tuple[Robot, Pose2D]],
) -> dict[str, tuple[Robot, Pose2D]]:
    """
    Find a place for each robot that has none.

    Parameters
    ----------
    robots : mapping of str to tuple of Robot and Pose2D or None
        Robots, and where they are to stand.
    around : Pose2D
        Near to which they are put, with its heading.
    grid : OccupancyGrid or None
        Map whose obstacles are kept clear of.
    standing : mapping of str to tuple of Robot and Pose2D
        Robots that are there already.

    Returns
    -------
    dict of str to tuple of Robot and Pose2D
        Every robot with a place.

    Raises
    ------
    ParameterError
        If there is no room for one.
    """
    taken = dict(standing)
    taken.update((name, (robot, at)) for name, (robot, at) in robots.items() if at is not None)
    made: dict[str, tuple[Robot, Pose2D]] = {}
    for name, (robot, pose) in robots.items():
        made[name] = robot, pose or _free_place(robot, around, grid, taken)
        taken[name] = made[name]
    return made


def check_apart(
    name: str,
    robot: Robot,
    pose: Pose2D,
    others: Mapping[str, tuple[Robot, Pose2D]],
    spacing: float = 0.0,
) -> None:
    """Raise PlaceTaken if a robot would stand nearer to another one than a spacing [m] allows."""
    for other, (body, place) in others.items():
        needed = robot.standing_radius + body.standing_radius + spacing
        if pose.distance_to(place) < needed:
            raise PlaceTaken(name, other, pose.distance_to(place), needed)


def _free_place(
    robot: Robot,
    around: Pose2D,
    grid: OccupancyGrid | None,
    others: Mapping[str, tuple[Robot, Pose2D]],
) -> Pose2D:
    """Find the place nearest to a pose, on rings around it, where nothing is in the way."""
    for ring in range(_REACH):
        count = max(1, 6 * ring)
        for angle in 2.0 * np.pi * np.arange(count) / count:
            reach = ring * _SPACING
            pose = Pose2D(
                float(around.x + reach * np.cos(angle)),
                float(around.y + reach * np.sin(angle)),
                around.yaw,
            )
            if grid is not None and not grid.contains(pose.x, pose.y):
                continue
            try:
                check_apart('', robot, pose, others, _SPACING)
                if grid is not None:
                    check_start(robot, grid, pose)
            except (PlaceTaken, ParameterError):
                continue
            return pose
    raise ParameterError(
        'robots',
        robot.name,
        'given with a place, as name=robot@x,y,yaw: there is no free place around start_pose',
    )


def _pose(text: str, whole: str) -> Pose2D:
    try:
        x, y, yaw = (float(part) for part in text.split(','))
    except ValueError:
        raise ParameterError('robots', whole, _VALID) from None
    return start_from('robots', (x, y, yaw))
