"""
Trots over slopes and bumps, by robots that do not know of them, or have a map.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_lab.balance.balance_case import BalanceCase, BalanceWalk
from quad_sim.world.terrain import Terrain
from quad_sim.world.terrain_spec import make_terrain, specs_from_text

SLOPES = {'up': -math.pi / 2.0, 'down': math.pi / 2.0, 'across': 0.0}
"""Slopes on which a robot starts, and the heading along which they rise to the left [rad]."""

RAMPS = {'onto': 1.0, 'off': -1.0}
"""Slopes that begin at an edge ahead of the robot, up and down, by the sign of their angle."""

BUMPS = 'bumps'
"""Round bumps all over the ground."""

ANGLE = math.radians(15.0)
"""Angle of the slopes [rad]."""

HEIGHT = 0.15
"""Height of the highest bumps, over the length of a leg."""

_STRAY = 0.2
"""Starts are turned by up to this from straight up, down or across [rad]."""

_DURATION = 8.0
"""Time of a walk [s]."""

_GOES_ON = 0.7
"""Part of the distance that was asked for which a robot must have come."""

_CLEAR = 1.6
"""Distance from the start to the foot of a slope, in hip heights; and up to one stride more."""

_BUMP, _ROUND_START = 1.65, 3.3
"""Diameter of bumps, and radius of the level ground around the start, in hip heights."""


@dataclass(frozen=True)
class GroundTrot:
    """A trot over ground that is not level."""

    case: BalanceCase
    """Who, and how fast."""
    ground: str
    """One of :data:`SLOPES`, of :data:`RAMPS`, or :data:`BUMPS`."""
    seed: int
    """Seed of the ground, of the heading and of the sensors' errors."""
    progress: float
    """Distance along its heading, as a fraction of what was asked for."""
    tilt: float
    """Root mean square of what its tilt differs from its mean [rad]."""
    has_fallen: bool
    """Whether it fell, or stopped."""

    @property
    def succeeds(self) -> bool:
        """Whether it trots on to the end."""
        return not self.has_fallen and self.progress >= _GOES_ON


def ground_of(robot: Robot, ground: str, seed: int) -> Terrain | None:
    """
    Make ground in proportion to a robot that starts at the origin, along x.

    Parameters
    ----------
    robot : Robot
        The robot.
    ground : str
        One of :data:`SLOPES`, of :data:`RAMPS`, or :data:`BUMPS`.
    seed : int
        Where things are, and at what angle a slope lies.

    Returns
    -------
    Terrain or None
    """
    rng = np.random.default_rng(seed)
    size, leg = robot.hip_height, float(max(leg.reach()[1] for leg in robot.legs))
    yaw, ahead = rng.uniform(-_STRAY, _STRAY), rng.uniform()
    clear = _CLEAR * size + ahead * robot.largest_stride
    if ground == BUMPS:
        text = (
            f'bumps:height={HEIGHT * leg:.4f},size={max(_BUMP * size, 0.1):.3f},'
            f'clear={_ROUND_START * size:.3f},seed={seed}'
        )
    elif ground in SLOPES:
        text = f'cross_slope:angle={ANGLE:.4f}'
        yaw += SLOPES[ground]
    else:
        text = f'slope:angle={RAMPS[ground] * ANGLE:.4f},length=20,clear={clear:.3f}'
    reach = 32.0 * size
    return make_terrain(
        specs_from_text(text),
        (-0.2 * reach, -0.4 * reach, reach, 0.4 * reach),
        Pose2D(0.0, 0.0, 0.0 if ground == BUMPS else yaw),
        level_at=((0.0, 0.0),),
        resolution=min(0.02, 0.15 * size),
    )


def trot_over(case: BalanceCase, ground: str, seed: int, duration: float = _DURATION) -> GroundTrot:
    """
    Trot straight on over ground.

    Parameters
    ----------
    case : BalanceCase
        Who, and how fast.
    ground : str
        One of :data:`SLOPES`, of :data:`RAMPS`, or :data:`BUMPS`.
    seed : int
        Seed of the ground and of the sensors' errors.
    duration : float
        Time of the walk, with its start [s].

    Returns
    -------
    GroundTrot
    """
    walk = BalanceWalk(case, seed, lambda robot: ground_of(robot, ground, seed))
    loop = walk.loop
    try:
        loop.run(duration - loop.time, until=lambda: loop.record.has_fallen)
        record = loop.record
        asked = walk.speed * duration
        angles = record.rolls_and_pitches
        apart = np.hypot(*(angles - angles.mean(axis=0)).T)
        progress = record.poses[-1].x / asked if asked else 1.0
        return GroundTrot(
            case, ground, seed, progress, float(np.sqrt(np.mean(apart**2))), walk.is_lost
        )
    finally:
        walk.close()
