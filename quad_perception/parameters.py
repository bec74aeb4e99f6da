"""The parameters of ``ceiling_camera_node``."""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.parameters import parameter
from quad_common.vision.color_parameters import color_parameter


@dataclass(frozen=True)
class CeilingCameraParameters:
    """Parameters of ``ceiling_camera_node``."""

    robot: str = parameter('titan_viii', 'Name of a robot, or path of a robot data file.')
    camera_file: str = parameter(
        '', "Camera file with the camera's pose, from quadwalk camera calibrate; empty: as below."
    )
    camera_position: list[float] = parameter(
        [4.0, 4.0, 6.0], 'Of the camera in the map: x, y, z.', 'm'
    )
    camera_yaw: float = parameter(
        0.0, "Direction in the map of the picture's right side; the camera looks down.", 'rad'
    )
    resolution: float = parameter(0.05, "Side of the map's cells.", 'm', lower=0.01, upper=1.0)
    map_bounds: list[float] = parameter(
        [],
        'x and y of the lower left and the upper right corner; empty: what the camera sees.',
        'm',
        length=4,
    )
    obstacle_color: list[float] = color_parameter('obstacle_color')
    front_color: list[float] = color_parameter('front_color')
    rear_color: list[float] = color_parameter('rear_color')
    goal_color: list[float] = color_parameter('goal_color')
    goal_heading_color: list[float] = color_parameter('goal_heading_color')
    goal_distance: float = parameter(
        0.05, 'A goal marker that moved by less is where it was.', 'm', lower=0.005
    )
    goal_angle: float = parameter(
        0.1, 'A goal marker that turned by less is as it was.', 'rad', lower=0.01
    )
    confirmations: int = parameter(
        2, 'The map changes where so many pictures in a row show it.', lower=1, upper=20
    )
    odometry_topic: str = parameter('odom/legs', 'Odometry between two pictures.')
    slip: float = parameter(
        0.03, "Standard deviation of the legs' odometry, for a metre walked.", 'm', lower=0.001
    )
    turning_slip: float = parameter(
        0.03, 'Of its heading, for a radian turned or a metre walked.', 'rad', lower=0.001
    )
    largest_age: float = parameter(
        3.0, 'Without a picture of the robot for so long its pose is not known.', 's', lower=0.1
    )
    map_frame: str = parameter('map', 'Frame of the map.')
    footprint_frame: str = parameter('base_footprint', 'Frame on the ground under the body.')
    publish_tf: bool = parameter(
        True, "Publish the camera's and the robot's transforms; the simulator then must not."
    )
