"""
A simulation as ``sim_node`` runs it: its pace, what its sensors measure and when, its status.

The session knows no topics. Its node tells it to go on, and publishes what comes of it.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from typing import Protocol

import numpy as np

from quad_common.errors import ParameterError, RobotIsAlone
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.status import Level, Status
from quad_sim.engines.registry import make_simulator
from quad_sim.engines.simulator import Observation
from quad_sim.pacing import Pacing
from quad_sim.parameters import SimParameters
from quad_sim.scenery import appearance_from, camera_from, scenery_from
from quad_sim.simulated_robot import SensorReadings, SimulatedRobot
from quad_sim.simulation import Simulation
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.simulated_camera import Picture
from quad_sim.world.world import Obstacle

_CLOCK_RATE = 100.0
"""Least rate of the published clock, in simulated time [Hz]."""

_LONGEST_WAIT = 0.1
"""Longest time for which a node is told to wait [s]."""


class Output(Protocol):
    """What becomes of a session's measurements."""

    def publish_clock(self, time: float) -> None:
        """Publish simulated time [s]."""

    def publish_picture(self, time: float, take: Callable[[], Picture]) -> None:
        """Publish what the camera sees at a time [s]; without a subscriber none is taken."""

    def publish_readings(self, readings: SensorReadings, name: str = '') -> None:
        """Publish what was measured of a robot; its name is empty if it is alone."""


class SteppedSimulation(Protocol):
    """What a session steps: the simulation of one robot, or of several."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    def step(self) -> None:
        """Advance by one time step."""

    def change_obstacles(self, changes: Iterable[ObstacleChange], most: int | None = None) -> None:
        """Put and remove obstacles; see :meth:`Simulation.change_obstacles`."""

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Obstacles that stand, by name."""

    def close(self) -> None:
        """Release the simulator."""


