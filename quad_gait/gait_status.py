"""
What ``gait_node`` reports: what the robot does, or why it does not move.
"""

from __future__ import annotations

from collections.abc import Callable

from quad_common.planar_pose import Pose2D
from quad_common.status import Level, Status
from quad_gait.behaviours.activity import Activity
from quad_gait.parameters import GaitParameters
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.supervisor import Supervisor

_LEVELS = {
    Activity.WAITING: Level.WARN,
    Activity.STOPPED: Level.ERROR,
    Activity.BLOCKED: Level.ERROR,
    Activity.FALLEN: Level.ERROR,
    Activity.LAME: Level.ERROR,
    Activity.NOT_EXECUTED: Level.ERROR,
    Activity.EMERGENCY_STOP: Level.ERROR,
}

_NUMB = 'joint states have no efforts: feet do not feel the ground'


class GaitStatus:
    """
    Puts together what supervisor and estimator say.

    Parameters
    ----------
    supervisor : Supervisor
        What decides.
    estimator : StateEstimator
        What it decides on.
    parameters : GaitParameters
        The node's.
    clock : callable
        Returns the time by the wall clock [s].
    """

    def __init__(
        self,
        supervisor: Supervisor,
        estimator: StateEstimator,
        parameters: GaitParameters,
        clock: Callable[[], float],
    ) -> None:
        self._supervisor = supervisor
        self._estimator = estimator
        self._topic = parameters.odom_topic
        self._timeout = parameters.odom_timeout
        self._feels_ground = parameters.is_uneven
        self._clock = clock
        self._received_at: float | None = None
        self._is_time_still = False
        self._distance_left = 0.0
        self._said: tuple[str, str, str, str, bool] | None = None

    def take_odometry(self, is_new: bool) -> None:
        """Note that odometry came, and whether it is another reading than the one before."""
        self._is_time_still = not is_new
        if is_new:
            self._received_at = self._clock()

    def has_changed(self, pose: Pose2D) -> bool:
        """Return whether there is something else to say than last time, with the robot here."""
        supervisor = self._supervisor
        is_silent = bool(self._estimator.imu_problem)
        remark = supervisor.felt_ground.remark
        said = supervisor.reason, supervisor.limit, supervisor.unbalanced, remark, is_silent
        if said == self._said:
            return False
        self._said = said
        self._distance_left = supervisor.distance_left(pose)
        return True

    def status(self, clock_problem: str | None, *notes: str) -> Status:
        """
        Return what is to be reported.

        Parameters
        ----------
        clock_problem : str or None
            That simulated time does not advance, as a sentence.
        *notes : str
            What else a user should know, as sentences; empty ones are left out.
        """
        is_stopped = self._supervisor.activity is Activity.EMERGENCY_STOP
        stop = 'the emergency stop is on' if is_stopped else ''
        if clock_problem is not None:
            return Status(Level.STALE, clock_problem, is_waiting=True).with_notes(stop)
        received = self._received_at
        if received is None or self._clock() - received > self._timeout:
            if self._is_time_still:
                message = 'stale odometry: it comes, and its time stands still'
            else:
                message = f"no odometry: waiting for it on '{self._topic}'"
            status = Status(Level.WARN, message, is_waiting=not self._is_time_still)
            return status.with_notes(stop)
        supervisor = self._supervisor
        activity, cycle = supervisor.activity, supervisor.cycle
        level = _LEVELS.get(activity, Level.OK)
        most = supervisor.gait_pair.largest_speeds
        silent_imu = self._estimator.imu_problem
        missing = '' if silent_imu in f'{supervisor.reason}; {supervisor.limit}' else silent_imu
        status = Status(
            level,
            f'{activity.value}: {supervisor.reason}',
            {
                'activity': activity.value,
                'gait': supervisor.gait.name,
                'distance_left': f'{self._distance_left:.3f}',
                'least_margin': '' if cycle is None else f'{cycle.least_margin:.4f}',
                'limit': supervisor.limit,
                'cycle_period': f'{supervisor.gait.cycle_period:.3f}',
                'largest_forward': f'{most.forward:.4f}',
                'largest_left': f'{most.left:.4f}',
                'largest_turn': f'{most.turn:.4f}',
            },
            is_waiting=activity is Activity.WAITING,
        )
        numb = _NUMB if self._feels_ground and self._estimator.lacks_efforts else ''
        own = supervisor.limit, missing, supervisor.unbalanced, supervisor.felt_ground.remark, numb
        return status.with_notes(*own, *notes)
