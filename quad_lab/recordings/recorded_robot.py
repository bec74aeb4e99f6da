"""
Which robot was recorded: by its name, or by the description that it published.
"""

from __future__ import annotations

from pathlib import Path

from std_msgs.msg import String

from quad_common.errors import ParameterError
from quad_common.named_robots.robot_cache import described_file
from quad_common.robot.robot import Robot
from quad_common.robot.urdf import published_urdf
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_lab.recordings.recorded_messages import RecordedMessages
from quad_lab.recordings.recorded_topics import DESCRIPTION
from quad_lab.recordings.recording_reader import facts_of


def recorded_robot(folder: Path, messages: RecordedMessages) -> Robot:
    """
    Load the robot of a recording.

    Parameters
    ----------
    folder : Path
        The recording.
    messages : RecordedMessages
        What it holds.

    Returns
    -------
    Robot
        The one that quadwalk has noted; else the one whose ``robot_description`` was recorded.

    Raises
    ------
    ParameterError
        If there is neither.
    RobotModelError
        If the robot that was noted cannot be loaded.
    DescriptionError
        If the description cannot be imported.
    """
    if name := facts_of(folder).get('robot'):
        return load_robot(str(name))
    described = messages.first(DESCRIPTION.name, String)
    if described is None:
        raise ParameterError(
            '--robot', '', 'given with this recording, which neither names nor describes its robot'
        )
    for name in available_robots():
        shipped = load_robot(name)
        if published_urdf(shipped) == described.data:
            return shipped
    return load_robot(described_file(described.data))
