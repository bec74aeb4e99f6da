"""
Walks several robots on one map at once, each with its planner and its gait, without topics.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import tilt_from_quaternion
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import SENSOR_PERIOD, ClosedLoop, Place
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.closed_loop.planner_in_loop import PlannerInLoop
from quad_planner.parameters import PlannerParameters
from quad_planner.session.immediate_request import ImmediateRequest
from quad_planner.traffic.traffic import Traffic
from quad_sim.engines.registry import AUTO
from quad_sim.engines.simulator import Observation
from quad_sim.fleet.shared_world import make_shared_world
from quad_sim.fleet_simulation import FleetSimulation
from quad_sim.simulation import Simulation
from quad_sim.world.world import world_from_map

_WORDS = 0.2
"""Time between two words of robots to one another [s]."""

_NEAR = 0.1
"""Distance from the goal within which a robot has arrived [m]."""


@dataclass(frozen=True)
class Member:
    """One of the robots."""

    kind: str
    """Name of the robot."""
    start: Pose2D
    goal: Pose2D
    gait: str = 'trot'
    """Name of its gait."""


@dataclass
class FleetRecord:
    """How a walk of several robots went."""

    arrived: dict[str, float] = field(default_factory=dict)
    """When each that arrived did so [s]."""
    contacts: set[str] = field(default_factory=set)
    """Contacts of anything but feet with the ground, with the robots' names."""
    duration: float = 0.0
    """Time until all had arrived, or it was given up [s]."""
    least_gap: float = float('inf')
    """Least distance between two circles that hold the robots' feet [m]."""
    waits: set[str] = field(default_factory=set)
    """What robots waited for."""
    said: dict[str, str] = field(default_factory=dict)
    """What each robot said last, if it did not arrive."""


class _Walker:
    """One robot of the walk."""

    def __init__(self, name: str, member: Member, grid: OccupancyGrid, simulation: Simulation):
        self.name, self.member = name, member
        robot = simulation.robot
        self.controller = measuring_controller(robot, load_gait(member.gait, robot))
        self.loop = ClosedLoop.around(self.controller, simulation)
        self.loop.locate = self._locate
        parameters = PlannerParameters(
            robot=member.kind, gait=member.gait, method='shortest', any_angle=True
        )
        self.planner = PlannerInLoop(robot, self.controller, parameters)
        self.session = self.planner.session
        self.traffic = Traffic(self.session, name, robot.standing_radius, ImmediateRequest())
        self.session.take_grid(grid, 'map')
        self.session.give_goal('map', member.goal)
        self.pose = member.start

    def _locate(self, seen: Observation) -> Place:
        self.pose = seen.pose
        self.planner.take_pose(seen.time, seen.pose)
        self.traffic.take_tilt(tilt_from_quaternion(seen.orientation))
        self.traffic.update(seen.time)
        return seen.pose, seen.pose

    @property
    def has_arrived(self) -> bool:
        """Whether its goal is reached."""
        return self.session.goal is None and self.pose.distance_to(self.member.goal) < _NEAR

    @property
    def says(self) -> str:
        """What it is doing, as a sentence."""
        return self.session.hold_reason or self.planner.problem or self.controller.reason


class FleetWalk:
    """
    Several robots on a map.

    Parameters
    ----------
    members : mapping of str to Member
        The robots by their names.
    grid : OccupancyGrid
        The map, whose occupied cells are walls.
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    """

    def __init__(
        self, members: Mapping[str, Member], grid: OccupancyGrid, backend: str = AUTO
    ) -> None:
        world = make_shared_world(backend, world_from_map(grid))
        self.simulation = FleetSimulation(world, grid)
        """What is stepped."""
        self.simulation.spawn(
            {name: (load_robot(one.kind), one.start) for name, one in members.items()}
        )
        robots = self.simulation.robots
        self.walkers = {
            name: _Walker(name, one, grid, robots[name]) for name, one in members.items()
        }
        """The robots by their names."""
        self._steps = round(SENSOR_PERIOD / self.simulation.time_step)
        self.record = FleetRecord()
        self.spent = {'physics': 0.0, 'gaits and planners': 0.0}
        """Time of the processor that was spent in each part [s]."""

    @property
    def poses(self) -> dict[str, Pose2D]:
        """Pose of each robot."""
        return {name: walker.pose for name, walker in self.walkers.items()}

    def run(self, timeout: float) -> FleetRecord:
        """Walk until all have arrived; at most so long [s], simulated."""
        record, walkers = self.record, self.walkers
        next_words = 0.0
        while self.simulation.time < timeout and len(record.arrived) < len(walkers):
            began = time.thread_time()
            if self.simulation.time >= next_words:
                next_words = self.simulation.time + _WORDS
                self._exchange_words()
            for walker in walkers.values():
                walker.loop.measure()
            self._note()
            decided = time.thread_time()
            for _ in range(self._steps):
                self.simulation.step()
            self.spent['gaits and planners'] += decided - began
            self.spent['physics'] += time.thread_time() - decided
        record.duration = self.simulation.time
        record.said = {n: w.says for n, w in walkers.items() if n not in record.arrived}
        return record

    def close(self) -> None:
        """Release the world."""
        self.simulation.close()

    def _exchange_words(self) -> None:
        """Tell every robot what the others say."""
        for walker in self.walkers.values():
            word = walker.traffic.own_word()
            for other in self.walkers.values():
                if word is not None:
                    other.traffic.take_robot(self.simulation.time, word)

    def _note(self) -> None:
        record = self.record
        for name, walker in self.walkers.items():
            seen = walker.loop.simulation.contacts_seen
            record.contacts |= {f'{name}: {contact}' for contact in seen}
            if walker.session.hold_reason:
                record.waits.add(f'{name}: {walker.session.hold_reason}')
            if walker.has_arrived:
                record.arrived.setdefault(name, self.simulation.time)
        for a, b in combinations(self.walkers.values(), 2):
            radii = a.loop.robot.standing_radius + b.loop.robot.standing_radius
            record.least_gap = min(record.least_gap, a.pose.distance_to(b.pose) - radii)
