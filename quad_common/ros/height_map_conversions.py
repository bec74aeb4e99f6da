"""
Conversions between height maps and point clouds.
"""

from __future__ import annotations

from array import array

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from sensor_msgs.msg import PointCloud2, PointField

from quad_common.errors import InvalidMessage, MapError
from quad_common.errors.quoting import LONGEST_QUOTE, clipped
from quad_common.frames.frame_names import check_frame
from quad_common.maps.height_map import MAX_CELLS, HeightMap
from quad_common.ros.pose_conversions import LARGEST_COORDINATE

Array = NDArray[np.float64]

_MOST_FIELDS = 64
"""Largest number of fields of a cloud's points."""

_OFF_GRID = 0.02
"""Distance by which points of a height map may be off their cells' centers [cells]."""

_ROUNDED = 7
"""Decimals of a resolution and an origin that come as single precision [m]."""


def height_map_message(heights: HeightMap, frame: str, stamp: Time) -> PointCloud2:
    """
    Write a height map as an organized point cloud.

    Parameters
    ----------
    heights : HeightMap
        The height map.
    frame : str
        Of the map.
    stamp : Time
        When it was made.

    Returns
    -------
    sensor_msgs/PointCloud2
        A point for each cell's center, row by row from the bottom; unknown ones have z NaN.
    """
    message = PointCloud2(height=heights.rows, width=heights.columns, is_bigendian=False)
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.fields = [
        PointField(name=name, offset=4 * index, datatype=PointField.FLOAT32, count=1)
        for index, name in enumerate('xyz')
    ]
    points = np.dstack([heights.centers, heights.heights]).astype('<f4')
    message.point_step, message.row_step = 12, 12 * heights.columns
    message.is_dense = not bool(np.isnan(heights.heights).any())
    message.data = array('B', points.tobytes())
    return message


def height_map_from_message(message: PointCloud2, frames: tuple[str, ...]) -> HeightMap:
    """
    Read a height map from an organized point cloud.

    Parameters
    ----------
    message : sensor_msgs/PointCloud2
        Points on a square grid along the axes of its frame: rows along x, from the lowest y up.
        Fields besides x, y and z are left out.
    frames : tuple of str
        In which it may be given.

    Returns
    -------
    HeightMap
        A cell around each point; unknown where z is not a number.

    Raises
    ------
    InvalidMessage
        If it is in another frame, not organized, too large, or its points are on no such grid.
    """
    what = 'height map'
    check_frame(what, message.header.frame_id, *frames)
    rows, columns = message.height, message.width
    if rows < 2 or columns < 2:
        raise InvalidMessage(
            what,
            f'it has {rows} rows of {columns} points; it must be organized, '
            'with at least 2 rows of 2 points',
        )
    if rows * columns > MAX_CELLS:
        raise InvalidMessage(what, f'it has {columns} x {rows} points; {MAX_CELLS} are the most')
    return _height_map_of(*_cloud_coordinates(message, what), what)


def _cloud_coordinates(message: PointCloud2, what: str) -> tuple[Array, Array, Array]:
    """Return x, y and z of the points of a cloud, shape (height, width) each."""
    rows, columns, step = message.height, message.width, message.point_step
    if len(message.fields) > _MOST_FIELDS:
        raise InvalidMessage(
            what, f'its points have {len(message.fields)} fields; {_MOST_FIELDS} are the most'
        )
    offsets = []
    for name in 'xyz':
        field = next((field for field in message.fields if field.name == name), None)
        if field is None:
            given = ', '.join(field.name for field in message.fields) or 'none'
            raise InvalidMessage(
                what, f"it has no field '{name}'; its fields are {clipped(given, LONGEST_QUOTE)}"
            )
        if field.datatype != PointField.FLOAT32 or field.count != 1 or field.offset + 4 > step:
            raise InvalidMessage(
                what,
                f"its field '{name}' is of type {field.datatype}, {field.count} of them, at byte "
                f'{field.offset} of {step}; it must be one FLOAT32 (7) within the point',
            )
        offsets.append(field.offset)
    if message.row_step < columns * step or len(message.data) != rows * message.row_step:
        raise InvalidMessage(
            what,
            f'{rows} rows of {columns} points of {step} bytes take rows of at least '
            f'{columns * step} bytes; it has {len(message.data)} bytes in rows of '
            f'{message.row_step}',
        )
    layout = np.dtype(
        {
            'names': ['x', 'y', 'z'],
            'formats': ['>f4' if message.is_bigendian else '<f4'] * 3,
            'offsets': offsets,
            'itemsize': step,
        }
    )
    cloud: NDArray[np.void] = np.ndarray(
        (rows, columns), layout, np.asarray(message.data, np.uint8), 0, (message.row_step, step)
    )
    x, y, z = (cloud[name].astype(float) for name in 'xyz')
    return x, y, z


def _height_map_of(x: Array, y: Array, z: Array, what: str) -> HeightMap:
    """Return the height map whose cells' centers are at points, shape (rows, columns) each."""
    rows, columns = z.shape
    # The extremes of what holds a NaN are NaN, at a fraction of what it takes to look for one.
    sides = np.array([[values.min(), values.max()] for values in (x, y)])
    if not np.isfinite(sides).all():
        raise InvalidMessage(
            what, 'x or y of a point is not finite; unknown heights have z NaN only'
        )
    farthest = float(np.abs(sides).max())
    if farthest > LARGEST_COORDINATE:
        raise InvalidMessage(
            what, f'a point is {farthest:g} m off its origin; {LARGEST_COORDINATE:g} m are the most'
        )
    first, last = (x[0, 0], y[0, 0]), (x[-1, -1], y[-1, -1])
    longer = 0 if columns >= rows else 1
    resolution = round(float(last[longer] - first[longer]) / (max(columns, rows) - 1), _ROUNDED)
    if not resolution > 0.0:
        raise InvalidMessage(
            what,
            f'its points go from {(float(first[0]), float(first[1]))} to '
            f'{(float(last[0]), float(last[1]))} m; '
            'x must rise along the rows, and y from row to row',
        )
    off_x = np.abs(x - (first[0] + resolution * np.arange(columns))).max()
    off_y = np.abs(y - (first[1] + resolution * np.arange(rows)[:, None])).max()
    off = float(max(off_x, off_y)) / resolution
    if off > _OFF_GRID:
        raise InvalidMessage(
            what,
            f'its points are up to {off:.2f} cells off a square grid of {resolution:g} m along '
            'the axes; x must rise along the rows, and y from row to row',
        )
    left, bottom = (round(float(value) - resolution / 2.0, _ROUNDED - 1) for value in first)
    z[~np.isfinite(z)] = np.nan
    try:
        return HeightMap(z, resolution, (left, bottom))
    except MapError as error:
        raise InvalidMessage(what, str(error)) from error
