"""
Where a foot met the ground, told from what was measured until the contact was sure.
"""

from __future__ import annotations

from quad_common.robot.robot import Robot
from quad_gait.state.stance import Stance


def as_touched(
    robot: Robot, leg: int, before: Stance | None, touched: Stance, now: Stance
) -> Stance:
    """
    Return the robot as it was when the foot met the ground.

    Until the contact is sure the foot presses on, and tilts the body: the other feet are
    where they were before, and this one belongs where it was at the first touch.

    Parameters
    ----------
    robot : Robot
        The robot.
    leg : int
        Index of the leg whose foot it is.
    before : Stance or None
        The last measurement without load on it; None if there was none.
    touched : Stance
        The first with load.
    now : Stance
        The newest.

    Returns
    -------
    Stance
    """
    if before is None:
        return now
    joints = now.joint_positions.copy()
    joints[leg] = touched.joint_positions[leg]
    feet = before.body.transform(robot.foot_positions(joints))
    return Stance(now.time, before.body, feet, joints, lambda: now.loads)
