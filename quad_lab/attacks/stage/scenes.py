"""
What is started for an attack by messages: nodes that walk by odometry, or by the ceiling camera.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.maps.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_lab.attacks.stage.stage import Stage
from quad_lab.topic_walk.walk import CAMERA_MAP_RESOLUTION, camera_over

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
"""Likewise where pictures are made, which takes most of the time."""

_PICTURES = 1.0
"""Pictures in a simulated second [Hz]."""


@dataclass(frozen=True)
class AttackScene:
    """Nodes, and which of them are attacked."""

    setup: str
    """``kinematic`` or ``bullet``: a walk by odometry, without physics or with; ``camera``: one by
    the ceiling camera."""
    states: tuple[str, ...]
    """States of the robot in which each node is attacked: ``standing``, ``walking``."""
    targets: tuple[str, ...]
    """Nodes that are attacked."""
    has_nonsense: bool
    """Whether they are also sent what they must refuse."""

    @property
    def clearance(self) -> float:
        """Distance that goals keep beyond the planner's own [m]: a camera sees walls thicker."""
        return 0.15 if self.setup == 'camera' else 0.0

    def start(self, stage: Stage) -> None:
        """Start the nodes, and wait until a goal would be walked to."""
        if self.setup == 'camera':
            start_camera_nodes(stage)
        else:
            start_nodes(stage, self.setup)


SCENES = (
    AttackScene('kinematic', ('standing',), NODES, has_nonsense=True),
    AttackScene('bullet', ('walking',), NODES, has_nonsense=False),
    AttackScene('camera', ('standing', 'walking'), (CAMERA,), has_nonsense=True),
)

QUICK_SCENES = (
    AttackScene('kinematic', ('walking',), NODES, has_nonsense=True),
    AttackScene('camera', ('walking',), (CAMERA,), has_nonsense=True),
)


def start_nodes(stage: Stage, backend: str, rate: float = _RATE, **gait: object) -> None:
    """
    Start simulator, planner and gait, and wait until a goal would be walked to.

    Parameters
    ----------
    stage : Stage
        Where they run.
    backend : str
        Of the simulator: ``kinematic`` or ``bullet``.
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


def start_camera_nodes(stage: Stage) -> None:
    """Start all nodes, so that only pictures and legs tell of the room, and wait likewise."""
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
        real_time_factor=_CAMERA_RATE,
        start_pose=[START.x, START.y, START.yaw],
        **place,
    )
    stage.start('planner_node', odom_topic='odom/camera')
    stage.start('gait_node', odom_topic='odom/camera', leg_odometry_start='origin')
    stage.wait_until_ready()
