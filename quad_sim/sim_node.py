"""
The node that walks the robot in simulation and closes the loop.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_sim.__main__ import main as start

    raise SystemExit(start())

import time
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import (
    DurabilityPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, PointCloud2
from std_msgs.msg import Bool, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory
from visualization_msgs.msg import MarkerArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import load_robot
from quad_common.robot.urdf import urdf_from_robot
from quad_common.ros.height_map_conversions import height_map_message
from quad_common.ros.image_conversions import (
    camera_info_message,
    image_message,
)
from quad_common.ros.pose_conversions import (
    base_transform,
    camera_transform,
    footprint_transform,
    grid_message,
    pose_from_message,
    pose_transform,
    time_from_seconds,
)
from quad_common.ros.ros_node import ERROR, OK, WARN, QuadNode
from quad_common.ros.run_node import run_node
from quad_sim.engines.joint_failure import JointFailure
from quad_sim.parameters import SimParameters
from quad_sim.ros_conversions import (
    MOST_OBSTACLE_BYTES,
    check_frame,
    imu_message,
    joint_state_message,
    most_trajectory_bytes,
    obstacle_changes_from_message,
    odometry_message,
    trajectory_from_message,
    true_odometry_message,
)
from quad_sim.scenery import appearance_from, camera_from, scenery_from
from quad_sim.simulated_localisation import LocalisationOptions, SimulatedLocalisation
from quad_sim.simulation import Simulation, make_simulator

try:
    from tf2_msgs.msg import TFMessage
except ImportError:
    TFMessage = None

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)

_CLOCK_RATE = 100.0
"""Of simulated time, at least [Hz]."""

_LATE = 0.25
"""Behind its real-time factor by more, the simulator lets the lost time go [s]."""


class SimNode(QuadNode[SimParameters]):
    """Steps the simulation, publishes its state and takes joint trajectories."""

    def __init__(self, **kwargs: Any) -> None:
        # It makes the simulated time, and so cannot wait for it.
        super().__init__('sim_node', SimParameters, use_sim_time=False, **kwargs)
        p = self.parameters
        robot = load_robot(p.robot)
        scenery = scenery_from(p, robot)
        look = appearance_from(p, robot)
        self._camera = camera_from(p) if p.camera else None
        simulator = make_simulator(p.backend, robot, scenery.world, p.time_step, p.gui, look)
        self._simulation = Simulation(simulator, robot, scenery.start)
        self._simulation.plan_failure(_failure_from(p))
        if scenery.goal is not None:
            self._simulation.put_goal_marker(scenery.goal)
        self._world = scenery.world
        self._joint_names = robot.joint_names
        self._rng = np.random.default_rng(p.seed)
        self._localisation = SimulatedLocalisation(
            LocalisationOptions(
                p.odom_drift, p.localiser_rate, p.localiser_noise, p.localiser_heading_noise, p.seed
            )
        )
        self._troubles_said = 0
        self._is_paused = False
        self._steps = 0
        self._steps_per_clock = max(1, int(1.0 / (_CLOCK_RATE * p.time_step) + 1e-9))
        self._steps_per_observation = max(1, round(1.0 / (p.sensor_rate * p.time_step)))
        self._steps_per_picture = max(1, round(1.0 / (p.camera_rate * p.time_step)))
        self._pace_from = (time.monotonic(), 0.0)
        self._speed_from = (time.monotonic(), 0.0)
        self._spent = {'physics': 0.0, 'publishing': 0.0, 'pictures': 0.0}

        sensor = qos_profile_sensor_data
        self._clock_publisher = self.create_publisher(Clock, '/clock', _CLOCK)
        self._odometry = self.create_publisher(Odometry, 'odom', sensor)
        self._truth = self.create_publisher(Odometry, 'odom/truth', sensor)
        self._corrections = self.create_publisher(TransformStamped, 'map_to_odom', 10)
        self._joint_states = self.create_publisher(JointState, 'joint_states', sensor)
        self._imu = self.create_publisher(Imu, 'imu', sensor)
        self._description = self.create_publisher(String, 'robot_description', _LATCHED)
        self._map = self.create_publisher(OccupancyGrid, 'map', _LATCHED)
        self._height_map = self.create_publisher(PointCloud2, 'height_map', _LATCHED)
        if self._camera is not None:
            self._simulation.check_visible('a camera')
            self._images = self.create_publisher(Image, 'ceiling_camera/image_raw', sensor)
            self._infos = self.create_publisher(CameraInfo, 'ceiling_camera/camera_info', sensor)
        self._transforms = self._make_transforms()
        self.create_subscription(
            JointTrajectory,
            'joint_trajectory',
            self._on_trajectory,
            10,
            most_bytes=most_trajectory_bytes(p.longest_trajectory),
        )
        self.create_subscription(
            MarkerArray, 'obstacles', self._on_obstacles, 10, most_bytes=MOST_OBSTACLE_BYTES
        )
        self.create_subscription(PoseStamped, 'goal_marker', self._on_goal_marker, 10)
        self.create_subscription(Bool, 'emergency_stop/active', self._on_emergency_stop, _LATCHED)
        self.create_service(Trigger, 'reset', self._on_reset)
        self.create_service(Trigger, 'pause', self._on_pause)
        self.create_service(Trigger, 'unpause', self._on_unpause)

        self._description.publish(String(data=urdf_from_robot(robot)))
        if scenery.grid is not None:
            self._map.publish(grid_message(scenery.grid, p.map_frame, time_from_seconds(0.0)))
        if scenery.height_map is not None:
            zero = time_from_seconds(0.0)
            self._height_map.publish(height_map_message(scenery.height_map, p.map_frame, zero))
        self._observe()
        self.update_status()

    def drive(self) -> float:
        """
        Simulate up to the next observation, if it is due.

        Returns
        -------
        float
            How long there is nothing to do [s].
        """
        if self._is_paused:
            return 0.1
        ahead = self._ahead_of_pace()
        if ahead > 0.0:
            return min(ahead, 0.1)
        for _ in range(self._steps_per_observation):
            began = time.perf_counter()
            self._simulation.step()
            self._steps += 1
            self._spent['physics'] += time.perf_counter() - began
            if self._steps % self._steps_per_clock == 0:
                stamp = time_from_seconds(self._simulation.time)
                self._clock_publisher.publish(Clock(clock=stamp))
            if self._camera is not None and self._steps % self._steps_per_picture == 0:
                self._take_picture()
        began = time.perf_counter()
        self._observe()
        self._spent['publishing'] += time.perf_counter() - began
        return 0.0

    def take_parameters(self, parameters: SimParameters) -> None:
        """Let a joint fail."""
        self._simulation.plan_failure(_failure_from(parameters))

    def update_status(self) -> None:
        """Say how the simulation goes."""
        simulation = self._simulation
        contacts = ', '.join(sorted(map(str, simulation.contacts_seen)))
        self._troubles_said = self._troubles()
        failed = simulation.failed
        values = {
            'time': f'{simulation.time:.2f}',
            'real_time_factor': f'{self._measured_factor():.2f}',
            'contacts': contacts,
            'has_fallen': simulation.has_fallen,
            'late_trajectories': simulation.late_trajectories,
            'seconds_in_physics': f'{self._spent["physics"]:.3f}',
            'seconds_publishing': f'{self._spent["publishing"]:.3f}',
            'seconds_in_pictures': f'{self._spent["pictures"]:.3f}',
        }
        if simulation.has_fallen:
            self.report(ERROR, 'the robot has fallen; reset stands it up again', **values)
        elif failed is not None:
            self.report(WARN, f'{failed.joint} is {failed.kind}; reset repairs it', **values)
        elif contacts:
            self.report(WARN, f'contact: {contacts}', **values)
        elif simulation.is_frozen:
            self.report(WARN, 'the emergency stop is on: no trajectory is executed', **values)
        elif self._is_paused:
            self.report(OK, 'paused', **values)
        else:
            self.report(OK, 'running', **values)

    def destroy_node(self) -> None:
        """Release the simulator."""
        self._simulation.close()
        super().destroy_node()

    def _ahead_of_pace(self) -> float:
        factor = self.parameters.real_time_factor
        if factor == 0.0:
            return 0.0
        since, start = self._pace_from
        now = time.monotonic()
        ahead = (self._simulation.time - start) / factor - (now - since)
        if ahead < -_LATE:
            self._pace_from = (now, self._simulation.time)
        return ahead

    def _measured_factor(self) -> float:
        since, start = self._speed_from
        now, simulated = time.monotonic(), self._simulation.time
        self._speed_from = (now, simulated)
        return (simulated - start) / max(now - since, 1e-6)

    def _observe(self) -> None:
        """Publish the robot's state."""
        p = self.parameters
        observation = self._simulation.observe()
        stamp = time_from_seconds(observation.time)
        told = self._localisation.observe(observation)
        odometry = odometry_message(told, p, self._rng.standard_normal(4), stamp)
        # Its noise is drawn in any case: who listens must not change the run.
        noise = self._rng.standard_normal((2, 3))
        # Heading, then joints, then pose: who hears of the next knows what belongs to it.
        if self._imu.get_subscription_count() > 0:
            self._imu.publish(imu_message(observation, p, noise, stamp))
        self._joint_states.publish(joint_state_message(observation, self._joint_names, stamp))
        self._publish_correction(self._localisation.correction(observation, told), stamp)
        self._odometry.publish(odometry)
        if self._truth.get_subscription_count() > 0:
            self._truth.publish(true_odometry_message(observation, p, stamp))
        if self._transforms is not None:
            base = base_transform(odometry)
            ground = float(self._world.ground_at(observation.position[:2]))
            footprint = footprint_transform(odometry, p.footprint_frame, ground)
            self._transforms.publish(TFMessage(transforms=[base, footprint]))
        troubles = self._troubles()
        if troubles > self._troubles_said:
            self.update_status()

    def _publish_correction(self, correction: Pose2D | None, stamp: Time) -> None:
        """Publish what the localiser says, if it says anything now."""
        if correction is None:
            return
        p = self.parameters
        transform = pose_transform(correction, p.map_frame, p.odom_frame, stamp)
        self._corrections.publish(transform)
        if self._transforms is not None:
            self._transforms.publish(TFMessage(transforms=[transform]))

    def _troubles(self) -> int:
        """Count the kinds of trouble that have been seen."""
        simulation = self._simulation
        seen = (simulation.contacts_seen, simulation.has_fallen, simulation.failed)
        return sum(map(bool, seen))

    def _take_picture(self) -> None:
        """Publish what the camera sees, if somebody looks."""
        assert self._camera is not None
        began = time.perf_counter()
        p = self.parameters
        stamp = time_from_seconds(self._simulation.time)
        if self._infos.get_subscription_count() > 0:
            self._infos.publish(camera_info_message(self._camera.model, p.camera_frame, stamp))
        if self._images.get_subscription_count() > 0:
            # Each picture has noise of its own: who looked at the others must not change it.
            rng = np.random.default_rng((p.seed, self._steps))
            picture = self._simulation.picture(self._camera, rng)
            self._images.publish(image_message(picture, p.camera_frame, stamp))
        self._spent['pictures'] += time.perf_counter() - began

    def _make_transforms(self) -> Any:
        p = self.parameters
        if not p.publish_tf:
            return None
        if TFMessage is None:
            self.get_logger().info('tf2_msgs is not installed: no transforms are published')
            return None
        static = self.create_publisher(TFMessage, 'tf_static', _LATCHED)
        zero = time_from_seconds(0.0)
        fixed = []
        if self._localisation.is_exact:
            fixed.append(pose_transform(Pose2D(0.0, 0.0, 0.0), p.map_frame, p.odom_frame, zero))
        if self._camera is not None:
            model = self._camera.model
            fixed.append(camera_transform(model, p.map_frame, p.camera_frame, zero))
        static.publish(TFMessage(transforms=fixed))
        return self.create_publisher(TFMessage, 'tf', 100)

    @property
    def _frames_on_map(self) -> tuple[str, ...]:
        """Frames that coincide with the world."""
        p = self.parameters
        is_exact = self._localisation.is_exact
        return (p.map_frame, p.odom_frame) if is_exact else (p.map_frame,)

    def _on_trajectory(self, message: JointTrajectory) -> None:
        longest = self.parameters.longest_trajectory
        self._simulation.accept(trajectory_from_message(message, longest))

    def _on_emergency_stop(self, message: Bool) -> None:
        self._simulation.freeze(message.data)
        self.update_status()

    def _on_obstacles(self, message: MarkerArray) -> None:
        p = self.parameters
        changes = obstacle_changes_from_message(message, self._frames_on_map)
        self._simulation.change_obstacles(changes, p.most_obstacles)

    def _on_goal_marker(self, message: PoseStamped) -> None:
        check_frame('goal_marker', message.header.frame_id, self._frames_on_map)
        self._simulation.put_goal_marker(pose_from_message(message.pose, 'goal_marker'))

    def _on_reset(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._simulation.reset()
        self._localisation.reset()
        self._observe()
        self.update_status()
        response.success = True
        response.message = 'the robot stands at its start pose; time goes on'
        return response

    def _on_pause(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._is_paused = True
        self.update_status()
        response.success = True
        response.message = f'paused at {self._simulation.time:.2f} s'
        return response

    def _on_unpause(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._is_paused = False
        self._pace_from = (time.monotonic(), self._simulation.time)
        self.update_status()
        response.success = True
        response.message = 'running'
        return response


def _failure_from(p: SimParameters) -> JointFailure | None:
    if not p.failing_joint:
        return None
    return JointFailure(p.failing_joint, p.failure, p.failure_time)


def main(args: list[str] | None = None) -> int:
    """Run the simulator node."""
    return run_node(SimNode, args, drive=SimNode.drive)
