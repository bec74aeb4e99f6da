"""
One walk over topics: starts the nodes, gives the goal, watches until it ends.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from quad_common.errors import QuadError
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import MAX_CELLS, OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.guided_end import GuidedEnd
from quad_lab.topic_walk.node_processes import NodeProcesses, isolated_domain, subnet_domain
from quad_lab.topic_walk.standstill import STALL_TIMEOUT, Standstill, TimeStandsStill
from quad_lab.topic_walk.viewer_process import PagePlace, start_viewer
from quad_lab.topic_walk.walk_observer import WalkObserver
from quad_lab.topic_walk.walk_record import WalkRecord
from quad_sim.engines.registry import AUTO
from quad_sim.world.terrain_spec import needs_footholds

if TYPE_CHECKING:
    from quad_lab.recordings.robot_recording import RobotRecording
    from quad_lab.topic_walk.composed_nodes import ComposedNodes

START_TIMEOUT = 90.0
"""For the nodes to be ready; after an installation the planner's searches are compiled [s]."""

PLAN_TIMEOUT = 60.0
"""For the planner to answer to the goal; on a busy machine it may still compile its search [s]."""

_FALLEN_FOR = 5.0
"""Time after which a robot that fell before its walk is not waited for any more [s], simulated."""

_PATIENCE = 30.0
"""For a robot that has given up to go on after all, with a new plan [s], simulated."""

_WORST_SPEED = 0.004
"""A robot slower than this over its whole path gets nowhere [m/s]."""

_CAMERA_VIEW = math.radians(70.0)
"""Field of view of the camera under the ceiling [rad]."""

_CAMERA_MARGIN = 1.05
"""It hangs so much higher than it must to see the whole map."""

CAMERA_MAP_RESOLUTION = 0.05
"""Side of the cells of the map that the camera makes [m]."""


@dataclass(eq=False, repr=False)
class NodesNotReady(QuadError):
    """The nodes of a walk were not ready in time."""

    limit: float
    """Time that they had [s]."""
    said: str
    """What they said of themselves; empty for nothing."""

    def sentence(self) -> str:
        """Say what the nodes said meanwhile."""
        said = self.said or 'none published a status'
        return f'the nodes were not ready within {self.limit:.0f} s ({said})'


@dataclass(eq=False, repr=False)
class DoesNotStand(QuadError):
    """The robot fell before its walk could begin."""

    robot: str
    """Its name or data file."""
    said: str
    """What the gait said of it; empty for nothing."""

    def sentence(self) -> str:
        """Say it, and what to look at."""
        said = f' ({self.said})' if self.said else ''
        return (
            f'the robot falls as it is to stand{said}; whether its motors are strong enough says '
            f'quadwalk robot check {self.robot}'
        )


@dataclass(frozen=True)
class WalkOptions:
    """What to walk, and how."""

    map_file: Path
    start: Pose2D
    goal: Pose2D
    robot: str = 'titan_viii'
    method: str = 'mesh'
    gait: str = 'crawl'
    turning: str = 'in_place'
    """How the plan is followed; see gait_node."""
    balance: bool = False
    """Whether a trot keeps its balance; see gait_node."""
    backend: str = AUTO
    safety_distance: float | None = None
    """The planner's default if None [m]."""
    seed: int = 0
    real_time_factor: float = 0.0
    """0: as fast as possible."""
    gui: bool = False
    recording: Path | None = None
    terrain: str = 'flat'
    """What the ground is; see sim_node's parameter ``terrain``."""
    perception: str = 'truth'
    """``truth``: map, goal and pose come from the simulator; ``camera``: from its pictures."""
    odom_drift: float = 0.0
    """Drift of odometry as a fraction of the distance; see sim_node."""
    localiser_rate: float = 0.0
    """Corrections of odometry in a second [Hz]."""
    composed: bool = False
    """Whether all nodes are in this process, in step with the simulator."""
    page: PagePlace | None = None
    """Where the viewer's page is; None for no viewer."""
    hosts: Mapping[str, str] = field(default_factory=dict)
    """Network namespaces of Linux that nodes run in, by their names; if there are any, nodes meet
    across the subnet, and in one process otherwise only on this machine."""
    lead_time: float | None = None
    """The gait's; its default if None [s]."""


