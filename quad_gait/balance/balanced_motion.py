"""
The motion of a robot that keeps its balance: knots that were given out, and those that replace them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, TrajectoryError
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.foot_laws import GRAVITY, Pace
from quad_gait.balance.foot_plan import Demand, FootPlan, FootPlanner
from quad_gait.balance.phase_clock import PhaseClock
from quad_gait.cycle.gait import Gait

Array = NDArray[np.float64]

_SHRINKING = (1.0, 0.8, 0.6, 0.4, 0.2, 0.0)


class BalancedMotion:
    def __init__(self, robot: Robot, gait: Gait, options: BalanceOptions, start: float):
        self._robot, self._options = robot, options
        self.clock = PhaseClock.of(gait, start + options.reaction_time)
        self.planner = FootPlanner(robot, gait, options)
        self.start = start
        n = math.ceil(options.reaction_time / options.knot_time - 1e-6) + 1
        self._first = 0
        self._knots: list[FootPlan] = n * [self.planner.at_rest()]
        self._joints = np.array(n * [robot.stacked_legs.inverse(robot.neutral_feet)])
        self._speeds = np.zeros_like(self._joints)
        self.trim = (0.0, 0.0)
        self._neutral = robot.neutral_feet
        self._limits = JointLimits.of(robot)
        self.slowed = 0

    def time_of(self, index: int) -> float:
        return self.start + index * self._options.knot_time

    def update(self, time: float, body: BodyEstimate, pace: Pace) -> JointTrajectory | None:
        o = self._options
        dt = o.knot_time
        kept = max(0, math.ceil((time + o.reaction_time - self.start) / dt - 1e-6))
        place = kept - self._first
        if place >= len(self._knots):
            return None
        plan = self._knots[place]
        self._trim(body, plan)
        measured = Pace(*body.velocity, body.turn)
        demand = Demand(pace, measured, *body.tilt_in(self.time_of(kept) - time), self.trim)
        knots = [plan]
        for k in range(kept, kept + o.knots):
            plan = self.planner.advance(plan, self.clock, self.time_of(k), demand)
            knots.append(plan)
        rest = Pace(0.0, 0.0, 0.0)
        tx, ty = self.trim
        for k in range(kept + o.knots, kept + o.knots + o.knots_tail):
            p = plan.pace
            demand = Demand(rest, Pace(p.forward - tx, p.left - ty, p.turn), 0.0, 0.0, self.trim)
            plan = self.planner.advance(plan, self.clock, self.time_of(k), demand)
            knots.append(plan)
        before = max(place - 1, 0)
        found = self._joint_motion(knots[1:], before, place)
        if found is None:
            return None
        joints, speeds = found
        self._knots = self._knots[before:place] + knots
        self._joints = joints
        self._speeds = speeds
        self._first += before
        return JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=self.time_of(self._first),
            times=dt * np.arange(len(self._knots)),
            positions=self._joints.reshape(-1, 12),
            velocities=self._speeds.reshape(-1, 12),
        )

    def _trim(self, body, plan):
        o = self._options
        unit = math.sqrt(GRAVITY * self.planner.height)
        ex, ey = body.velocity[0] - plan.pace.forward, body.velocity[1] - plan.pace.left
        if max(abs(ex), abs(ey)) < 0.3 * unit:
            g, m = o.trim_gain * o.knot_time, o.largest_trim * unit
            self.trim = (
                min(max(self.trim[0] + g * float(ex), -m), m),
                min(max(self.trim[1] + g * float(ey), -m), m),
            )

    def _joint_motion(self, knots, before, place):
        dt = self._options.knot_time
        wanted = self._inverse(np.array([[foot.in_body for foot in k.feet] for k in knots]))
        given, given_speeds = self._joints[before : place + 1], self._speeds[before : place + 1]
        n = len(given)
        joints = np.concatenate([given, wanted])
        speeds = np.empty_like(joints)
        speeds[1:-1] = (joints[2:] - joints[:-2]) / (2.0 * dt)
        speeds[-1] = 0.0
        speeds[:n] = given_speeds
        if self._is_possible(joints[n - 1 :], speeds[n - 1 :]):
            return joints, speeds
        self.slowed += 1
        joints[n:] = self._slowed(wanted, given[-1])
        speeds = monotone_speeds(joints, dt)
        speeds[:n] = given_speeds
        if self._is_possible(joints[n - 1 :], speeds[n - 1 :]):
            return joints, speeds
        return None

    def _is_possible(self, joints, speeds) -> bool:
        times = self._options.knot_time * np.arange(len(joints))
        try:
            self._limits.check(times, joints.reshape(-1, 12), speeds.reshape(-1, 12))
        except TrajectoryError:
            return False
        return True

    def _slowed(self, wanted, last):
        r = self._robot
        joints = np.clip(wanted, r.lower + 0.02, r.upper - 0.02)
        most = r.velocity * self._options.knot_time
        part = 0.5
        for k in range(len(joints)):
            step = joints[k] - last
            over = (np.abs(step) / (part * most)).max(axis=1)
            joints[k] = last + step / np.maximum(1.0, over)[:, None]
            last = joints[k]
            part = self._options.speed_fraction
        return joints

    def _inverse(self, feet):
        r = self._robot
        try:
            return r.stacked_legs.inverse(feet)
        except GaitError:
            q = np.empty_like(feet)
            for i, f in enumerate(feet):
                for share in _SHRINKING:
                    try:
                        q[i] = r.stacked_legs.inverse(self._neutral + share * (f - self._neutral))
                        break
                    except GaitError:
                        continue
            return q


def monotone_speeds(positions: Array, dt: float) -> Array:
    slopes = np.diff(positions, axis=0) / dt
    a, b = slopes[:-1], slopes[1:]
    product = a * b
    speeds = np.zeros_like(positions)
    same = product > 0.0
    speeds[1:-1] = np.where(same, 2.0 * product / np.where(same, a + b, 1.0), 0.0)
    return speeds
