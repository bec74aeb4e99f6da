"""
``quadwalk demo``: walk from a start to a goal over topics, and say how well it went.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table

from quad_cli.arguments import map_argument, pose_argument
from quad_common.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot import load_robot
from quad_planner.parameters import PlannerParameters

EXAMPLES = """examples:
  quadwalk demo
  quadwalk demo --map office --start 1.5,1.5,0 --goal 12,8,90deg
  quadwalk demo --map warehouse.yaml --start 0,0,0 --goal 5,3,1.57 --seed 3 --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        '--map', type=map_argument, default=None, help='Nav2 map file or sample map (room)'
    )
    parser.add_argument(
        '--start', type=pose_argument, default=Pose2D(1.2, 1.2, 0.0), help='x,y,yaw [m, m, rad]'
    )
    parser.add_argument(
        '--goal', type=pose_argument, default=Pose2D(6.8, 4.8, math.pi / 2), help='x,y,yaw'
    )
    parser.add_argument('--seed', type=int, default=0, help="of the sensors' noise")
    parser.add_argument('--robot', default='titan_viii', help='name or data file')
    parser.add_argument(
        '--backend', choices=('bullet', 'kinematic'), default='bullet', help='the simulator'
    )
    parser.add_argument('--safety-distance', type=float, default=None, help='around the feet [m]')
    parser.add_argument(
        '--real-time-factor', type=float, default=0.0, help='0: as fast as possible (default)'
    )
    parser.add_argument('--gui', action='store_true', help="show PyBullet's window")
    parser.add_argument('--output', type=Path, default=Path('demo'), help='folder for the results')
    parser.add_argument('--no-recording', action='store_true', help='do not record the topics')
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if the robot arrived."""
    # Here, so that 'quadwalk --help' and the commands without ROS work where rclpy is absent.
    from quad_cli.walk import WalkOptions, walk
    from quad_cli.walk_observer import WalkObserver

    console = Console(stderr=arguments.json)
    map_file = arguments.map or sample_map()
    output: Path = arguments.output
    recording = None if arguments.no_recording else output / 'recording'
    if recording is not None:
        recording = _recordable(recording, console)
    options = WalkOptions(
        map_file=map_file,
        start=arguments.start,
        goal=arguments.goal,
        robot=arguments.robot,
        backend=arguments.backend,
        safety_distance=arguments.safety_distance,
        seed=arguments.seed,
        real_time_factor=arguments.real_time_factor,
        gui=arguments.gui,
        recording=recording,
    )
    console.print(f'{options.robot} on {map_file.stem}: starting planner, gait and simulator ...')
    columns = (TextColumn('{task.description}'), BarColumn(), TextColumn('{task.fields[state]}'))
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task('walking', total=None, state='')

        def show(observer: WalkObserver) -> None:
            plan, pose = observer.plan, observer.pose
            if plan is None or pose is None:
                return
            record = observer.record
            left = _distance_left(observer)
            simulated = observer.time - (record.times[0] if record.times else observer.time)
            factor = simulated / max(record.wall_time, 1e-6)
            progress.update(
                task,
                total=plan.length,
                completed=max(0.0, plan.length - left),
                state=f'{left:5.2f} m left, {simulated:5.0f} s simulated, {factor:4.1f}x real time',
            )

        record = walk(options, show)
    result = record.result()
    robot = load_robot(options.robot)
    safety = options.safety_distance
    clearance = robot.footprint_radius + (
        PlannerParameters().safety_distance if safety is None else safety
    )
    picture = output / 'walk.png'
    # Imported late: matplotlib takes its time, and the robot should walk meanwhile.
    from quad_cli.picture import draw_walk

    draw_walk(
        picture,
        load_map(map_file),
        robot,
        clearance,
        record.plans[-1] if record.plans else None,
        options.start,
        options.goal,
        record,
        title=f'{options.robot} on {map_file.stem}',
    )
    summary: dict[str, object] = {
        'map': map_file.stem,
        'start': [options.start.x, options.start.y, options.start.yaw],
        'goal': [options.goal.x, options.goal.y, options.goal.yaw],
        'seed': options.seed,
        **result.as_dict(),
        'picture': str(picture),
        'recording': None if recording is None else str(recording),
    }
    (output / 'walk.json').write_text(json.dumps(summary, indent=2) + '\n', encoding='utf-8')
    if arguments.json:
        print(json.dumps(summary))
    else:
        _print_table(console, summary)
    return 0 if result.arrived else 1


def _recordable(recording: Path, console: Console) -> Path | None:
    from quad_cli.recording import can_record

    if can_record():
        return recording
    console.print('no recording: the package rosbags is not installed (pip install rosbags)')
    return None


def _distance_left(observer: object) -> float:
    values = observer.statuses.get('gait_node', (b'', '', {}))[2]  # type: ignore[attr-defined]
    return float(values.get('distance_left', 0.0))


def _print_table(console: Console, summary: dict[str, object]) -> None:
    table = Table(title=f'Walk on {summary["map"]}', show_header=False)
    rows = (
        ('arrived', 'yes' if summary['arrived'] else f'no: {summary["problem"]}', ''),
        ('final position error', summary['position_error'], 'm'),
        ('final heading error', summary['heading_error'], 'deg'),
        ('largest distance from the path', summary['largest_path_distance'], 'm'),
        ('least stability margin, planned', summary['least_stability_margin'], 'm'),
        ('walking time, simulated', summary['walking_time'], 's'),
        ('path', summary['path_length'], 'm'),
        ('turning points', summary['turning_points'], ''),
        ('gait cycles', summary['cycles'], ''),
        ('contacts other than feet on the ground', summary['contacts'] or 'none', ''),
        ('fallen', 'yes' if summary['fallen'] else 'no', ''),
        ('speed', summary['real_time_factor'], 'x real time'),
    )
    for name, value, unit in rows:
        table.add_row(name, _cell(value), unit)
    console.print(table)
    console.print(f'picture:   {summary["picture"]}', highlight=False)
    if summary['recording'] is not None:
        console.print(f'recording: {summary["recording"]}', highlight=False)


def _cell(value: object) -> str:
    if value is None:
        return 'not measured'
    return f'{value:.3f}' if isinstance(value, float) else str(value)
