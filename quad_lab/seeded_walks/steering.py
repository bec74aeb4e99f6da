"""
A walk that is steered in one direction on an open floor, as figures.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from quad_common.errors import GaitError
from quad_common.planar_pose import Pose2D
from quad_gait.cycle.body_motion import BodyMotion
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import largest_speed
from quad_lab.closed_loop.gait_measures import SteadyWalk, steered_walk
from quad_lab.seeded_walks.ready_robot import ReadyRobot
from quad_lab.seeded_walks.scene import ground_seed
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_settings import Walk
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import World, world_from_map

_DIRECTIONS = {
    'forward': BodyMotion(1.0, 0.0, 0.0),
    'backward': BodyMotion(-1.0, 0.0, 0.0),
    'left': BodyMotion(0.0, 1.0, 0.0),
    'turn': BodyMotion(0.0, 0.0, 1.0),
}


@dataclass(eq=False, repr=False)
class GaitStandsStill(GaitError):
    """The limits of a gait allow no motion in a direction."""

    robot: str
    """Name of the robot."""
    gait: str
    """Name of the gait."""
    reason: str
    """What limits it."""

    def sentence(self) -> str:
        """Say what limits it."""
        return f'{self.gait} of {self.robot} cannot move in this direction: {self.reason}'


_START = Pose2D(0.0, 0.0, 0.0)

_BEYOND = 2.0
"""Ground beyond the distance that is walked, on all sides [m]."""


def walk_steered(
    walk: Walk, seed: int, watch: Callable[[ClosedLoop], None] = lambda loop: None
) -> WalkFigures:
    """
    Steer a robot in one direction.

    Parameters
    ----------
    walk : Walk
        What to walk.
    seed : int
        Of the ground and the noise.
    watch : callable
        Called with the loop before the robot walks.

    Returns
    -------
    WalkFigures
        How it went.
    """
    settings, ready = walk.settings, ReadyRobot.of_walk(walk)
    direction = _DIRECTIONS[settings.direction]
    speed = settings.speed or settings.fraction * _most(ready, direction)
    world = _world(walk, speed, seed)
    loop = ready.stand(walk, world, _START, seed)
    try:
        watch(loop)
        if world.terrain is not None:
            ready.controller.set_height_map(world.terrain.height_map)
        asked = direction.scaled(speed * ready.controller.gait.cycle_period)
        steady = steered_walk(loop, direction, settings.duration, asked)
        # The record knows an imported robot's mass without what it carries.
        weight = loop.robot.mass / (ready.robot.mass + settings.payload)
        figures = _figures(steady, direction, speed)
        return replace(
            figures,
            duration=loop.time,
            largest_tilt=float(loop.record.tilts.max()),
            transport_cost=steady.transport_cost * weight,
        )
    finally:
        loop.close()


def _most(ready: ReadyRobot, direction: BodyMotion) -> float:
    """Return the largest speed of the gait with none of its numbers changed [m/s or rad/s]."""
    most = largest_speed(ready.robot, ready.derived, direction, ready.least_margin)
    if most.scale == 0.0:
        raise GaitStandsStill(ready.robot.name, ready.derived.name, most.reason)
    return most.scale


def _world(walk: Walk, speed: float, seed: int) -> World:
    """Make an open floor, as large as the walk needs it."""
    half = speed * walk.settings.duration + _BEYOND
    specs = specs_from_text(walk.settings.terrain, seed=ground_seed(seed))
    terrain = make_terrain(specs, (-half, -half, half, half), _START, ((0.0, 0.0),))
    return replace(world_from_map(None, friction=walk.settings.friction), terrain=terrain)


def _figures(steady: SteadyWalk, direction: BodyMotion, speed: float) -> WalkFigures:
    """Take over what was measured."""
    fraction = _along(steady.done, direction) / _along(steady.asked, direction)
    has_ended = steady.is_finite and math.isfinite(fraction) and not steady.has_fallen
    return WalkFigures(
        arrived=has_ended,
        has_fallen=steady.has_fallen,
        contacts='; '.join(steady.contacts),
        problem='' if has_ended else 'the walk did not go on to its end',
        tilt_rms=steady.tilt_rms,
        least_margin=steady.least_margin,
        torque_rms=steady.torque_rms,
        transport_cost=steady.transport_cost,
        speed=fraction * speed,
        speed_error=abs(fraction - 1.0),
        drift=steady.drift,
        slip=steady.slip,
    )


def _along(motion: BodyMotion, direction: BodyMotion) -> float:
    """Return the part of a motion along a direction of size 1."""
    return (
        motion.forward * direction.forward
        + motion.left * direction.left
        + motion.turn * direction.turn
    )
