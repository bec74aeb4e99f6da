"""
``quadwalk plan``: plan on a map without ROS, print the turning points, draw them.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from pathlib import Path

from quad_cli.arguments import map_argument, pose_argument
from quad_common.map_file import load_map
from quad_common.resources import sample_map
from quad_common.robot import load_robot
from quad_planner.parameters import PlannerParameters
from quad_planner.planner import METHODS, make_planner

EXAMPLES = """examples:
  quadwalk plan --start 1.2,1.2,0 --goal 6.8,4.8,90deg --picture plan.png
  quadwalk plan --map warehouse.yaml --start 0,0,0 --goal 5,3,0 --json
  quadwalk plan --method shortest --any-angle --start 1.2,1.2,0 --goal 6.8,4.8,0
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        '--map', type=map_argument, default=None, help='Nav2 map file or sample map (room)'
    )
    parser.add_argument('--start', type=pose_argument, required=True, help='x,y,yaw [m, m, rad]')
    parser.add_argument('--goal', type=pose_argument, required=True, help='x,y,yaw')
    parser.add_argument('--method', choices=sorted(METHODS), default='mesh')
    parser.add_argument(
        '--any-angle', action='store_true', help="let paths of 'shortest' have any direction"
    )
    parser.add_argument('--robot', default='titan_viii', help='name or data file')
    parser.add_argument(
        '--safety-distance',
        type=float,
        default=PlannerParameters().safety_distance,
        help='kept free around the feet [m]',
    )
    parser.add_argument('--picture', type=Path, default=None, help='where to draw the plan')
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; a plan that cannot be made is an error."""
    robot = load_robot(arguments.robot)
    grid = load_map(arguments.map or sample_map())
    clearance = robot.footprint_radius + arguments.safety_distance
    planner = make_planner(
        arguments.method,
        mesh_size=robot.mesh_size,
        clearance_radius=clearance,
        any_angle=arguments.any_angle,
    )
    began = time.perf_counter()
    planner.set_map(grid)
    prepared = time.perf_counter()
    plan = planner.plan(arguments.start, arguments.goal)
    done = time.perf_counter()
    if arguments.json:
        print(
            json.dumps(
                {
                    'method': arguments.method,
                    'length': plan.length,
                    'poses': [[pose.x, pose.y, pose.yaw] for pose in plan.poses],
                    'preparation_time': prepared - began,
                    'search_time': done - prepared,
                }
            )
        )
    else:
        print(f'{plan.length:.2f} m, {len(plan.poses)} turning points:')
        for pose in plan.poses:
            print(f'  {pose.x:8.3f} {pose.y:8.3f} m   {math.degrees(pose.yaw):7.1f} deg')
        print(f'{prepared - began:.3f} s to prepare the map, {done - prepared:.3f} s to search it')
    if arguments.picture is not None:
        # Imported late: matplotlib is slow to import.
        from quad_cli.picture import draw_walk

        draw_walk(arguments.picture, grid, robot, clearance, plan, arguments.start, arguments.goal)
    return 0
