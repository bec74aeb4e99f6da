"""
Conversions between ROS messages and plain values that more than one package needs.
"""

from __future__ import annotations

import math
from array import array

import cv2
import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import OccupancyGrid as OccupancyGridMessage
from nav_msgs.msg import Odometry, Path
from numpy.typing import ArrayLike, NDArray
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, PointCloud2, PointField

from quad_common.camera import CameraModel
from quad_common.errors import InvalidMessage, InvalidPose, MapError
from quad_common.height_map import MAX_CELLS as MAX_HEIGHT_CELLS
from quad_common.height_map import HeightMap
from quad_common.occupancy_grid import OccupancyGrid
from quad_common.plan import LONGEST_PLAN, Plan
from quad_common.planar_pose import Pose2D
from quad_common.quoting import LONGEST_QUOTE, clipped, quoted

LARGEST_COORDINATE = 1e6
"""A position is no farther from its frame's origin, along each axis [m]."""

LARGEST_PICTURE = 2**24
"""Pixels of a picture that is taken: 4096 x 4096."""

LONGEST_NAME = 200
"""Characters of the name of a frame, a joint or an obstacle."""

_ROOM, _POSE_BYTES = 10_000, 300
"""Of a message with a plan: for its head, and for a pose with the name of its frame."""

_MOST_FIELDS = 64
"""Of the points of a cloud."""

_FOCAL_LENGTHS = (1.0, 1e5)
"""Range of a camera's focal lengths [pixels]."""

_LARGEST_CAMERA_NUMBER = 1e5
"""Of a principal point [pixels], and of the numbers of a lens."""

_CHANNELS = {'rgb8': 3, 'bgr8': 3, 'mono8': 1}
"""Of the encodings of pictures that are understood."""

_CENTRE = 0.5
"""Of the first pixel in a `CameraModel`; for ROS and OpenCV it is at 0 [pixels]."""

_OFF_GRID = 0.02
"""By which points of a height map may be off their cells' centres [cells]."""

_ROUNDED = 7
"""Decimals of a resolution and an origin that come as single precision [m]."""


def check_clock(message: Clock) -> None:
    """Raise InvalidMessage if simulated time is none that a stamp can hold."""
    seconds_from_time(message.clock, 'clock')


