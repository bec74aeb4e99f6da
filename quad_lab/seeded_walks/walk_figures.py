"""
What is measured of one walk: a flat record, the same for every task.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, fields

Value = bool | float | str


@dataclass(frozen=True)
class WalkFigures:
    """Figures of one walk; nan where one means nothing for the task, or could not be measured."""

    arrived: bool = False
    """Whether the goal was reached; of a steered walk, whether it went on to its end."""
    has_fallen: bool = False
    """Whether the robot fell."""
    contacts: str = ''
    """Contacts of anything but feet with the ground, between semicolons."""
    problem: str = ''
    """Reason why it did not arrive, or could not be walked; empty if it did."""
    duration: float = math.nan
    """Time that it took, simulated [s]."""
    length: float = math.nan
    """Length of the first plan, or distance that was to be walked [m; rad for a turn]."""
    position_error: float = math.nan
    """True distance to the goal at the end [m]."""
    heading_error: float = math.nan
    """True angle to the goal's heading at the end, without its sign [rad]."""
    off_plan: float = math.nan
    """Largest distance from the first plan's line [m]."""
    plans: float = math.nan
    """Number of plans, those that were made again included."""
    tilt_rms: float = math.nan
    """Root mean square of the body's tilt [rad]."""
    largest_tilt: float = math.nan
    """Largest tilt of the body [rad]."""
    least_margin: float = math.nan
    """Least measured static stability margin [m]."""
    torque_rms: float = math.nan
    """Root mean square of the joints' torques [N m]."""
    transport_cost: float = math.nan
    """Mechanical energy over weight and distance; nan for a turn."""
    speed: float = math.nan
    """Speed along the direction or the first plan [m/s; rad/s for a turn]."""
    speed_error: float = math.nan
    """Fraction by which a steered walk's speed differs from what was asked, without its sign."""
    drift: float = math.nan
    """Drift sideways of a steered walk over its distance."""
    slip: float = math.nan
    """Distance that standing feet moved in a cycle, all four together [m]; rolling counts."""
    start_x: float = math.nan
    """Start in the map [m]."""
    start_y: float = math.nan
    """Start in the map [m]."""
    start_yaw: float = math.nan
    """Heading at the start [rad]."""
    goal_x: float = math.nan
    """Goal in the map [m]."""
    goal_y: float = math.nan
    """Goal in the map [m]."""
    goal_yaw: float = math.nan
    """Heading at the goal [rad]."""
    succeeded: bool = field(init=False)
    """Whether it arrived without a fall or a contact."""

    def __post_init__(self) -> None:
        """Sum it up."""
        succeeded = self.arrived and not (self.has_fallen or self.contacts or self.problem)
        object.__setattr__(self, 'succeeded', succeeded)

    def as_dict(self) -> dict[str, Value]:
        """Return the figures by name."""
        return asdict(self)


NUMBERS = tuple(item.name for item in fields(WalkFigures) if item.type == 'float')
"""Names of the figures that are numbers."""
