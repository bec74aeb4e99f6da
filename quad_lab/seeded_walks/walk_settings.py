"""
What can vary between walks, by name: one table with ranges, besides the parameters of the nodes.

A *case* is what a campaign says of a walk: names and values. Names without a point are those of
:class:`WalkSettings`; ``gait.NAME`` is a number of the gait's file, ``gait_node.NAME`` and
``planner_node.NAME`` are parameters of the nodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from quad_common.errors import ParameterError, UnknownKey
from quad_common.parameters import Value, checked_parameters, parameter, parameters_of
from quad_gait.cycle.gait_document import QUANTITIES
from quad_gait.parameters import GaitParameters
from quad_planner.parameters import PlannerParameters

Case = Mapping[str, Value]
"""Names and values, as at the head of this module."""

GAIT_NUMBERS = ('cycle_period', 'duty_factor', 'swing_height', 'support_depth', 'sway_weight')
"""Numbers of a gait's file that can vary."""

TASKS = ('goal', 'steer')
"""A walk to a goal on a map, and one that is steered in one direction on an open floor."""

DIRECTIONS = ('forward', 'backward', 'left', 'turn')
"""Directions of steering."""

_OWN = ('robot', 'gait')
"""Parameters of the nodes that the settings give."""

_NODES = {'gait_node': GaitParameters, 'planner_node': PlannerParameters}

_GAIT = 'gait'


@dataclass(frozen=True)
class WalkSettings:
    """What varies between walks, besides the gait's numbers and the parameters of the nodes."""

    task: str = parameter(
        'goal',
        'A walk to a goal on a map, or one that is steered on an open floor.',
        choices=TASKS,
    )
    robot: str = parameter('titan_viii', 'Name of a robot, or path of a robot data file.')
    gait: str = parameter('crawl', 'Name of a gait, or path of a gait file.')
    engine: str = parameter('bullet', 'The physics engine.', choices=('bullet', 'mujoco'))
    friction: float = parameter(
        0.8, 'Coulomb friction between feet and ground.', lower=0.01, upper=10.0
    )
    terrain: str = parameter(
        'flat',
        'The ground, as sim_node takes it, for example bumps:height=0.03; bumps, noise and boxes '
        "are drawn by the walk's seed.",
    )
    payload: float = parameter(
        0.0,
        "A mass that is added to the body where the body's own center is; the gait is not told.",
        'kg',
        lower=0.0,
        upper=1000.0,
    )
    position_noise: float = parameter(
        0.0, "Of the measured position, along each axis; a normal noise's deviation.", 'm', 0.0, 1.0
    )
    heading_noise: float = parameter(0.0, 'Of the measured heading.', 'rad', 0.0, 1.0)
    joint_noise: float = parameter(0.0, 'Of the measured joint angles.', 'rad', 0.0, 1.0)
    map: str = parameter(
        'room', 'Of goals: a sample map, the path of a Nav2 map, or random, a room with obstacles.'
    )
    shortest: float = parameter(0.5, 'Least length of the plan to the goal.', 'm', 0.05, 1e3)
    longest: float = parameter(2.0, 'Largest length of the plan to the goal.', 'm', 0.05, 1e3)
    timeout: float = parameter(
        1800.0, 'A walk to a goal is given up after so long, simulated.', 's', 1.0, 1e5
    )
    direction: str = parameter('forward', 'Direction of steering.', choices=DIRECTIONS)
    speed: float = parameter(
        0.0, 'Speed of steering, in rad/s for turn; 0: as fraction says.', 'm/s', 0.0, 100.0
    )
    fraction: float = parameter(
        0.6,
        'Fraction of the most that the gait, with none of its numbers changed, does in that '
        'direction.',
        lower=0.01,
        upper=1.0,
    )
    duration: float = parameter(12.0, 'Duration of steering, simulated.', 's', 2.0, 1e4)


@dataclass(frozen=True)
class Walk:
    """A case, checked and completed by defaults."""

    settings: WalkSettings
    """What varies."""
    gait_numbers: Mapping[str, float]
    """Numbers of the gait that are not its file's."""
    gait_node: GaitParameters
    """Parameters as of the node that walks."""
    planner_node: PlannerParameters
    """Parameters as of the node that plans."""


def checked_value(name: str, value: object) -> Value:
    """
    Check one value of a case.

    Parameters
    ----------
    name : str
        Its name.
    value : object
        What was given.

    Returns
    -------
    bool, int, float, str or list of float
        The value, of its own type.

    Raises
    ------
    ParameterError
        If there is no such name, or the value is not valid.
    """
    room, point, inner = name.partition('.')
    if point and room == _GAIT:
        if inner not in GAIT_NUMBERS:
            raise UnknownKey(_GAIT, inner, GAIT_NUMBERS)
        return QUANTITIES[inner].check(name, value)
    table = _NODES.get(room, WalkSettings) if point else WalkSettings
    known = {item.name: item for item in parameters_of(table)}
    if point:
        if room not in _NODES:
            raise UnknownKey('', name, (*_names(WalkSettings), 'gait.*', 'gait_node.*',
                                        'planner_node.*'))  # fmt: skip
        known = {key: item for key, item in known.items() if key not in _OWN}
        if inner not in known:
            raise UnknownKey(room, inner, known)
    elif name not in known:
        raise UnknownKey('', name, (*known, 'gait.*', 'gait_node.*', 'planner_node.*'))
    try:
        return known[inner if point else name].check(value)
    except ParameterError as error:
        raise ParameterError(name, error.value, error.valid) from error


def checked_case(case: Mapping[str, object]) -> dict[str, Value]:
    """Check all values of a case; return them sorted by name, of their own types."""
    return {name: checked_value(name, case[name]) for name in sorted(case)}


def walk_of(case: Case) -> Walk:
    """
    Complete a case by the defaults.

    Parameters
    ----------
    case : mapping
        As :func:`checked_case` returns it.

    Returns
    -------
    Walk
        What to walk.

    Raises
    ------
    ParameterError
        If a value is not valid, or the lengths of plans exclude each other.
    """
    settings = checked_parameters(
        WalkSettings, {name: value for name, value in case.items() if '.' not in name}
    )
    if settings.shortest >= settings.longest:
        raise ParameterError('shortest', settings.shortest, f'below longest, {settings.longest:g}')
    own = {'robot': settings.robot, 'gait': settings.gait}
    uneven = {} if settings.terrain == 'flat' else {'ground': 'uneven'}
    return Walk(
        settings,
        {name: float(value) for name, value in _inner(case, _GAIT).items()},  # type: ignore[arg-type]
        checked_parameters(GaitParameters, {**uneven, **_inner(case, 'gait_node'), **own}),
        checked_parameters(PlannerParameters, {**_inner(case, 'planner_node'), **own}),
    )


def _inner(case: Case, room: str) -> dict[str, Value]:
    """Return the values of names in a room, by what follows the point."""
    prefix = f'{room}.'
    return {name[len(prefix) :]: value for name, value in case.items() if name.startswith(prefix)}


def _names(table: type) -> tuple[str, ...]:
    return tuple(item.name for item in parameters_of(table))
