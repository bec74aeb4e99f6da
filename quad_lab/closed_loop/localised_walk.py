"""
Walks a robot to a goal on a map by odometry that drifts and a localiser, without topics.

What the nodes decide is decided by the same parts: the planner's session, what places odometry on
the map, and the controller of the gait.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

from quad_common.frames.frame_tree import FrameTransform
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import ClosedLoop, Place
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.closed_loop.guided_end import GuidedEnd
from quad_lab.closed_loop.planner_in_loop import PlannerInLoop
from quad_planner.parameters import PlannerParameters
from quad_sim.engines.registry import AUTO
from quad_sim.engines.simulator import Observation
from quad_sim.simulated_localisation import LocalisationOptions, SimulatedLocalisation
from quad_sim.world.world import world_from_map


@dataclass
class LocalisedRecord:
    """How a walk went."""

    has_arrived: bool = False
    """Whether the robot says that it has."""
    reason: str = ''
    """What it says last."""
    duration: float = 0.0
    """Time that it took [s]."""
    position_error: float = float('nan')
    """True distance to the goal in the map at the end [m]."""
    heading_error: float = float('nan')
    """True angle to the goal's heading at the end [rad]."""
    odometry_error: float = float('nan')
    """Distance by which odometry is wrong at the end [m]."""
    largest_pose_error: float = 0.0
    """Largest distance between where the robot was and where it took itself to be [m]."""
    plans: int = 0
    """Number of plans, those that were made again included."""
    contacts: set[str] = field(default_factory=set)
    """Contacts of anything but feet with the ground."""


class LocalisedWalk:
    """
    A robot on a map, its planner's session and its gait.

    Parameters
    ----------
    robot : Robot
        The robot.
    map_file : Path
        Map of Nav2's format.
    start, goal : Pose2D
        From where to where, in the map.
    localisation : LocalisationOptions
        How odometry drifts and is corrected.
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    """

    def __init__(
        self,
        robot: Robot,
        map_file: Path,
        start: Pose2D,
        goal: Pose2D,
        localisation: LocalisationOptions,
        backend: str = AUTO,
    ) -> None:
        grid = load_map(map_file)
        self._goal = goal
        self._localisation = SimulatedLocalisation(localisation)
        self._frame = MapFrame('map', PlannerParameters().correction_time_constant)
        self._controller = measuring_controller(robot, load_gait('crawl', robot))
        world = world_from_map(grid)
        self._walk = ClosedLoop(robot, self._controller, backend, world, start)
        self._walk.locate = self._locate
        self._walk.on_observation.append(self._note_contacts)
        self._odometry = start
        self.record = LocalisedRecord()
        self._planner = PlannerInLoop(
            robot, self._controller, PlannerParameters(any_angle=True), self._frame
        )
        self._planner.session.take_grid(grid, self._frame.name)
        self._planner.session.give_goal(self._frame.name, goal)

    def run(self, timeout: float) -> LocalisedRecord:
        """Walk until the robot has arrived or given up; at most so long [s], simulated."""
        end = GuidedEnd()
        self._walk.run(timeout, lambda: end.is_over(self._walk.time, self._controller.activity))
        record, controller = self.record, self._controller
        true = self._walk.simulation.observe().pose
        error = true.inverse() @ self._goal
        record.has_arrived = controller.activity is Activity.ARRIVED
        record.reason = controller.reason
        record.duration = self._walk.time
        record.plans = self._planner.plans
        record.position_error = true.distance_to(self._goal)
        record.heading_error = abs(error.yaw)
        record.odometry_error = true.distance_to(self._odometry)
        return record

    def close(self) -> None:
        """Release the simulator."""
        self._walk.close()

    def _locate(self, seen: Observation) -> Place:
        """Return where the robot takes itself to be in the map, and its odometry."""
        told = self._localisation.observe(seen)
        correction = self._localisation.correction(seen, told)
        if correction is not None:
            self._frame.add([_transform(self._frame.name, correction)])
        self._odometry = told.pose
        pose = self._frame.locate(seen.time, 'odom', told.pose)
        self.record.largest_pose_error = max(
            self.record.largest_pose_error, pose.distance_to(seen.pose)
        )
        self._planner.take_pose(seen.time, pose)
        return pose, told.pose

    def _note_contacts(self, seen: Observation) -> None:
        self.record.contacts |= {str(contact) for contact in seen.contacts}


def _transform(frame: str, pose: Pose2D) -> FrameTransform:
    half = pose.yaw / 2.0
    return FrameTransform(
        frame, 'odom', (pose.x, pose.y, 0.0), (0.0, 0.0, math.sin(half), math.cos(half))
    )
