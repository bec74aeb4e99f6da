"""
What a behaviour is: it owns its fields, and answers one question.

Given the state of the robot now: which trajectory is to be given out, if any, or is there
nothing for me to do?
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity, Report
from quad_gait.behaviours.guidance import Guidance
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.wishes import Wish
from quad_gait.faults.commanded_joints import CommandedJoints
from quad_gait.following.motion_sequence import MotionSequence
from quad_gait.following.slip_compensation import SlipCompensation
from quad_gait.following.step import Step
from quad_gait.state.robot_state import RobotState
from quad_gait.state.support import BY_FEET, Support


@dataclass(frozen=True)
class Command:
    """The behaviour decides on what happens now."""

    trajectory: JointTrajectory | None = None
    """Replaces the last one; None: that goes on."""


@dataclass(frozen=True)
class Done:
    """The behaviour has nothing to do, now or any more."""

    next: Activity | None = None
    """Activity to hand over to; None: whoever comes after in the table."""
    step: Step | None = None
    """Step that is to be walked, where that is the next activity."""


GO_ON = Command()
"""Nothing new is given out."""

PASS = Done()
"""The question goes to whoever comes after in the table."""


@dataclass(frozen=True)
class Shared:
    """What all behaviours of a robot share."""

    robot: Robot
    """The robot."""
    options: SupervisorOptions
    """Timing and tolerances."""
    compensation: SlipCompensation
    """Factors by which more is commanded than is wanted."""
    report: Report
    """What the robot says of itself."""
    joints: CommandedJoints
    """What the joints are commanded."""
    guidance: Guidance
    """What is wished for, as steps."""
    cycles: MotionSequence
    """Cycles that were given out."""


class Behaviour(ABC):
    """
    One thing that a robot does while it is sound; one of them acts at a time.

    Parameters
    ----------
    shared : Shared
        What it has in common with the others.
    """

    def __init__(self, shared: Shared) -> None:
        self._robot = shared.robot
        self._options = shared.options
        self._report = shared.report
        self._joints = shared.joints
        self._guidance = shared.guidance
        self._cycles = shared.cycles

    def begin(self, state: RobotState, done: Done) -> Command | Done:
        """Take over from the behaviour that is done; decide at once."""
        return self.update(state)

    @abstractmethod
    def update(self, state: RobotState) -> Command | Done:
        """Decide, at each measurement while it acts."""

    def come_to_rest(self, state: RobotState) -> bool:
        """Begin nothing more; return whether what was given out still moves the robot."""
        return state.time < self._joints.busy_until

    def forget(self) -> None:  # noqa: B027
        """Know nothing of what was planned: it does not hold any more."""

    @property
    def _is_settled_at(self) -> float:
        return self._joints.busy_until + self._options.settle_time


class Walk(Behaviour):
    """A behaviour that walks: others ask what its feet do."""

    def prepare(self) -> None:
        """Do beforehand what would keep a robot waiting in the middle of a walk."""
        return

    @abstractmethod
    def in_contact_at(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are planned to be down at a time [s], shape (4,)."""

    def support_at(self, time: float) -> Support:
        """Return what is known at a time [s] of feet and body that their heights do not tell."""
        return BY_FEET

    @abstractmethod
    def footholds(self) -> NDArray[np.float64]:
        """Return the footholds at the end of what is planned, (4, 3) [m]; (0, 3) for none."""

    @abstractmethod
    def take(self, wish: Wish) -> None:
        """Take notice of a wish that changes how it walks."""
