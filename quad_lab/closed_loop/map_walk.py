"""
Walks a robot to a goal on a map, with a planner's session, without topics.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_gait.following.follower_options import FollowerOptions
from quad_lab.closed_loop.closed_loop import ClosedLoop, Place
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.closed_loop.guided_end import GuidedEnd
from quad_lab.closed_loop.planner_in_loop import PlannerInLoop
from quad_planner.parameters import PlannerParameters
from quad_sim.engines.registry import AUTO
from quad_sim.engines.simulator import Observation
from quad_sim.world.world import world_from_map


@dataclass
class MapWalkRecord:
    """How a walk went."""

    has_arrived: bool = False
    """Whether the robot says that it has."""
    reason: str = ''
    """What it says last, or why there is no plan."""
    duration: float = 0.0
    """Time that it took [s]."""
    position_error: float = float('nan')
    """True distance to the goal at the end [m]."""
    plans: list[Plan] = field(default_factory=list)
    """Plans, those that were made again included."""
    contacts: set[str] = field(default_factory=set)
    """Contacts of anything but feet with the ground."""


class MapWalk:
    """
    A robot on a map, its planner's session and its gait.

    Parameters
    ----------
    parameters : PlannerParameters
        As planner_node takes them; robot, gait and turning are theirs.
    grid : OccupancyGrid
        The map, whose occupied cells are walls.
    start, goal : Pose2D
        From where to where, in the map.
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    """

    def __init__(
        self,
        parameters: PlannerParameters,
        grid: OccupancyGrid,
        start: Pose2D,
        goal: Pose2D,
        backend: str = AUTO,
    ) -> None:
        robot = load_robot(parameters.robot)
        self._goal = goal
        self._controller = measuring_controller(
            robot,
            load_gait(parameters.gait, robot),
            follower=FollowerOptions(
                turning=parameters.turning,
                corner_deviation=parameters.corner_deviation,
                corner_radius=parameters.corner_radius,
            ),
        )
        self._walk = ClosedLoop(robot, self._controller, backend, world_from_map(grid), start)
        self._walk.locate = self._locate
        self._walk.on_observation.append(self._note_contacts)
        self.record = MapWalkRecord()
        self._planner = PlannerInLoop(robot, self._controller, parameters)
        self._planner.session.take_grid(grid, 'map')
        self._planner.session.give_goal('map', goal)

    def run(self, timeout: float) -> MapWalkRecord:
        """Walk until the robot has arrived or given up; at most so long [s], simulated."""
        end = GuidedEnd()
        self._walk.run(timeout, lambda: end.is_over(self._walk.time, self._controller.activity))
        record, controller = self.record, self._controller
        record.has_arrived = controller.activity is Activity.ARRIVED
        record.reason = self._planner.problem or controller.reason
        record.duration = self._walk.time
        record.position_error = self._walk.simulation.observe().pose.distance_to(self._goal)
        return record

    def close(self) -> None:
        """Release the simulator."""
        self._walk.close()

    @property
    def loop(self) -> ClosedLoop:
        """The closed loop, to look at."""
        return self._walk

    def _locate(self, seen: Observation) -> Place:
        self._planner.take_pose(seen.time, seen.pose)
        plan = self._planner.session.plan
        if plan is not None and (not self.record.plans or self.record.plans[-1] is not plan):
            self.record.plans.append(plan)
        return seen.pose, seen.pose

    def _note_contacts(self, seen: Observation) -> None:
        self.record.contacts |= {str(contact) for contact in seen.contacts}
