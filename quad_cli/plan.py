"""
``quadwalk plan``: plan on a map without ROS, print the turning points, draw them.

Several methods are compared: lengths, walking times, and all of them in one picture.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import threading
import time
from dataclasses import dataclass, replace
from typing import Any

from quad_cli.arguments import (
    add_parameter,
    drawing_argument,
    input_argument,
    map_argument,
    pose_argument,
)
from quad_common.errors import ParameterError, PlannerError
from quad_common.maps.height_map_file import load_height_map
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.walking_time import WalkingTimeModel, load_pace
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.traversability import Ground
from quad_planner.methods.outline_planner import OutlineOptions
from quad_planner.methods.planner import METHODS, Planner
from quad_planner.methods.potential_planner import POTENTIALS
from quad_planner.outline.arcs import ArcTurns
from quad_planner.parameters import FOOTPRINTS, LOW_OBSTACLES, TURNINGS, PlannerParameters
from quad_planner.planner_setup import outline_for, planner_for, start_tolerance

EXAMPLES = """examples:
  quadwalk plan --start 1.2,1.2,0 --goal 6.8,4.8,90deg --picture plan.png
  quadwalk plan --map warehouse.yaml --start 0,0,0 --goal 5,3,0 --json
  quadwalk plan --method potential --start 1.2,1.2,0 --goal 6.8,4.8,0
  quadwalk plan --map room.yaml --height-map hills.yaml --start 1,1,0 --goal 5,3,0 --picture p.png
  quadwalk plan --robot a1 --footprint outline --map office.yaml --start 1,1,0 --goal 5,3,0
  quadwalk plan --method mesh shortest quickest --any-angle --start 1.2,1.2,0 --goal 6.8,4.8,0
"""


_LONG = 2.0
"""Compiled code that is there is ready sooner [s]."""

_COMPILING = 'compiling the searches: once after an installation, for up to ten seconds ...'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        '--map', type=map_argument, default=None, help='Nav2 map file or sample map (room)'
    )
    parser.add_argument(
        '--height-map',
        type=input_argument,
        default=None,
        help='height map file of the ground under the map',
    )
    add_parameter(
        parser,
        PlannerParameters,
        'step_height',
        "height of steps above which they are walked around; 0: the robot's own [m]",
    )
    add_parameter(
        parser,
        PlannerParameters,
        'largest_slope',
        'slope above which ground is walked around [rad]',
    )
    parser.add_argument(
        '--low-obstacles',
        choices=LOW_OBSTACLES,
        default=PlannerParameters().low_obstacles,
        help='what becomes of obstacles that the height map shows to be low',
    )
    pose = 'x,y,yaw [m, m, rad or 90deg]'
    parser.add_argument('--start', type=pose_argument, required=True, help=pose)
    parser.add_argument('--goal', type=pose_argument, required=True, help=pose)
    _add_method_arguments(parser)
    parser.add_argument(
        '--robot', default='titan_viii', help='name of a robot, or path of a data file'
    )
    parser.add_argument(
        '--gait',
        default=PlannerParameters().gait,
        help='gait whose cycles are counted: crawl, wave, trot, walk',
    )
    add_parameter(
        parser, PlannerParameters, 'safety_distance', 'distance kept free around the feet [m]'
    )
    parser.add_argument(
        '--footprint',
        choices=FOOTPRINTS,
        default=PlannerParameters().footprint,
        help="what keeps that distance: the circle around the feet, or also the robot's outline",
    )
    parser.add_argument(
        '--turning',
        choices=TURNINGS,
        default=PlannerParameters().turning,
        help='how the gait follows the plan, for footprint outline',
    )
    parser.add_argument(
        '--picture', type=drawing_argument, default=None, help='picture of the plans to write'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def _add_method_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--method',
        choices=sorted(METHODS),
        nargs='+',
        default=['mesh'],
        help='planning method, or several to compare',
    )
    parser.add_argument(
        '--any-angle',
        action='store_true',
        help="let paths of 'shortest' and 'quickest' have any direction",
    )
    parser.add_argument(
        '--potential',
        choices=POTENTIALS,
        default=PlannerParameters().potential,
        help="potential that 'potential' descends",
    )
    add_parameter(
        parser,
        PlannerParameters,
        'path_deviation',
        "how far a path of 'potential' may be from the descent [m]",
    )


@dataclass(frozen=True)
class _PlanOutcome:
    """What a method made of the request."""

    method: str
    plan: Plan | None
    """None if there is none."""
    error: PlannerError | None
    preparation_time: float
    """[s]"""
    search_time: float
    """[s]"""


def run(arguments: argparse.Namespace) -> int:
    """Run the command; a plan that cannot be made is an error, or a line of the comparison."""
    robot = load_robot(arguments.robot)
    of_map = grid = load_map(arguments.map or sample_map())
    ground = _ground(arguments, robot)
    if ground is not None:
        grid = ground.added_to(of_map, steps_over_low=arguments.low_obstacles == 'step_over')
    methods = list(dict.fromkeys(arguments.method))
    pace = _pace(arguments.robot, arguments.gait, is_needed='quickest' in methods)
    clearance = robot.standing_radius + arguments.safety_distance
    outline = _outline(arguments, robot, pace)
    outcomes = []
    for method in methods:
        planner = planner_for(
            robot,
            method,
            arguments.safety_distance,
            any_angle=arguments.any_angle,
            potential=arguments.potential,
            path_deviation=arguments.path_deviation,
            pace=pace,
            start_tolerance=start_tolerance(arguments.safety_distance, pace),
            outline=outline,
        )
        outcome = _attempt(method, planner, grid, arguments.start, arguments.goal)
        if outcome.error is not None and len(methods) == 1:
            raise outcome.error
        outcomes.append(outcome)
    if arguments.json:
        described = [_described(outcome, arguments.start, pace) for outcome in outcomes]
        print(json.dumps(described[0] if len(methods) == 1 else {'plans': described}))
    elif len(methods) == 1:
        _print_plan(outcomes[0], arguments.start, pace)
    else:
        _print_comparison(outcomes, arguments.start, pace)
    if arguments.picture is not None:
        # Imported late: matplotlib is slow to import.
        from quad_cli.output.picture import Scene, draw_plans

        plans = {outcome.method: outcome.plan for outcome in outcomes if outcome.plan is not None}
        scene = Scene(grid, robot, clearance, arguments.start, arguments.goal)
        if outline is not None:
            scene = replace(scene, outline=outline.outline)
        if ground is not None:
            scene = replace(scene, heights=ground.heights, level_grid=of_map)
        draw_plans(arguments.picture, scene, plans)
    return 1 if any(outcome.plan is None for outcome in outcomes) else 0


def _outline(
    arguments: argparse.Namespace, robot: Robot, pace: WalkingTimeModel | None
) -> OutlineOptions | None:
    """Return the robot's outline if it is planned for."""
    if arguments.footprint == 'circle':
        return None
    return outline_for(
        robot,
        arguments.safety_distance,
        start_tolerance=start_tolerance(arguments.safety_distance, pace),
        keeps_heading=arguments.turning == 'crab',
        arcs=ArcTurns() if arguments.turning == 'arc' else None,
        pace=pace,
    )