def seconds_from_time(stamp: Time, what: str = 'time stamp') -> float:
    """
    Convert a time stamp to seconds.

    Parameters
    ----------
    stamp : Time
        From 0 s on.
    what : str
        What it is, for the error's sentence.

    Returns
    -------
    float
        Seconds.

    Raises
    ------
    InvalidMessage
        If the seconds are negative, or the nanoseconds are a second or more.
    """
    if stamp.sec < 0 or stamp.nanosec >= 10**9:
        raise InvalidMessage(
            what,
            f'it is {stamp.sec} s and {stamp.nanosec} ns; it must be 0 s or more, and less '
            'than 1000000000 ns',
        )
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def nanoseconds_from_time(stamp: Time) -> int:
    """Convert a time stamp to nanoseconds, to tell stamps apart exactly."""
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def time_from_seconds(seconds: float) -> Time:
    """
    Convert seconds to a time stamp, to the nanosecond.

    Parameters
    ----------
    seconds : float
        Before 2^31 s; times before 0 become 0, as trajectories that run already have them.

    Returns
    -------
    Time
        The stamp.

    Raises
    ------
    InvalidMessage
        If no stamp can hold them.
    """
    if not seconds < 2.0**31 - 1.0:
        raise InvalidMessage('time stamp', f'it would be {seconds:g} s; 2147483646 s are the most')
    nanoseconds = max(0, round(max(seconds, 0.0) * 1e9))
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def quaternion_from_yaw(yaw: float) -> Quaternion:
    """Convert a heading [rad] to a quaternion."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(yaw / 2.0), w=math.cos(yaw / 2.0))


def pose_message(pose: Pose2D) -> Pose:
    """Convert a planar pose to a message on the ground."""
    message = Pose(orientation=quaternion_from_yaw(pose.yaw))
    message.position.x = float(pose.x)
    message.position.y = float(pose.y)
    return message


def pose_from_message(message: Pose, what: str = 'pose') -> Pose2D:
    """
    Read position and heading of a pose.

    Parameters
    ----------
    message : Pose
        Any pose; its height, roll and pitch are ignored.
    what : str
        What it is, for the error's sentence.

    Returns
    -------
    Pose2D
        Position and heading.

    Raises
    ------
    InvalidPose
        If a number is not finite, the position is out of range, or the quaternion is no
        rotation.
    """
    x, y, _ = position_from_message(message.position, what)
    qx, qy, qz, qw = unit_quaternion(message.orientation, what)
    yaw = math.atan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy**2 + qz**2))
    return Pose2D(x, y, yaw)


def checked_name(name: str, what: str) -> str:
    """
    Return the name of a frame, a joint or an obstacle.

    Parameters
    ----------
    name : str
        The name.
    what : str
        What it belongs to, for the error's sentence.

    Raises
    ------
    InvalidMessage
        If it is too long to be kept and sent on, or cannot be printed.
    """
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise InvalidMessage(
            what,
            f'a name in it is {quoted(name, 60)}; {LONGEST_NAME} printable characters are the most',
        )
    return name


def position_from_message(position: Point, what: str) -> tuple[float, float, float]:
    """
    Read a position.

    Parameters
    ----------
    position : Point
        In any frame.
    what : str
        What is there, for the error's sentence.

    Returns
    -------
    tuple of float
        x, y and z [m].

    Raises
    ------
    InvalidPose
        If one is not finite, or farther than `LARGEST_COORDINATE` from the frame's origin.
    """
    numbers = (position.x, position.y, position.z)
    if not all(abs(number) <= LARGEST_COORDINATE for number in numbers):
        raise InvalidPose(
            what,
            f'its position is {numbers} m; each must be from {-LARGEST_COORDINATE:g} to '
            f'{LARGEST_COORDINATE:g} m',
        )
    return numbers


def unit_quaternion(q: Quaternion, what: str) -> tuple[float, float, float, float]:
    """
    Read a rotation.

    Parameters
    ----------
    q : Quaternion
        Of about length 1.
    what : str
        What is turned by it, for the error's sentence.

    Returns
    -------
    tuple of float
        x, y, z and w, of length 1.

    Raises
    ------
    InvalidPose
        If its length is not within 0.1 of 1.
    """
    # Squares of large components would overflow; hypot scales them.
    length = math.hypot(q.x, q.y, q.z, q.w)
    if not 0.9 < length < 1.1:
        raise InvalidPose(
            what,
            f'its quaternion xyzw {(q.x, q.y, q.z, q.w)} has length {length:.4g}; it must be 1',
        )
    return (q.x / length, q.y / length, q.z / length, q.w / length)


def tilt_from_odometry(message: Odometry) -> float:
    """Return the angle between the body's z axis and the vertical [rad]; or InvalidPose."""
    x, y, _, _ = unit_quaternion(message.pose.pose.orientation, 'odometry')
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x**2 + y**2))))


def orientation_from_odometry(message: Odometry) -> NDArray[np.float64]:
    """Return the body's orientation, a unit quaternion xyzw, shape (4,); or InvalidPose."""
    return np.array(unit_quaternion(message.pose.pose.orientation, 'odometry'))


def base_transform(odometry: Odometry) -> TransformStamped:
    """Write the pose of an odometry as a transform; InvalidPose if it is none."""
    transform = TransformStamped(header=odometry.header, child_frame_id=odometry.child_frame_id)
    pose = odometry.pose.pose
    x, y, z = position_from_message(pose.position, 'odometry')
    transform.transform.translation = Vector3(x=x, y=y, z=z)
    qx, qy, qz, qw = unit_quaternion(pose.orientation, 'odometry')
    transform.transform.rotation = Quaternion(x=qx, y=qy, z=qz, w=qw)
    return transform


