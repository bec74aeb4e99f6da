"""
Cycles one after the other: what the robot is doing now, and what it will do next.

A body that keeps its speed from cycle to cycle always has a last cycle planned that
brings it to rest: if nothing more comes, the robot stops on four feet.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.cycle import Cycle
from quad_gait.following.stoppable_cycle import StoppableCycle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ScheduledCycle:
    """A cycle with its place in time and in the plane."""

    cycle: Cycle
    """Cycle that is given out."""
    start: float
    """Time at which it starts [s]."""
    pose: Pose2D
    """Pose of the body at its start: the cycle's ground frame."""

    @property
    def end(self) -> float:
        """When it ends [s]."""
        return self.start + self.cycle.period

    @property
    def end_pose(self) -> Pose2D:
        """Where the body is to be at its end."""
        return self.pose @ self.cycle.motion.end

    def pose_at(self, time: float) -> Pose2D:
        """Return where the body is to be at a time [s]."""
        return self.pose @ self.cycle.pose_at(time - self.start)


def schedule(planned: StoppableCycle, start: float, pose: Pose2D) -> list[ScheduledCycle]:
    """Return a cycle from a time [s] and a pose on, and the stop after it, if it needs one."""
    cycle = ScheduledCycle(planned.cycle, start, pose)
    if planned.stop is None:
        return [cycle]
    return [cycle, ScheduledCycle(planned.stop, cycle.end, cycle.end_pose)]


class MotionSequence:
    """The cycles that have been given out; the last one ends at rest."""

    def __init__(self) -> None:
        self._cycles: list[ScheduledCycle] = []

    def __bool__(self) -> bool:
        """Return whether there is any cycle."""
        return bool(self._cycles)

    @property
    def end(self) -> float:
        """When the last cycle ends [s]; minus infinity without one."""
        return self._cycles[-1].end if self._cycles else -np.inf

    @property
    def last(self) -> ScheduledCycle | None:
        """The cycle planned last that is no mere stop."""
        moving = [scheduled for scheduled in self._cycles if scheduled.cycle.exit]
        return moving[-1] if moving else (self._cycles[-1] if self._cycles else None)

    @property
    def final(self) -> ScheduledCycle | None:
        """The cycle at whose end the robot is at rest."""
        return self._cycles[-1] if self._cycles else None

    def clear(self) -> None:
        """Forget everything."""
        self._cycles = []

    def replace(self, *cycles: ScheduledCycle) -> None:
        """Go on with these cycles in place of all that begin when they do or later."""
        kept = [scheduled for scheduled in self._cycles if scheduled.start < cycles[0].start - 1e-9]
        # Of the past only the cycle before matters.
        self._cycles = [*kept[-1:], *cycles]

    def at(self, time: float) -> ScheduledCycle | None:
        """Return the cycle that runs at a time [s]; None before, between and after."""
        for scheduled in self._cycles:
            if scheduled.start <= time < scheduled.end:
                return scheduled
        return None

    def in_contact_at(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are planned to be down at a time [s], shape (4,)."""
        scheduled = self.at(time)
        if scheduled is None:
            return np.ones(4, dtype=bool)
        cycle = scheduled.cycle
        in_contact: NDArray[np.bool_] = cycle.in_contact[cycle.sample(time - scheduled.start)]
        return in_contact

    def trajectory(self, robot: Robot, since: float) -> JointTrajectory:
        """
        Write all cycles as one joint trajectory.

        Parameters
        ----------
        robot : Robot
            Whose joints.
        since : float
            Points long before this time are left out [s].

        Returns
        -------
        JointTrajectory
            Its last point is at rest.
        """
        parts = [scheduled.cycle.trajectory(robot, scheduled.start) for scheduled in self._cycles]
        parts = [part for part in parts if part.end > since]
        stamp = parts[0].stamp
        # Where two cycles meet, the later one has the point.
        times = [part.times[:-1] + (part.stamp - stamp) for part in parts]
        positions = [part.positions[:-1] for part in parts]
        velocities = [part.velocities[:-1] for part in parts]
        last = parts[-1]
        all_times = np.concatenate([*times, last.times[-1:] + (last.stamp - stamp)])
        first = max(int(np.searchsorted(all_times, since - stamp, side='right')) - 1, 0)
        return JointTrajectory(
            joint_names=robot.joint_names,
            stamp=stamp,
            times=all_times[first:],
            positions=np.concatenate([*positions, last.positions[-1:]])[first:],
            velocities=np.concatenate([*velocities, last.velocities[-1:]])[first:],
        )
