"""
Kinds of arguments that several commands take.
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map, share_directory


def pose_argument(text: str) -> Pose2D:
    """
    Read ``x,y,yaw`` in metres and radians; ``90deg`` gives the yaw in degrees.

    Raises
    ------
    argparse.ArgumentTypeError
        If the text is no such pose.
    """
    try:
        x, y, yaw = text.split(',')
        angle = math.radians(float(yaw[:-3])) if yaw.endswith('deg') else float(yaw)
        pose = Pose2D(float(x), float(y), angle)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not x,y,yaw, for example 1.5,2,0") from None
    if not pose.is_finite():
        raise argparse.ArgumentTypeError(f"'{text}' holds a number that is not finite")
    return pose


def map_argument(text: str) -> Path:
    """
    Read a map: a file, or the name of a sample map.

    Raises
    ------
    argparse.ArgumentTypeError
        If there is neither.
    """
    path = Path(text)
    if path.is_file():
        return path
    if sample_map(text).is_file():
        return sample_map(text)
    samples = ', '.join(sorted(path.stem for path in (share_directory() / 'maps').glob('*.yaml')))
    raise argparse.ArgumentTypeError(
        f"there is no map file '{text}'; give a Nav2 map YAML, or a sample map: {samples}"
    )
