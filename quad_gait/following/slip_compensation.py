"""
Slip compensation: how much more must be asked of a gait than is wanted (S2's lambda).

A robot that slips, or rolls on its feet, does not go quite as far as planned. What it
does is measured (``quadwalk calibrate``) and kept beside the robot's data.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from quad_common.errors import FileUnusable, ParameterError
from quad_common.files.bounded_file import is_file, path_exists, user_path
from quad_common.files.whole_file import write_text
from quad_common.files.yaml_document import check_keys, read_yaml
from quad_common.quantity import ANGLE, CYCLE_PERIOD, Quantity, list_of
from quad_common.robot_files.robot_file import ROBOTS_FOLDER, robot_file
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait

Array = NDArray[np.float64]

QUANTITIES = {
    'forward': Quantity(-100.0, 100.0, 'm'),
    'left': Quantity(-100.0, 100.0, 'm'),
    'turn': ANGLE,
}
"""Ranges of the motions of a calibration file."""

_KEYS = ('gait', 'cycle_period', 'wanted', 'asked')
_WHAT = 'calibration file'

_LARGEST = 0.5
"""A compensation larger than this fraction of the motion is a mistake."""

_WEIGHT_OF_NOTHING = 4.0
"""As if the gait were known to do as it is told in a motion half as large as itself away."""


@dataclass(frozen=True)
class Calibration:
    """One motion of one gait, as wanted and as it must be commanded."""

    gait: str
    """Name of the gait."""
    cycle_period: float
    """Duration of a cycle [s]."""
    wanted: BodyMotion
    """Motion that one cycle is to do."""
    asked: BodyMotion
    """Motion that must be asked of the gait for it."""


@dataclass(frozen=True)
class SlipCompensation:
    """What is known of a robot's slip."""

    calibrations: tuple[Calibration, ...] = ()
    """Calibrations of the gaits."""

    def compensated(self, gait: Gait, motion: BodyMotion) -> BodyMotion:
        """
        Say what to ask for.

        Parameters
        ----------
        gait : Gait
            The gait.
        motion : BodyMotion
            What one cycle is to do.

        Returns
        -------
        BodyMotion
            The motion, and as much more as in the gait's calibrations; the more alike
            these are, the more they count. As it is without any.
        """
        known = [c for c in self.calibrations if _is_of(c, gait)]
        size = _size(motion)
        if not known or size == 0.0:
            return motion
        # Motions unlike any that was calibrated are commanded as they are.
        total = _WEIGHT_OF_NOTHING
        more = np.zeros(3)
        for calibration in known:
            weight = _likeness(motion, calibration.wanted)
            total += weight
            excess = _parts(calibration.asked) - _parts(calibration.wanted)
            more += weight * excess * size / _size(calibration.wanted)
        return BodyMotion(*(_parts(motion) + more / total).tolist())


NO_SLIP = SlipCompensation()
"""Ask for what is wanted."""


def load_compensation(path: Path) -> SlipCompensation:
    """
    Read calibrations from a YAML file.

    Parameters
    ----------
    path : Path
        A file written by :func:`save_compensation`; one that is not there holds nothing.

    Returns
    -------
    SlipCompensation
        What the file holds.

    Raises
    ------
    ParameterError
        If the file is damaged.
    """
    if not path_exists(path):
        return NO_SLIP
    try:
        document = read_yaml(path, _WHAT, 'the key calibrations')
    except FileUnusable as error:
        valid = f'a file written by quadwalk calibrate ({error.reason})'
        raise ParameterError('calibration', str(path), valid) from error
    try:
        check_keys(document, ('calibrations',))
        entries = document['calibrations']
        if not isinstance(entries, list):
            raise ParameterError('calibrations', entries, 'a list')
        return SlipCompensation(
            tuple(_calibration(f'calibrations[{k}]', entry) for k, entry in enumerate(entries))
        )
    except ParameterError as error:
        raise error.at(f'{_WHAT} {path}: ') from error


def calibration_file(robot: str) -> Path:
    """
    Say where a robot's calibrations are kept.

    Parameters
    ----------
    robot : str
        Name of a robot that ships, or path of a robot data file.

    Returns
    -------
    Path
        Beside the robot's data file: ``my_robot.calibration.yaml``, or in the folder
        ``calibration`` of the robots that ship. It need not exist.
    """
    data = robot_file(robot)
    if data.parent == ROBOTS_FOLDER:
        return ROBOTS_FOLDER / 'calibration' / data.name
    return data.with_suffix('.calibration.yaml')


