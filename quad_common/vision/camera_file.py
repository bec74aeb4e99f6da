"""
Camera files: what a lens does and where the camera is, as YAML.

The keys of the lens are those of ROS's ``camera_calibration`` and ``camera_info_manager``,
so that its files can be used; ours are ``position`` and ``orientation``. In files, as
everywhere in ROS and OpenCV, the center of the first pixel is (0, 0); in
:class:`quad_common.vision.camera.CameraModel` it is (0.5, 0.5). This module converts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from quad_common.errors import (
    CameraEntryInvalid,
    CameraFileUnusable,
    CameraValueOutOfRange,
    FileUnusable,
    MatrixSizeWrong,
    MissingKey,
    NumbersInvalid,
    ParameterError,
)
from quad_common.files.bounded_file import user_path
from quad_common.files.whole_file import write_text
from quad_common.files.yaml_document import check_keys, in_file, read_yaml
from quad_common.quantity import number_from
from quad_common.rotations import matrix_from_quaternion, quaternion_from_matrix
from quad_common.vision.camera import CameraModel

KEYS = (
    'image_width',
    'image_height',
    'camera_name',
    'camera_matrix',
    'distortion_model',
    'distortion_coefficients',
    'rectification_matrix',
    'projection_matrix',
    'position',
    'orientation',
)
"""
Keys that a camera file may have; the ranges of the numbers are those of
:data:`quad_common.vision.camera.QUANTITIES`. ROS's own name, rectification and projection are left
as they are: one camera has no use for them.
"""

_MATRIX_KEYS = ('rows', 'cols', 'data')
_WHAT = 'camera file'

Array = NDArray[np.float64]

_HALF = 0.5
_DOWN = np.diag([1.0, -1.0, -1.0])


def load_camera(path: str | Path, *, needs_pose: bool = True) -> CameraModel:
    """
    Read a camera.

    Parameters
    ----------
    path : str or Path
        The YAML file.
    needs_pose : bool
        Whether the file must say where the camera is. If not, a camera without a pose is
        1 m above the origin and looks down.

    Returns
    -------
    CameraModel
        The camera.

    Raises
    ------
    CameraError
        If the file is missing, unreadable, or says what it cannot.
    """
    try:
        path = user_path(path, _WHAT)
        document = read_yaml(path, _WHAT, 'keys such as image_width and camera_matrix')
    except FileUnusable as error:
        raise error.of_kind(CameraFileUnusable) from error
    try:
        check_keys(document, KEYS)
        return _camera(document, needs_pose)
    except (ParameterError, MissingKey, MatrixSizeWrong, NumbersInvalid) as error:
        raise in_file(error, _WHAT, path, CameraEntryInvalid, CameraValueOutOfRange) from error


def save_camera(camera: CameraModel, path: str | Path, name: str = 'ceiling_camera') -> None:
    """
    Write a camera.

    Parameters
    ----------
    camera : CameraModel
        The camera.
    path : str or Path
        The YAML file.
    name : str
        The camera's.

    Raises
    ------
    CameraError
        If the file cannot be written.
    """
    matrix = camera.matrix.copy()
    matrix[:2, 2] -= _HALF
    document = {
        'image_width': camera.width,
        'image_height': camera.height,
        'camera_name': name,
        'camera_matrix': {'rows': 3, 'cols': 3, 'data': matrix.ravel().tolist()},
        'distortion_model': 'plumb_bob',
        'distortion_coefficients': {'rows': 1, 'cols': 5, 'data': camera.distortion.tolist()},
        'position': camera.position.tolist(),
        'orientation': quaternion_from_matrix(camera.rotation).tolist(),
    }
    comment = (
        '# A camera. The lens is as in ROS: pixels are counted from the center of the first one.\n'
        '# position: in the world [m]; orientation: quaternion x, y, z, w from the optical frame\n'
        '# (x right, y down in the picture, z along the view) to the world.\n'
    )
    try:
        text = yaml.safe_dump(document, sort_keys=False, default_flow_style=None)
        write_text(user_path(path, _WHAT), comment + text, _WHAT)
    except FileUnusable as error:
        raise error.of_kind(CameraFileUnusable) from error


def _camera(document: Mapping[str, Any], needs_pose: bool) -> CameraModel:
    width, height = (_whole(document, key) for key in ('image_width', 'image_height'))
    matrix = _numbers(document, 'camera_matrix', 9).reshape(3, 3)
    matrix[:2, 2] += _HALF
    model = document.get('distortion_model', 'plumb_bob')
    if model != 'plumb_bob':
        raise ParameterError('distortion_model', model, 'plumb_bob')
    distortion = _numbers(document, 'distortion_coefficients', 5)
    if not needs_pose and 'position' not in document and 'orientation' not in document:
        return CameraModel(width, height, matrix, _DOWN, np.array([0.0, 0.0, 1.0]), distortion)
    for key in ('position', 'orientation'):
        if key not in document:
            raise MissingKey(key, "'quadwalk camera calibrate' finds where a camera is")
    quaternion = _numbers(document, 'orientation', 4)
    if not math.isclose(math.hypot(*quaternion), 1.0, abs_tol=0.01):
        raise ParameterError('orientation', quaternion.tolist(), 'a quaternion of length 1')
    rotation = matrix_from_quaternion(quaternion)
    position = _numbers(document, 'position', 3)
    return CameraModel(width, height, matrix, rotation, position, distortion)


def _whole(document: Mapping[str, Any], key: str) -> int:
    value = document.get(key)
    if not isinstance(value, int) or isinstance(value, bool) or value <= 0:
        raise ParameterError(key, value, 'a whole number above 0')
    return value


def _numbers(document: Mapping[str, Any], key: str, count: int) -> Array:
    """Read numbers; where they stand under ``data``, as ROS writes them, its shape counts too."""
    value = document.get(key)
    if isinstance(value, dict):
        check_keys(value, _MATRIX_KEYS, key)
        shape = [value[side] for side in ('rows', 'cols') if side in value]
        if shape and (not all(type(side) is int for side in shape) or math.prod(shape) != count):
            raise MatrixSizeWrong(key, shape, count)
        value = value.get('data')
    # A matrix may be written in rows.
    flat = value
    if isinstance(value, list) and all(isinstance(row, list) for row in value):
        flat = [number for row in value for number in row]
    numbers = [number_from(number) for number in flat] if isinstance(flat, list) else []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise NumbersInvalid(key, value, count)
    return np.array(numbers)
