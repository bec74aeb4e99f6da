"""
What the nodes say, in plain words: who is there, who is missing, and what follows from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from quad_common.status import Level

SILENT = 3.5
"""A node that has said nothing for so long does not run: each speaks every second [s]."""

_MOST_OTHERS = 50
"""Nodes besides quadwalk's own whose words are shown."""

NO_ROBOT = (
    "no robot: nobody publishes 'joint_states'; start a simulator (sim_node) or the robot's "
    'driver, in the same ROS_DOMAIN_ID'
)
"""What is said where there is no robot at all."""

_WITHOUT = {
    'sim_node': 'nothing moves the robot, unless a real one does',
    'planner_node': 'no path to a goal is planned',
    'gait_node': 'the robot does not walk, stand up, or stop',
}
"""What is missing without a node."""


@dataclass(frozen=True)
class Said:
    """What a node has said of itself."""

    level: Level
    """Level of concern."""
    message: str
    """Sentence for a reader."""
    values: Mapping[str, str] = field(default_factory=dict)
    """Values beside it."""
    at: float = 0.0
    """Time at which it was received [s]."""


def newest_said(said: Mapping[str, Said]) -> dict[str, Said]:
    """Return what the nodes of quadwalk have said, and of others so many as a page can show."""
    others = [name for name in said if name not in _WITHOUT]
    others.sort(key=lambda name: said[name].at, reverse=True)
    kept = {*_WITHOUT, *others[:_MOST_OTHERS]}
    return {name: word for name, word in said.items() if name in kept}


@dataclass(frozen=True)
class Line:
    """A sentence about a node."""

    level: Level
    """Level of concern."""
    node: str
    """Name of the node."""
    text: str
    """Sentence."""


def lines(said: Mapping[str, Said], has_robot: bool, now: float) -> tuple[Line, ...]:
    """
    Say of each node what it does, or what follows from its absence.

    Parameters
    ----------
    said : mapping of str to Said
        What each node said last, by its name.
    has_robot : bool
        Whether a robot's joint states and odometry come in.
    now : float
        Time [s].

    Returns
    -------
    tuple of Line
        One for each node that is there or should be.
    """
    rows = []
    for node in sorted({*_WITHOUT, *said}):
        word = said.get(node)
        if word is not None and now - word.at <= SILENT:
            rows.append(Line(word.level, node, word.message))
        elif node == 'sim_node' and has_robot and word is None:
            # A real robot needs no simulator.
            continue
        elif word is not None:
            rows.append(Line(Level.ERROR, node, f'has ended, or hangs: {_lack(node)}'))
        elif node in _WITHOUT:
            rows.append(Line(Level.ERROR, node, f'is missing: {_lack(node)}'))
    return tuple(rows)


def headline(
    said: Mapping[str, Said], has_robot: bool, is_stopped: bool, now: float
) -> tuple[Level, str]:
    """
    Say in one sentence what the robot does, or why it does not move.

    Parameters
    ----------
    said, has_robot, now
        As of :func:`lines`.
    is_stopped : bool
        Whether the emergency stop is on.

    Returns
    -------
    tuple of Level and str
        Level of concern, and sentence.
    """
    if is_stopped:
        return Level.ERROR, 'emergency stop: all joints hold; release it, then let the robot stand'
    if not has_robot:
        return Level.WARN, 'no robot: waiting for its joint_states and odom'
    rows = {line.node: line for line in lines(said, has_robot, now)}
    gait, planner = rows['gait_node'], rows['planner_node']
    if gait.level >= Level.WARN or 'gait_node' not in said:
        return gait.level, _named(gait)
    # A robot that stands because its goal was refused says only that it has no plan.
    activity = said['gait_node'].values.get('activity', '')
    if planner.level >= Level.WARN and activity in ('standing', 'arrived', ''):
        return planner.level, _named(planner)
    return gait.level, gait.text


def _named(line: Line) -> str:
    """Name the node where the sentence needs a subject."""
    return f'{line.node} {line.text}' if line.text.startswith(('is ', 'has ')) else line.text


def _lack(node: str) -> str:
    return f'{_WITHOUT.get(node, "it no longer does its work")}; start it with: {node}'
