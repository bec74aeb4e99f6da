"""
Which robots there are, by the names of what they publish.
"""

from __future__ import annotations

from collections.abc import Iterable

_TOPIC = 'joint_states'

MOST_ROBOTS = 20
"""Robots on one page."""


def namespaces_of(wanted: str, topics: Iterable[str]) -> tuple[str, ...]:
    """
    List the namespaces of robots.

    Parameters
    ----------
    wanted : str
        Namespaces that are asked for, with commas between them; empty for all there are.
    topics : iterable of str
        Names of the topics with joint states.

    Returns
    -------
    tuple of str
        Namespaces without a slash at their ends, in alphabetical order; one may be empty.
    """
    if wanted.strip():
        names = {name.strip().strip('/') for name in wanted.split(',')}
    else:
        names = {
            topic[: -len(_TOPIC)].strip('/')
            for topic in topics
            if topic.rpartition('/')[2] == _TOPIC
        }
    return tuple(sorted(names)[:MOST_ROBOTS])
