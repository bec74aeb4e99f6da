"""The parameters of ``sim_node``."""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.parameters import parameter
from quad_common.trajectory.joint_trajectory import LONGEST_TRAJECTORY
from quad_common.vision.color_parameters import color_parameter
from quad_sim.engines.registry import AUTO, BACKENDS
from quad_sim.engines.simulator import FAILURES


@dataclass(frozen=True)
class SimParameters:
    """Parameters of ``sim_node``."""

    robot: str = parameter('titan_viii', 'Name of a robot, or path of a robot data file.')
    robots: str = parameter(
        '',
        'Several robots in one world, each with its topics in a namespace: "titan_viii, cuhk, a1", '
        'or with names and places "left=cuhk@1,2,0; right=a1@4,2,3.14"; empty: the one of '
        "'robot'; 'none': a world without any. A change spawns those that are new, and removes "
        'those that are missing.',
        is_dynamic=True,
    )
    map_file: str = parameter(
        '', "Nav2 map file; empty: the sample map 'room'; 'none': an empty floor, no map."
    )
    publish_map: bool = parameter(
        True,
        'Publish the map; false: another node, such as ceiling_camera_node, has to publish it.',
    )
    publish_tf: bool = parameter(
        True, 'Publish transforms; false: the node that localises the robot publishes them.'
    )
    publish_clock: bool = parameter(
        True,
        'Publish simulated time on /clock; false: another simulator in this ROS domain does. Nodes '
        'that belong to this one then need use_sim_time false.',
    )
    room_seed: int = parameter(
        -1, 'Of a room of obstacles at random, in place of a map; -1: none.', lower=-1
    )
    room_obstacles: int = parameter(
        -1, 'How many obstacles the room has; -1: 3 to 12, drawn.', lower=-1, upper=12
    )
    terrain: str = parameter(
        'flat',
        'Ground: flat, bumps, slope, cross_slope, kerb, noise, boxes, stairs, stones, gap, beam, '
        "or a height map file; '+' adds several.",
    )
    terrain_height: float = parameter(
        0.04,
        'Of the highest bumps, boxes and waves of noise, of kerbs and of each stair; by which '
        'stepping stones differ.',
        'm',
        0.0,
        1.0,
    )
    terrain_angle: float = parameter(0.15, 'Of slopes.', 'rad', lower=-0.6, upper=0.6)
    terrain_size: float = parameter(
        0.4,
        "Mean diameter of bumps, diagonal of boxes, length of noise's waves, depth of treads, side "
        'of stepping stones.',
        'm',
        0.1,
        10.0,
    )
    terrain_length: float = parameter(
        1.5,
        'Of each of the three parts of a slope, of a kerb, of the landing above stairs, of the '
        'path over stepping stones and of a beam.',
        'm',
        0.1,
        100.0,
    )
    terrain_clear: float = parameter(
        0.8, 'Of the level ground around start and goal: its radius.', 'm', 0.0, 10.0
    )
    terrain_seed: int = parameter(0, 'Of bumps, noise, boxes and stepping stones.', lower=0)
    publish_height_map: bool = parameter(
        True, 'Publish the height map of uneven ground; false: the robot has to feel its way.'
    )
    start_pose: list[float] = parameter(
        [1.2, 1.2, 0.0], 'Where the robot stands at first: x, y, yaw in the map.', 'm, m, rad'
    )
    real_time_factor: float = parameter(
        1.0, 'Simulated over real time; 0: as fast as possible.', lower=0.0
    )
    backend: str = parameter(
        AUTO,
        'Physics, or a simulator that follows commands exactly; auto: the first physics engine of '
        'these that is installed.',
        choices=BACKENDS,
    )
    failing_joint: str = parameter(
        '',
        "Name of a joint that fails; empty: none. A failed one is sound again after 'reset'.",
        is_dynamic=True,
    )
    failure: str = parameter(
        'free',
        'How it fails: its motor gives no torque, or it keeps its angle whatever is commanded.',
        choices=FAILURES,
        is_dynamic=True,
    )
    failure_time: float = parameter(
        0.0,
        'When it fails, in simulated time; at once if that is over.',
        's',
        lower=0.0,
        is_dynamic=True,
    )
    push_duration: float = parameter(
        0.1,
        "Simulated time for which a message on 'push' pushes the robot.",
        's',
        lower=0.001,
        upper=60.0,
        is_dynamic=True,
    )
    longest_trajectory: int = parameter(
        LONGEST_TRAJECTORY,
        'Joint trajectories with more points are refused.',
        lower=1,
        upper=1_000_000,
    )
    most_obstacles: int = parameter(
        1000, "So many obstacles may stand at once by 'obstacles'.", lower=0, upper=10_000
    )
    gui: bool = parameter(False, "Show the engine's own window, where it has one.")
    seed: int = parameter(0, 'Of the noise of the simulated sensors.', lower=0)
    time_step: float = parameter(
        0.005, 'Of the physics; /clock comes at 100 Hz at least.', 's', lower=0.001, upper=0.01
    )
    sensor_rate: float = parameter(
        50.0,
        'How often odom, joint_states, imu and tf are published.',
        'Hz',
        lower=1.0,
        upper=1000.0,
    )
    friction: float = parameter(
        0.8, 'Coulomb friction between feet and ground.', lower=0.0, upper=10.0
    )
    gyroscope_noise: float = parameter(
        0.002, "Standard deviation of the imu's angular velocity.", 'rad/s', 0.0, 100.0
    )
    accelerometer_noise: float = parameter(
        0.02, "Standard deviation of the imu's acceleration.", 'm/s^2', 0.0, 1000.0
    )
    odom_position_noise: float = parameter(
        0.0, "Standard deviation of odom's position.", 'm', 0.0, 10.0
    )
    odom_yaw_noise: float = parameter(0.0, "Standard deviation of odom's heading.", 'rad', 0.0, 3.0)
    odom_drift: float = parameter(
        0.0,
        'Drift of odom as real odometry has it: fraction of the distance and of the angle turned, '
        'and radians a metre.',
        lower=0.0,
        upper=0.5,
    )
    localiser_rate: float = parameter(
        0.0,
        'How often a localiser publishes map -> odom on map_to_odom and tf; 0: there is none.',
        'Hz',
        lower=0.0,
        upper=50.0,
    )
    localiser_noise: float = parameter(
        0.02, 'Standard deviation of the position it sees, along each axis.', 'm', 0.0, 10.0
    )
    localiser_heading_noise: float = parameter(
        0.01, 'Standard deviation of the heading it sees.', 'rad', 0.0, 3.0
    )
    camera: bool = parameter(False, 'Publish pictures of a camera under the ceiling.')
    camera_rate: float = parameter(
        2.0, 'How often there is a picture, in simulated time.', 'Hz', lower=0.01, upper=100.0
    )
    camera_position: list[float] = parameter(
        [4.0, 4.0, 6.0], 'Where the camera is in the map; it looks straight down.', 'm'
    )
    camera_yaw: float = parameter(0.0, "Direction in the map of the picture's right side.", 'rad')
    camera_field_of_view: float = parameter(
        1.4, "Angle that the picture's width spans.", 'rad', lower=0.01, upper=3.0
    )
    camera_size: list[float] = parameter(
        [640.0, 640.0], 'Width and height of the picture, 16 to 2048 each.', 'pixels'
    )
    camera_distortion: list[float] = parameter(
        [0.0, 0.0, 0.0, 0.0, 0.0], 'Of the lens, plumb_bob: k1, k2, p1, p2, k3.'
    )
    camera_noise: float = parameter(
        0.0, 'Standard deviation of each number in a picture, of 255.', lower=0.0, upper=255.0
    )
    camera_brightness: float = parameter(
        1.0, 'By which the numbers in a picture are multiplied.', lower=0.0, upper=10.0
    )
    obstacle_color: list[float] = color_parameter('obstacle_color')
    floor_color: list[float] = parameter([205.0, 205.0, 200.0], 'Red, green and blue of the floor.')
    floor_checker: float = parameter(
        0.0, 'Side of the squares of a pattern on the floor; 0: none.', 'm', lower=0.0, upper=10.0
    )
    front_color: list[float] = color_parameter('front_color')
    rear_color: list[float] = color_parameter('rear_color')
    goal_color: list[float] = color_parameter('goal_color')
    goal_heading_color: list[float] = color_parameter('goal_heading_color')
    camera_frame: str = parameter(
        'ceiling_camera', 'Frame of the camera: x right and y down in the picture.'
    )
    frame_prefix: str = parameter(
        '',
        "What the robot's own frames begin with, as robot_state_publisher's frame_prefix; of "
        "several robots in one world each has its name and '/' after it.",
    )
    map_frame: str = parameter('map', 'Frame of the map.')
    odom_frame: str = parameter(
        'odom', 'Frame of the odometry; it coincides with the map unless odometry drifts.'
    )
    base_frame: str = parameter('base_link', "Frame of the robot's body.")
    footprint_frame: str = parameter('base_footprint', 'Frame on the ground under the body.')
