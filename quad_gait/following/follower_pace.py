"""
How many cycles a follower needs, for planners that plan the walking time.
"""

from __future__ import annotations

from quad_common.errors import CannotFollow, CyclePeriodsDiffer
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.step import AT_ONCE, Gear


def pace_of(
    walking: Gear, turning: Gear, options: FollowerOptions | None = None, sweep: float = 0.0
) -> WalkingTimeModel:
    """
    Say how many cycles a follower needs for stretches and turns, for a planner to know.

    Parameters
    ----------
    walking : Gear
        The gait for walking.
    turning : Gear
        The gait for turning on the spot, with cycles as long.
    options : FollowerOptions, optional
        How plans are followed, ``in_place``.
    sweep : float
        Distance by which the robot's parts leave its footprint in a turn on the spot [m].

    Returns
    -------
    WalkingTimeModel
        What :func:`~quad_gait.following.step.advance` makes of lengths and angles.

    Raises
    ------
    CannotFollow
        If the gaits can do nothing at all.
    GaitError
        If their cycles are not equally long.
    """
    options = options or FollowerOptions()
    if abs(walking.period - turning.period) > 1e-9:
        raise CyclePeriodsDiffer(walking.period, turning.period)
    stride = walking.largest_scale(BodyMotion(forward=1.0))
    turns = [turning.largest_scale(BodyMotion(turn=sign)) for sign in (1.0, -1.0)]
    if not stride > 0.0:
        raise CannotFollow('walk straight on', walking.reason(BodyMotion(forward=1.0)))
    if not min(turns) > 0.0:
        raise CannotFollow('turn on the spot', turning.reason(BodyMotion(turn=1.0)))
    return WalkingTimeModel(
        cycle_period=walking.period,
        stride=stride,
        turn=min(turns),
        stopping=1.0 - AT_ONCE if walking.is_steady else 0.0,
        bend=options.turn_threshold,
        heading_tolerance=options.heading_tolerance,
        sweep=sweep,
    )
