"""
Timing and tolerances by which the gait decides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.uneven.uneven_options import UnevenOptions


@dataclass(frozen=True)
class SupervisorOptions:
    """Timing and tolerances of the supervisor and its behaviours."""

    settle_time: float = 0.2
    """Time after a cycle's end before the robot's pose is measured for the next [s]."""
    lead_time: float = 0.3
    """Least time between giving a trajectory out and its first movement [s]."""
    sample_period: float = 0.02
    """Time between a trajectory's points [s]."""
    least_margin: float = 0.01
    """Predicted stability margin below which cycles are shortened [m]."""
    largest_tilt: float = math.radians(30.0)
    """Tilt of a body beyond which it has fallen [rad]."""
    posture_tolerance: float = 0.15
    """Angle within which joints are in a posture [rad]."""
    stand_up_time: float = 3.0
    """Time to regain the initial posture, and to sit down [s]."""
    twist_timeout: float = 1.0
    """Age at which steering is over [s]."""
    tracking_gain: float | None = None
    """Gain of S1's backstepping law [1/s]; None for closed-form inverse kinematics."""
    hold_course: bool = True
    """Whether steering also takes back what the robot drifts meanwhile."""
    follower: FollowerOptions = field(default_factory=FollowerOptions)
    """Options for following plans."""
    uneven: UnevenOptions | None = None
    """Options for walking where the ground is not flat; None: it is flat."""
    balance: BalanceOptions | None = None
    """Options for keeping the balance in gaits with two feet down; None: they are planned a cycle
    ahead."""
    watches_joints: bool = True
    """Whether a joint that does not answer brings the robot to a standstill."""

    @property
    def steps_in_place(self) -> bool:
        """Whether a robot that keeps its balance steps in place when nothing else is wanted."""
        return self.balance is not None and self.balance.steps_in_place