class SimSession:
    """
    Steps the simulation that parameters describe.

    Parameters
    ----------
    parameters : SimParameters
        Of the node.
    robot : Robot
        The robot.
    clock : callable
        Returns the wall clock's time [s].
    """

    def __init__(self, parameters: SimParameters, robot: Robot, clock: Callable[[], float]) -> None:
        p = parameters
        self._parameters = p
        self._clock = clock
        self.robot = robot
        """The robot."""
        self.scenery = scenery_from(p, robot)
        """World, maps, start and goal."""
        self.camera = camera_from(p) if p.camera else None
        """The camera under the ceiling, if there is one."""
        self._build()
        self._pacing = Pacing(p.real_time_factor, clock())
        self._is_paused = False
        self._steps = 0
        self._steps_per_clock = max(1, int(1.0 / (_CLOCK_RATE * p.time_step) + 1e-9))
        self._steps_per_observation = max(1, round(1.0 / (p.sensor_rate * p.time_step)))
        self._steps_per_picture = max(1, round(1.0 / (p.camera_rate * p.time_step)))
        self._spent = {'physics': 0.0, 'publishing': 0.0, 'pictures': 0.0}
        self._troubles_reported = 0

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.simulation.time

    @property
    def frames_on_map(self) -> tuple[str, ...]:
        """Frames that coincide with the world."""
        frames = [self._parameters.map_frame]
        for robot in self.robots.values():
            frames += [robot.parameters.odom_frame] if robot.has_exact_odometry else []
        return tuple(frames)

    @property
    def has_news(self) -> bool:
        """Whether there is trouble of a kind that no :meth:`status` has told of."""
        return self._troubles() > self._troubles_reported

    def _build(self) -> None:
        """Make the simulator, and put the robot into it."""
        p = self._parameters
        world, look = self.scenery.world, appearance_from(p, self.robot)
        simulator = make_simulator(p.backend, self.robot, world, p.time_step, p.gui, look)
        simulation = Simulation(simulator, self.robot, self.scenery.start)
        self.simulation: SteppedSimulation = simulation
        """What is stepped."""
        self.robots = {'': SimulatedRobot(simulation, p)}
        """Robots by their names; that of one alone is empty."""
        self.plan_failure(p)
        if self.scenery.goal is not None:
            self.put_goal_marker(self.scenery.goal)
        if self.camera is not None:
            # Where nothing can draw, it is said at the start.
            simulation.check_visible('a camera').prepare_pictures()

    def take_parameters(self, parameters: SimParameters) -> None:
        """Let a joint fail, or robots come and go, as parameters say; QuadError refuses both."""
        # What only refuses comes first: nothing of a change that is refused takes effect.
        self.take_robots(parameters.robots)
        self.plan_failure(parameters)

    def plan_failure(self, parameters: SimParameters) -> None:
        """Let a joint fail as parameters say; see :meth:`Simulation.plan_failure`."""
        self._alone.plan_failure(parameters)

    def take_robots(self, text: str) -> None:
        """Raise ParameterError if robots are to come: this one is alone in its world."""
        if text.strip():
            raise ParameterError('robots', text, 'empty, as it was when the node began')

    @property
    def can_spawn(self) -> bool:
        """Whether robots may come and go."""
        return False

    def observations(self) -> dict[str, Observation]:
        """Return the state of each robot by its name; one alone has that of its kind."""
        return {
            name or robot.robot.name: robot.simulation.observe()
            for name, robot in self.robots.items()
        }

    @property
    def robots_text(self) -> str:
        """Robots that there are, as the parameter ``robots`` has them."""
        return ''

    def spawn_robot(self, name: str, kind: str, start: Pose2D) -> None:
        """
        Put a robot into the world.

        Parameters
        ----------
        name : str
            Its name.
        kind : str
            Name of one that is known, or path of its file.
        start : Pose2D
            Where it stands, in the map [m, m, rad].

        Raises
        ------
        RobotIsAlone
            If this simulation has one robot for good.
        QuadError
            If it cannot come; then all stays as it was.
        """
        raise RobotIsAlone()

    def remove_robot(self, name: str) -> None:
        """Take a robot out of the world; RobotNotFound or RobotIsAlone if it cannot go."""
        raise RobotIsAlone()

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Lay the goal's marker on the floor, or move it; NotSimulated if it cannot be seen."""
        self._alone.simulation.put_goal_marker(pose)

    @property
    def _alone(self) -> SimulatedRobot:
        return self.robots['']

    def wait(self) -> float:
        """Return how long there is nothing to do [s]; 0 if the next observation is due."""
        if self._is_paused:
            return _LONGEST_WAIT
        wall = self._clock()
        waits = [robot.answers.wait(self.time, wall) for robot in self.robots.values()]
        wait = max(self._pacing.ahead(self.time, wall), *waits, 0.0)
        return min(max(wait, 0.0), _LONGEST_WAIT)

    def take_answer(self, name: str, stamp: float) -> None:
        """Take it that a robot's gait has answered what was measured up to a time [s]."""
        self.robots[name].answers.take(stamp, self.time, self._clock())

    def advance(self, output: Output) -> None:
        """Simulate up to the next observation, and publish what is measured meanwhile."""
        for _ in range(self._steps_per_observation):
            began = self._clock()
            self.simulation.step()
            self._steps += 1
            self._spent['physics'] += self._clock() - began
            if self._steps % self._steps_per_clock == 0:
                output.publish_clock(self.time)
            if self.camera is not None and self._steps % self._steps_per_picture == 0:
                began = self._clock()
                output.publish_picture(self.time, self._take_picture)
                self._spent['pictures'] += self._clock() - began
        began = self._clock()
        self.observe(output)
        self._spent['publishing'] += self._clock() - began

    def observe(self, output: Output) -> None:
        """Measure, and publish it."""
        for name, robot in self.robots.items():
            output.publish_readings(robot.observe(), name)

    def reset(self, name: str) -> None:
        """Put a robot back to its start pose, its name being empty if it is alone."""
        self.robots[name].reset()

    @property
    def is_paused(self) -> bool:
        """Whether simulated time stands still."""
        return self._is_paused

    def pause(self) -> None:
        """Let simulated time stand still."""
        self._is_paused = True

    def unpause(self) -> None:
        """Go on, at the pace from now on."""
        self._is_paused = False
        self._pacing.restart(self.time, self._clock())

    def status(self) -> Status:
        """Return how the simulation goes."""
        self._troubles_reported = self._troubles()
        seen = {name: robot.simulation for name, robot in self.robots.items()}
        contacts = ', '.join(
            f'{name}: {contact}' if name else str(contact)
            for name, simulation in seen.items()
            for contact in sorted(map(str, simulation.contacts_seen))
        )
        has_fallen = any(simulation.has_fallen for simulation in seen.values())
        values = {
            'time': f'{self.time:.2f}',
            'real_time_factor': f'{self._pacing.measured_factor(self.time, self._clock()):.2f}',
            'contacts': contacts,
            'has_fallen': has_fallen,
            'late_trajectories': sum(one.late_trajectories for one in seen.values()),
            'pushes': sum(one.pushes for one in seen.values()),
            'seconds_in_physics': f'{self._spent["physics"]:.3f}',
            'seconds_publishing': f'{self._spent["publishing"]:.3f}',
            'seconds_in_pictures': f'{self._spent["pictures"]:.3f}',
        }
        fallen = [name or 'the robot' for name, one in seen.items() if one.has_fallen]
        if fallen:
            said = f'{", ".join(fallen)} has fallen; reset stands it up again'
            return Status(Level.ERROR, said, values)
        for failed in (one.failed for one in seen.values()):
            if failed is not None:
                said = f'{failed.joint} is {failed.kind}; reset repairs it'
                return Status(Level.WARN, said, values)
        if contacts:
            return Status(Level.WARN, f'contact: {contacts}', values)
        if any(one.is_frozen for one in seen.values()):
            return Status(Level.WARN, 'the emergency stop is on: no trajectory is executed', values)
        return Status(Level.OK, 'paused' if self._is_paused else 'running', values)

    def close(self) -> None:
        """Release the simulator."""
        self.simulation.close()

    def _troubles(self) -> int:
        """Count the kinds of trouble that have been seen."""
        return sum(robot.troubles() for robot in self.robots.values())

    def _take_picture(self) -> Picture:
        assert self.camera is not None
        # Each picture has noise of its own: who looked at the others must not change it.
        rng = np.random.default_rng((self._parameters.seed, self._steps))
        return self._alone.simulation.picture(self.camera, rng)
