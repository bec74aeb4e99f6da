"""
``quadwalk demo``: walk from a start to a goal over topics, and say how well it went.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape

from quad_cli.arguments import (
    folder_argument,
    map_argument,
    parameter_argument,
    pose_argument,
    quantity_argument,
    seed_argument,
)
from quad_cli.fleet.fleet_demo import walk_robots
from quad_cli.output.walk_table import print_walk
from quad_cli.view import add_page_arguments, page_place
from quad_common.errors import GoalOutsideMap, StartOutsideMap
from quad_common.files.bounded_file import make_folder
from quad_common.files.whole_file import write_text
from quad_common.maps.map_file import load_map
from quad_common.named_robots.robot_cache import assumptions, is_kept
from quad_common.planar_pose import Pose2D
from quad_common.quantity import Quantity
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot, robot_file
from quad_gait.cycle.gait import load_gait
from quad_gait.following.follower_options import TURNINGS
from quad_lab.topic_walk.viewer_process import invitation
from quad_planner.parameters import PLANNING_METHODS, PlannerParameters
from quad_sim.engines.registry import AUTO, BACKENDS
from quad_sim.world.terrain_spec import specs_from_text

if TYPE_CHECKING:
    from quad_lab.topic_walk.walk import WalkOptions
    from quad_lab.topic_walk.walk_record import WalkRecord

EXAMPLES = """examples:
  quadwalk demo
  quadwalk demo --map office --start 1.5,1.5,0 --goal 12,8,90deg
  quadwalk demo --robot cuhk --gait trot --turning arc
  quadwalk demo --view
  quadwalk demo --method quickest
  quadwalk demo --perception camera
  quadwalk demo --robots titan_viii,cuhk,a1 --gait trot --view
  quadwalk demo --terrain noise+boxes:height=0.03 --seed 2
  quadwalk demo --map warehouse.yaml --start 0,0,0 --goal 5,3,1.57 --seed 3 --json
"""


_WATCHABLE = 4.0
"""Simulated over real time of a walk that is looked at."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        '--map', type=map_argument, default=None, help='Nav2 map file or sample map (room)'
    )
    _add_pose_arguments(parser)
    parser.add_argument('--seed', type=seed_argument, default=0, help="seed of the sensors' noise")
    parser.add_argument(
        '--robot', default='titan_viii', help='name of a robot, or path of a data file'
    )
    parser.add_argument(
        '--robots',
        help='several robots in one world, with commas: each walks to where the next one stands',
    )
    parser.add_argument('--gait', default='crawl', help='name of a gait, or path of a gait file')
    parser.add_argument(
        '--method',
        choices=PLANNING_METHODS,
        default='mesh',
        help='planning method; shortest and quickest take any angle',
    )
    parser.add_argument(
        '--turning',
        choices=TURNINGS,
        default='in_place',
        help='how the robot turns at turning points',
    )
    parser.add_argument(
        '--balance',
        action='store_true',
        help='keep the balance at every measurement, in gaits such as the trot',
    )
    parser.add_argument('--backend', choices=BACKENDS, default=AUTO, help='the simulator')
    parser.add_argument(
        '--terrain',
        default='flat',
        help='ground: bumps, slope, cross_slope, kerb, noise, boxes, stairs, stones, gap, beam; '
        'several with +; or a file',
    )
    parser.add_argument(
        '--perception',
        choices=('truth', 'camera'),
        default='truth',
        help='source of map, goal and pose: the simulator, or its ceiling camera alone',
    )
    _add_pace_arguments(parser)
    _add_result_arguments(parser)


