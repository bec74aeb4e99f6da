"""
How fast a gait takes a robot along a plan, counted in whole gait cycles.

S0 (sec. 3) wants the path that costs the least time. A robot that walks straight and
turns on the spot spends whole cycles on each stretch and on each turn: a stretch takes
its length over the stride, a turn its angle over the largest turn of a cycle, each
rounded up. For TITAN-VIII a turn of 45 degrees takes two cycles, as long as 0.45 m.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import yaml

from quad_common.errors import FileUnusable, ParameterError
from quad_common.files.bounded_file import make_folder, path_exists
from quad_common.files.whole_file import write_text
from quad_common.files.yaml_document import check_keys, read_yaml
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.quantity import CYCLE_PERIOD, Quantity
from quad_common.robot_files.robot_file import ROBOTS_FOLDER, robot_file

QUANTITIES = {
    'cycle_period': CYCLE_PERIOD,
    'stride': Quantity(1e-4, 100.0, 'm'),
    'turn': Quantity(1e-4, 2.0 * math.pi, 'rad'),
    'stopping': Quantity(0.0, 100.0, 'cycles'),
    'bend': Quantity(0.0, math.pi, 'rad'),
    'heading_tolerance': Quantity(0.0, math.pi, 'rad'),
    'sweep': Quantity(0.0, 10.0, 'm'),
}
"""Ranges of what a file of paces says of a gait."""

_WHAT = 'file of paces'

LENGTH_SLACK = 1e-5
"""Fraction by which a stride may be longer than it is: lengths are often multiples of it."""


@dataclass(frozen=True)
class WalkingTimeModel:
    """
    How far the cycles of a gait go on a robot.

    Raises
    ------
    ParameterError
        If a number is not what its description says.
    """

    cycle_period: float
    """Duration of a cycle, of straight walking as of turning, > 0 [s]."""
    stride: float
    """Distance walked straight on in a cycle, > 0 [m]."""
    turn: float
    """Turn of one cycle on the spot, > 0 [rad]."""
    stopping: float = 0.0
    """
    Part of a cycle that is added to each stretch and each turn: a gait that keeps its speed
    from cycle to cycle has to gather it and to come to rest again.
    """
    bend: float = math.radians(12.0)
    """Smaller changes of heading are made while walking, without a turn [rad]."""
    heading_tolerance: float = math.radians(2.0)
    """Angle within which the robot has the goal's heading [rad]."""
    sweep: float = 0.0
    """Distance by which the robot's parts leave its footprint in a turn on the spot [m]."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, quantity in QUANTITIES.items():
            quantity.check(name, getattr(self, name))

    def straight_cycles(self, length: float) -> int:
        """Return how many cycles a straight stretch takes [m], from rest to rest."""
        if length <= 0.0:
            return 0
        return max(1, math.ceil(length / (self.stride * (1.0 + LENGTH_SLACK)) + self.stopping))

    def turn_cycles(self, angle: float) -> int:
        """Return how many cycles a change of heading takes before a stretch [rad]."""
        angle = abs(wrap_angle(angle))
        if angle <= self.bend:
            return 0
        return max(1, math.ceil(angle / (self.turn * (1.0 + LENGTH_SLACK)) + self.stopping))

    def last_turn_cycles(self, angle: float) -> int:
        """Return how many cycles it takes to get the goal's heading, once there [rad]."""
        if abs(wrap_angle(angle)) <= self.heading_tolerance:
            return 0
        return max(1, self.turn_cycles(angle))

    def cycles(self, start: Pose2D, plan: Plan, lengths: Sequence[float] | None = None) -> int:
        """
        Count the cycles that a plan takes.

        Parameters
        ----------
        start : Pose2D
            Where the robot is, at the plan's first point; its heading counts [m, m, rad].
        plan : Plan
            The turning points.
        lengths : sequence of float, optional
            Lengths of level ground that take as long as each segment of the plan [m]; those of the
            segments if not given.

        Returns
        -------
        int
            Cycles of straight walking and of turning.
        """
        total, stretch = 0, 0.0
        heading = start.yaw
        for at, (here, there) in enumerate(pairwise(plan.poses)):
            if abs(wrap_angle(here.yaw - heading)) > self.bend:
                total += self.straight_cycles(stretch) + self.turn_cycles(here.yaw - heading)
                stretch = 0.0
            stretch += here.distance_to(there) if lengths is None else lengths[at]
            heading = here.yaw
        total += self.straight_cycles(stretch)
        return total + self.last_turn_cycles(plan.poses[-1].yaw - heading)

    def walking_time(self, start: Pose2D, plan: Plan) -> float:
        """Return how long a plan takes [s]; parameters as for :meth:`cycles`."""
        return self.cycle_period * self.cycles(start, plan)


