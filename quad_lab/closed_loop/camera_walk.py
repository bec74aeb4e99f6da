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

from quad_common.errors import QuadError
from quad_common.plan import Plan
from quad_common.planar_pose import wrap_angle
from quad_common.robot.robot import Robot
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import RobotMarker
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_gait.state.leg_odometry import LegOdometry
from quad_lab.closed_loop.closed_loop import SENSOR_PERIOD, ClosedLoop, Place
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.closed_loop.guided_end import GuidedEnd
from quad_lab.closed_loop.planner_in_loop import PlannerInLoop
from quad_perception.picture.color_segmentation import Picture
from quad_perception.picture.perception import Perceiver
from quad_perception.tracking.scene_tracker import SceneTracker
from quad_planner.parameters import PlannerParameters
from quad_sim.engines.simulator import Observation
from quad_sim.simulation import Simulation
from quad_sim.world.appearance import Appearance
from quad_sim.world.random_room import Room
from quad_sim.world.simulated_camera import SimulatedCamera


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
        self._room = room
        self._options = options
        self._rng = np.random.default_rng(options.seed)
        self._controller = measuring_controller(robot, load_gait(options.gait, robot))
        look = Appearance(robot_marker=RobotMarker.on(robot))
        self._loop = ClosedLoop(
            robot, self._controller, world=room.world, start=room.start, appearance=look
        )
        self._loop.on_observation += [self._take_picture, self._note_contacts]
        self._loop.locate = self._locate
        half = room.size / 2.0
        lens = CameraModel.looking_down((half, half, 0.75 * room.size), 0.0, 1.4)
        self._camera = SimulatedCamera(lens, options.noise)
        self._observations = 0
        self._late: deque[tuple[float, float, Picture]] = deque()
        self.watch = SceneTracker(Perceiver.of_robot(lens, robot, bounds=room.bounds))
        self._legs = LegOdometry(robot)
        parameters = PlannerParameters(
            robot=robot.name, gait=options.gait, method=options.method, any_angle=True
        )
        self._planner = PlannerInLoop(robot, self._controller, parameters)
        self.record = CameraWalkRecord()

    @property
    def simulation(self) -> Simulation:
        """The simulation, to look at and to change."""
        return self._loop.simulation

    @property
    def plan(self) -> Plan | None:
        """The plan in force."""
        return self._planner.session.plan

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
        end = GuidedEnd()

        def is_over() -> bool:
            on_time(self)
            return end.is_over(self._loop.time, self._controller.activity)

        self._loop.run(timeout, is_over)
        return self._ended()

    def close(self) -> None:
        """Release the simulator."""
        self._loop.close()

    def _note_contacts(self, seen: Observation) -> None:
        self.record.contacts |= {str(contact) for contact in seen.contacts}

    def _take_picture(self, seen: Observation) -> None:
        """Take a picture if it is time to; what it shows is known later."""
        if self._observations % round(self._options.picture_period / SENSOR_PERIOD) == 0:
            picture = self.simulation.picture(self._camera, self._rng)
            self._late.append((seen.time + self._options.latency, seen.time, picture))
        self._observations += 1

    def _locate(self, seen: Observation) -> Place | None:
        """Return where the robot takes itself to be, by its legs and by pictures."""
        rate = float(seen.angular_velocity_base_in_base[2])
        self._legs.update(seen.time, seen.joint_positions, None, seen.orientation, rate)
        self.watch.add_odometry(seen.time, self._legs.pose)
        while self._late and self._late[0][0] <= seen.time:
            _, taken_at, picture = self._late.popleft()
            self._look(taken_at, picture)
        pose = self.watch.fusion.pose
        if pose is None or self.watch.is_lost:
            return None
        self.record.pose_errors.append(pose.distance_to(seen.pose))
        self.record.heading_errors.append(abs(wrap_angle(pose.yaw - seen.pose.yaw)))
        self._planner.take_pose(seen.time, pose)
        return pose, pose

    def _look(self, taken_at: float, picture: Picture) -> None:
        """Tell the planner what a picture has changed."""
        session, frame = self._planner.session, self._planner.frame.name
        try:
            sighting = self.watch.add_picture(taken_at, picture)
            self.record.problem = ''
            if sighting.map is not None:
                session.take_grid(sighting.map, frame)
            if sighting.goal is not None:
                session.give_goal(frame, sighting.goal)
        except QuadError as error:
            self.record.problem = str(error)

    def _ended(self) -> CameraWalkRecord:
        record = self.record
        record.arrived = self._controller.activity is Activity.ARRIVED
        record.duration = self._loop.time
        record.plans = self._planner.plans
        record.final_error = self.simulation.observe().pose.distance_to(self._room.goal)
        if record.arrived:
            record.problem = ''
        else:
            problems = (record.problem, self._planner.problem, self._controller.reason)
            record.problem = next(filter(None, problems))
        return record
