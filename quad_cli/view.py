"""
``quadwalk view``: robots on a page in the browser, where a click on the floor lets them walk.
"""

from __future__ import annotations

import argparse
import contextlib
import importlib
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from quad_cli.arguments import count_argument, map_argument, pose_argument, quantity_argument
from quad_common.errors import ParameterError, StartOutsideMap
from quad_common.maps.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.quantity import Quantity
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import load_gait
from quad_gait.following.follower_options import TURNINGS
from quad_lab.topic_walk.viewer_process import PagePlace, invitation, start_viewer
from quad_planner.parameters import PLANNING_METHODS
from quad_sim.engines.registry import AUTO, BACKENDS
from quad_view.parameters import ViewerParameters

EXAMPLES = """examples:
  quadwalk view
  quadwalk view --robot genibo --gait trot --turning arc
  quadwalk view --map office --start 1.5,1.5,0
  quadwalk view --robots 2
  quadwalk view --attach                 # nothing but the page, for nodes that run already
  quadwalk view --host 0.0.0.0           # for the whole network: whoever comes can steer
"""

_LOOK_PERIOD = 0.5
"""Between two looks whether the nodes run [s]."""

_MOST_ROBOTS = 4

_BESIDE = 1.4
"""Distance between the starts of two robots [m]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        '--attach', action='store_true', help='show what runs already, and start nothing else'
    )
    parser.add_argument(
        '--map', type=map_argument, default=None, help='Nav2 map file or sample map (room)'
    )
    parser.add_argument(
        '--start',
        type=pose_argument,
        default=Pose2D(1.2, 1.2, 0.0),
        help='x,y,yaw [m, m, rad or 90deg]',
    )
    parser.add_argument(
        '--robot', default='titan_viii', help='name of a robot, or path of a data file'
    )
    parser.add_argument(
        '--robots', type=count_argument, default=1, help='how many, each in a namespace of its own'
    )
    parser.add_argument('--gait', default='crawl', help='name of a gait, or path of a gait file')
    parser.add_argument('--method', choices=PLANNING_METHODS, default='mesh')
    parser.add_argument('--turning', choices=TURNINGS, default='in_place')
    parser.add_argument('--backend', choices=BACKENDS, default=AUTO, help='the simulator')
    parser.add_argument(
        '--real-time-factor',
        type=quantity_argument('real_time_factor', Quantity(0.0, 1000.0)),
        default=1.0,
        help='simulated over real time; 0: as fast as possible (default 1)',
    )
    add_page_arguments(parser)


def add_page_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where the page is."""
    default = ViewerParameters()
    parser.add_argument(
        '--host', default=default.host, help='address of the page; others than this machine steer!'
    )
    parser.add_argument(
        '--port',
        type=count_argument,
        default=default.port,
        help='port of the page, or the next free one',
    )


def page_place(arguments: argparse.Namespace) -> PagePlace:
    """Return where the page is to be; ParameterError if there is no such port."""
    if not 0 <= arguments.port <= 65535:
        raise ParameterError('--port', arguments.port, 'a whole number from 0 to 65535')
    return PagePlace(arguments.host, arguments.port)


def run(arguments: argparse.Namespace) -> int:
    """Run the command until it is interrupted, or a node ends."""
    place = page_place(arguments)
    return _show(arguments, place, () if arguments.attach else _starts(arguments))


def _show(arguments: argparse.Namespace, place: PagePlace, starts: Sequence[Pose2D]) -> int:
    """Start a robot at each place, if any, and the page."""
    # Here, so that 'quadwalk --help' works where rclpy is absent; which is said before a node is
    # started that would end without it.
    importlib.import_module('rclpy')
    from quad_lab.topic_walk.node_processes import NodeProcesses, isolated_domain

    console = Console()
    with contextlib.ExitStack() as stack:
        groups = [stack.enter_context(NodeProcesses())] if arguments.attach else []
        if not arguments.attach:
            stack.enter_context(isolated_domain())
            for number, start in enumerate(starts, start=1):
                namespace = f'robot{number}' if len(starts) > 1 else ''
                groups.append(stack.enter_context(NodeProcesses(namespace)))
                is_only, is_first = len(starts) == 1, number == 1
                _start_robot(groups[-1], arguments, start, is_only, is_first)
        viewer = stack.enter_context(NodeProcesses())
        console.print(invitation(start_viewer(viewer, place), place), highlight=False)
        console.print('A click on the floor is a goal. Ctrl-C ends.')
        while True:
            time.sleep(_LOOK_PERIOD)
            for nodes in (*groups, viewer):
                nodes.check()


def _starts(arguments: argparse.Namespace) -> list[Pose2D]:
    """Return where each robot starts: on the map, beside one another; refuse what cannot be."""
    if arguments.robots > _MOST_ROBOTS:
        raise ParameterError('--robots', arguments.robots, f'from 1 to {_MOST_ROBOTS}')
    load_gait(arguments.gait, load_robot(arguments.robot))
    grid = load_map(arguments.map or sample_map())
    starts = [
        arguments.start @ Pose2D(0.0, number * _BESIDE, 0.0) for number in range(arguments.robots)
    ]
    for pose in starts:
        if not grid.contains(pose.x, pose.y):
            raise StartOutsideMap(pose.x, pose.y, grid.bounds())
    return starts


def _start_robot(
    nodes: object, arguments: argparse.Namespace, start: Pose2D, is_only: bool, is_first: bool
) -> None:
    from quad_lab.topic_walk.node_processes import NodeProcesses

    assert isinstance(nodes, NodeProcesses)
    map_file: Path = arguments.map or sample_map()
    # Several simulators make several times: then each robot goes by its measurements' alone.
    clock: dict[str, object] = {} if is_only else {'use_sim_time': False}
    nodes.start(
        'sim_node',
        robot=arguments.robot,
        map_file=str(map_file.resolve()),
        start_pose=[start.x, start.y, start.yaw],
        real_time_factor=float(arguments.real_time_factor),
        backend=arguments.backend,
        publish_clock=is_first,
    )
    nodes.start(
        'planner_node',
        robot=arguments.robot,
        method=arguments.method,
        any_angle=True,
        gait=arguments.gait,
        **clock,
    )
    nodes.start(
        'gait_node',
        robot=arguments.robot,
        gait=arguments.gait,
        turning=arguments.turning,
        **clock,
    )