def paces_file(robot: str | Path) -> Path:
    """
    Say where a robot's paces are kept.

    Parameters
    ----------
    robot : str or Path
        Name of a robot that ships, or path of a robot data file.

    Returns
    -------
    Path
        Beside the robot's data file: ``my_robot.pace.yaml``, or in the folder ``pace`` of
        the robots that ship. It need not exist.
    """
    data = robot_file(robot)
    if data.parent == ROBOTS_FOLDER:
        return ROBOTS_FOLDER / 'pace' / data.name
    return data.with_suffix('.pace.yaml')


def load_paces(path: Path) -> dict[str, WalkingTimeModel]:
    """
    Load a file of paces.

    Parameters
    ----------
    path : Path
        Written by :func:`save_paces`; one that is not there holds nothing.

    Returns
    -------
    dict of str to WalkingTimeModel
        By the gaits' names.

    Raises
    ------
    ParameterError
        If the file is damaged.
    """
    if not path_exists(path):
        return {}
    try:
        document = read_yaml(path, _WHAT, 'the key paces')
    except FileUnusable as error:
        raise ParameterError('paces', str(path), f'a file of paces ({error.reason})') from error
    try:
        check_keys(document, ('paces',))
        entries = document['paces']
        if not isinstance(entries, dict):
            raise ParameterError('paces', entries, 'keys, each the name of a gait')
        return {gait: _pace(gait, entry) for gait, entry in entries.items()}
    except ParameterError as error:
        raise error.at(f'{_WHAT} {path}: ') from error


def load_pace(robot: str | Path, gait: str) -> WalkingTimeModel:
    """
    Load the pace of a gait on a robot.

    Parameters
    ----------
    robot : str or Path
        Name of a robot that ships, or path of a robot data file.
    gait : str
        Name of the gait, or path of a gait file.

    Returns
    -------
    WalkingTimeModel
        From the robot's file of paces.

    Raises
    ------
    ParameterError
        If that file is damaged, or the gait is not in it.
    """
    path = paces_file(robot)
    paces = load_paces(path)
    name = Path(gait).stem
    if name not in paces:
        known = ', '.join(sorted(paces)) or 'none'
        raise ParameterError(
            'gait',
            gait,
            f'one whose pace is in {path} ({known}); '
            f'written by: quadwalk gait pace {gait} --robot {robot}',
        )
    return paces[name]


def save_paces(paces: Mapping[str, WalkingTimeModel], path: Path, heading: Iterable[str]) -> None:
    """
    Write paces, under lines of comment that say where they come from.

    Parameters
    ----------
    paces : mapping of str to WalkingTimeModel
        By the gaits' names.
    path : Path
        The file.
    heading : iterable of str
        Lines of comment.
    """
    entries = {
        gait: {name: round(value, 6) for name, value in asdict(pace).items()}
        for gait, pace in paces.items()
    }
    text = ''.join(f'# {line}\n' for line in heading)
    make_folder(path.parent)
    write_text(path, text + yaml.safe_dump({'paces': entries}, sort_keys=False), _WHAT)


def _pace(gait: str, entry: object) -> WalkingTimeModel:
    """Read the pace of a gait."""
    name = f'paces.{gait}'
    if not isinstance(entry, dict):
        raise ParameterError(name, entry, f'keys: {", ".join(QUANTITIES)}')
    check_keys(entry, QUANTITIES, name)
    missing = [key for key in ('cycle_period', 'stride', 'turn') if key not in entry]
    if missing:
        raise ParameterError(name, entry, f'complete: {", ".join(missing)} is missing')
    return WalkingTimeModel(
        **{key: QUANTITIES[key].check(f'{name}.{key}', value) for key, value in entry.items()}
    )
