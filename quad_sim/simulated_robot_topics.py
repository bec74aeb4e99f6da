"""
What ``sim_node`` publishes and takes for each robot; of several, each has its namespace.
"""

from __future__ import annotations

from typing import Any

from geometry_msgs.msg import TransformStamped, WrenchStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import Imu, JointState, PointCloud2
from std_msgs.msg import Bool, Header, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from quad_common.errors import QuadError, TrajectoryOver
from quad_common.planar_pose import Pose2D
from quad_common.robot.urdf import published_urdf
from quad_common.ros.height_map_conversions import height_map_message
from quad_common.ros.pose_conversions import (
    base_transform,
    footprint_transform,
    grid_message,
    pose_transform,
    seconds_from_time,
    time_from_seconds,
)
from quad_common.ros.ros_node import WARN, QuadNode
from quad_common.ros.transform_publisher import TransformPublisher
from quad_sim.batch_topics import BatchTopics
from quad_sim.parameters import SimParameters
from quad_sim.ros_conversions import (
    imu_message,
    joint_state_message,
    most_trajectory_bytes,
    odometry_message,
    push_from_message,
    trajectory_from_message,
    true_odometry_message,
)
from quad_sim.sim_session import SimSession
from quad_sim.simulated_robot import SensorReadings, SimulatedRobot

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Namespace:
    """
    Makes what a node makes, with names below a robot's; and takes it all away.

    Parameters
    ----------
    node : QuadNode
        The node.
    name : str
        Name of the robot; empty for one alone.
    """

    def __init__(self, node: QuadNode[Any], name: str) -> None:
        self._node = node
        self._prefix = f'{name}/' if name else ''
        self._made: list[tuple[Any, Any]] = []

    def create_publisher(self, kind: Any, topic: str, *args: Any) -> Any:
        """Make a publisher; see rclpy's Node."""
        made = self._node.create_publisher(kind, self._prefix + topic, *args)
        self._made.append((self._node.destroy_publisher, made))
        return made

    def create_subscription(self, kind: Any, topic: str, *args: Any, **kwargs: Any) -> None:
        """Subscribe; see :class:`GuardedNode`."""
        made = self._node.create_subscription(kind, self._prefix + topic, *args, **kwargs)
        self._made.append((self._node.destroy_subscription, made))

    def create_service(self, kind: Any, name: str, *args: Any) -> None:
        """Offer a service; see :class:`GuardedNode`."""
        made = self._node.create_service(kind, self._prefix + name, *args)
        self._made.append((self._node.destroy_service, made))

    def destroy(self) -> None:
        """Take away all that was made."""
        for destroy, made in self._made:
            destroy(made)
        self._made.clear()


