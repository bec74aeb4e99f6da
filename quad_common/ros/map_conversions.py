"""
Reading maps from messages.
"""

from __future__ import annotations

import numpy as np
from nav_msgs.msg import OccupancyGrid as OccupancyGridMessage

from quad_common.errors import MapSizesDisagree, MapTooLarge
from quad_common.maps.occupancy_grid import MAX_CELLS, OccupancyGrid
from quad_common.ros.pose_conversions import checked_name, pose_from_message


def grid_from_message(message: OccupancyGridMessage, most_cells: int = MAX_CELLS) -> OccupancyGrid:
    """
    Read an occupancy grid, without copying it cell by cell.

    Parameters
    ----------
    message : nav_msgs/OccupancyGrid
        The map.
    most_cells : int
        Cells that it may have.

    Returns
    -------
    OccupancyGrid
        The same map.

    Raises
    ------
    MapError
        If it is too large, its sizes disagree, or a value is not valid.
    InvalidMessage
        If the name of its frame is none.
    InvalidPose
        If its origin is not a pose.
    """
    info = message.info
    checked_name(message.header.frame_id, 'map')
    cells = np.frombuffer(message.data, dtype=np.int8)
    if max(cells.size, info.width * info.height) > most_cells:
        raise MapTooLarge(info.width, info.height, cells.size, most_cells)
    if cells.size != info.width * info.height:
        raise MapSizesDisagree(info.width, info.height, cells.size)
    origin = pose_from_message(info.origin, "map's origin")
    return OccupancyGrid(cells.reshape(info.height, info.width).copy(), info.resolution, origin)
