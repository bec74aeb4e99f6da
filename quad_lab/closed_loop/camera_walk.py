"""
Walks a robot through a room by a ceiling camera alone, in one process, without topics.

What the nodes do is done by the same parts, at the same rates: pictures come late, legs
tell between them, and every change of the map or the goal leads to a new plan.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from quad_common.errors import PlannerError, QuadError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_common.robot.robot import Robot
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import RobotMarker
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_gait.state.leg_odometry import LegOdometry
from quad_gait.state.measurement import Measurement
from quad_lab.closed_loop.gait_measures import make_controller
from quad_perception.picture.color_segmentation import Picture
from quad_perception.picture.perception import Perceiver
from quad_perception.tracking.scene_tracker import SceneTracker, Sighting
from quad_planner.methods.planner import make_planner
from quad_planner.parameters import PlannerParameters
from quad_sim.engines.simulator import Observation, tilt_of
from quad_sim.simulation import Simulation, make_simulator
from quad_sim.world.appearance import Appearance
from quad_sim.world.random_room import Room
from quad_sim.world.simulated_camera import SimulatedCamera

_SENSOR_PERIOD = 0.02
"""Between two measurements, as sim_node publishes them [s]."""


@dataclass(frozen=True)
class CameraWalkOptions:
    """What hangs under the ceiling, and how the robot walks."""

    gait: str = 'crawl'
    method: str = 'mesh'
    picture_period: float = 0.5
    """Between two pictures [s]."""
    latency: float = 0.2
    """From a picture to what is known of it [s]."""
    noise: float = 0.0
    """Of each number in a picture, of 255."""
    seed: int = 0
    """Of the noise."""


@dataclass
class CameraWalkRecord:
    """What was seen of a walk."""

    arrived: bool = False
    problem: str = ''
    """Why it did not arrive."""
    duration: float = 0.0
    """[s]"""
    plans: int = 0
    contacts: set[str] = field(default_factory=set)
    """Of anything but feet with the ground."""
    pose_errors: list[float] = field(default_factory=list)
    """Of the fused pose, at every measurement while it is known [m]."""
    heading_errors: list[float] = field(default_factory=list)
    """[rad]"""
    final_error: float = math.nan
    """True distance to the goal at the end [m]."""


class CameraWalk:
    """
    A robot in a room, under a camera.

    Parameters
    ----------
    robot : Robot
        The robot.
    room : Room
        With start and goal.
    options : CameraWalkOptions
        How it is seen, and walks.
    """

    def __init__(self, robot: Robot, room: Room, options: CameraWalkOptions) -> None:
        self._robot = robot
        self._room = room
        self._options = options
        self._rng = np.random.default_rng(options.seed)
        marker = RobotMarker.on(robot)
        simulator = make_simulator(
            'bullet', robot, room.world, appearance=Appearance(robot_marker=marker)
        )
        self.simulation = Simulation(simulator, robot, room.start)
        half = room.size / 2.0
        lens = CameraModel.looking_down((half, half, 0.75 * room.size), 0.0, 1.4)
        self._camera = SimulatedCamera(lens, options.noise)
        self.watch = SceneTracker(Perceiver.of_robot(lens, robot, bounds=room.bounds))
        self._legs = LegOdometry(robot)
        self._controller = make_controller(robot, load_gait(options.gait, robot))
        parameters = PlannerParameters()
        self._planner = make_planner(
            options.method,
            mesh_size=robot.mesh_size,
            any_angle=True,
            clearance_radius=robot.footprint_radius + parameters.safety_distance,
            start_tolerance=parameters.safety_distance,
        )
        self._replan_distance = parameters.replan_distance
        self._goal: Pose2D | None = None
        self.plan: Plan | None = None
        """The plan in force."""
        self._late: deque[tuple[float, float, Picture]] = deque()
        self.record = CameraWalkRecord()

    def run(
        self, timeout: float, on_time: Callable[[CameraWalk], None] = lambda walk: None
    ) -> CameraWalkRecord:
        """
        Walk to the goal's marker.

        Parameters
        ----------
        timeout : float
            Given up after so long [s], simulated.
        on_time : callable
            Called at every measurement, for what is to happen meanwhile.

        Returns
        -------
        CameraWalkRecord
            How it went.
        """
        self.simulation.put_goal_marker(self._room.goal)
        steps = round(_SENSOR_PERIOD / self.simulation.time_step)
        between_pictures = round(self._options.picture_period / _SENSOR_PERIOD)
        count = 0
        while self.simulation.time < timeout:
            seen = self.simulation.observe()
            if count % between_pictures == 0:
                picture = self.simulation.picture(self._camera, self._rng)
                self._late.append((seen.time + self._options.latency, seen.time, picture))
            self._measure(seen)
            on_time(self)
            activity = self._controller.activity
            if activity is Activity.ARRIVED or activity.is_disabled:
                break
            for _ in range(steps):
                self.simulation.step()
            count += 1
        return self._ended()

    def close(self) -> None:
        """Release the simulator."""
        self.simulation.close()

    def _measure(self, seen: Observation) -> None:
        legs, record = self._legs, self.record
        legs.update(
            seen.time,
            seen.joint_positions,
            None,
            seen.orientation,
            float(seen.angular_velocity_base_in_base[2]),
        )
        self.watch.add_odometry(seen.time, legs.pose)
        record.contacts |= {str(contact) for contact in seen.contacts}
        while self._late and self._late[0][0] <= seen.time:
            _, taken_at, picture = self._late.popleft()
            self._look(taken_at, picture)
        pose = self.watch.fusion.pose
        if pose is None or self.watch.is_lost:
            return
        record.pose_errors.append(pose.distance_to(seen.pose))
        record.heading_errors.append(abs(wrap_angle(pose.yaw - seen.pose.yaw)))
        if self.plan is not None:
            away = distance_to_polyline((pose.x, pose.y), self.plan.corners)
            if away > self._replan_distance:
                self._plan_anew()
        trajectory = self._controller.update(
            Measurement(
                seen.time, pose, tilt_of(seen.orientation), seen.joint_positions,
                seen.joint_velocities,
            )
        )  # fmt: skip
        if trajectory is not None:
            self.simulation.accept(trajectory)

    def _look(self, taken_at: float, picture: Picture) -> None:
        try:
            sighting: Sighting = self.watch.add_picture(taken_at, picture)
        except QuadError as error:
            self.record.problem = str(error)
            return
        if sighting.goal is not None:
            self._goal = sighting.goal
        if sighting.map is not None:
            self._planner.set_map(sighting.map)
        if sighting.map is not None or sighting.goal is not None:
            self._plan_anew()

    def _plan_anew(self) -> None:
        pose = self.watch.fusion.pose
        if self._goal is None or pose is None or self._planner.prepared is None:
            return
        try:
            self.plan = self._planner.plan(pose, self._goal)
            self.record.plans += 1
            self.record.problem = ''
        except PlannerError as error:
            self.plan = None
            self.record.problem = str(error)
        self._controller.set_plan(self.plan)

    def _ended(self) -> CameraWalkRecord:
        record = self.record
        record.arrived = self._controller.activity is Activity.ARRIVED
        record.duration = self.simulation.time
        record.final_error = self.simulation.observe().pose.distance_to(self._room.goal)
        if not record.arrived and not record.problem:
            record.problem = self._controller.reason
        return record
