"""
How a lame robot comes to a standstill, in numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class SafeStopOptions:
    """How a lame robot comes to a standstill; lengths are TITAN-VIII's."""

    sample_period: float = 0.02
    """Time between a trajectory's points [s]."""
    reaction: float = 0.02
    """Time after the measurement at which a trajectory begins [s]."""
    catch_time: float = 0.25
    """Time in which swinging feet are put down, and the body is lowered [s]."""
    press: float = 0.01
    """Depth below where the ground may be to which feet are put down [m]."""
    settle_time: float = 1.2
    """Time for the body to go over the sound feet [s]."""
    pause: float = 0.3
    """Time between two of these motions, for the body to come to rest [s]."""
    margin: float = 0.035
    """Distance inside the sound feet to which the center of mass is brought, if it can be [m]."""
    clearance: float = 0.02
    """Height of the lifted leg over the ground [m]."""
    least_margin: float = 0.01
    """Margin with less of which the robot sits down [m]."""
    giving_way: float = 0.1
    """Further tilt with which a body has lost the leg that was to bear [rad]."""
    attempts: int = 3
    """Number of motions to bring the center of mass there."""
    shifts_at_once: bool = False
    """Whether the center of mass goes over the sound feet while those that swing are put down."""
    lands_on_it: bool = False
    """Whether a lame leg that swings is put down too, if it may bear: then it is a foot more."""
    sufficient: float = 0.8
    """Fraction of ``margin`` with which the body is not moved any more."""
    least_lever: float = 0.0
    """Least lever of the weight at a free joint, of the hips' height, with which its leg is lost at
    once; with less the body goes over the sound feet before it is lowered."""
    slowly_giving_way: float = 0.1
    """The further tilt for a leg that has less: going over the sound feet tilts the body, too."""
    largest_tilt: float = 0.05
    """Tilt below which it is not moved either [rad]."""

    @classmethod
    def hasty(cls, relative_size: float = 1.0) -> SafeStopOptions:
        """
        Return the options for a gait that is not static: it leaves no time to settle.

        A small robot tips faster, in proportion to the square root of its size: so its motions are
        as much faster than TITAN-VIII's, with relative size 1.
        """
        tempo = math.sqrt(relative_size)
        return cls(
            catch_time=0.27 * tempo,
            settle_time=0.45 * tempo,
            pause=0.08 * tempo,
            attempts=2,
            shifts_at_once=True,
            lands_on_it=True,
            sufficient=0.45,
            largest_tilt=0.1,
            least_lever=0.5,
            slowly_giving_way=0.15,
        )