class RobotTopics:
    """
    The publishers and subscriptions of one robot; what does not change is published at once.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : SimSession
        What is simulated.
    robot : SimulatedRobot
        The robot.
    transforms : TransformPublisher
        Publishes its transforms.
    clock : publisher of rclpy, optional
        Publisher of simulated time, which its batches hold too.
    """

    def __init__(
        self,
        node: QuadNode[SimParameters],
        session: SimSession,
        robot: SimulatedRobot,
        transforms: TransformPublisher,
        clock: Any = None,
    ) -> None:
        self._node, self._session, self._robot = node, session, robot
        self._world = session.scenery.world
        self._transforms = transforms
        self._place = place = Namespace(node, robot.name)
        sensor = qos_profile_sensor_data
        self._odometry = place.create_publisher(Odometry, 'odom', sensor)
        self._truth = place.create_publisher(Odometry, 'odom/truth', sensor)
        self._corrections = place.create_publisher(TransformStamped, 'map_to_odom', 10)
        self._joint_states = place.create_publisher(JointState, 'joint_states', sensor)
        self._imu = place.create_publisher(Imu, 'imu', sensor)
        frequent = clock, self._imu, self._joint_states, self._odometry
        self._batches = BatchTopics(place, *filter(None, frequent))
        self._description = place.create_publisher(String, 'robot_description', _LATCHED)
        self._map = place.create_publisher(OccupancyGrid, 'map', _LATCHED)
        self._height_map = place.create_publisher(PointCloud2, 'height_map', _LATCHED)
        longest = most_trajectory_bytes(node.parameters.longest_trajectory)
        place.create_subscription(
            JointTrajectory, 'joint_trajectory', self._on_trajectory, 10, most_bytes=longest
        )
        place.create_subscription(WrenchStamped, 'push', self._on_push, 10)
        self._held = place.create_publisher(Bool, 'emergency_stop/held', _LATCHED)
        place.create_subscription(Bool, 'emergency_stop/active', self._on_emergency_stop, _LATCHED)
        if node.parameters.real_time_factor == 0.0:
            # The next one says more than one that is lost, and to acknowledge each takes time.
            place.create_subscription(Header, 'gait/heartbeat', self._on_gait_heartbeat, sensor)
        place.create_service(Trigger, 'reset', self._on_reset)
        self._publish_fixed()

    def _publish_fixed(self) -> None:
        """Publish the robot and its maps."""
        scenery, zero = self._session.scenery, time_from_seconds(0.0)
        frame = self._robot.parameters.map_frame
        self._description.publish(String(data=published_urdf(self._robot.robot)))
        if scenery.grid is not None:
            self._map.publish(grid_message(scenery.grid, frame, zero))
        if scenery.height_map is not None:
            self._height_map.publish(height_map_message(scenery.height_map, frame, zero))

    @property
    def fixed_transforms(self) -> list[TransformStamped]:
        """Transforms of its frames that do not move."""
        p, robot = self._robot.parameters, self._robot
        if not robot.has_exact_odometry:
            return []
        origin, zero = Pose2D(0.0, 0.0, 0.0), time_from_seconds(0.0)
        return [pose_transform(origin, p.map_frame, p.odom_frame, zero)]

    def publish_readings(self, readings: SensorReadings) -> None:
        """Publish what was measured."""
        p, truth = self._robot.parameters, readings.truth
        stamp = time_from_seconds(truth.time)
        odometry = odometry_message(readings.odometry, p, readings.odometry_noise, stamp)
        # Heading, then joints, then pose: who receives the next knows what belongs to it.
        publish = self._batches.publish
        if self._batches.is_wanted or self._imu.get_subscription_count() > 0:
            publish(self._imu, imu_message(truth, p, readings.imu_noise, stamp))
        names = self._robot.robot.joint_names
        publish(self._joint_states, joint_state_message(truth, names, stamp))
        if readings.correction is not None:
            transform = pose_transform(readings.correction, p.map_frame, p.odom_frame, stamp)
            self._corrections.publish(transform)
            self._transforms.publish(transform)
        publish(self._odometry, odometry)
        if self._truth.get_subscription_count() > 0:
            self._truth.publish(true_odometry_message(truth, p, stamp))
        if self._transforms.is_active:
            ground = float(self._world.ground_at(truth.position[:2]))
            footprint = footprint_transform(odometry, p.footprint_frame, ground)
            self._transforms.publish(base_transform(odometry), footprint)
        self._batches.send()

    def keep_clock(self, clock: Any, data: bytes) -> None:
        """Have simulated time, as it was published, in the batches too."""
        if self._batches.is_wanted:
            self._batches.keep(clock, data)

    def send_batches(self) -> None:
        """Publish what waits for more to come, if it has waited."""
        self._batches.send()

    def destroy(self) -> None:
        """Take away publishers, subscriptions and services."""
        self._place.destroy()

    def _on_trajectory(self, message: JointTrajectory) -> None:
        longest = self._node.parameters.longest_trajectory
        try:
            self._robot.simulation.accept(trajectory_from_message(message, longest))
        except TrajectoryOver as error:
            if not error.is_delayed:
                raise
            # Nothing is wrong with it but the machine's pace, as with one that comes late.
            self._node.report(WARN, str(error))

    def _on_push(self, message: WrenchStamped) -> None:
        robot, simulation = self._robot, self._robot.simulation
        frames = (robot.parameters.base_frame, *self._session.frames_on_map)
        force = push_from_message(message, robot.robot, simulation.observe(), frames)
        simulation.push(force, self._node.parameters.push_duration)

    def _on_emergency_stop(self, message: Bool) -> None:
        simulation = self._robot.simulation
        if simulation.is_frozen != message.data:
            simulation.freeze(message.data)
            self._held.publish(Bool(data=message.data))
        self._node.update_status()

    def _on_gait_heartbeat(self, message: Header) -> None:
        self._session.take_answer(self._robot.name, seconds_from_time(message.stamp))

    def _on_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._session.reset(self._robot.name)
        except QuadError as error:
            response.message = str(error)
            return response
        self.publish_readings(self._robot.observe())
        self._node.update_status()
        response.success = True
        response.message = 'the robot stands at its start pose; time goes on'
        return response
