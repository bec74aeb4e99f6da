"""
What is started for an attack by messages: nodes that walk by odometry, or by the ceiling camera.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from quad_common.maps.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.attacks.stage.stage import Stage
from quad_lab.topic_walk.node_processes import isolated_domain
from quad_lab.topic_walk.walk import CAMERA_MAP_RESOLUTION, camera_over
from quad_sim.engines.registry import AUTO

MAP = 'room'
ROBOT = 'titan_viii'
START = Pose2D(1.2, 1.2, 0.0)
"""Where the robot begins."""

NODES = ('planner_node', 'gait_node', 'sim_node')
"""Nodes of a walk by odometry."""

CAMERA = 'ceiling_camera_node'

_RATE = 4.0
"""Simulated over real time."""

_CAMERA_RATE = 2.0
"""The same where pictures are made, which takes most of the time."""

_PICTURES = 1.0
"""Pictures in a simulated second [Hz]."""


@dataclass(frozen=True)
class AttackScene:
    """Nodes, and which of them are attacked."""

    setup: str
    """``camera``: a walk by the ceiling camera; otherwise one by odometry, and the simulator's
    backend, without physics or with."""
    states: tuple[str, ...]
    """States of the robot in which each node is attacked: ``standing``, ``walking``."""
    targets: tuple[str, ...]
    """Nodes that are attacked."""
    has_nonsense: bool
    """Whether they are also sent what they must refuse."""
    gait: str = 'crawl'
    """Gait of the robot."""
    rate: float | None = None
    """Simulated over real time; that of the setup if None."""

    @property
    def clearance(self) -> float:
        """Distance that goals keep beyond the planner's own [m]: a camera sees walls thicker."""
        return 0.15 if self.setup == 'camera' else 0.0

    @contextmanager
    def running(self) -> Iterator[Stage]:
        """Run the nodes in a domain of their own, ready for a goal, on the stage that it yields."""
        with isolated_domain(), Stage(load_robot(ROBOT)) as stage:
            self.start(stage)
            yield stage

    def start(self, stage: Stage) -> None:
        """Start the nodes, and wait until a goal would be walked to."""
        if self.setup == 'camera':
            start_camera_nodes(stage, self.rate or _CAMERA_RATE, gait=self.gait)
        else:
            start_nodes(stage, self.setup, self.rate or _RATE, gait=self.gait)


SCENES = (
    AttackScene('kinematic', ('standing',), NODES, has_nonsense=True),
    AttackScene(AUTO, ('walking',), NODES, has_nonsense=False),
    AttackScene('camera', ('standing', 'walking'), (CAMERA,), has_nonsense=True),
)

QUICK_WALK = AttackScene('kinematic', ('walking',), NODES, has_nonsense=True)
QUICK_CAMERA = AttackScene('camera', ('walking',), (CAMERA,), has_nonsense=True, gait='trot')
QUICK_SCENES = (QUICK_WALK, QUICK_CAMERA)


def start_nodes(stage: Stage, backend: str, rate: float = _RATE, **gait: object) -> None:
    """
    Start simulator, planner and gait, and wait until a goal would be walked to.

    Parameters
    ----------
    stage : Stage
        Where they run.
    backend : str
        Of the simulator.
    rate : float
        Simulated over real time; 0 is as fast as possible.
    **gait
        Parameters of gait_node.
    """
    start = [START.x, START.y, START.yaw]
    stage.start('sim_node', backend=backend, real_time_factor=rate, start_pose=start)
    stage.start('planner_node')
    stage.start('gait_node', **gait)
    stage.wait_until_ready()


def start_camera_nodes(stage: Stage, rate: float = _CAMERA_RATE, **gait: object) -> None:
    """
    Start all nodes, so that only pictures and legs tell of the room; wait as `start_nodes`.

    Parameters
    ----------
    stage : Stage
        Where they run.
    rate : float
        Simulated over real time; 0 is as fast as possible.
    **gait
        Parameters of gait_node.
    """
    place = camera_over(load_map(sample_map(MAP)))
    stage.start(
        CAMERA,
        camera_position=place['camera_position'],
        camera_yaw=place['camera_yaw'],
        resolution=CAMERA_MAP_RESOLUTION,
    )
    stage.start(
        'sim_node',
        camera=True,
        camera_rate=_PICTURES,
        publish_map=False,
        publish_tf=False,
        real_time_factor=rate,
        start_pose=[START.x, START.y, START.yaw],
        **place,
    )
    stage.start('planner_node', odom_topic='odom/camera')
    stage.start('gait_node', odom_topic='odom/camera', leg_odometry_start='origin', **gait)
    stage.wait_until_ready()
