"""
``quadwalk demo --robots``: several robots in one world, each to where another one stands.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from quad_common.errors import ParameterError
from quad_common.files.bounded_file import make_folder
from quad_common.maps.map_file import load_map
from quad_common.plan import Plan
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import load_gait
from quad_lab.tools.fleet_maps import spread_places
from quad_lab.topic_walk.viewer_process import PagePlace, invitation
from quad_planner.parameters import PlannerParameters

if TYPE_CHECKING:
    from quad_lab.topic_walk.fleet import FleetNotes, FleetOptions

_SPARE = 0.1
"""Distance that is left to obstacles around the places, beyond the safety distance [m]."""

_MOST = 16
"""Number of robots that a demonstration starts: each has two processes."""


def walk_robots(arguments: argparse.Namespace, page: PagePlace | None, pace: float) -> int:
    """
    Walk several robots; return 0 if all arrived, and none touched anything.

    Parameters
    ----------
    arguments : argparse.Namespace
        Of ``quadwalk demo``.
    page : PagePlace or None
        Where the viewer's page is; None for no viewer.
    pace : float
        Simulated over real time; 0 for as fast as possible.

    Returns
    -------
    int
        Exit code.

    Raises
    ------
    ParameterError
        If there are too few or too many robots, or too little room.
    """
    from quad_lab.topic_walk.fleet import walk_fleet

    options = _options(arguments, page, pace)
    make_folder(arguments.output)
    console = Console(stderr=arguments.json)
    names = ', '.join(f'{name} ({robot.kind})' for name, robot in options.robots.items())
    console.print(f'{names} on {options.map_file.stem}: starting the nodes ...')
    said: dict[str, str] = {}

    def show(notes: FleetNotes) -> None:
        for name, robot in notes.robots.items():
            word = 'arrived' if robot.arrived else (robot.waits[-1] if robot.waits else '')
            if word and said.get(name) != word:
                said[name] = word
                console.print(f'{robot.time:6.1f} s  {name}: {word}', highlight=False)

    def invite(address: str) -> None:
        if page is not None:
            console.print(invitation(address, page), highlight=False)

    notes = walk_fleet(options, show, invite)
    _report(arguments, options, notes, console)
    return 0 if notes.have_arrived and not notes.contacts else 1


def _options(arguments: argparse.Namespace, page: PagePlace | None, pace: float) -> FleetOptions:
    from quad_lab.topic_walk.fleet import FleetOptions, FleetRobot

    kinds = [kind.strip() for kind in arguments.robots.split(',') if kind.strip()]
    if not 2 <= len(kinds) <= _MOST:
        raise ParameterError('--robots', arguments.robots, f'2 to {_MOST} names, with commas')
    map_file: Path = arguments.map or sample_map()
    robots = [load_robot(kind) for kind in kinds]
    for robot in robots:
        load_gait(arguments.gait, robot)
    widest = max(robot.standing_radius for robot in robots)
    clearance = widest + PlannerParameters().safety_distance + _SPARE
    places = spread_places(load_map(map_file), clearance, len(kinds))
    fleet = {
        f'robot{index + 1}': FleetRobot(kind, places[index], places[(index + 1) % len(places)])
        for index, kind in enumerate(kinds)
    }
    return FleetOptions(
        map_file,
        fleet,
        gait=arguments.gait,
        turning=arguments.turning,
        backend=arguments.backend,
        seed=arguments.seed,
        real_time_factor=pace,
        page=page,
    )


def _report(
    arguments: argparse.Namespace, options: FleetOptions, notes: FleetNotes, console: Console
) -> None:
    """Draw the tracks, and say how it went."""
    picture = arguments.output / 'fleet.png'
    _draw(picture, options, notes)
    summary = {
        'map': options.map_file.stem,
        'duration': notes.duration,
        'contacts': notes.contacts,
        'problem': notes.problem,
        'picture': str(picture),
        'robots': {
            name: {'kind': options.robots[name].kind, 'arrived': one.arrived, 'waits': one.waits}
            for name, one in notes.robots.items()
        },
    }
    if arguments.json:
        print(json.dumps(summary), flush=True)
        return
    table = Table('robot', 'kind', 'arrived', 'waited')
    for name, one in notes.robots.items():
        arrived = 'NO' if one.arrived is None else f'at {one.arrived:.1f} s'
        table.add_row(name, options.robots[name].kind, arrived, '; '.join(one.waits))
    console.print(table)
    if notes.problem:
        console.print(notes.problem, highlight=False)
    console.print(f'contacts: {notes.contacts or "none"}; picture: {picture}', highlight=False)


def _draw(picture: Path, options: FleetOptions, notes: FleetNotes) -> None:
    from quad_cli.output.picture import Scene, draw_plans

    first = next(iter(options.robots.values()))
    robot = load_robot(first.kind)
    radius = robot.standing_radius + PlannerParameters().safety_distance
    scene = Scene(load_map(options.map_file), robot, radius, first.start, first.goal)
    draw_plans(picture, scene, {name: Plan(tuple(n.track)) for name, n in notes.robots.items()})
