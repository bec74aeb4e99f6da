"""
What a steady trot needs of the joints' speeds, and the largest one that leaves enough of them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.feet import Demand
from quad_gait.balance.foot_laws import Pace, pendulum_time
from quad_gait.balance.foot_plan import FootPlanner
from quad_gait.balance.joint_motion import JointMotionPlanner
from quad_gait.balance.phase_clock import PhaseClock, pendulum_factor
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait

_TRIALS = 6
"""Number of bisections: to 2 %, as the reserve of limits has it."""


class SteadyTrot:
    """
    A trot that keeps its balance, while nothing disturbs it.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        Its gait, with the period in which it keeps its balance.
    options : BalanceOptions
        Gains and times.
    """

    def __init__(self, robot: Robot, gait: Gait, options: BalanceOptions) -> None:
        self._robot = robot
        # As if it had that speed already.
        at_once = replace(options, acceleration=math.inf, turn_acceleration=math.inf)
        self._planner = FootPlanner(robot, gait, at_once)
        self._clock = PhaseClock.of(gait)
        self._rate = 1.0 / pendulum_time(self._planner.height)
        self._knot_time = options.knot_time
        self._most = options.steady_speed
        # This compiles the march of feet, or reads its code: no decision is to wait for that.
        self.speed_use(BodyMotion())
        JointMotionPlanner(robot, options.speed_fraction).warm_up()

    def speed_use(self, motion: BodyMotion) -> float:
        """
        Return how much of their largest speeds the joints need, from knot to knot.

        Parameters
        ----------
        motion : BodyMotion
            Of one cycle.

        Returns
        -------
        float
            Of the joint that needs most, as a fraction of its largest speed; inf if a leg does
            not reach that far.
        """
        clock = self._clock
        wanted = Pace(*(part / clock.period for part in (motion.forward, motion.left, motion.turn)))
        # In the first cycle feet come from where they stood; the second one is steady.
        plan = self._planner.at_rest(self._robot.neutral_feet)._replace(pace=wanted)
        cycle = math.ceil(clock.period / self._knot_time)
        feet = []
        for times in pairwise(k * self._knot_time for k in range(2 * cycle + 2)):
            # The body goes as planned: no leg gives way, and no step is made to catch it.
            factor = pendulum_factor(clock, sum(times) / 2.0, self._rate)
            measured = Pace(*(factor * part for part in wanted))
            plan = self._planner.advance(plan, clock, times, Demand(wanted, measured))
            if times[0] >= clock.period:
                feet.append([foot.in_body for foot in plan.feet])
        try:
            joints = self._robot.stacked_legs.inverse(np.array(feet))
        except GaitError:
            return math.inf
        speeds = np.abs(np.diff(joints, axis=0)) / self._knot_time
        return float((speeds / self._robot.velocity).max())

    def possible(self, motion: BodyMotion) -> tuple[float, str]:
        """
        Return which fraction of a motion leaves enough of the joints' speeds for corrections.

        Parameters
        ----------
        motion : BodyMotion
            Of one cycle.

        Returns
        -------
        tuple of float and str
            The fraction, at most 1, and why it is not more; empty if it is all of it.
        """
        use = self.speed_use(motion)
        if use <= self._most:
            return 1.0, ''
        low, high = 0.0, 1.0
        for _ in range(_TRIALS):
            middle = (low + high) / 2.0
            if self.speed_use(motion.scaled(middle)) <= self._most:
                low = middle
            else:
                high = middle
        reason = (
            f'a robot that keeps its balance may use at most {100.0 * self._most:.0f} % of the '
            'largest joint speeds while nothing disturbs it; the rest is reserved for corrections'
        )
        return low, reason
