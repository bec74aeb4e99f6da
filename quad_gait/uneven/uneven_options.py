"""
Options of walking over ground that is not flat, and gaits that suit it.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors import ParameterError
from quad_common.footing.foothold_criterion import FootholdCriterion
from quad_gait.cycle.gait import Gait


@dataclass(frozen=True)
class UnevenOptions:
    """How a robot walks where the ground is not flat; lengths are TITAN-VIII's."""

    sample_period: float = 0.02
    """Time between a trajectory's points [s]."""
    reaction_time: float = 0.06
    """Time between a contact and the trajectory that answers to it [s]: it must have come to the
    joints by then, and the foot presses on meanwhile."""
    margin: float = 0.035
    """Distance of the center of mass inside its three feet, if they give so much [m]."""
    least_margin: float = 0.02
    """The same where legs do not reach otherwise: onto a chosen foothold, or for a foot that would
    be left behind [m]."""
    contact_fraction: float = 0.05
    """Fraction of the weight above which a foot stands."""
    clearance: float = 0.03
    """Height of a foot over what a height map shows in its path [m]."""
    search_speed: float = 0.12
    """Speed at which a foot is lowered where the ground may be [m/s]."""
    search_above: float = 0.01
    """Height above the ground of a height map at which the search begins [m]."""
    shift_time: float = 0.4
    """Time in which the body goes over three feet, at least [s]."""
    shift_speed: float = 0.2
    """Speed of the body in longer moves, on average [m/s]."""
    lift_time: float = 0.2
    """Time in which a foot is lifted, at least [s]."""
    transfer_time: float = 0.35
    """Time in which a foot goes forward, at least [s]."""
    lower_time: float = 0.2
    """Time in which a foot is lowered, at least [s]."""
    foot_speed: float = 0.65
    """Speed of a foot over longer distances, on average [m/s]."""
    foothold_reach: float = FootholdCriterion.reach
    """Distance from its place at which a foot may be put for a better hold, at most [m]."""
    foothold_radius: float = 0.045
    """Radius around a foot in which the ground should be even [m]."""
    shin_clearance: float = FootholdCriterion.shin_clearance
    """Distance of foot and shin from what is higher than they are [m]."""
    largest_step: float = FootholdCriterion.largest_step
    """Difference of the heights around a foot on even ground, at most [m]."""
    plans_footsteps: bool = False
    """Whether footholds are planned ahead where strides would not find even ground."""


def check_suits_uneven_ground(gait: Gait) -> None:
    """Raise ParameterError for a gait in which a robot could not stop at any time."""
    if not gait.is_static:
        raise ParameterError(
            'gait',
            gait.name,
            'one with three feet on the ground at any time where that is uneven, as crawl and '
            'wave have',
        )
