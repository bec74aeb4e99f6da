"""
Options of the path follower.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

TURNINGS = ('in_place', 'crab', 'arc')
"""Manners in which a plan is followed."""


@dataclass(frozen=True)
class FollowerOptions:
    """How a plan is followed, and when the robot has arrived."""

    turning: str = 'in_place'
    """Turning at corners, one of :data:`TURNINGS`."""
    position_tolerance: float = 0.02
    """Distance within which the robot is at a turning point or the goal [m]."""
    heading_tolerance: float = math.radians(2.0)
    """Angle within which the robot has the goal's heading [rad]."""
    turn_threshold: float = math.radians(12.0)
    """Heading error above which the robot turns on the spot [rad]."""
    largest_correction: float = 0.05
    """Correction sideways in a straight cycle, and in any direction while turning, at most [m]."""
    path_tolerance: float = 0.5
    """Distance from the plan within which the robot follows it [m]."""
    corner_deviation: float = 0.1
    """Distance by which a rounded corner may pass inside the turning point [m]."""
    corner_radius: float = 1.0
    """Largest radius of a rounded corner [m]."""
    largest_speed: float = math.inf
    """Speed along the path that is not exceeded, though the gait could [m/s]."""
    final_cycles: int = 12
    """Number of cycles at the goal, at most, that bring the robot no nearer to it."""
    settling_distance: float = 0.0
    """Distance from the goal within which a robot stays that corrections bring no nearer; 0: it
    must be within ``position_tolerance`` [m]."""
    settling_angle: float = 0.0
    """The same of its heading [rad]."""
