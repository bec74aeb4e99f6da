"""
What every part of quadwalk shares: errors, geometry, maps, trajectories, robots.

This package is a leaf: it imports no other package of quadwalk, and its core
modules import neither rclpy nor pybullet.
"""

from quad_common.lazy_names import lazy_names

TYPE_CHECKING = False

if TYPE_CHECKING:
    from quad_common.errors import QuadError as QuadError
    from quad_common.maps.height_map import HeightMap as HeightMap
    from quad_common.maps.height_map_file import load_height_map as load_height_map
    from quad_common.maps.height_map_file import save_height_map as save_height_map
    from quad_common.maps.map_file import load_map as load_map
    from quad_common.maps.map_file import save_map as save_map
    from quad_common.maps.occupancy_grid import OccupancyGrid as OccupancyGrid
    from quad_common.plan import Plan as Plan
    from quad_common.planar_pose import Pose2D as Pose2D
    from quad_common.planar_pose import Twist2D as Twist2D
    from quad_common.resources import sample_map as sample_map
    from quad_common.robot.robot import Robot as Robot
    from quad_common.robot.urdf import urdf_from_robot as urdf_from_robot
    from quad_common.robot_files.robot_file import available_robots as available_robots
    from quad_common.robot_files.robot_file import load_robot as load_robot
    from quad_common.robot_files.walking_time import WalkingTimeModel as WalkingTimeModel
    from quad_common.robot_files.walking_time import load_pace as load_pace
    from quad_common.trajectory.joint_trajectory import JointTrajectory as JointTrajectory
    from quad_common.vision.camera import CameraModel as CameraModel
    from quad_common.vision.camera_file import load_camera as load_camera
    from quad_common.vision.camera_file import save_camera as save_camera
else:
    __getattr__, __dir__, __all__ = lazy_names(
        __name__,
        {
            'quad_common.errors': ('QuadError',),
            'quad_common.planar_pose': ('Pose2D', 'Twist2D'),
            'quad_common.plan': ('Plan',),
            'quad_common.resources': ('sample_map',),
            'quad_common.maps.occupancy_grid': ('OccupancyGrid',),
            'quad_common.maps.map_file': ('load_map', 'save_map'),
            'quad_common.maps.height_map': ('HeightMap',),
            'quad_common.maps.height_map_file': ('load_height_map', 'save_height_map'),
            'quad_common.robot.robot': ('Robot',),
            'quad_common.robot_files.robot_file': ('available_robots', 'load_robot'),
            'quad_common.robot.urdf': ('urdf_from_robot',),
            'quad_common.robot_files.walking_time': ('WalkingTimeModel', 'load_pace'),
            'quad_common.trajectory.joint_trajectory': ('JointTrajectory',),
            'quad_common.vision.camera': ('CameraModel',),
            'quad_common.vision.camera_file': ('load_camera', 'save_camera'),
        },
    )