def walk(
    options: WalkOptions,
    on_progress: Callable[[WalkObserver], None] = lambda observer: None,
    on_page: Callable[[str], None] = lambda address: None,
    on_end: Callable[[WalkRecord, Callable[[], None]], None] = lambda record, listen: None,
) -> WalkRecord:
    """
    Walk once, with the three nodes as processes that talk over topics only, or composed.

    Parameters
    ----------
    options : WalkOptions
        What to walk.
    on_progress : callable
        Called several times a second with the observer.
    on_page : callable
        Called with the address of the viewer's page, once that is there.
    on_end : callable
        Called when the walk has ended, before the nodes do, with its record and with what lets
        them go on for a moment.

    Returns
    -------
    WalkRecord
        What happened; also if the robot did not arrive.

    Raises
    ------
    NodesNotReady
        If the nodes do not become ready.
    DoesNotStand
        If the robot falls before it walks.
    NodeDied
        If a node ends on its own.
    """
    with contextlib.ExitStack() as stack:
        stack.enter_context(subnet_domain() if options.hosts else isolated_domain())
        nodes = _nodes(options)
        stack.enter_context(nodes)
        _start_nodes(nodes, options)
        if options.page is not None:
            on_page(start_viewer(stack.enter_context(NodeProcesses()), options.page))
        recording = stack.enter_context(_recording(options))
        observer = stack.enter_context(_observer(options, nodes, recording))
        listen = observer.listen
        if not isinstance(nodes, NodeProcesses):
            nodes.tell(observer)
            listen = nodes.listen
        _wait_until_ready(observer, nodes, listen, options.robot)
        record = _watch(observer, nodes, listen, on_progress)
        if recording is not None:
            recording.note(_facts(options, record))

        def go_on() -> None:
            listen(0.1)
            nodes.check()

        on_end(record, go_on)
        return record


def _recording(options: WalkOptions) -> contextlib.AbstractContextManager[RobotRecording | None]:
    """Return what records the walk, or nothing."""
    if options.recording is None:
        return contextlib.nullcontext()
    # It needs a package that is not everywhere.
    from quad_lab.recordings.robot_recording import MOST_KEPT, RobotRecording

    is_fast = options.real_time_factor == 0.0
    return RobotRecording(options.recording, most_kept=MOST_KEPT if is_fast else 0)


def _facts(options: WalkOptions, record: WalkRecord) -> dict[str, object]:
    """Return what no message tells of a walk."""
    return {
        'robot': options.robot,
        'map': options.map_file.stem,
        'problem': record.problem,
        'wall_time': record.wall_time,
    }


def _observer(
    options: WalkOptions, nodes: NodeProcesses | ComposedNodes, recording: RobotRecording | None
) -> WalkObserver:
    return WalkObserver(
        options.goal,
        recording,
        by_marker=options.perception == 'camera',
        by_truth=options.odom_drift > 0.0,
        executor=None if isinstance(nodes, NodeProcesses) else nodes.executor,
    )


def _nodes(options: WalkOptions) -> NodeProcesses | ComposedNodes:
    if not options.composed:
        return NodeProcesses(hosts=options.hosts)
    # Only here: the nodes' own modules are imported with it.
    from quad_lab.topic_walk.composed_nodes import ComposedNodes

    return ComposedNodes()


def _start_nodes(nodes: NodeProcesses | ComposedNodes, options: WalkOptions) -> None:
    simulator: dict[str, object] = {
        'robot': options.robot,
        'map_file': str(options.map_file.resolve()),
        'start_pose': [float(v) for v in (options.start.x, options.start.y, options.start.yaw)],
        'real_time_factor': float(options.real_time_factor),
        'backend': options.backend,
        'seed': options.seed,
        'gui': options.gui,
        'odom_drift': float(options.odom_drift),
        'localiser_rate': float(options.localiser_rate),
    }
    planner: dict[str, object] = {
        'robot': options.robot,
        'method': options.method,
        'any_angle': True,
        'gait': options.gait,
        # Whatever can be read is walked on.
        'largest_map': MAX_CELLS,
    }
    gait: dict[str, object] = {
        'robot': options.robot,
        'gait': options.gait,
        'turning': options.turning,
        'balance': options.balance,
    }
    if options.terrain != 'flat':
        simulator |= {'terrain': options.terrain, 'terrain_seed': options.seed}
        if not _keeps_balance(options):
            gait['ground'] = 'uneven'
            if needs_footholds(options.terrain):
                gait['footsteps'] = planner['footsteps'] = True
    if options.lead_time is not None:
        gait['lead_time'] = options.lead_time
    if options.safety_distance is not None:
        planner['safety_distance'] = options.safety_distance
    if options.perception == 'camera':
        # One camera under the ceiling is all that tells of the room; the legs tell between
        # its pictures.
        place = camera_over(load_map(options.map_file))
        simulator |= {'camera': True, 'publish_map': False, 'publish_tf': False, **place}
        planner['odom_topic'] = 'odom/camera'
        gait |= {'odom_topic': 'odom/camera', 'leg_odometry_start': 'origin'}
        position, yaw = place['camera_position'], place['camera_yaw']
        nodes.start(
            'ceiling_camera_node',
            robot=options.robot,
            camera_position=position,
            camera_yaw=yaw,
            resolution=CAMERA_MAP_RESOLUTION,
        )
    nodes.start('sim_node', **simulator)
    nodes.start('planner_node', **planner)
    nodes.start('gait_node', **gait)