def footprint_transform(odometry: Odometry, frame: str, ground: float = 0.0) -> TransformStamped:
    """
    Write where the body stands on the ground: its position and heading there (REP-120).

    Parameters
    ----------
    odometry : nav_msgs/Odometry
        Of the body.
    frame : str
        Of the footprint.
    ground : float
        Height of the ground below the body, in the odometry's frame [m].

    Returns
    -------
    geometry_msgs/TransformStamped
        Upright.
    """
    transform = TransformStamped(header=odometry.header, child_frame_id=frame)
    position = odometry.pose.pose.position
    transform.transform.translation = Vector3(x=position.x, y=position.y, z=ground)
    transform.transform.rotation = quaternion_from_yaw(pose_from_message(odometry.pose.pose).yaw)
    return transform


def pose_transform(pose: Pose2D, parent: str, child: str, stamp: Time) -> TransformStamped:
    """Write where a frame is in another one."""
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id = parent
    transform.header.stamp = stamp
    transform.transform.translation = Vector3(x=pose.x, y=pose.y, z=0.0)
    transform.transform.rotation = quaternion_from_yaw(pose.yaw)
    return transform


def camera_transform(model: CameraModel, parent: str, child: str, stamp: Time) -> TransformStamped:
    """Write where a camera is and how it looks."""
    transform = pose_transform(Pose2D(0.0, 0.0, 0.0), parent, child, stamp)
    x, y, z = (float(v) for v in model.position)
    transform.transform.translation = Vector3(x=x, y=y, z=z)
    turn = cv2.Rodrigues(model.rotation)[0].reshape(3)
    angle = float(np.linalg.norm(turn))
    x, y, z = (float(v) for v in turn * (math.sin(angle / 2.0) / max(angle, 1e-12)))
    transform.transform.rotation = Quaternion(x=x, y=y, z=z, w=math.cos(angle / 2.0))
    return transform


def most_plan_bytes(longest: int) -> int:
    """Return the bytes that a message with a plan of so many poses may have."""
    return _ROOM + _POSE_BYTES * longest


def plan_from_message(message: Path, longest: int = LONGEST_PLAN) -> Plan | None:
    """
    Read a plan.

    Parameters
    ----------
    message : Path
        Turning points; an empty path takes the plan back.
    longest : int
        Poses that it may have.

    Returns
    -------
    Plan or None
        None for an empty path.

    Raises
    ------
    InvalidMessage
        If it has more poses.
    InvalidPose
        If a pose is not valid.
    """
    if not message.poses:
        return None
    if len(message.poses) > longest:
        raise InvalidMessage(
            'plan', f'it has {len(message.poses)} poses; {longest} turning points are the most'
        )
    return Plan(
        tuple(
            pose_from_message(stamped.pose, f'pose {index} of the plan')
            for index, stamped in enumerate(message.poses)
        )
    )


