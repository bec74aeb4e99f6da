"""
From a path of turning points to joint trajectories for four legs.

The core (everything but ``ros_conversions`` and ``gait_node``) imports no rclpy.
"""

from quad_common.lazy_names import lazy_names

TYPE_CHECKING = False

if TYPE_CHECKING:
    from quad_gait.behaviours.activity import Activity as Activity
    from quad_gait.behaviours.options import SupervisorOptions as SupervisorOptions
    from quad_gait.cycle.body_motion import BodyMotion as BodyMotion
    from quad_gait.cycle.cycle import Cycle as Cycle
    from quad_gait.cycle.cycle import CycleEnds as CycleEnds
    from quad_gait.cycle.gait import Gait as Gait
    from quad_gait.cycle.gait import available_gaits as available_gaits
    from quad_gait.cycle.gait import load_gait as load_gait
    from quad_gait.cycle.gait import turning_gait_for as turning_gait_for
    from quad_gait.cycle.gait_check import GaitReport as GaitReport
    from quad_gait.cycle.gait_check import check_gait as check_gait
    from quad_gait.cycle.gait_generator import CycleOptions as CycleOptions
    from quad_gait.cycle.gait_generator import generate_cycle as generate_cycle
    from quad_gait.cycle.gait_generator import generate_steady_cycle as generate_steady_cycle
    from quad_gait.cycle.motion_limits import MotionLimits as MotionLimits
    from quad_gait.cycle.stability import stability_margin as stability_margin
    from quad_gait.cycle.stability import support_polygon as support_polygon
    from quad_gait.following.follower_options import FollowerOptions as FollowerOptions
    from quad_gait.state.leg_odometry import LegOdometry as LegOdometry
    from quad_gait.state.measurement import Measurement as Measurement
    from quad_gait.state.robot_state import RobotState as RobotState
    from quad_gait.state.state_estimator import StateEstimator as StateEstimator
    from quad_gait.supervisor import Supervisor as Supervisor
else:
    __getattr__, __dir__, __all__ = lazy_names(
        __name__,
        {
            'quad_gait.cycle.gait': ('Gait', 'available_gaits', 'load_gait', 'turning_gait_for'),
            'quad_gait.cycle.body_motion': ('BodyMotion',),
            'quad_gait.cycle.cycle': ('Cycle', 'CycleEnds'),
            'quad_gait.cycle.gait_generator': (
                'CycleOptions',
                'generate_cycle',
                'generate_steady_cycle',
            ),
            'quad_gait.cycle.motion_limits': ('MotionLimits',),
            'quad_gait.cycle.gait_check': ('GaitReport', 'check_gait'),
            'quad_gait.cycle.stability': ('stability_margin', 'support_polygon'),
            'quad_gait.state.measurement': ('Measurement',),
            'quad_gait.state.robot_state': ('RobotState',),
            'quad_gait.state.state_estimator': ('StateEstimator',),
            'quad_gait.state.leg_odometry': ('LegOdometry',),
            'quad_gait.following.follower_options': ('FollowerOptions',),
            'quad_gait.behaviours.activity': ('Activity',),
            'quad_gait.behaviours.options': ('SupervisorOptions',),
            'quad_gait.supervisor': ('Supervisor',),
        },
    )