def _keeps_balance(options: WalkOptions) -> bool:
    """Return whether the robot keeps its balance in its gait, on any ground."""
    return options.balance and not load_gait(options.gait, load_robot(options.robot)).is_static


def camera_over(grid: OccupancyGrid) -> dict[str, object]:
    """Hang a camera where it sees a whole map."""
    middle = grid.map_to_world(np.array([grid.width / 2.0, grid.height / 2.0]))
    half = grid.resolution * max(grid.width, grid.height) / 2.0
    height = half / math.tan(_CAMERA_VIEW / 2.0) * _CAMERA_MARGIN
    return {
        'camera_position': [float(middle[0]), float(middle[1]), height],
        'camera_yaw': grid.origin.yaw,
        'camera_field_of_view': _CAMERA_VIEW,
    }


def _watch(
    observer: WalkObserver,
    nodes: NodeProcesses | ComposedNodes,
    listen: Callable[[float], None],
    on_progress: Callable[[WalkObserver], None],
) -> WalkRecord:
    record = observer.record
    observer.give_goal()
    began = time.monotonic()
    start_time = observer.time
    standstill = Standstill(start_time)
    end = GuidedEnd(_PATIENCE)
    while not record.has_arrived and not record.problem:
        listen(0.1)
        nodes.check()
        on_progress(observer)
        seen = observer.time
        record.wall_time = time.monotonic() - began
        stalled = standstill.duration(seen)
        record.problem = _problem(observer, record.wall_time, stalled, seen - start_time)
        is_over = end.is_over(seen, observer.activity)
        if is_over and not record.problem and not record.has_arrived:
            record.problem = observer.statuses['gait_node'][1]
    observer.note_poses()
    return record


def _wait_until_ready(
    observer: WalkObserver,
    nodes: NodeProcesses | ComposedNodes,
    listen: Callable[[float], None],
    robot: str,
) -> None:
    deadline = time.monotonic() + START_TIMEOUT
    fell_at = math.inf
    while not (
        observer.planner_is_ready()
        and observer.has_found_gait()
        and observer.activity is Activity.STANDING
    ):
        listen(0.05)
        nodes.check()
        if observer.statuses.get('sim_node', (b'', '', {}))[2].get('has_fallen') != 'True':
            fell_at = math.inf
        else:
            fell_at = min(fell_at, observer.time)
        if observer.time - fell_at > _FALLEN_FOR:
            raise DoesNotStand(robot, observer.statuses.get('gait_node', (b'', '', {}))[1])
        if time.monotonic() > deadline:
            said = '; '.join(f'{name}: {status[1]}' for name, status in observer.statuses.items())
            raise NodesNotReady(START_TIMEOUT, said)


def _problem(observer: WalkObserver, waited: float, stalled: float, walked: float) -> str:
    """Say why the walk will not succeed; empty while it may."""
    record = observer.record
    said = {name: status[1] for name, status in observer.statuses.items()}
    if record.has_fallen:
        return said.get('sim_node', 'the robot has fallen')
    if observer.activity is not None and observer.activity.is_disabled:
        return said['gait_node']
    values = observer.statuses.get('planner_node', (b'', '', {}))[2]
    if not record.plans and values.get('error_code', '0') != '0':
        return said['planner_node']
    if not record.plans and waited > PLAN_TIMEOUT:
        return f'no plan within {PLAN_TIMEOUT:.0f} s: {said.get("planner_node", "no word")}'
    if stalled > STALL_TIMEOUT:
        return str(TimeStandsStill(STALL_TIMEOUT))
    if record.plans and walked > 120.0 + record.plans[0].length / _WORST_SPEED:
        return f'not there after {walked:.0f} s of walking: {said.get("gait_node", "no word")}'
    return ''
