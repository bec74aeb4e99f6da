"""
Kinds of arguments that several commands take.
"""

from __future__ import annotations

import argparse
import math
import re
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


def finite_argument(text: str) -> float:
    """
    Read a number that is neither infinite nor nan.

    Raises
    ------
    argparse.ArgumentTypeError
        If it is no such number.
    """
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise argparse.ArgumentTypeError(f"'{text}' is not a finite number")
    return number


def with_negative_values(arguments: list[str]) -> list[str]:
    """
    Join options with values that begin with a minus sign: ``--start -1,2,0``.

    By itself argparse takes such a value for another option, unless it is a plain number.
    """
    joined: list[str] = []
    for text in arguments:
        is_value = re.match(r'-[\d.][^=]*,', text) is not None
        if is_value and joined and re.fullmatch(r'--[\w-]+', joined[-1]):
            joined[-1] += f'={text}'
        else:
            joined.append(text)
    return joined


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
