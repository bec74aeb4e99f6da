"""
Odometry that drifts as real odometry does, and a localiser that corrects it.

The model: between two observations the robot moves by (dx, dy, dyaw) in its own axes, and odometry
takes it for (1 + a) dx, (1 + a) dy and (1 + b) dyaw + c ds, with ds the length of the path. For a
drift of d, each of a, b [1] and c [rad/m] is d (s + w / 2). s is drawn once as 1 or -1: what a
wrong leg length, or slip, does all the time. w wanders with the distance, an Ornstein-Uhlenbeck
process of standard deviation 1 that has forgotten a 1/e part after 1 m; a turn of 1 rad counts as
0.25 m.

The localiser says at its rate where the robot is in the map, with normal noise, and publishes what
that makes of map -> odom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_sim.engines.simulator import Observation

_FORGETS = 1.0
"""Distance after which a 1/e part is left of what drift was [m]."""

_TURN = 0.25
"""A turn of 1 rad counts as so much distance [m]."""

_ORIGIN = Pose2D(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class LocalisationOptions:
    """How odometry drifts, and how a localiser corrects it."""

    drift: float = 0.0
    """Drift of odometry as a fraction of the distance and of the angle turned, and in rad/m [1]."""
    rate: float = 0.0
    """Corrections in a second [Hz]; 0: none."""
    noise: float = 0.02
    """Standard deviation of the position that the localiser sees, along each axis [m]."""
    heading_noise: float = 0.01
    """Standard deviation of the heading that it sees [rad]."""
    seed: int = 0
    """Seed of what is drawn; other noise of the simulator is drawn elsewhere."""


class DriftingOdometry:
    """
    What odometry makes of where the robot is.

    Parameters
    ----------
    drift : float
        See :class:`LocalisationOptions`.
    rng : numpy.random.Generator
        What signs and wandering are drawn with.
    """

    def __init__(self, drift: float, rng: np.random.Generator) -> None:
        self._drift = drift
        self._rng = rng
        self._signs = rng.choice((-1.0, 1.0), 3)
        self._wandering = rng.standard_normal(3)
        self._true: Pose2D | None = None
        self._pose = _ORIGIN

    def locate(self, true: Pose2D) -> Pose2D:
        """
        Move on.

        Parameters
        ----------
        true : Pose2D
            Pose of the robot in the world.

        Returns
        -------
        Pose2D
            Its pose by odometry, which begins with the true one.
        """
        if self._true is None:
            self._true = self._pose = true
        moved = self._true.inverse() @ true
        self._true = true
        distance = math.hypot(moved.x, moved.y)
        along, turning, veering = self._rates(
            distance + _TURN * abs(wrap_angle(moved.yaw))
        ).tolist()
        yaw = (1.0 + turning) * wrap_angle(moved.yaw) + veering * distance
        self._pose = self._pose @ Pose2D((1.0 + along) * moved.x, (1.0 + along) * moved.y, yaw)
        return self._pose

    def reset(self) -> None:
        """Begin again with the true pose: the robot was put elsewhere."""
        self._true = None

    def _rates(self, distance: float) -> NDArray[np.float64]:
        """Let the drift wander; return the rates a, b and c."""
        kept = math.exp(-distance / _FORGETS)
        spread = math.sqrt(1.0 - kept * kept)
        self._wandering = kept * self._wandering + spread * self._rng.standard_normal(3)
        rates: NDArray[np.float64] = self._drift * (self._signs + 0.5 * self._wandering)
        return rates


class SimulatedLocalisation:
    """
    Odometry and localiser of a simulated robot.

    Parameters
    ----------
    options : LocalisationOptions
        How good they are.
    """

    def __init__(self, options: LocalisationOptions) -> None:
        self._options = options
        odometry, localiser = np.random.SeedSequence(options.seed, spawn_key=(7,)).spawn(2)
        self._odometry = DriftingOdometry(options.drift, np.random.default_rng(odometry))
        self._rng = np.random.default_rng(localiser)
        self._next = -math.inf

    @property
    def is_exact(self) -> bool:
        """Whether odometry's frame coincides with the world for good."""
        return self._options.drift == 0.0 and self._options.rate == 0.0

    def observe(self, seen: Observation) -> Observation:
        """
        Return what odometry makes of an observation.

        Parameters
        ----------
        seen : Observation
            The truth.

        Returns
        -------
        Observation
            With x, y and the heading as odometry has them; the very same without drift.
        """
        if self._options.drift == 0.0:
            return seen
        pose, true = self._odometry.locate(seen.pose), seen.pose
        half = wrap_angle(pose.yaw - true.yaw) / 2.0
        s, c = math.sin(half), math.cos(half)
        x, y, z, w = seen.orientation
        return replace(
            seen,
            position=np.array([pose.x, pose.y, seen.position[2]]),
            # A turn about the vertical, after the orientation.
            orientation=np.array([c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z]),
        )

    def correction(self, seen: Observation, told: Observation) -> Pose2D | None:
        """
        Return what the localiser says, if it is time to.

        Parameters
        ----------
        seen, told : Observation
            The truth, and what odometry makes of it.

        Returns
        -------
        Pose2D or None
            Odometry's frame in the map.
        """
        rate = self._options.rate
        if rate == 0.0 or self._next - 1.0 / rate <= seen.time < self._next - 1e-9:
            return None
        self._next = seen.time + 1.0 / rate
        dx, dy, turn = self._rng.standard_normal(3).tolist()
        noise, true = self._options.noise, seen.pose
        pose = Pose2D(
            true.x + noise * dx, true.y + noise * dy, true.yaw + self._options.heading_noise * turn
        )
        return pose @ told.pose.inverse()

    def reset(self) -> None:
        """Begin again: the robot was put elsewhere."""
        self._odometry.reset()
        self._next = -math.inf
