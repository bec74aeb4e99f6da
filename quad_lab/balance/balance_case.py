"""
A robot that keeps its balance, and what makes that harder.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Twist2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import GaitSettings
from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.foot_laws import GRAVITY
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.balance_loop import NO_NOISE, NOISY, BalanceLoop
from quad_lab.closed_loop.controllers import controller_for
from quad_sim.world.terrain import Terrain
from quad_sim.world.world import World

Array = NDArray[np.float64]

LATENCY = 0.02
"""Time that trajectories travel in every case [s]."""

_SETTLING = 2.0
"""Time after which a robot walks steadily, at least [s]; and eight cycles."""

_SLOWEST = 1e-4
"""Velocity of a trot in place, which the planned gait takes for a walk [m/s]."""

_SLIPPERY, _PAYLOAD, _DELAY = 0.4, 0.2, 0.02

_TROTTING = (Activity.BALANCING, Activity.WALKING, Activity.TURNING)


@dataclass(frozen=True)
class BalanceCase:
    """Who trots how fast, and what makes it harder."""

    robot: str
    """Name of the robot."""
    period: float | None = None
    """Period of the gait [s]; the robot's own if None."""
    speed: float = 0.5
    """Speed as a fraction of the most; 0 in place."""
    is_slippery: bool = False
    """Whether the friction is 0.4, and not 0.8."""
    has_payload: bool = False
    """Whether a fifth of its weight lies on it, of which it does not know."""
    is_late: bool = False
    """Whether trajectories travel 20 ms longer."""
    is_noisy: bool = False
    """Whether its sensors err."""
    keeps_balance: bool = True
    """Whether it keeps its balance; or walks by cycles that are planned as a whole."""
    knows_ground: bool = False
    """Whether it has a height map of the ground, and goes by it where its own legs take it."""
    gait: str = 'trot'
    """Name of a gait with two feet down."""

    def __str__(self) -> str:
        """Name it."""
        speeds = {0.0: 'in place', 0.5: 'at half speed', 1.0: 'at full speed'}
        words = [self.robot]
        if self.gait != 'trot':
            words.append(self.gait)
        if self.period is not None:
            words.append(f'({self.period:g} s)')
        words.append(speeds.get(self.speed, f'at {self.speed:g} of the most'))
        names = ('is_slippery', 'has_payload', 'is_late', 'is_noisy')
        words += [name.rpartition('_')[2] for name in names if getattr(self, name)]
        if not self.keeps_balance:
            words.append('planned')
        if self.knows_ground:
            words.append('with a height map')
        return ' '.join(words)

    def hardest(self) -> BalanceCase:
        """Return the same with everything that makes it harder."""
        return replace(self, is_slippery=True, has_payload=True, is_late=True, is_noisy=True)


def push_unit(robot: Robot) -> float:
    """Return the velocity sqrt(g h) by which pushes of a robot are measured [m/s]."""
    return math.sqrt(GRAVITY * robot.center_height)


def trotting_robot(name: str, period: float | None, gait: str = 'trot') -> Robot:
    """Return a robot by its name, with another period of its gait [s] unless that is None."""
    robot = load_robot(name)
    if period is None:
        return robot
    settings = replace(robot.gaits.get(gait, GaitSettings()), cycle_period=period)
    return replace(robot, gaits={**robot.gaits, gait: settings})


class BalanceWalk:
    """
    A robot that trots steadily.

    Parameters
    ----------
    case : BalanceCase
        Who, how fast, and what makes it harder.
    seed : int
        Seed of its sensors' errors.
    ground : callable, optional
        Makes the ground for the robot; level without it.
    """

    def __init__(
        self,
        case: BalanceCase,
        seed: int = 0,
        ground: Callable[[Robot], Terrain | None] | None = None,
    ) -> None:
        robot = trotting_robot(case.robot, case.period, case.gait)
        gait = load_gait(case.gait, robot)
        options = SupervisorOptions(
            least_margin=0.005,
            twist_timeout=math.inf,
            balance=BalanceOptions(steps_in_place=True) if case.keeps_balance else None,
        )
        controller = controller_for(robot, gait, options)
        world = World(
            np.empty((0, 4, 2)),
            friction=_SLIPPERY if case.is_slippery else 0.8,
            terrain=None if ground is None else ground(robot),
        )
        if case.knows_ground and world.terrain is not None:
            controller.set_height_map(world.terrain.height_map)
        delay = (LATENCY if case.keeps_balance else 0.0) + _DELAY * case.is_late
        noise = NOISY if case.is_noisy else NO_NOISE
        self.loop = BalanceLoop(robot, controller, delay, noise, seed, world=world)
        """The robot in its simulator."""
        self.robot = robot
        self.unit = push_unit(robot)
        """Velocity sqrt(g h), by which pushes are measured [m/s]."""
        self._weight: Array = np.zeros(3)
        if case.has_payload:
            self._weight = np.array([0.0, 0.0, -_PAYLOAD * robot.mass * GRAVITY])
        self.push(np.zeros(3))
        self.loop.run(0.1)
        gear = controller.gait_pair.walking
        most = gear.largest_scale(BodyMotion(forward=1.0)) / gear.period
        self.speed = case.speed * most
        """Velocity that is asked for [m/s]."""
        is_placed = case.speed == 0.0 and not case.keeps_balance
        self.loop.controller.set_twist(Twist2D(_SLOWEST if is_placed else self.speed))
        self.period = gear.period
        """Period of the trot [s]."""
        self.loop.run(max(_SETTLING, 8.0 * self.period))

    def push(self, force: Array) -> None:
        """Push against the body from now on with a force, (3,) [N], and the payload's."""
        self.loop.simulation.push(force + self._weight)

    @property
    def velocity(self) -> Array:
        """Velocity of the body along its own axes, forward and left, shape (2,) [m/s]."""
        velocity: Array = self.loop.simulation.observe().linear_velocity_base_in_base[:2]
        return velocity

    @property
    def is_lost(self) -> bool:
        """Whether it has fallen, or stands though it is to trot."""
        return self.loop.record.has_fallen or self.loop.controller.activity not in _TROTTING

    @property
    def tilts(self) -> Array:
        """Tilts of the body up to now, shape (n,) [rad]."""
        return self.loop.record.tilts

    def close(self) -> None:
        """Release the simulator."""
        self.loop.close()
