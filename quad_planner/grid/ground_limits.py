"""
What ground a robot can walk on: how high its steps may be, and how steep it may rise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.errors import ParameterError
from quad_common.robot.robot import Robot

LARGEST_SLOPE = 0.26
"""Largest slope of the ground, by default: 15 degrees [rad]."""


STEEPEST = 1.2
"""The largest limit that may be set [rad]."""


_STRIDES = 3.0
"""A step is climbed with a stride that is so many times shorter than the largest."""


_STANCES = 1.5
"""A step's height over this many stances is fitted by a plane as steep as height per stance."""


_GAP = 0.5
"""Width of the widest gap that is bridged, in lengths of a leg."""


@dataclass(frozen=True)
class GroundLimits:
    """
    What ground a robot can walk on.

    Raises
    ------
    ParameterError
        If a limit is not what its description says.
    """

    step_height: float
    """Highest step that it climbs, > 0 [m]."""
    step_length: float
    """A rise within this length is a step, > 0 [m]."""
    largest_slope: float
    """
    Largest slope of the ground, averaged over `slope_length`; from 0 to :data:`STEEPEST`, not 0
    [rad].
    """
    slope_length: float
    """Side of the square over which slopes are averaged, > 0 [m]."""
    largest_gap: float = 0.0
    """Width of gaps that are bridged from foothold to foothold; 0: none are [m]."""

    def __post_init__(self) -> None:
        """Check the limits."""
        for name in ('step_height', 'step_length', 'slope_length'):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, 'a finite length above 0 m')
        if not 0.0 < self.largest_slope <= STEEPEST:
            raise ParameterError('largest_slope', self.largest_slope, f'above 0, to {STEEPEST} rad')

    @classmethod
    def of(
        cls,
        robot: Robot,
        step_height: float = 0.0,
        largest_slope: float = LARGEST_SLOPE,
        plans_footsteps: bool = False,
    ) -> GroundLimits:
        """
        Derive the limits of a robot.

        Parameters
        ----------
        robot : Robot
            The robot.
        step_height : float
            0 for the robot's own [m].
        largest_slope : float
            [rad]
        plans_footsteps : bool
            Whether the gait finds footholds on both sides of gaps: they are bridged then up to
            half the length of a leg.

        Returns
        -------
        GroundLimits
            A step is what rises within a third of the largest stride. Slopes are averaged over
            one and a half times the stance, the lesser of its length and its width: the plane
            that fits a step there is as steep as the line from foot to foot across it.
        """
        stance = float(np.ptp(robot.neutral_feet[:, :2], axis=0).min())
        leg = robot.legs[0]
        gap = _GAP * float(leg.thigh_length + leg.calf_length) if plans_footsteps else 0.0
        return cls(
            step_height or robot.step_height,
            robot.largest_stride / _STRIDES,
            largest_slope,
            _STANCES * stance,
            gap,
        )
