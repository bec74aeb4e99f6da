"""
What leaves the gait: no trajectory that the joints could not follow from where they are.

The gate knows what the joints are commanded at each instant, as their controller does, from the
trajectories that it let through.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits, check_command, joining_time

Array = NDArray[np.float64]


class CommandGate:
    """
    Lets trajectories through that stay within the limits, and remembers what they command.

    Parameters
    ----------
    robot : Robot
        The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.limits = JointLimits.of(robot)
        self._executor: TrajectoryExecutor | None = None

    @property
    def end(self) -> float:
        """When the last trajectory that passed comes to rest [s]; minus infinity without one."""
        return -np.inf if self._executor is None else self._executor.end

    def forget(self) -> None:
        """Know nothing of what is commanded: something else has moved the joints."""
        self._executor = None

    def go_back_to(self, trajectory: JointTrajectory) -> None:
        """
        Take the joints to follow an earlier trajectory: what was given out since has not arrived.

        Parameters
        ----------
        trajectory : JointTrajectory
            One that passed, with a time of its own.
        """
        self._executor = self._executor_at(trajectory.positions[0])
        self._executor.accept(trajectory, trajectory.stamp)

    def command(self, time: float, measured: Array) -> tuple[Array, Array]:
        """
        Return what the joints are commanded.

        Parameters
        ----------
        time : float
            [s]
        measured : ndarray, shape (12,)
            Where they are [rad]; they are taken to hold it while nothing has been commanded.

        Returns
        -------
        tuple of ndarray, each of shape (12,)
            Positions [rad], within their range, and velocities [rad/s].
        """
        return self._known(measured).command(time)

    def time_to(self, time: float, measured: Array, target: Array) -> float:
        """Return how long the joints need from their commands to rest at a target, (12,) [s]."""
        return joining_time(self.limits, *self.command(time, measured), target)

    def admit(self, trajectory: JointTrajectory, time: float, measured: Array) -> JointTrajectory:
        """
        Let a trajectory through.

        One that begins on arrival begins as much later as the joints need to its first point: the
        robot may have received the last one later than was known when this one was planned.

        Parameters
        ----------
        trajectory : JointTrajectory
            For all joints, in the robot's order.
        time : float
            When it is given out [s].
        measured : ndarray, shape (12,)
            Where the joints are [rad].

        Returns
        -------
        JointTrajectory
            As it is to be given out.

        Raises
        ------
        TrajectoryError
            If it leaves the limits, or the joints cannot follow it from their commands.
        """
        executor = self._known(measured)
        delay = executor.delay_of(trajectory, time)
        if np.isfinite(delay):
            trajectory = trajectory.delayed(delay)
        check_command(self.limits, trajectory, time, *executor.command(time))
        executor.accept(trajectory, time)
        return trajectory

    def _known(self, measured: Array) -> TrajectoryExecutor:
        if self._executor is None:
            self._executor = self._executor_at(measured)
        return self._executor

    def _executor_at(self, positions: Array) -> TrajectoryExecutor:
        limits = self.limits
        return TrajectoryExecutor(limits.joint_names, limits.clip(positions), limits)
