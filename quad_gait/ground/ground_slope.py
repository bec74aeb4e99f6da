"""
The gradient of the ground, by the feet that stand on it, and the body's attitude over it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_LEAST, _CERTAIN = 0.04, 0.1
"""Gradients below which ground is level, and from which on they count in full: feet that bend
and bounce let level ground look like the least."""

_STEEPEST = 0.45
"""Largest gradient that is believed."""

_ROUGH, _ROUGHEST = 4.0, 30.0
"""Time constants with which rough ground is forgotten, over that of its gradient: for as long as
the first the body goes up and down with it, and for as long as the second feet are lifted higher,
for between bumps there is level ground."""

_KEPT = 1e-3
"""Weight of the last estimate, over that of what feet have told."""


class Slope(NamedTuple):
    """A plane of ground beside the level body: z rises by ``ahead`` x + ``aside`` y."""

    ahead: float
    """Gradient along x."""
    aside: float
    """Gradient along y."""
    roll: float = 0.0
    """Roll of a body that goes along [rad]."""
    pitch: float = 0.0
    """Pitch of a body that goes along [rad]."""

    @classmethod
    def along(cls, ahead: float, aside: float, fraction: float) -> Slope:
        """Return a plane over which a body takes a fraction of the plane's own tilt."""
        roll = math.asin(aside / math.sqrt(1.0 + ahead * ahead + aside * aside))
        return cls(ahead, aside, fraction * roll, -fraction * math.atan(ahead))

    @property
    def is_level(self) -> bool:
        """Whether it is level."""
        return not (self.ahead or self.aside)

    @property
    def normal(self) -> tuple[float, float, float]:
        """Unit vector out of the ground."""
        size = math.sqrt(1.0 + self.ahead * self.ahead + self.aside * self.aside)
        return -self.ahead / size, -self.aside / size, 1.0 / size

    def rise(self, x: float, y: float) -> float:
        """Return how much higher the ground is at a place than under the body [m]."""
        return self.ahead * x + self.aside * y


LEVEL = Slope(0.0, 0.0)
"""Level ground."""


class SlopeEstimator:
    """
    Follows the gradient g of the ground by recursive least squares.

    Feet that stand at the same instant lie on the ground: about their mean, with their places p
    in the plane and their heights z, z = g p. Two feet tell of one line, and the next two of
    another. What was told is forgotten with a time constant T (L. Ljung, *System Identification*,
    Prentice Hall 1999, 11.2)::

        A = e^(-dt / T) A + dt / T sum p p^T,   b = e^(-dt / T) b + dt / T sum p z,   A g = b

    The axes turn with the body's heading, and A, b and g with them.

    Parameters
    ----------
    memory : float
        Time constant T [s].
    fraction : float
        Fraction of the ground's tilt that the body takes.
    """

    def __init__(self, memory: float, fraction: float) -> None:
        self._memory, self._fraction = memory, fraction
        self.forget()

    def forget(self) -> None:
        """Know of nothing."""
        self._matrix: Array = np.zeros((2, 2))
        self._vector: Array = np.zeros(2)
        self._gradient: Array = np.zeros(2)
        self.roughness = 0.0
        """Height by which feet were off the plane lately [m]."""
        self.roughest = 0.0
        """The same for a longer while [m]."""

    def update(self, dt: float, turn: float, feet: Array, is_upright: bool = True) -> None:
        """
        Take notice of feet.

        Parameters
        ----------
        dt : float
            Time since the last time [s]; 0 if nothing was known before.
        turn : float
            Angle by which the heading turned meanwhile [rad].
        feet : ndarray, shape (n, 3)
            Centers of those that stand, in level axes [m].
        is_upright : bool
            Whether the body is about as on even ground; feet of one that falls over stand anywhere.
        """
        c, s = math.cos(turn), math.sin(turn)
        turned = np.array([[c, s], [-s, c]])
        kept = math.exp(-dt / self._memory)
        self._matrix = kept * turned @ self._matrix @ turned.T
        self._vector = kept * turned @ self._vector
        self._gradient = turned @ self._gradient
        self.roughness *= math.exp(-dt / (_ROUGH * self._memory))
        self.roughest *= math.exp(-dt / (_ROUGHEST * self._memory))
        if len(feet) < 2:
            return
        apart = feet - feet.mean(axis=0)
        off = apart[:, 2] - apart[:, :2] @ self._gradient
        height = float(np.ptp(off))
        self.roughness = max(self.roughness, height)
        if dt > 0.0 and is_upright:
            # Of a slope on which it begins all is off the plane for a moment.
            self.roughest = max(self.roughest, height)
        weight = dt / self._memory if dt > 0.0 else 1.0
        self._matrix += weight * apart[:, :2].T @ apart[:, :2]
        self._vector += weight * apart[:, :2].T @ apart[:, 2]
        # A line tells nothing across: there the last estimate is kept.
        prior = _KEPT * float(self._matrix.trace())
        matrix = self._matrix + prior * np.eye(2)
        told = np.linalg.solve(matrix, self._vector + prior * self._gradient)
        solved: Array = np.asarray(told, dtype=np.float64)
        size = math.hypot(*solved.tolist())
        self._gradient = min(1.0, _STEEPEST / max(size, 1e-9)) * solved

    @property
    def slope(self) -> Slope:
        """The ground, which is level unless its gradient is certain."""
        ahead, aside = self._gradient.tolist()
        certainty = (math.hypot(ahead, aside) - _LEAST) / (_CERTAIN - _LEAST)
        if certainty <= 0.0:
            return LEVEL
        part = min(certainty, 1.0)
        part = part * part * (3.0 - 2.0 * part)
        return Slope.along(part * ahead, part * aside, self._fraction)