def _add_pace_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how near to things, how fast and in how many processes it walks."""
    parser.add_argument(
        '--safety-distance',
        type=parameter_argument(PlannerParameters, 'safety_distance'),
        default=None,
        help='distance kept free around the feet [m]',
    )
    parser.add_argument(
        '--real-time-factor',
        type=quantity_argument('real_time_factor', Quantity(0.0, 1000.0)),
        default=None,
        help='simulated over real time; 0: as fast as possible (default; with --view it is 4)',
    )
    parser.add_argument(
        '--composed',
        action='store_true',
        help='all nodes in one process, in step: the walk repeats bit for bit',
    )


def _add_result_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where the walk is seen and kept."""
    parser.add_argument('--gui', action='store_true', help="show the physics engine's own window")
    parser.add_argument(
        '--view',
        action='store_true',
        help='show the walk on a page in the browser; afterwards a click walks on, Ctrl-C ends',
    )
    add_page_arguments(parser)
    parser.add_argument(
        '--output', type=folder_argument, default=Path('demo'), help='folder for the results'
    )
    parser.add_argument('--no-recording', action='store_true', help='do not record the topics')
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def _add_pose_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        '--start',
        type=pose_argument,
        default=Pose2D(1.2, 1.2, 0.0),
        help='x,y,yaw [m, m, rad or 90deg]',
    )
    parser.add_argument(
        '--goal',
        type=pose_argument,
        default=Pose2D(6.8, 4.8, math.pi / 2),
        help='x,y,yaw [m, m, rad or 90deg]',
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if the robot arrived."""
    if arguments.robots is not None:
        page = page_place(arguments) if arguments.view else None
        return walk_robots(arguments, page, _real_time_factor(arguments))
    _check(arguments)
    return _walk(arguments)


def _walk(arguments: argparse.Namespace) -> int:
    """Walk, draw and say how it went; return 0 if the robot arrived."""
    # Here, so that 'quadwalk --help' and the commands without ROS work where rclpy is absent.
    from quad_cli.output.progress import walk_progress
    from quad_lab.topic_walk.walk import WalkOptions, walk

    console = Console(stderr=arguments.json)
    output: Path = arguments.output
    options = WalkOptions(
        map_file=arguments.map or sample_map(),
        start=arguments.start,
        goal=arguments.goal,
        robot=arguments.robot,
        method=arguments.method,
        gait=arguments.gait,
        turning=arguments.turning,
        balance=arguments.balance,
        backend=arguments.backend,
        terrain=arguments.terrain,
        perception=arguments.perception,
        safety_distance=arguments.safety_distance,
        seed=arguments.seed,
        real_time_factor=_real_time_factor(arguments),
        gui=arguments.gui,
        composed=arguments.composed,
        recording=None if arguments.no_recording else _recording(output, console),
        page=page_place(arguments) if arguments.view else None,
    )
    name = options.map_file.stem
    if is_kept(file := robot_file(options.robot)):
        console.print(f'{options.robot} is imported, and kept as {file}', highlight=False)
        for sentence in assumptions(file):
            console.print(f'assumed: {escape(sentence)}', highlight=False)
    console.print(f'{options.robot} on {name}: starting planner, gait and simulator ...')
    with contextlib.ExitStack() as bar:
        show = bar.enter_context(walk_progress(console))

        def stay(record: WalkRecord, go_on: Callable[[], None]) -> None:
            bar.close()
            if options.page is None:
                return
            _report(arguments, options, record, console)
            console.print('The robot stays: a click on the floor is a goal. Ctrl-C ends.')
            while True:
                go_on()

        record = walk(options, show, partial(_invite, console, options), stay)
    # The recording is complete only now.
    _report(arguments, options, record, console)
    return 0 if record.result().arrived else 1


def _real_time_factor(arguments: argparse.Namespace) -> float:
    """Return the pace that was asked for, or one at which a walk can be watched."""
    if arguments.real_time_factor is not None:
        return float(arguments.real_time_factor)
    return _WATCHABLE if arguments.view else 0.0


def _invite(console: Console, options: WalkOptions, address: str) -> None:
    """Say how to open the page."""
    assert options.page is not None
    console.print(invitation(address, options.page), highlight=False)


def _report(
    arguments: argparse.Namespace, options: WalkOptions, record: WalkRecord, console: Console
) -> None:
    """Draw the walk, and say how it went."""
    output: Path = arguments.output
    result = record.result()
    picture = output / 'walk.png'
    _draw(picture, options, record)
    summary: dict[str, object] = {
        'map': options.map_file.stem,
        'start': [options.start.x, options.start.y, options.start.yaw],
        'goal': [options.goal.x, options.goal.y, options.goal.yaw],
        'seed': options.seed,
        **result.as_dict(),
        'picture': str(picture),
        'recording': _existing(options.recording),
    }
    write_text(output / 'walk.json', json.dumps(summary, indent=2) + '\n')
    if arguments.json:
        print(json.dumps(summary), flush=True)
    else:
        print_walk(console, summary)


def _check(arguments: argparse.Namespace) -> None:
    """Refuse what no node could use, before any of them is started."""
    load_gait(arguments.gait, load_robot(arguments.robot))
    specs_from_text(arguments.terrain)
    grid = load_map(arguments.map or sample_map())
    for pose, error in ((arguments.start, StartOutsideMap), (arguments.goal, GoalOutsideMap)):
        if not grid.contains(pose.x, pose.y):
            raise error(pose.x, pose.y, grid.bounds())
    make_folder(arguments.output)


def _draw(picture: Path, options: WalkOptions, record: WalkRecord) -> None:
    # Imported late: matplotlib takes its time, and the robot should walk meanwhile.
    from quad_cli.output.picture import Scene, draw_walk

    robot = load_robot(options.robot)
    safety = options.safety_distance
    if safety is None:
        safety = PlannerParameters().safety_distance
    scene = Scene(
        load_map(options.map_file),
        robot,
        robot.standing_radius + safety,
        options.start,
        options.goal,
        record.height_map,
    )
    draw_walk(picture, scene, record, f'{options.robot} on {options.map_file.stem}')


def _recording(output: Path, console: Console) -> Path | None:
    from quad_lab.recordings.recording import can_record

    if can_record():
        return output / 'recording'
    console.print('no recording: the package rosbags is not installed (pip install rosbags)')
    return None


def _existing(recording: Path | None) -> str | None:
    """Return where a recording is; None if there is none, or nothing was received for it."""
    return None if recording is None or not recording.is_dir() else str(recording)