def _ground(arguments: argparse.Namespace, robot: Robot) -> Ground | None:
    """Read the ground; None if there is no height map."""
    if arguments.height_map is None:
        return None
    limits = GroundLimits.of(robot, arguments.step_height, arguments.largest_slope)
    return Ground(load_height_map(arguments.height_map), limits)


def _pace(robot: str, gait: str, is_needed: bool) -> WalkingTimeModel | None:
    """Load the pace, which only some methods cannot do without."""
    try:
        return load_pace(robot, gait)
    except ParameterError:
        if is_needed:
            raise
        return None


def _attempt(
    method: str, planner: Planner[Any], grid: OccupancyGrid, start: Pose2D, goal: Pose2D
) -> _PlanOutcome:
    patience = threading.Timer(_LONG, lambda: print(_COMPILING, file=sys.stderr, flush=True))
    patience.daemon = True
    patience.start()
    planner.warm_up()
    patience.cancel()
    began = time.perf_counter()
    planner.set_map(grid)
    prepared = time.perf_counter()
    plan, error = None, None
    try:
        plan = planner.plan(start, goal)
    except PlannerError as problem:
        error = problem
    done = time.perf_counter()
    return _PlanOutcome(method, plan, error, prepared - began, done - prepared)


def _described(
    outcome: _PlanOutcome, start: Pose2D, pace: WalkingTimeModel | None
) -> dict[str, object]:
    if outcome.plan is None:
        return {'method': outcome.method, 'error': str(outcome.error)}
    plan = outcome.plan
    described: dict[str, object] = {
        'method': outcome.method,
        'length': plan.length,
        'poses': [[pose.x, pose.y, pose.yaw] for pose in plan.poses],
        'preparation_time': outcome.preparation_time,
        'search_time': outcome.search_time,
    }
    if plan.remark:
        described['remark'] = plan.remark
    if pace is not None:
        described['cycles'] = pace.cycles(start, plan)
        described['walking_time'] = pace.walking_time(start, plan)
    return described


def _print_plan(outcome: _PlanOutcome, start: Pose2D, pace: WalkingTimeModel | None) -> None:
    plan = outcome.plan
    assert plan is not None
    walking = '' if pace is None else f', {pace.walking_time(start, plan):.0f} s of walking'
    print(f'{plan.length:.2f} m, {len(plan.poses)} turning points{walking}:')
    for pose in plan.poses:
        print(f'  {pose.x:8.3f} {pose.y:8.3f} m   {math.degrees(pose.yaw):7.1f} deg')
    if plan.remark:
        print(plan.remark)
    print(
        f'{outcome.preparation_time:.3f} s to prepare the map, '
        f'{outcome.search_time:.3f} s to search it'
    )


def _print_comparison(
    outcomes: list[_PlanOutcome], start: Pose2D, pace: WalkingTimeModel | None
) -> None:
    # Imported late: a single plan is printed without.
    from rich.console import Console
    from rich.table import Table

    table = Table('method', 'length', 'turning points', 'gait cycles', 'walking', 'search')
    for outcome in outcomes:
        plan = outcome.plan
        if plan is None:
            table.add_row(outcome.method, str(outcome.error))
            continue
        table.add_row(
            outcome.method,
            f'{plan.length:.2f} m',
            str(len(plan.poses)),
            '' if pace is None else str(pace.cycles(start, plan)),
            '' if pace is None else f'{pace.walking_time(start, plan):.0f} s',
            f'{1e3 * outcome.search_time:.1f} ms',
        )
    Console().print(table)