def compensation_for(robot: str, calibration: str) -> SlipCompensation:
    """
    Choose the slip compensation as the parameter ``calibration`` says.

    Parameters
    ----------
    robot : str
        Name of a robot that ships, or path of a robot data file.
    calibration : str
        ``auto`` for the robot's own, if it has any; ``none``; or the path of a file.

    Returns
    -------
    SlipCompensation
        Empty for ``none``.

    Raises
    ------
    ParameterError
        If the file is not there, or damaged.
    """
    if calibration == 'none':
        return NO_SLIP
    if calibration == 'auto':
        return load_compensation(calibration_file(robot))
    try:
        path = user_path(calibration, _WHAT)
    except FileUnusable as error:
        raise ParameterError('calibration', calibration, f'a file ({error.reason})') from error
    if not is_file(path):
        raise ParameterError('calibration', calibration, "'auto', 'none', or a file that is there")
    return load_compensation(path)


def save_compensation(compensation: SlipCompensation, path: Path, heading: str) -> None:
    """Write calibrations as YAML, under a heading that says where they come from."""
    entries = [
        {
            'gait': c.gait,
            'cycle_period': c.cycle_period,
            'wanted': _rounded(c.wanted),
            'asked': _rounded(c.asked),
        }
        for c in compensation.calibrations
    ]
    comment = ''.join(f'# {line}\n' for line in heading.splitlines())
    text = yaml.safe_dump({'calibrations': entries}, sort_keys=False, default_flow_style=None)
    write_text(path, comment + text, _WHAT)


def with_calibrations(
    compensation: SlipCompensation, new: Iterable[Calibration]
) -> SlipCompensation:
    """Add calibrations, in place of earlier ones of the same gait and motion."""
    new = tuple(new)
    kept = tuple(
        old
        for old in compensation.calibrations
        if not any(old.gait == c.gait and old.wanted == c.wanted for c in new)
    )
    return SlipCompensation(kept + new)


def _calibration(name: str, entry: object) -> Calibration:
    """Read a calibration; `name` is its own, for errors."""
    if not isinstance(entry, dict) or not set(_KEYS) <= set(entry):
        raise ParameterError(name, entry, f'keys: {", ".join(_KEYS)}')
    check_keys(entry, _KEYS, name)
    wanted, asked = (_motion(f'{name}.{part}', entry[part]) for part in ('wanted', 'asked'))
    period = CYCLE_PERIOD.check(f'{name}.cycle_period', entry['cycle_period'])
    if not isinstance(entry['gait'], str):
        raise ParameterError(f'{name}.gait', entry['gait'], 'the name of a gait')
    if _size(wanted) == 0.0:
        raise ParameterError(f'{name}.wanted', entry['wanted'], 'a motion other than zero')
    excess = BodyMotion(*(_parts(asked) - _parts(wanted)).tolist())
    if _size(excess) > _LARGEST * _size(wanted):
        raise ParameterError(
            f'{name}.asked',
            entry['asked'],
            f'a motion that differs from the wanted one, {entry["wanted"]}, by at most half of '
            f'its size',
        )
    return Calibration(entry['gait'], period, wanted, asked)


def _motion(name: str, value: object) -> BodyMotion:
    """Read forward, left and turn."""
    parts = ('forward', 'left', 'turn')
    return BodyMotion(
        *(
            QUANTITIES[part].check(f'{name}.{part}', number)
            for part, number in zip(parts, list_of(name, value, parts))
        )
    )


def _is_of(calibration: Calibration, gait: Gait) -> bool:
    return calibration.gait == gait.name and math.isclose(
        calibration.cycle_period, gait.cycle_period, rel_tol=0.05
    )


def _parts(motion: BodyMotion) -> Array:
    return np.array([motion.forward, motion.left, motion.turn])


def _rounded(motion: BodyMotion) -> list[float]:
    return [round(part, 6) for part in _parts(motion).tolist()]


def _size(motion: BodyMotion) -> float:
    """Measure a motion in metres: a turn of 1 rad counts as much as 0.2 m."""
    return math.hypot(motion.forward, motion.left, 0.2 * motion.turn)


def _likeness(a: BodyMotion, b: BodyMotion) -> float:
    """Weight of a calibration: large for the same direction and size, small for others."""
    apart = math.hypot(a.forward - b.forward, a.left - b.left, 0.2 * (a.turn - b.turn))
    scale = max(_size(a), _size(b))
    return 1.0 / (apart / scale + 0.01) ** 2
