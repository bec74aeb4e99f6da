"""
The motion of a robot that keeps its balance, replaced at every measurement.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.feet import UNKNOWN, Demand, FootPlan, GroundAhead
from quad_gait.balance.followed_motion import FollowedMotion
from quad_gait.balance.foot_laws import (
    GRAVITY,
    STILL,
    Pace,
    pendulum_time,
    sway_velocity,
)
from quad_gait.balance.foot_plan import FootPlanner, March
from quad_gait.balance.joint_motion import JointMotion, JointMotionPlanner
from quad_gait.balance.known_ground import KnownGround
from quad_gait.balance.learned_errors import LearnedErrors
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import Gait
from quad_gait.ground.ground_slope import Slope

Array = NDArray[np.float64]

_LEAST_SPEED = 0.02
"""Velocity, as a fraction of sqrt(g h), below which a body comes to rest at once."""


class BalancedMotion:
    """
    Knots that were given out, and those that replace them.

    What was given out holds until a reaction time after a measurement. From there on knots answer
    to it, and after them the robot comes to rest: it goes on trotting while it loses its speed,
    then no foot lifts any more. So a robot that receives nothing more stands on four feet.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        Its trot, fitted to it.
    options : BalanceOptions
        Gains and times.
    start : float
        When it begins [s].
    joints : ndarray, shape (4, 3)
        Where the joints are commanded then, at rest [rad].
    body : BodyEstimate, optional
        How it stands; level if not given.
    """

    def __init__(
        self,
        robot: Robot,
        gait: Gait,
        options: BalanceOptions,
        start: float,
        joints: Array,
        body: BodyEstimate | None = None,
    ) -> None:
        self._robot, self._options = robot, options
        self._planner = FootPlanner(robot, gait, options)
        self._joint_planner = JointMotionPlanner(robot, options.speed_fraction)
        self._start = start
        still = math.ceil(options.reaction_time / options.knot_time - 1e-6) + 1
        begins = self._time_of(still - 1)
        feet = robot.foot_positions(joints)
        if body is None or body.slope.is_level:
            plan = self._planner.at_rest(feet)
        else:
            begins += options.leaning * options.leaning_time
            plan = self._planner.at_rest(feet, body.slope, body.roll, body.pitch)
        self.clock = PhaseClock.of(gait, begins)
        """When feet swing."""
        self._first = 0
        self._knots = still * [plan]
        self._given = JointMotion(
            np.array([self._time_of(k) for k in range(still)]),
            np.repeat(joints[None], still, axis=0),
            np.zeros((still, 4, 3)),
        )
        self._unit = math.sqrt(GRAVITY * self._planner.height)
        self._followed = FollowedMotion(options)
        self.learned = LearnedErrors(options, self._unit)
        """What it has learned of errors that stay, or come back in every cycle."""
        self._delay = 0.0
        self._decided = -math.inf

    @property
    def unit(self) -> float:
        """Velocity sqrt(g h), by which others are measured [m/s]."""
        return self._unit

    @property
    def lead(self) -> float:
        """
        Time after which the body has a velocity that is asked for [s].

        Feet land, in the mean, half a stance after they are planned; and an error of the velocity
        by which the capture step answers is worth sqrt(h / g) of an acceleration.
        """
        options = self._options
        stance = self.clock.stance_times[0]
        return options.reaction_time + stance / 2.0 + pendulum_time(self._planner.height)

    @property
    def pace(self) -> Pace:
        """Velocity that is planned at the first knot that answers to the last measurement."""
        return self._knots[min(1, len(self._knots) - 1)].pace

    @property
    def given(self) -> JointMotion:
        """Joint motion that was given out last."""
        return self._given

    @property
    def slope(self) -> Slope:
        """The ground by the last measurement."""
        return self._knots[-1].slope

    def footholds(self) -> Array:
        """Return where the feet land next, or have landed, beside the body, (4, 3) [m]."""
        return np.array([(foot.target_x, foot.target_y, 0.0) for foot in self._knots[-1].feet])

    def is_over(self, time: float) -> bool:
        """Return whether nothing can follow any more what was given out by a time [s]."""
        return self._index_at(time) - self._first >= len(self._knots)

    def is_pushed(self, body: BodyEstimate) -> bool:
        """Return whether a body is so far off the planned velocity that it was pushed."""
        pace = self.pace
        x, y = body.velocity[0] - pace.forward, body.velocity[1] - pace.left
        return math.hypot(x, y) > self._options.pushed * self._unit

    def is_leaning(self, time: float) -> bool:
        """Return whether a robot leans uphill at a time [s], before its first step on a slope."""
        return time < self.clock.start and not self.slope.is_level

    def is_due(self, time: float) -> bool:
        """Return whether a decision is due at a time [s]."""
        return time >= self._decided + self._options.knot_time - 1e-6

    def rest(self, time: float) -> None:
        """Let no foot lift any more after what holds at a time [s]."""
        self.clock = self.clock._replace(end=self._time_of(self._index_at(time)))

    def follow(self, time: float, joints: Array) -> JointTrajectory | None:
        """
        Go on from what joints follow.

        That is what was given out last, unless nothing has arrived for a while: then they come to
        rest by an earlier motion. Joints that had to be elsewhere at once, when trajectories arrive
        again, would throw the body.

        Parameters
        ----------
        time : float
            When they were measured [s].
        joints : ndarray, shape (4, 3)
            Their positions [rad].

        Returns
        -------
        JointTrajectory or None
            The earlier one that they follow; None if it is the last.
        """
        earlier = self._followed.earlier(time, joints)
        place = self._index_at(time) - self._first
        if earlier is None or not 1 <= place < len(self._knots):
            return None
        held = slice(place - 1, place + 1)
        given = self._given
        positions, speeds = given.positions.copy(), given.speeds.copy()
        for k in range(held.start, held.stop):
            positions[k], speeds[k] = earlier.at_or_after(float(given.times[k]))
        # Between its points a motion may be a little faster than joints are to be at them.
        speeds[held] = np.clip(speeds[held], -self._robot.velocity, self._robot.velocity)
        self._given = JointMotion(given.times, positions, speeds)
        self._knots[place] = self._planner.rejoined(
            self._knots[place],
            self._robot.foot_positions(positions[held]),
            float(given.times[place] - given.times[place - 1]),
        )
        return self._trajectory(earlier)

    def update(
        self,
        time: float,
        body: BodyEstimate,
        pace: Pace,
        due: Pace | None = None,
        ground: KnownGround | None = None,
        delay: float = 0.0,
    ) -> JointTrajectory | None:
        """
        Answer to a measurement.

        Parameters
        ----------
        time : float
            When it was taken [s].
        body : BodyEstimate
            How the body moves.
        pace : Pace
            Velocity that is wanted once the body has answered.
        due : Pace, optional
            Velocity that it should have by now; what is planned if not given.
        ground : KnownGround, optional
            What is known of the ground ahead.
        delay : float
            Delay of answers, as :class:`~quad_gait.balance.answer_delay.AnswerDelay` tells it.

        Returns
        -------
        JointTrajectory or None
            It replaces the last one; None if that is to go on.
        """
        self._decided = time
        self._delay = delay
        index = self._index_at(time)
        place = index - self._first
        if place >= len(self._knots):
            return None
        if self.is_leaning(time):
            pace = STILL
        else:
            planned = self._knots[place].pace
            self.learned.learn(body, planned, due or planned, pace, self._phase(time))
        times = [self._time_of(index + k) for k in range(self._options.knots + 1)]
        plan = self._planner.met(self._knots[place], self.clock, time, body)
        ahead = UNKNOWN
        if ground is not None:
            landings = self._planner.landings(plan, self.clock, times[0], body)
            ahead = ground.ahead(times[0] - time, body, landings)
        answers = self._answers(plan, times, time, body, pace, ahead)
        knots = answers.plans()
        risen = self._planner.risen(ahead, times[-1] - times[0])
        rest, rest_times = self._coming_to_rest(knots[-1], times[-1], body, ahead.after(risen))
        before = max(place - 1, 0)
        held = slice(before, place + 1)
        given = self._given
        motion = self._joint_planner.go_on(
            JointMotion(given.times[held], given.positions[held], given.speeds[held]),
            np.concatenate([answers.places[1:], rest.places[1:]]),
            np.concatenate([times[1:], rest_times[1:]]),
        )
        if motion is None:
            return None
        if motion.is_slowed:
            reached = motion.positions[place - before :][: len(times)]
            knots = answers.reached(self._robot.foot_positions(reached), times).plans()
        self._knots = self._knots[before:place] + knots
        self._first += before
        self._given = motion
        self._followed.note(motion)
        return self._trajectory(motion)

    def _trajectory(self, motion: JointMotion) -> JointTrajectory:
        stamp = float(motion.times[0])
        return JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=stamp,
            times=motion.times - stamp,
            positions=motion.positions.reshape(-1, 12),
            velocities=motion.speeds.reshape(-1, 12),
        )

    def _answers(
        self,
        plan: FootPlan,
        times: list[float],
        time: float,
        body: BodyEstimate,
        pace: Pace,
        ground: GroundAhead,
    ) -> March:
        """Return the knot that still holds, and those after it that answer to a measurement."""
        roll, pitch = body.tilt_in(times[0] - time)
        slope, options = body.slope, self._options
        demand = Demand(
            pace, Pace(*body.velocity, body.turn), roll - slope.roll, pitch - slope.pitch,
            slope, self.learned.trim, body.roughness, ground=ground,
            leveling=1.0 - self._delay * (1.0 - options.late_leveling),
            capturing=1.0 - self._delay * (1.0 - options.late_capture),
            upright=self.learned.upright, roughest=body.roughest,
            sway=self.learned.sway, swaying=sway_velocity(self._phase(time), self.learned.sway),
        )  # fmt: skip
        return self._planner.march(plan, self.clock, times, demand)

    def _coming_to_rest(
        self, plan: FootPlan, time: float, body: BodyEstimate, ground: GroundAhead
    ) -> tuple[March, list[float]]:
        """Return a plan at a time [s] and the knots after it that bring the robot to rest."""
        options, clock = self._options, self.clock
        slowing = GRAVITY * options.slowing
        speed = math.hypot(*body.velocity)
        end = time
        slope = plan.slope
        is_tilted = any(f.roll != slope.roll or f.pitch != slope.pitch for f in plan.feet)
        if speed > _LEAST_SPEED * self._unit or is_tilted:
            end += max(clock.period, speed / slowing)
        clock = clock._replace(end=min(clock.end, end))
        plan = plan._replace(pace=Pace(*body.velocity, plan.pace.turn))
        # A body that is slowed down has its feet ahead, as if it were faster than it is to be.
        lead = self._planner.height / GRAVITY * slowing / max(self._planner.capture_time, 1e-6)
        demand = Demand(
            STILL, STILL, slope=slope, trim=self.learned.trim, roughness=body.roughness, lead=lead,
            ground=ground, roughest=body.roughest,
        )  # fmt: skip
        count = math.ceil((end + clock.longest_swing - time) / options.rest_knot_time) + 1
        times = [time]
        for _ in range(count):
            times.append(times[-1] + options.rest_knot_time)
        return self._planner.march(plan, clock, times, demand), times

    def _phase(self, time: float) -> float:
        """Return how many cycles have gone by at a time [s]."""
        return (time - self.clock.start) / self.clock.period

    def _index_at(self, time: float) -> int:
        """Return which knot is the first that need not hold after a measurement at a time [s]."""
        since = time + self._options.reaction_time - self._start
        return max(0, math.ceil(since / self._options.knot_time - 1e-6))

    def _time_of(self, index: int) -> float:
        return self._start + index * self._options.knot_time
