"""
Whether a robot that stands says why: read from what its gait node says on diagnostics.
"""

from __future__ import annotations

from collections.abc import Mapping

from quad_gait.behaviours.activity import Activity

_FIRST_LEVEL = 1
"""WARN; above it are ERROR and STALE (diagnostic_msgs/DiagnosticStatus)."""


def reason_for_standing(level: bytes, message: str, values: Mapping[str, str]) -> str:
    """
    Return why a robot stands, as its gait node says.

    Parameters
    ----------
    level : bytes
        Level of the node's last status, one byte.
    message : str
        Its sentence.
    values : mapping of str to str
        Its values.

    Returns
    -------
    str
        The reason. Empty if the level is OK, if the activity is one of a robot that moves or is
        only ready to, or if nothing follows its name: then it does not say why it stands.
    """
    if not level or level[0] < _FIRST_LEVEL:
        return ''
    activity = values.get('activity', '')
    if not activity:
        # Without odometry or a clock the node does not know what the robot does; it says that.
        return message.strip()
    try:
        stands = Activity(activity)
    except ValueError:
        return ''
    if not stands.is_terminal and stands is not Activity.WAITING:
        return ''
    return message.removeprefix(f'{activity}:').strip()
