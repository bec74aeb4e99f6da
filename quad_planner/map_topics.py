"""
The maps that ``planner_node`` subscribes to.
"""

from __future__ import annotations

from typing import Any

from nav_msgs.msg import OccupancyGrid
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import PointCloud2

from quad_common.errors import QuadError
from quad_common.ros.height_map_conversions import height_map_from_message
from quad_common.ros.map_conversions import grid_from_message
from quad_common.ros.ros_node import QuadNode
from quad_planner.grid.grid_update import GridUpdate
from quad_planner.parameters import PlannerParameters
from quad_planner.ros_conversions import update_from_message
from quad_planner.session.planning_session import PlanningSession

try:
    from map_msgs.msg import OccupancyGridUpdate
except ImportError:
    OccupancyGridUpdate = None

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class MapTopics:
    """
    Hands maps on to a session: the map, its updates, where to keep out, and the ground.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : PlanningSession
        Its session.
    """

    def __init__(self, node: QuadNode[PlannerParameters], session: PlanningSession) -> None:
        self._node = node
        self._session = session
        self.refusal = ''
        """Sentence with which the last map was refused; empty if it was not."""
        node.create_subscription(OccupancyGrid, 'map', self._on_map, _LATCHED)
        node.create_subscription(OccupancyGrid, 'keepout_filter_mask', self._on_mask, _LATCHED)
        node.create_subscription(PointCloud2, 'height_map', self._on_height_map, _LATCHED)
        if OccupancyGridUpdate is not None:
            node.create_subscription(OccupancyGridUpdate, 'map_updates', self._on_update, 10)

    def _on_map(self, message: OccupancyGrid) -> None:
        try:
            grid = grid_from_message(message, self._node.parameters.largest_map)
            self._session.take_grid(grid, message.header.frame_id or 'map')
        except QuadError as error:
            self.refusal = str(error)
            raise
        self.refusal = ''

    def _on_update(self, message: Any) -> None:
        update: GridUpdate = update_from_message(message)
        self._session.take_update(update, message.header.frame_id or 'map')

    def _on_mask(self, message: OccupancyGrid) -> None:
        mask = grid_from_message(message, self._node.parameters.largest_map)
        self._session.take_mask(mask, message.header.frame_id or 'map')

    def _on_height_map(self, message: PointCloud2) -> None:
        frame = message.header.frame_id
        self._session.take_heights(height_map_from_message(message, (frame,)), frame)
