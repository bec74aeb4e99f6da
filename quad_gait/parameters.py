"""The parameters of ``gait_node``."""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.parameters import parameter


@dataclass(frozen=True)
class GaitParameters:
    """Parameters of ``gait_node``."""

    robot: str = parameter('titan_viii', 'Name of a robot, or path of a robot data file.')
    gait: str = parameter('crawl', 'Gait for walking: its name, or the path of a gait file.')
    turning: str = parameter(
        'in_place', 'How the plan is followed: turning on the spot.', choices=('in_place',)
    )
    turning_gait: str = parameter(
        'turn', 'Gait for turning on the spot to the left: its name, or the path of a gait file.'
    )
    map_frame: str = parameter('map', 'Frame of the plans; it coincides with that of the odometry.')
    transient_local_plan: bool = parameter(
        True, "Hear the last plan when starting late; false to hear volatile plans, as Nav2's."
    )
    odom_topic: str = parameter('odom', "Where the robot's pose comes from.")
    settle_time: float = parameter(
        0.2, "After a cycle's end, before the pose is measured for the next.", 's', 0.0, 10.0
    )
    lead_time: float = parameter(
        0.3, 'A trajectory is published at least so long before its first movement.', 's', 0.0, 10.0
    )
    sample_period: float = parameter(
        0.02, "Between a trajectory's points.", 's', lower=0.002, upper=0.1
    )
    least_margin: float = parameter(
        0.01, 'Cycles with a smaller predicted stability margin are shortened.', 'm', lower=0.0
    )
    position_tolerance: float = parameter(
        0.02, 'The robot is at a turning point or the goal when it is this near.', 'm', 0.005, 1.0
    )
    heading_tolerance: float = parameter(
        0.035, "The robot has the goal's heading when it is this near.", 'rad', 0.005, 1.0
    )
    path_tolerance: float = parameter(
        0.5, 'Farther from its plan the robot stops and waits for a new one.', 'm', lower=0.05
    )
    odom_timeout: float = parameter(1.0, 'Older odometry is said to be missing.', 's', lower=0.05)