def grid_message(grid: OccupancyGrid, frame: str, stamp: Time) -> OccupancyGridMessage:
    """Write an occupancy grid, without walking over its cells."""
    message = OccupancyGridMessage()
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.info.resolution = float(grid.resolution)
    message.info.width = grid.width
    message.info.height = grid.height
    message.info.origin = pose_message(grid.origin)
    data = array('b')
    data.frombytes(np.ascontiguousarray(grid.cells).tobytes())
    message.data = data
    return message


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
        A point for each cell's centre, row by row from the bottom; unknown ones have z NaN.
    """
    message = PointCloud2(height=heights.rows, width=heights.columns, is_bigendian=False)
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.fields = [
        PointField(name=name, offset=4 * index, datatype=PointField.FLOAT32, count=1)
        for index, name in enumerate('xyz')
    ]
    points = np.dstack([heights.centres, heights.heights]).astype('<f4')
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
    frame = message.header.frame_id
    if frame not in frames:
        raise InvalidMessage(
            what, f'it is in frame {quoted(frame)}; give it in {quoted(frames[0])}'
        )
    rows, columns = message.height, message.width
    if rows < 2 or columns < 2:
        raise InvalidMessage(
            what,
            f'it has {rows} rows of {columns} points; it must be organized, '
            'with at least 2 rows of 2 points',
        )
    if rows * columns > MAX_HEIGHT_CELLS:
        raise InvalidMessage(
            what, f'it has {columns} x {rows} points; {MAX_HEIGHT_CELLS} are the most'
        )
    points = _cloud_points(message, what)
    return _height_map_of(points, what)


def _cloud_points(message: PointCloud2, what: str) -> NDArray[np.float64]:
    """Return x, y and z of the points of a cloud, shape (height, width, 3)."""
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
    return np.stack([cloud[name] for name in 'xyz'], axis=-1).astype(float)


def _height_map_of(points: NDArray[np.float64], what: str) -> HeightMap:
    """Return the height map whose cells' centres are at points, shape (rows, columns, 3)."""
    rows, columns, _ = points.shape
    flat = points[..., :2]
    if not np.isfinite(flat).all():
        raise InvalidMessage(
            what, 'x or y of a point is not finite; unknown heights have z NaN only'
        )
    farthest = float(np.abs(flat).max())
    if farthest > LARGEST_COORDINATE:
        raise InvalidMessage(
            what, f'a point is {farthest:g} m off its origin; {LARGEST_COORDINATE:g} m are the most'
        )
    longer = 0 if columns >= rows else 1
    span = flat[-1, -1, longer] - flat[0, 0, longer]
    resolution = round(float(span) / (max(columns, rows) - 1), _ROUNDED)
    if not resolution > 0.0:
        raise InvalidMessage(
            what,
            f'its points go from {tuple(flat[0, 0].tolist())} to {tuple(flat[-1, -1].tolist())} m; '
            'x must rise along the rows, and y from row to row',
        )
    column, row = np.meshgrid(np.arange(columns), np.arange(rows))
    first = flat[0, 0]
    off = np.abs(flat - first - resolution * np.stack([column, row], axis=-1)).max() / resolution
    if off > _OFF_GRID:
        raise InvalidMessage(
            what,
            f'its points are up to {off:.2f} cells off a square grid of {resolution:g} m along '
            'the axes; x must rise along the rows, and y from row to row',
        )
    x, y = (round(float(value) - resolution / 2.0, _ROUNDED - 1) for value in first)
    heights = np.where(np.isfinite(points[..., 2]), points[..., 2], np.nan)
    try:
        return HeightMap(heights, resolution, (x, y))
    except MapError as error:
        raise InvalidMessage(what, str(error)) from error


def image_message(rgb: NDArray[np.uint8], frame: str, stamp: Time) -> Image:
    """
    Write a picture.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (height, width, 3)
        Red, green and blue; the first row is the top.
    frame : str
        Of the camera.
    stamp : Time
        When it was taken.

    Returns
    -------
    sensor_msgs/Image
        In the encoding rgb8.
    """
    height, width, _ = rgb.shape
    message = Image(height=height, width=width, encoding='rgb8', step=3 * width)
    message.header.frame_id = frame
    message.header.stamp = stamp
    message.data = array('B', np.ascontiguousarray(rgb).tobytes())
    return message


def rgb_from_image(message: Image) -> NDArray[np.uint8]:
    """
    Read a picture.

    Parameters
    ----------
    message : sensor_msgs/Image
        In one of the encodings rgb8, bgr8 and mono8; rows may be padded.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        Red, green and blue; the first row is the top. It may share the message's memory.

    Raises
    ------
    InvalidMessage
        If the encoding is another one, or the sizes disagree.
    """
    channels = _CHANNELS.get(message.encoding)
    if channels is None:
        known = ', '.join(_CHANNELS)
        raise InvalidMessage(
            'image', f'its encoding is {quoted(message.encoding)}; known are {known}'
        )
    height, width, step = message.height, message.width, message.step
    if not (height > 0 and width > 0):
        raise InvalidMessage('image', f'it has {width} x {height} pixels')
    if width * height > LARGEST_PICTURE:
        raise InvalidMessage(
            'image', f'it has {width} x {height} pixels; {LARGEST_PICTURE} are the most'
        )
    if step < channels * width or len(message.data) != step * height:
        raise InvalidMessage(
            'image',
            f'{width} x {height} pixels in {message.encoding} take {height} rows of at least '
            f'{channels * width} bytes; it has {len(message.data)} bytes in rows of {step}',
        )
    rows = np.frombuffer(message.data, np.uint8).reshape(height, step)
    pixels = rows[:, : channels * width].reshape(height, width, channels)
    if message.encoding == 'bgr8':
        return pixels[..., ::-1]
    return np.repeat(pixels, 3, axis=2) if channels == 1 else pixels


