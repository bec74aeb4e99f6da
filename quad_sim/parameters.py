"""The parameters of ``sim_node``."""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.parameters import parameter
from quad_sim.simulation import BACKENDS


@dataclass(frozen=True)
class SimParameters:
    """Parameters of ``sim_node``."""

    robot: str = parameter('titan_viii', 'Name of a robot, or path of a robot data file.')
    map_file: str = parameter(
        '', "Nav2 map file; empty: the sample map 'room'; 'none': an empty floor, no map."
    )
    start_pose: list[float] = parameter(
        [1.2, 1.2, 0.0], 'Where the robot stands at first: x, y, yaw in the map.', 'm, m, rad'
    )
    real_time_factor: float = parameter(
        1.0, 'Simulated over real time; 0: as fast as possible.', lower=0.0
    )
    backend: str = parameter(
        'bullet', 'Physics, or a simulator that follows commands exactly.', choices=BACKENDS
    )
    gui: bool = parameter(False, "Show PyBullet's own window.")
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
    friction: float = parameter(0.8, 'Coulomb friction between feet and ground.', lower=0.0)
    gyroscope_noise: float = parameter(
        0.002, "Standard deviation of the imu's angular velocity.", 'rad/s', lower=0.0
    )
    accelerometer_noise: float = parameter(
        0.02, "Standard deviation of the imu's acceleration.", 'm/s^2', lower=0.0
    )
    odom_position_noise: float = parameter(
        0.0, "Standard deviation of odom's position.", 'm', lower=0.0
    )
    odom_yaw_noise: float = parameter(
        0.0, "Standard deviation of odom's heading.", 'rad', lower=0.0
    )
    map_frame: str = parameter('map', 'Frame of the map.')
    odom_frame: str = parameter('odom', 'Frame of the odometry; it coincides with the map.')
    base_frame: str = parameter('base_link', "Frame of the robot's body.")
    footprint_frame: str = parameter('base_footprint', 'Frame on the ground under the body.')
