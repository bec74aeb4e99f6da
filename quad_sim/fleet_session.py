"""
A simulation of several robots as ``sim_node`` runs it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from quad_common.errors import ParameterError, RobotNameTaken, RobotNotFound
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_sim.fleet.shared_world import make_shared_world
from quad_sim.fleet_simulation import FleetSimulation
from quad_sim.fleet_text import (
    NamedRobot,
    check_apart,
    placed,
    robots_from_text,
    text_from_robots,
)
from quad_sim.parameters import SimParameters
from quad_sim.sim_session import SimSession
from quad_sim.simulated_robot import SimulatedRobot
from quad_sim.simulation import start_from

_ONE_ONLY = ('camera', 'gui', 'failing_joint')
"""Parameters that are for a robot alone in its world."""


class FleetSession(SimSession):
    """
    Steps one world with the robots that parameters name.

    Parameters
    ----------
    parameters : SimParameters
        Of the node.
    clock : callable
        Returns the wall clock's time [s].

    Raises
    ------
    ParameterError
        If the robots cannot be read, or something is wanted that a robot has alone.
    """

    def __init__(self, parameters: SimParameters, clock: Callable[[], float]) -> None:
        self._wanted = robots_from_text(parameters.robots)
        self._text = parameters.robots
        self._count = 0
        for name in _ONE_ONLY:
            if getattr(parameters, name):
                value = getattr(parameters, name)
                raise ParameterError(name, value, "not set where 'robots' names several")
        kinds = [one.kind for one in self._wanted.values()] or [parameters.robot]
        super().__init__(parameters, load_robot(kinds[0]), clock)

    def _build(self) -> None:
        p = self._parameters
        world = make_shared_world(p.backend, self.scenery.world, p.time_step)
        self.simulation = self._fleet = FleetSimulation(world, self.scenery.grid)
        self.robots = {}
        wanted, self._wanted = self._wanted, {}
        self._spawn(wanted)

    def reset(self, name: str) -> None:
        """Put a robot back to its start pose; PlaceTaken if another one stands there."""
        simulation = self.robots[name].simulation
        others = {n: one for n, one in self._fleet.standing.items() if n != name}
        check_apart(name, simulation.robot, simulation.start_pose, others)
        super().reset(name)

    def take_robots(self, text: str) -> None:
        """
        Spawn the robots that are new, and remove those that are missing.

        Parameters
        ----------
        text : str
            See :func:`quad_sim.fleet_text.robots_from_text`; those that stay are not moved.

        Raises
        ------
        QuadError
            If one cannot come; then all stays as it was.
        """
        if text == self._text:
            return
        wanted = robots_from_text(text)
        for name in wanted:
            if name in self.robots and wanted[name].kind != self._wanted[name].kind:
                valid = f'one with another name: {name} is {self._wanted[name].kind}'
                raise ParameterError('robots', text, valid)
        gone = [name for name in self.robots if name not in wanted]
        self._spawn({n: one for n, one in wanted.items() if n not in self.robots}, gone)
        self._text = text

    @property
    def can_spawn(self) -> bool:
        """Whether robots may come and go: they may."""
        return True

    @property
    def robots_text(self) -> str:
        """Robots that there are, as the parameter ``robots`` has them."""
        return self._text

    def spawn_robot(self, name: str, kind: str, start: Pose2D) -> None:
        """Put a robot into the world; see :meth:`SimSession.spawn_robot`."""
        one = NamedRobot(kind, start_from('initial_pose', (start.x, start.y, start.yaw)))
        if name in self.robots:
            raise RobotNameTaken(name)
        text = text_from_robots({**self._wanted, name: one})
        self._spawn({name: one})
        self._text = text

    def remove_robot(self, name: str) -> None:
        """Take a robot out of the world; RobotNotFound if it is not there."""
        if name not in self.robots:
            raise RobotNotFound(name, self.robots)
        self._spawn({}, [name])
        self._text = text_from_robots(self._wanted)

    def take_parameters(self, parameters: SimParameters) -> None:
        """Let robots come and go as parameters say; QuadError refuses all of a change."""
        self.plan_failure(parameters)
        self.take_robots(parameters.robots)

    def plan_failure(self, parameters: SimParameters) -> None:
        """Raise ParameterError if a joint is to fail: it is not said whose."""
        if parameters.failing_joint:
            joint = parameters.failing_joint
            raise ParameterError('failing_joint', joint, 'not set where there are several robots')

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Do nothing: there is no camera that would see it."""

    def _spawn(self, wanted: dict[str, NamedRobot], gone: Sequence[str] = ()) -> None:
        """Put robots into the world, in place of others."""
        robots: dict[str, tuple[Robot, Pose2D | None]] = {
            name: (load_robot(one.kind), one.start) for name, one in wanted.items()
        }
        standing = {n: one for n, one in self._fleet.standing.items() if n not in gone}
        places = placed(robots, self.scenery.start, self.scenery.grid, standing)
        self._fleet.spawn(places, gone)
        for name in gone:
            del self.robots[name], self._wanted[name]
        for name in wanted:
            simulation = self._fleet.robots[name]
            self.robots[name] = SimulatedRobot(simulation, self._parameters, name, self._count)
            self._count += 1
        self._wanted |= wanted


def session_from_parameters(parameters: SimParameters, clock: Callable[[], float]) -> SimSession:
    """Make the session of one robot, or of those that ``robots`` names."""
    if parameters.robots.strip():
        return FleetSession(parameters, clock)
    return SimSession(parameters, load_robot(parameters.robot), clock)
