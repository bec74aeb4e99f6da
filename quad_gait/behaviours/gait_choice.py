"""
Which gaits a robot walks by, and whether it keeps its balance in them.
"""

from __future__ import annotations

import math
from dataclasses import replace

from quad_common.robot.robot import Robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.foot_laws import GRAVITY
from quad_gait.balance.steady_trot import SteadyTrot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.wishes import ChangeGaits
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.motion_limits import Bound, MotionLimits
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.path_follower import PathFollower
from quad_gait.following.step import Gear, LongGear, Step
from quad_gait.state.robot_state import RobotState

_SETTLING_DISTANCE, _SETTLING_ANGLE = 0.06, math.radians(5.0)
"""Distance from the goal, and angle, at which a robot may stay on uneven ground where corrections
bring it no nearer [m, of TITAN-VIII; rad]."""


class GaitChoice:
    """
    The gaits for walking and turning, planned a cycle ahead or keeping the balance.

    Parameters
    ----------
    robot : Robot
        The robot.
    gaits : ChangeGaits
        The gaits, and how plans are followed.
    options : SupervisorOptions
        Margins, and whether the balance is to be kept.
    """

    def __init__(self, robot: Robot, gaits: ChangeGaits, options: SupervisorOptions) -> None:
        self._robot = robot
        # Over uneven ground every swing is balanced by itself: there only legs and joints limit.
        self._least_margin = options.least_margin if options.uneven is None else -math.inf
        self._is_uneven = options.uneven is not None
        self._balance = options.balance if options.uneven is None else None
        self.unbalanced = ''
        """Reason why the robot walks without keeping its balance; empty if it need not."""
        self.take(gaits)

    def take(self, gaits: ChangeGaits) -> None:
        """Take other gaits; they are planned ahead until the robot is looked at."""
        self._keeps_balance = False
        self._planned = self._balanced = GaitPair(
            self._robot, gaits.gait, gaits.turning_gait, self._least_margin
        )
        if self._balance is not None and not gaits.gait.is_static:
            walking = balanced_gait(gaits.gait, self._balance)
            turning = balanced_gait(gaits.turning_gait, self._balance)
            self._balanced = GaitPair(
                self._robot, walking, turning, self._least_margin, self._bound_of
            )
        self._follower_options = gaits.follower
        if self._is_uneven:
            self._follower_options = _settling(gaits.follower, self._robot)

    def _bound_of(self, gait: Gait) -> Bound | None:
        """Return what a robot that keeps its balance in a gait needs beside what legs can do."""
        if self._balance is None or gait.is_static:
            return None
        return SteadyTrot(self._robot, gait, self._balance).possible

    @property
    def pair(self) -> GaitPair:
        """The gaits for walking and for turning."""
        return self._balanced if self._keeps_balance else self._planned

    @property
    def follower_options(self) -> FollowerOptions:
        """Options for following plans."""
        return self._follower_options

    @property
    def gears(self) -> tuple[Gear, Gear]:
        """What a follower of plans needs to know of both."""
        pair, balance = self.pair, self._balance
        if not self._keeps_balance or balance is None:
            return pair.walking, pair.turning
        walking = long_gear(pair.walking, balance, BodyMotion(forward=1.0))
        return walking, long_gear(pair.turning, balance, BodyMotion(turn=1.0))

    def follower(self) -> PathFollower:
        """Return what follows plans by these gaits."""
        return PathFollower(*self.gears, self._follower_options)

    def prepare(self) -> None:
        """Find the commonest limits of all gaits beforehand: it takes a while."""
        for pair in {id(pair): pair for pair in (self._planned, self._balanced)}.values():
            pair.prepare()

    def look_at(self, state: RobotState) -> bool:
        """Keep the balance if that is wanted and possible; return whether it is another manner."""
        self.unbalanced = ''
        is_wanted = self._balance is not None and not self._planned.walking.gait.is_static
        if is_wanted and state.balance_problem:
            self.unbalanced = (
                f'the robot walks without keeping its balance: {state.balance_problem}'
            )
        before, self._keeps_balance = self._keeps_balance, is_wanted and not self.unbalanced
        return self._keeps_balance != before

    def manner_of(self, step: Step) -> Activity:
        """Return whether a step is walked a cycle ahead, or keeping the balance."""
        is_static = self.pair.of(step).gait.is_static
        return Activity.BALANCING if self._keeps_balance and not is_static else Activity.WALKING

    def period_of(self, step: Step | None, is_steered: bool) -> float:
        """Return for how long a step that keeps the balance is taken, or coming to rest [s]."""
        if is_steered:
            return self.pair.walking.period
        return self.gears[step is not None and step.is_turn].period


def _settling(follower: FollowerOptions, robot: Robot) -> FollowerOptions:
    """Let a robot stay near the goal where there is no footing to get nearer."""
    distance = robot.relative_size * _SETTLING_DISTANCE
    return replace(follower, settling_distance=distance, settling_angle=_SETTLING_ANGLE)


def balanced_gait(gait: Gait, options: BalanceOptions) -> Gait:
    """Return a gait as fast as a robot that keeps its balance in it steps at least."""
    if gait.is_static:
        return gait
    swing = gait.longest_swing * gait.pendulum_rate
    return gait.with_period(gait.cycle_period * min(1.0, options.longest_swing / swing))


def long_gear(limits: MotionLimits, options: BalanceOptions, motion: BodyMotion) -> Gear:
    """Return as many cycles as it takes to gather the full speed of a motion along plans."""
    if limits.gait.is_static:
        return limits
    speed = motion.scaled(limits.largest_scale(motion)).rate(limits.period)
    time = max(
        math.hypot(speed.forward, speed.left) / (GRAVITY * options.gathering),
        abs(speed.turn) / options.turn_acceleration,
    )
    return LongGear(limits, max(1, math.ceil(time / limits.period - 0.1)))
