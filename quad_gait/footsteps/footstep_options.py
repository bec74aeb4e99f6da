"""
Options of planning footsteps.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.footing.foothold_criterion import FootholdCriterion
from quad_gait.uneven.uneven_options import UnevenOptions


@dataclass(frozen=True)
class FootstepOptions:
    """How footsteps are planned; lengths are TITAN-VIII's."""

    cell: float = 0.03
    """Distance between the places that are looked at [m]."""
    radius: float = FootholdCriterion.radius
    """Radius around a foot in which the ground is even [m]."""
    blocks: tuple[int, ...] = (3, 2)
    """Sides of the squares of which each gives one foothold, that with the most room; the next
    where no footsteps are found over those before [cells]."""
    longest_step: float = 0.36
    """Distance that a foot goes in one step, at most [m]."""
    margin: float = 0.035
    """Distance of the center of mass inside the three feet that stand, at least [m]."""
    least_margin: float = UnevenOptions.least_margin
    """The same where no footsteps are found with that [m]."""
    separation: float = 0.5
    """Distance between feet, as a fraction of the least one in the initial posture."""
    breadth: float = 0.3
    """Distance to the side between left and right foot of a pair, as a fraction of that in the
    initial posture: feet do not cross."""
    horizon: float = 1.2
    """Distance along the plan to which footsteps are planned ahead [m]."""
    aside: float = 0.3
    """Distance by which footholds may be beside and beyond where the feet would be [m]."""
    distance_tolerance: float = 0.03
    """Distance from the wanted pose at the end of footsteps that will do [m]."""
    far_tolerance: float = 0.1
    """The same where that pose is the horizon [m]."""
    angle_tolerance: float = 0.1
    """Angle from the wanted pose that will do [rad]."""
    weight: float = 3.0
    """Factor of the cost ahead, which makes the search quick, and its first path longer."""
    strain: float = 4.0
    """Factor of how far feet are off their initial posture, by which such stances come later."""
    expansions: int = 400
    """Number of stances from which steps are looked for after the first path was found."""
    most_expansions: int = 4000
    """Number of stances from which steps are looked for before there is none."""
    coarse_expansions: int = 1000
    """The same over the larger squares: where there are footsteps over them, few are looked at."""
    strained: float = 0.12
    """Distance of a foot from its initial posture beyond which strides without footsteps do not
    begin [m]."""
    off_plan: float = 0.03
    """Distance of a foot from where it was to be beyond which footsteps are planned again [m]."""