def camera_info_message(model: CameraModel, frame: str, stamp: Time) -> CameraInfo:
    """
    Write what a camera's lens does.

    Parameters
    ----------
    model : CameraModel
        The camera.
    frame : str
        Of the camera.
    stamp : Time
        Of the picture that it goes with.

    Returns
    -------
    sensor_msgs/CameraInfo
        Its matrices count pixels from the centre of the first one, as OpenCV does.
    """
    message = CameraInfo(height=model.height, width=model.width, distortion_model='plumb_bob')
    message.header.frame_id = frame
    message.header.stamp = stamp
    matrix = model.matrix.copy()
    matrix[:2, 2] -= _CENTRE
    message.d = model.distortion.tolist()
    message.k = matrix.reshape(-1)
    message.r = np.eye(3).reshape(-1)
    message.p = np.column_stack([matrix, np.zeros(3)]).reshape(-1)
    return message


def camera_model_from_info(
    message: CameraInfo, rotation: ArrayLike, position: ArrayLike
) -> CameraModel:
    """
    Read what a camera's lens does.

    Parameters
    ----------
    message : sensor_msgs/CameraInfo
        Of a calibrated camera, with the distortion model plumb_bob or none.
    rotation : array_like, shape (3, 3)
        From the camera's frame to the world.
    position : array_like, shape (3,)
        Of the camera in the world [m].

    Returns
    -------
    CameraModel
        The camera at that place.

    Raises
    ------
    InvalidMessage
        If it is not calibrated, uses another model, or shows a part of the picture only.
    ParameterError
        If a number is not valid.
    """
    what = 'camera_info'
    if message.k[0] == 0.0:
        raise InvalidMessage(what, 'its matrix K is 0: the camera is not calibrated')
    numbers = len(message.d)
    if message.distortion_model not in ('plumb_bob', '') or numbers not in (0, 4, 5):
        raise InvalidMessage(
            what,
            f'its distortion model is {quoted(message.distortion_model)} with {numbers} numbers; '
            "it must be 'plumb_bob' with 4 or 5, or none",
        )
    if max(message.binning_x, message.binning_y) > 1 or message.roi.width or message.roi.height:
        raise InvalidMessage(what, 'it has binning or a region of interest; both must be unset')
    width, height = message.width, message.height
    if not 0 < width * height <= LARGEST_PICTURE:
        raise InvalidMessage(
            what, f'its pictures have {width} x {height} pixels; 1 to {LARGEST_PICTURE} are valid'
        )
    low, high = _FOCAL_LENGTHS
    if not all(low <= message.k[index] <= high for index in (0, 4)):
        raise InvalidMessage(
            what,
            f'its focal lengths are {message.k[0]:g} and {message.k[4]:g} pixels; '
            f'they must be from {low:g} to {high:g}',
        )
    if not all(abs(value) <= _LARGEST_CAMERA_NUMBER for value in (*message.k, *message.d)):
        raise InvalidMessage(
            what,
            f'a number of its matrix K or of its lens D is not from {-_LARGEST_CAMERA_NUMBER:g} '
            f'to {_LARGEST_CAMERA_NUMBER:g}',
        )
    matrix = np.reshape(message.k, (3, 3)).astype(float)
    matrix[:2, 2] += _CENTRE
    distortion = np.zeros(5)
    distortion[:numbers] = message.d
    return CameraModel(
        int(message.width),
        int(message.height),
        matrix,
        np.asarray(rotation, dtype=float),
        np.asarray(position, dtype=float),
        distortion,
    )
