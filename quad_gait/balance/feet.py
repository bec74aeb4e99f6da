"""
Feet at a knot, beside the level body, and what is to be done with them until the next.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_gait.balance.foot_laws import Pace, tilted_back
from quad_gait.ground.ground_slope import LEVEL, Slope

Array = NDArray[np.float64]

FOOT = np.dtype(
    (
        np.record,
        [
            ('x', 'f8'), ('y', 'f8'), ('z', 'f8'), ('vx', 'f8'), ('vy', 'f8'), ('rise', 'f8'),
            ('roll', 'f8'), ('pitch', 'f8'), ('swings', 'f8'), ('target_x', 'f8'),
            ('target_y', 'f8'), ('lift', 'f8'), ('has_landed', 'f8'),
        ],
    )
)  # fmt: skip
"""Record of a :class:`Foot`, as arrays hold it; truths are 1 and 0."""


class Foot(NamedTuple):
    """A foot at a knot, beside the level body."""

    x: float
    """Place of its center along x [m]."""
    y: float
    """The same along y [m]."""
    z: float
    """The same along z [m]."""
    vx: float = 0.0
    """Velocity along x while it swings [m/s]."""
    vy: float = 0.0
    """The same along y [m/s]."""
    rise: float = 0.0
    """Height above the plane of the ground of what it stands on, or left [m]."""
    roll: float = 0.0
    """Roll of the body that the leg makes up for [rad]."""
    pitch: float = 0.0
    """Pitch of the body that the leg makes up for [rad]."""
    swings: bool = False
    """Whether it swings."""
    target_x: float = 0.0
    """Place where it lands, or has landed, along x [m]."""
    target_y: float = 0.0
    """The same along y [m]."""
    lift: float = 0.0
    """Height to which it is lifted in this swing, or was in the last one [m]."""
    has_landed: bool = False
    """Whether it met the ground before its time, and stands since."""

    @property
    def in_body(self) -> tuple[float, float, float]:
        """Place in the body's axes [m]."""
        return tilted_back(self.x, self.y, self.z, self.roll, self.pitch)


class FootPlan(NamedTuple):
    """The feet at a knot, and how fast the body is to be."""

    records: NDArray[np.void]
    """Feet in the order of ``LEGS``, shape (4,), of the type :data:`FOOT`."""
    pace: Pace
    """Velocity that is planned by now."""
    slope: Slope = LEVEL
    """The ground on which they are planned."""

    @property
    def feet(self) -> tuple[Foot, ...]:
        """Feet in the order of ``LEGS``."""
        return tuple(Foot(*record) for record in self.records.tolist())

    def with_feet(self, feet: Iterable[Foot]) -> FootPlan:
        """Return the same plan with other feet."""
        return self._replace(records=np.array(list(feet), dtype=FOOT))


class Landings(NamedTuple):
    """Feet at a knot, and where each lands next; places are beside the level body."""

    feet: Array
    """Where they are, shape (4, 2) [m]."""
    rises: Array
    """Heights of what they stand on, or have left, over the plane of the ground, shape (4,) [m]."""
    stand: NDArray[np.bool_]
    """Which of them stand, shape (4,)."""
    targets: Array
    """Where they land next, beside the body as it will be by then, shape (4, 2) [m]."""
    times: Array
    """Times until they do, shape (4,) [s]."""
    neutral: Array
    """Their places under a standing body, shape (4, 2) [m]."""
    stance: float
    """Duration of a stance [s]."""
    slope: Slope
    """The plane of the ground."""


class GroundAhead(NamedTuple):
    """What is known of the ground ahead, over the plane on which feet are planned at first [m]."""

    is_known: bool
    """Whether anything is."""
    rises: tuple[float, float, float, float]
    """Heights of the places on which the feet land next."""
    bumps: tuple[float, float, float, float]
    """Heights of what is highest on their ways, over the straight lines to there."""
    body: float
    """Mean height of the ground under the body."""

    def after(self, risen: float) -> GroundAhead:
        """Return the same over a plane that has risen by a height [m]."""
        a, b, c, d = self.rises
        rises = a - risen, b - risen, c - risen, d - risen
        return self._replace(rises=rises, body=self.body - risen)


_NOWHERE = (0.0, 0.0, 0.0, 0.0)

UNKNOWN = GroundAhead(False, _NOWHERE, _NOWHERE, 0.0)
"""Nothing is known: feet land on the plane."""


class Demand(NamedTuple):
    """What is to be done from one knot to the next."""

    pace: Pace
    """Velocity that is wanted."""
    measured: Pace
    """Velocity of the body; while it is slowed down, it is taken to be as fast as planned."""
    roll: float = 0.0
    """Roll of the body, over that which it is to have [rad]."""
    pitch: float = 0.0
    """Pitch of the body, over that which it is to have [rad]."""
    slope: Slope = LEVEL
    """The ground."""
    trim: tuple[float, float] = (0.0, 0.0)
    """Velocity by which less is asked for than is wanted [m/s]."""
    roughness: float = 0.0
    """Height by which feet that stood were off the plane of the ground lately [m]."""
    lead: float = math.nan
    """Velocity by which a body that is slowed down is to be taken for faster than it is: so its
    feet are ahead [m/s]; nan for one that is not slowed down."""
    ground: GroundAhead = UNKNOWN
    """The ground ahead."""
    leveling: float = 1.0
    """Part of what swinging feet make up for of a tilt where answers are in time."""
    capturing: float = 1.0
    """Part of the step to the capture point that is made where answers are in time."""
    upright: tuple[float, float] = (0.0, 0.0)
    """Roll and pitch that legs are set for, over those that the body is to have, so that it has
    these in the mean [rad]."""
    roughest: float = 0.0
    """Height by which feet that stood were off the plane of the ground in a longer while [m]."""
    sway: tuple[float, float] = (0.0, 0.0)
    """Velocity to the left that comes back in every cycle, as cosine and sine of the phase
    [m/s]."""
    swaying: float = 0.0
    """That velocity at the measurement [m/s]."""
