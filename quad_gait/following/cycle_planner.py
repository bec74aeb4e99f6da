"""
Plans cycles of a gait one after the other: from rest, or at the speed of the one before.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle, CycleEnds
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.motion_sequence import ScheduledCycle
from quad_gait.following.slip_compensation import SlipCompensation
from quad_gait.following.speed_change import bearable_motion, gathered
from quad_gait.following.step import Step
from quad_gait.following.stoppable_cycle import (
    CycleRules,
    StoppableCycle,
    generate_stoppable_cycle,
)

Array = NDArray[np.float64]

_MORE_BESIDE = 1.2
"""Factor by which the body may be farther beside its feet while a dynamic gait changes speed."""


class CyclePlanner:
    """
    Makes steps into cycles, with the slip made up for, that can always be brought to rest.

    Parameters
    ----------
    robot : Robot
        The robot.
    compensation : SlipCompensation
        Factors by which more is commanded than is wanted.
    sample_period : float
        Between a cycle's samples [s].
    tracking_gain : float or None
        Gain of S1's backstepping law [1/s]; None for closed-form inverse kinematics.
    """

    def __init__(
        self,
        robot: Robot,
        compensation: SlipCompensation,
        sample_period: float,
        tracking_gain: float | None,
    ) -> None:
        self._robot = robot
        self._compensation = compensation
        self._sample_period = sample_period
        self._tracking_gain = tracking_gain
        self.speed = STILL
        """Velocity at the end of the cycle that was planned last, without compensation for slip."""
        self.gear: MotionLimits | None = None
        """Gait of the cycle that was planned last; None before the first."""
        # What slip takes from that cycle, by the compensation.
        self._slip = BodyMotion()

    def begin(self, gait_pair: GaitPair, step: Step, joints: Array) -> StoppableCycle:
        """
        Plan a step from rest.

        Parameters
        ----------
        gait_pair : GaitPair
            The gaits.
        step : Step
            What to do.
        joints : ndarray, shape (4, 3)
            The joints' angles now [rad].

        Returns
        -------
        StoppableCycle
            As much of the step as legs, joints and margin allow, and the stop after it.

        Raises
        ------
        GaitError
            If none of it is possible.
        """
        return self._generate(gait_pair, step, gait_pair.order_of(step), joints, None)

    def go_on(self, gait_pair: GaitPair, step: Step, before: Cycle) -> StoppableCycle:
        """Plan a step that follows a cycle at its speed; see :meth:`begin`."""
        return self._generate(gait_pair, step, before.gait, before.joint_positions[-1], before)

    def end_with_slip(self, current: ScheduledCycle, time: float) -> Pose2D:
        """Return how the body moves from a time [s] to a cycle's end: slip takes back its part."""
        ahead = current.pose_at(time).inverse() @ current.end_pose
        left = (current.end - time) / current.cycle.period
        slip = self._slip
        return ahead @ BodyMotion(-left * slip.forward, -left * slip.left, -left * slip.turn).end

    def _generate(
        self, gait_pair: GaitPair, step: Step, gait: Gait, joints: Array, before: Cycle | None
    ) -> StoppableCycle:
        gear = gait_pair.of(step)
        self.gear = gear
        entry = STILL if before is None else self.speed
        motion, exit = step.motion, gathered(step.exit, entry, gear)
        if exit is not step.exit:
            # Less speed at the end: less distance.
            lost = BodyMotion.during(
                step.exit.minus(exit), gear.acceleration_fraction * gear.period
            )
            motion = motion.minus(lost)
        motion = bearable_motion(motion, (entry, exit), self._robot, gear.gait)
        compensated = self._compensation.compensated
        speed = compensated(gear.gait, BodyMotion.during(exit, gear.period)).rate(gear.period)
        planned = generate_stoppable_cycle(
            self._robot,
            gait,
            compensated(gear.gait, motion),
            CycleEnds(exit=speed)
            if before is None
            else CycleEnds(before.end_feet, before.exit, speed),
            CycleRules(self._sample_period, _slack(gear.least_margin), self._tracking_gain),
            joints,
        )
        kept = _ratio(planned.cycle.exit, speed)
        self.speed = exit.scaled(kept)
        self._slip = BodyMotion.during(speed.minus(exit), kept * gear.period)
        return planned


def _ratio(a: Twist2D, b: Twist2D) -> float:
    """Say how much of a velocity another one with the same direction is."""
    part, whole = (abs(v.forward) + abs(v.left) + abs(v.turn) for v in (a, b))
    return part / whole if whole else 0.0


def _slack(least_margin: float) -> float:
    """Allow dynamic gaits a little more while they change their speed."""
    return least_margin if least_margin >= 0.0 else _MORE_BESIDE * least_margin
