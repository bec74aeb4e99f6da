"""The parameters of ``gait_node``."""

from __future__ import annotations

import math
from dataclasses import dataclass

from quad_common.parameters import parameter
from quad_common.plan import LONGEST_PLAN
from quad_common.robot.robot import Robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import Gait, load_gait, resting, turning_gait_for
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.state.sensor_inputs import InputOptions
from quad_gait.state.state_estimator import EstimatorOptions
from quad_gait.uneven.uneven_options import UnevenOptions, check_suits_uneven_ground


@dataclass(frozen=True)
class GaitParameters:
    """Parameters of ``gait_node``."""

    robot: str = parameter('titan_viii', 'Name of a robot, or path of a robot data file.')
    gait: str = parameter(
        'crawl', 'Gait for walking: its name, or the path of a gait file.', is_dynamic=True
    )
    turning: str = parameter(
        'in_place',
        'How a plan is followed: turning on the spot, keeping the heading, or along arcs.',
        choices=('in_place', 'crab', 'arc'),
        is_dynamic=True,
    )
    turning_gait: str = parameter(
        'auto',
        "Gait for turning on the spot: a name, the path of a file, or 'auto': 'turn' if the "
        'gait for walking rests between cycles, and that gait itself if it does not.',
        is_dynamic=True,
    )
    largest_speed: float = parameter(
        0.0,
        'A plan is walked no faster; 0 for as fast as the gait allows.',
        'm/s',
        lower=0.0,
        is_dynamic=True,
    )
    balance: bool = parameter(
        False,
        'Whether the robot keeps its balance in gaits with two feet down, as the trot: decisions '
        'are made at every measurement, by joints and imu, and not once a cycle. Feet are put down '
        'on the ground of height_map where there is one.',
    )
    balance_reaction_time: float = parameter(
        0.02,
        'With balance, time that a trajectory has to reach the joints: what runs holds until then.',
        's',
        lower=0.0,
        upper=0.1,
    )
    steps_in_place: bool = parameter(
        False, 'With balance, whether a robot that is steered at zero trots in place.'
    )
    ground: str = parameter(
        'flat',
        "What the robot walks on. 'uneven': each foot is lowered until it bears load, the body "
        'is kept level, and steps go by height_map where there is one.',
        choices=('flat', 'uneven'),
    )
    reaction_time: float = parameter(
        0.06,
        'On uneven ground, time from a foot contact to the start of the trajectory that answers '
        'it; the trajectory must reach the joints within this time.',
        's',
        lower=0.01,
        upper=0.5,
    )
    footsteps: bool = parameter(
        False,
        'On uneven ground with a height map, whether footholds are planned ahead, foot by foot, '
        'where strides would not find even ground: on stairs, stepping stones and beams.',
    )
    foot_tracking: str = parameter(
        'inverse_kinematics',
        'How foot paths become joint motion: in closed form, or by the law of S1.',
        choices=('inverse_kinematics', 'backstepping'),
    )
    tracking_gain: float = parameter(4.0, "Gain K of 'backstepping'.", '1/s', 0.1, 50.0)
    calibration: str = parameter(
        'auto',
        "Slip compensation: 'auto' for the robot's own, if it has any, 'none', or a file "
        'of quadwalk calibrate.',
    )
    map_frame: str = parameter(
        'map', "Frame of the map; it coincides with odometry's unless transforms relate the two."
    )
    correction_time_constant: float = parameter(
        3.0,
        'Corrections of odometry are followed as by a first-order filter; 0: each is taken whole.',
        's',
        0.0,
        60.0,
    )
    correction_timeout: float = parameter(
        5.0,
        'Corrections of odometry older than this are reported as old; they stay in force.',
        's',
        lower=0.1,
    )
    longest_plan: int = parameter(
        LONGEST_PLAN, 'Plans with more poses are refused.', lower=1, upper=100_000
    )
    transient_local_plan: bool = parameter(
        True, "Receive the last plan when starting late; false for volatile plans, as Nav2's."
    )
    managed: bool = parameter(
        False,
        "Whether the node works only while ROS 2's lifecycle manager, or `ros2 lifecycle`, has it "
        'active.',
    )
    odom_topic: str = parameter(
        'odom', "Where the robot's pose comes from; 'odom/legs' for the node's own odometry."
    )
    leg_odometry_start: str = parameter(
        'odom',
        "Where odom/legs begins: where odom_topic first has the robot, or at its own frame's "
        'origin, for others to place it on the map.',
        choices=('odom', 'origin'),
    )
    cmd_vel_timeout: float = parameter(
        1.0,
        'A velocity command older than this is no longer followed.',
        's',
        lower=0.05,
        upper=60.0,
    )
    stamped_cmd_vel: bool = parameter(
        False, 'Whether cmd_vel is a TwistStamped, as later ROS distributions have it.'
    )
    trajectory_action: str = parameter(
        '',
        'Action of a joint controller, of type control_msgs/FollowJointTrajectory, to which '
        'trajectories go as goals, besides the topic; empty: none.',
    )
    settle_time: float = parameter(
        0.2, "After a cycle's end at rest, before the pose is measured.", 's', 0.0, 10.0
    )
    lead_time: float = parameter(
        0.3, 'A trajectory is published at least so long before its first movement.', 's', 0.0, 10.0
    )
    sample_period: float = parameter(
        0.02, "Between a trajectory's points.", 's', lower=0.002, upper=0.1
    )
    least_margin: float = parameter(
        0.005,
        'Cycles of static gaits with a smaller predicted stability margin are shortened.',
        'm',
        lower=0.0,
    )
    position_tolerance: float = parameter(
        0.02,
        'The robot is at a turning point or the goal when it is this near.',
        'm',
        lower=0.005,
        upper=1.0,
        is_dynamic=True,
    )
    heading_tolerance: float = parameter(
        0.035,
        "The robot has the goal's heading when it is this near.",
        'rad',
        lower=0.005,
        upper=1.0,
        is_dynamic=True,
    )
    path_tolerance: float = parameter(
        0.5,
        'Farther from its plan the robot stops and waits for a new one.',
        'm',
        lower=0.05,
        is_dynamic=True,
    )
    corner_deviation: float = parameter(
        0.1,
        "How far an arc may pass inside a turning point, with turning 'arc'.",
        'm',
        lower=0.001,
        upper=10.0,
        is_dynamic=True,
    )
    corner_radius: float = parameter(
        1.0,
        "Largest radius of a rounded corner, with turning 'arc'.",
        'm',
        lower=0.01,
        upper=100.0,
        is_dynamic=True,
    )
    odom_timeout: float = parameter(
        1.0, 'Odometry older than this is reported as missing.', 's', lower=0.05
    )
    joint_timeout: float = parameter(
        0.2,
        'Joint states that are older than the odometry by more are missing: the robot comes to '
        'rest.',
        's',
        lower=0.02,
        upper=10.0,
    )
    imu_timeout: float = parameter(
        0.2,
        "The imu's readings that are older than the odometry by more are left out: the "
        "odometry's attitude takes their place.",
        's',
        lower=0.02,
        upper=10.0,
    )
    planner_timeout: float = parameter(
        3.0,
        'If the planner sends no heartbeat for this long, by the wall clock, the robot stops '
        'following the plan until it does; 0: plans are followed to their end. Planners that '
        'publish no heartbeat are not watched.',
        's',
        lower=0.0,
        upper=3600.0,
    )

    @property
    def is_uneven(self) -> bool:
        """Whether the ground is."""
        return self.ground == 'uneven'

    @property
    def uses_height_map(self) -> bool:
        """Whether the robot goes by a map of the ground where there is one."""
        return self.is_uneven or self.balance

    @property
    def has_odometry_by_legs(self) -> bool:
        """Whether the robot's pose is the node's own odometry."""
        return self.odom_topic == 'odom/legs'

    def gaits(self, robot: Robot) -> tuple[Gait, Gait]:
        """Load the gaits for walking and for turning."""
        gait = load_gait(self.gait, robot)
        if self.is_uneven:
            check_suits_uneven_ground(gait)
            gait = resting(gait)
        return gait, turning_gait_for(gait, robot, self.turning_gait)

    @property
    def follower_options(self) -> FollowerOptions:
        """Options for following plans."""
        return FollowerOptions(
            turning=self.turning,
            position_tolerance=self.position_tolerance,
            heading_tolerance=self.heading_tolerance,
            path_tolerance=self.path_tolerance,
            corner_deviation=self.corner_deviation,
            corner_radius=self.corner_radius,
            largest_speed=self.largest_speed or math.inf,
        )

    @property
    def supervisor_options(self) -> SupervisorOptions:
        """Timing and tolerances of the supervisor."""
        uneven = UnevenOptions(
            sample_period=self.sample_period,
            reaction_time=self.reaction_time,
            plans_footsteps=self.footsteps,
        )
        balance = BalanceOptions(
            reaction_time=self.balance_reaction_time, steps_in_place=self.steps_in_place
        )
        return SupervisorOptions(
            settle_time=self.settle_time,
            lead_time=self.lead_time,
            sample_period=self.sample_period,
            least_margin=self.least_margin,
            twist_timeout=self.cmd_vel_timeout,
            tracking_gain=self.tracking_gain if self.foot_tracking == 'backstepping' else None,
            follower=self.follower_options,
            uneven=uneven if self.is_uneven else None,
            balance=balance if self.balance else None,
        )

    @property
    def estimator_options(self) -> EstimatorOptions:
        """Ages that readings may have, and where leg odometry begins."""
        return EstimatorOptions(
            InputOptions(
                self.joint_timeout,
                self.imu_timeout,
                odometry_has_attitude=not self.has_odometry_by_legs,
                needs_attitude=self.is_uneven,
            ),
            has_leg_odometry=True,
            starts_at_origin=self.has_odometry_by_legs or self.leg_odometry_start == 'origin',
        )
