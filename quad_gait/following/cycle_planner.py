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
from quad_gait.cycle.foot_tracking import track_feet
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.gait_generator import (
    CycleOptions,
    FootTracking,
    generate_cycle,
    generate_largest_cycle,
)
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.motion_sequence import ScheduledCycle
from quad_gait.following.slip_compensation import SlipCompensation
from quad_gait.following.step import Step

Array = NDArray[np.float64]

_SPEED_STEP = 0.4
"""Share of its largest speed that a dynamic gait gathers in one cycle."""

_MORE_BESIDE = 1.2
"""How much farther beside its feet the body may be in a dynamic gait's changes of speed."""


class CyclePlanner:
    """
    Makes steps into cycles, with the slip made up for, that can always be brought to rest.

    Parameters
    ----------
    robot : Robot
        The robot.
    compensation : SlipCompensation
        How much more must be asked for than is wanted.
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
        """At the end of the cycle that was planned last, without compensation for slip."""
        self.gear: MotionLimits | None = None
        """Of the cycle that was planned last; None before the first."""
        # What slip takes from that cycle, by the compensation.
        self._slip = BodyMotion()

    def begin(self, gait_pair: GaitPair, step: Step, joints: Array) -> Cycle:
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
        Cycle
            As much of the step as legs, joints and margin allow.

        Raises
        ------
        GaitError
            If none of it is possible.
        """
        return self._generate(gait_pair, step, gait_pair.order_of(step), joints, None)

    def go_on(self, gait_pair: GaitPair, step: Step, before: Cycle) -> Cycle:
        """Plan a step that follows a cycle at its speed; see :meth:`begin`."""
        return self._generate(gait_pair, step, before.gait, before.joint_positions[-1], before)

    def with_stop(self, scheduled: ScheduledCycle) -> list[ScheduledCycle]:
        """Add the cycle that brings the body to rest, if it is not at rest anyway."""
        stop = self._stop_after(scheduled.cycle)
        if stop is None:
            return [scheduled]
        return [scheduled, ScheduledCycle(stop, scheduled.end, scheduled.end_pose)]

    def end_with_slip(self, current: ScheduledCycle, time: float) -> Pose2D:
        """Return how the body moves from a time [s] to a cycle's end: slip takes back its part."""
        ahead = current.pose_at(time).inverse() @ current.end_pose
        share = (current.end - time) / current.cycle.period
        slip = self._slip
        return ahead @ BodyMotion(-share * slip.forward, -share * slip.left, -share * slip.turn).end

    def _generate(
        self, gait_pair: GaitPair, step: Step, gait: Gait, joints: Array, before: Cycle | None
    ) -> Cycle:
        gear = gait_pair.of(step)
        self.gear = gear
        entry = STILL if before is None else self.speed
        motion, exit = step.motion, _gathered(step.exit, entry, gear)
        if exit is not step.exit:
            # Less speed at the end: less way.
            lost = BodyMotion.during(
                step.exit.minus(exit), gear.acceleration_fraction * gear.period
            )
            motion = motion.minus(lost)
        compensated = self._compensation.compensated
        speed = compensated(gear.gait, BodyMotion.during(exit, gear.period)).rate(gear.period)
        cycle = generate_largest_cycle(
            self._robot,
            gait,
            compensated(gear.gait, motion),
            CycleEnds(exit=speed)
            if before is None
            else CycleEnds(before.end_feet, before.exit, speed),
            self._cycle_options(gear, joints),
            accept=self._check_stop_after,
        )
        share = _ratio(cycle.exit, speed)
        self.speed = exit.scaled(share)
        self._slip = BodyMotion.during(speed.minus(exit), share * gear.period)
        return cycle

    def _stop_after(self, cycle: Cycle) -> Cycle | None:
        """Plan the cycle that brings the body to rest; None if it is at rest anyway."""
        if not cycle.exit:
            return None
        assert self.gear is not None
        return generate_cycle(
            self._robot,
            cycle.gait,
            BodyMotion.during(cycle.exit, (1.0 - cycle.gait.acceleration_fraction) * cycle.period),
            CycleEnds(cycle.end_feet, entry=cycle.exit),
            self._cycle_options(self.gear, cycle.joint_positions[-1]),
        )

    def _check_stop_after(self, cycle: Cycle) -> None:
        """Raise a GaitError if the body could not be brought to rest after a cycle."""
        self._stop_after(cycle)

    def _cycle_options(self, gear: MotionLimits, start_joints: Array) -> CycleOptions:
        """Say how a cycle is computed that begins at the joints' angles."""
        least_margin = _slack(gear.least_margin)
        return CycleOptions(self._sample_period, least_margin, self._tracking(start_joints))

    def _tracking(self, start_joints: Array) -> FootTracking | None:
        """Return S1's law, beginning at the joints' angles, if it is to be used."""
        gain = self._tracking_gain
        if gain is None:
            return None
        return lambda robot, times, feet, velocities: track_feet(
            robot, times, feet, velocities, start_joints, gain
        )


def _gathered(wanted: Twist2D, entry: Twist2D, gear: MotionLimits) -> Twist2D:
    """Let a dynamic gait gather speed over a few cycles: it would rock otherwise."""
    if gear.gait.is_static or not wanted:
        return wanted
    way = BodyMotion.during(wanted, gear.period)
    largest = gear.largest_share(way) * gear.size(way)
    gain = wanted.minus(entry)
    size = gear.size(BodyMotion.during(gain, gear.period))
    if size <= _SPEED_STEP * largest:
        return wanted
    return entry.plus(gain.scaled(_SPEED_STEP * largest / size))


def _ratio(a: Twist2D, b: Twist2D) -> float:
    """Say how much of a velocity another one with the same direction is."""
    part, whole = (abs(v.forward) + abs(v.left) + abs(v.turn) for v in (a, b))
    return part / whole if whole else 0.0


def _slack(least_margin: float) -> float:
    """Allow dynamic gaits a little more while they change their speed."""
    return least_margin if least_margin >= 0.0 else _MORE_BESIDE * least_margin
