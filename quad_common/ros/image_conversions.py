"""
Conversions between messages of cameras, pictures and plain values.
"""

from __future__ import annotations

from array import array

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import ArrayLike, NDArray
from sensor_msgs.msg import CameraInfo, Image

from quad_common.errors import InvalidMessage
from quad_common.errors.quoting import quoted
from quad_common.vision.camera import CameraModel

LARGEST_PICTURE = 2**24
"""Pixels of a picture that is taken: 4096 x 4096."""

_FOCAL_LENGTHS = (1.0, 1e5)
"""Range of a camera's focal lengths [pixels]."""

_LARGEST_CAMERA_NUMBER = 1e5
"""Largest principal point [pixels], and largest number of a lens."""

_CHANNELS = {'rgb8': 3, 'bgr8': 3, 'mono8': 1}
"""Number of channels of the encodings of pictures that are understood."""

_CENTER = 0.5
"""Center of the first pixel in a `CameraModel`; for ROS and OpenCV it is at 0 [pixels]."""


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
        Its matrices count pixels from the center of the first one, as OpenCV does.
    """
    message = CameraInfo(height=model.height, width=model.width, distortion_model='plumb_bob')
    message.header.frame_id = frame
    message.header.stamp = stamp
    matrix = model.matrix.copy()
    matrix[:2, 2] -= _CENTER
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
    _check_info(message)
    matrix = np.reshape(message.k, (3, 3)).astype(float)
    matrix[:2, 2] += _CENTER
    distortion = np.zeros(5)
    distortion[: len(message.d)] = message.d
    return CameraModel(
        int(message.width),
        int(message.height),
        matrix,
        np.asarray(rotation, dtype=float),
        np.asarray(position, dtype=float),
        distortion,
    )


def _check_info(message: CameraInfo) -> None:
    """Raise InvalidMessage unless a lens is one that can be computed."""
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
