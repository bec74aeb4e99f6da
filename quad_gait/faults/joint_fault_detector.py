"""
Notices joints that do not do what they are commanded to do.

A sound joint follows its command, with the lag of its drive. One that stays off while all
others follow does not answer any more: it gives way, or it is stuck. If no joint follows,
none has failed: the trajectories are not executed. What the joints are commanded to do is
told by :class:`~quad_gait.faults.command_tracker.CommandTracker`, which knows that trajectories may
come late, or never.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.faults.checks.powerless_check import PowerlessCheck
from quad_gait.faults.checks.pull_check import PullCheck
from quad_gait.faults.checks.turning_check import TurningCheck
from quad_gait.faults.command_tracker import CommandTracker, Explanation, TrackerOptions
from quad_gait.faults.joint_fault import JointFault
from quad_gait.faults.joint_path import JointPath
from quad_gait.faults.standstill_check import StandstillCheck

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FaultDetectorOptions:
    """When a joint has failed."""

    tracker: TrackerOptions = field(default_factory=TrackerOptions)
    """Distance that sound joints may have from their commands."""
    patience: float = 0.04
    """Time that a joint whose motor gives no torque must stay off to have failed [s]."""
    doubt: float = 0.12
    """The same for one that bears, or while it is not sure which trajectory runs [s]."""
    settling: float = 0.1
    """Time for which all joints must have been on the latest trajectory for that to be sure [s]."""
    swinging_on: float = 0.5
    """Time that a joint must stay off where it is not sure, and one starts on arrival [s]: a joint
    that turns when it arrives swings on before it turns back."""
    convergence: float = 0.1
    """Time within which a joint would reach its command that is approaching it [s]."""
    longest_approach: float = 0.5
    """Time for which a joint may approach its command [s]."""
    compliance: float = 0.35
    """Distance from its command at which a position drive gives all its torque [rad]."""
    longest_gap: float = 0.03
    """Two measurements farther apart count as if they were so near [s]."""
    saturated: float = 0.95
    """Fraction of its torque from which on a motor is overloaded, and has not failed."""
    slack: float = 0.03
    """Fraction of its torque below which a motor gives none."""
    slack_tolerance: float = 0.025
    """Distance that a joint may have from its command while its motor gives none [rad]; a drive
    that is farther off would pull."""
    slack_time: float = 0.06
    """Time for which it must have given none, for that to count [s]."""
    tight_tolerance: float = 0.03
    """Distance that all joints but one have from their commands while one may be found that does
    not turn [rad]."""
    rest: float = 0.004
    """Angle; a joint that has turned by less since it is off does not move [rad]."""
    jump: float = 0.08
    """Angle, beyond four times what a drive can do, by which joints that were moved jump [rad]."""


class JointFaultDetector:
    """
    Compares joints with their commands, measurement by measurement.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : FaultDetectorOptions
        When a joint has failed.
    """

    def __init__(self, robot: Robot, options: FaultDetectorOptions | None = None) -> None:
        self._robot = robot
        self._options = FaultDetectorOptions() if options is None else options
        self._largest = robot.effort.reshape(-1)
        self._fastest = np.broadcast_to(robot.velocity, (4, 3)).reshape(-1)
        # Faster than any drive.
        self._leap = 4.0 * self._fastest
        self._tracker = CommandTracker(self._options.tracker)
        self._turning = TurningCheck(self._largest)
        self._pull = PullCheck(self._largest)
        self._powerless = PowerlessCheck()
        self._standstill = StandstillCheck()
        self.late = 0.0
        """Time for which the joints have been on their way into what they were to follow already,
        or on what came before, since the beginning [s]."""
        self.forget()

    def forget(self) -> None:
        """Know no commands, until the next trajectory is given out."""
        self._tracker.forget()
        self._knows_posture = False
        self._last: tuple[float, Array] | None = None
        self._suspect = -1
        self._slack_for: Array = np.zeros(len(self._largest))
        self._turning.forget()
        self._pull.forget()
        self._powerless.forget()
        self._standstill.forget()
        self.unfollowed = 0.0
        """Time for which the joints have not followed what was given out [s]."""
        self._unfollowed_at: Array | None = None
        self._on_latest_for = self._off_latest_for = 0.0

    def expect(self, trajectory: JointTrajectory, time: float) -> None:
        """Take notice of a trajectory that is given out at a time [s]."""
        options = self._options.tracker
        if not self._knows_posture and self._last is not None:
            self._tracker.hold(*self._last)
            self._knows_posture = True
        self._tracker.add(JointPath(trajectory, time, options.tolerance, options.lag))

    def commanded(self, time: float) -> Array | None:
        """Return where the joints are commanded to be at a time [s], shape (12,) [rad]."""
        return self._tracker.commanded(time)

    def update(
        self, time: float, positions: Array, efforts: Array | None = None
    ) -> JointFault | None:
        """
        Take a measurement.

        Parameters
        ----------
        time : float
            When it was taken [s].
        positions : ndarray, shape (12,)
            [rad]
        efforts : ndarray, shape (12,), optional
            Torques of the motors [N m].

        Returns
        -------
        JointFault or None
            The joint that has failed, if one has.
        """
        last = self._last
        if last is None:
            self._last = (time, positions)
            return None
        dt = time - last[0]
        if dt <= 0.0:
            # Nothing new; or the clock was set back.
            if dt < 0.0:
                self.forget()
                self._last = (time, positions)
            return None
        self._last = (time, positions)
        moved = positions - last[1]
        if (np.abs(moved) > self._leap * dt + self._options.jump).any():
            # No drive moves like that: the robot was put somewhere else, as by a reset.
            self.forget()
            self._last = (time, positions)
            return None
        if not self._tracker:
            return None
        if not self._knows_posture:
            self._tracker.hold(*last)
            self._knows_posture = True
        step = min(dt, self._options.longest_gap)
        self._standstill.update(time, positions, moved / dt)
        strictness = self._strictness(efforts, step)
        found = self._tracker.explain(time, positions, strictness)
        powerless = self._hidden(found, time, positions, strictness, step)
        if powerless >= 0 and not self._have_stopped(powerless, positions, step):
            assert found is not None
            commanded = float(found.posture[powerless])
            kind = self._kind(powerless, positions, self._powerless.since)
            return self._fault(powerless, kind, time, positions, commanded, efforts)
        if found is not None and found.off.any() and not found.is_latest:
            # Where it is not sure which trajectory runs, a little off says nothing.
            found = self._tracker.explain(time, positions)
        if found is None or not found.off.any():
            self._note_following(found, positions, step)
            self._suspect = -1
            return self._unturned(found, time, positions, step, efforts)
        return self._suspected(found, time, positions, moved / dt, step, efforts)

    def _strictness(self, efforts: Array | None, step: float) -> Array | None:
        """Return by how much less joints may be off whose motors give no torque, (12,) [rad]."""
        options = self._options
        if efforts is None or not efforts.any():
            self._slack_for[:] = 0.0
            return None
        is_slack = np.abs(efforts) < options.slack * self._largest
        self._slack_for = np.where(is_slack, self._slack_for + step, 0.0)
        less = max(0.0, options.tracker.tolerance - options.slack_tolerance)
        strictness: Array = np.where(self._slack_for >= options.slack_time - 1e-9, less, 0.0)
        return strictness

    def _hidden(
        self,
        found: Explanation | None,
        time: float,
        positions: Array,
        strictness: Array | None,
        step: float,
    ) -> int:
        """Return a joint without torque that only an outdated command explains; -1 for none."""
        latest = None
        if found is not None and strictness is not None and self._tracker.is_exact:
            is_sound = found.is_latest and found.is_joined and not found.off.any()
            latest = None if is_sound else self._tracker.latest(time)
        if found is None or strictness is None or latest is None:
            self._powerless.forget()
            return -1
        explained = (found.posture, found.allowed)
        return self._powerless.update(latest, explained, positions, strictness, step)

    def _unturned(
        self,
        found: Explanation | None,
        time: float,
        positions: Array,
        step: float,
        efforts: Array | None,
    ) -> JointFault | None:
        """Look for a joint near its command that does not turn, or that nothing pulls there."""
        options = self._options
        is_known = found is not None and found.is_latest and found.is_joined
        if not is_known or efforts is None or not efforts.any() or not self._tracker.is_exact:
            self._turning.forget()
            self._pull.forget()
            return None
        assert found is not None
        # In transition into one that came late all joints are off, and some rest.
        loose = options.tracker.tolerance - options.tight_tolerance
        far = np.abs(positions - found.posture) > found.allowed - loose
        if np.count_nonzero(far) > 1 or self._on_latest_for < options.settling - 1e-9:
            self._pull.forget()
            return None
        speeds = (found.allowed - options.tracker.tolerance) / options.tracker.lag
        unpulled = self._pull.update(found.posture, speeds, positions, efforts, step)
        joint = self._turning.update(found.posture, positions, efforts, step)
        kind = 'stuck' if joint >= 0 else 'undriven'
        joint = joint if joint >= 0 else unpulled
        if joint < 0 or self._have_stopped(joint, positions, step):
            return None
        # One that is hardly off still bears: it is not given up at once, as one that gives way.
        return self._fault(joint, kind, time, positions, float(found.posture[joint]), efforts)

    def _note_following(self, found: Explanation | None, positions: Array, step: float) -> None:
        """Count for how long the joints have followed what should run, or have not."""
        if found is not None and found.is_latest and found.is_joined:
            self._on_latest_for += step
            self._off_latest_for = 0.0
        elif found is not None or self._suspect < 0:
            # A joint that begins to stay behind looks for an instant like one in transition.
            self._off_latest_for += step
            if self._off_latest_for > self._options.patience + 1e-9:
                self._on_latest_for = 0.0
        if found is not None and not (found.is_latest and found.is_joined):
            self.late += step
        if found is None or not (found.is_latest or found.is_sure):
            self._count_unfollowed(positions, step)
        elif found.is_sure and self._has_moved(positions):
            self.unfollowed = 0.0
            self._unfollowed_at = None

    def _count_unfollowed(self, positions: Array, step: float) -> None:
        """Count for how long the joints have not followed, and note where they began to."""
        if self._unfollowed_at is None:
            self._unfollowed_at = positions
        self.unfollowed += step

    def _has_moved(self, positions: Array) -> bool:
        """
        Return whether the joints have turned since they do not follow.

        A trajectory that begins where they are measured is followed at first by joints that rest.
        """
        at = self._unfollowed_at
        return at is None or bool(np.abs(positions - at).max() > self._options.tight_tolerance)

    def _suspected(
        self,
        found: Explanation,
        time: float,
        positions: Array,
        velocities: Array,
        step: float,
        efforts: Array | None,
    ) -> JointFault | None:
        """Follow a joint that is off while all others follow; return its fault if it has one."""
        options = self._options
        joint = int(found.off.argmax())
        if joint != self._suspect:
            self._suspect, self._off_from = joint, float(positions[joint])
            self._off_for = self._approaching_for = 0.0
        if self._have_stopped(joint, positions, step):
            self._off_for = 0.0
            return None
        error = float(found.posture[joint] - positions[joint])
        is_slack = False
        if efforts is not None:
            torque = abs(float(efforts[joint])) / float(self._largest[joint])
            if torque >= options.saturated:
                self._off_for = 0.0
                return None
            is_slack = torque < options.slack and bool(efforts.any())
            pull = float(efforts[joint]) * error
            allowed = float(found.allowed[joint]) + options.compliance * torque
            if pull > 0.0 and abs(error) <= allowed:
                # It is as far off as its load bends it.
                self._off_for = 0.0
                return None
        needed = min(abs(error) / options.convergence, 0.5 * float(self._fastest[joint]))
        if float(velocities[joint]) * np.sign(error) >= needed:
            self._approaching_for += step
            if self._approaching_for < options.longest_approach:
                return None
        self._off_for += step
        # A leg that gives way leaves no time; one that bears does.
        is_settled = found.is_latest and self._on_latest_for >= options.settling - 1e-9
        if is_settled or self._tracker.is_exact:
            patience = options.patience if is_slack and is_settled else options.doubt
        else:
            patience = options.swinging_on
        if self._off_for < patience - 1e-9:
            return None
        kind = self._kind(joint, positions, self._off_from)
        return self._fault(joint, kind, time, positions, float(found.posture[joint]), efforts)

    def _have_stopped(self, joint: int, positions: Array, step: float) -> bool:
        """Return whether it is not this joint, but a trajectory that no joint executes."""
        has_stopped = self._standstill.has_stopped(joint, self._tracker)
        if has_stopped:
            self._count_unfollowed(positions, step)
        return has_stopped

    def _kind(self, joint: int, positions: Array, off_from: float) -> str:
        """Return which kind of fault a joint has that was at an angle when it began [rad]."""
        return 'free' if abs(positions[joint] - off_from) > self._options.rest else 'stuck'

    def _fault(
        self,
        joint: int,
        kind: str,
        time: float,
        positions: Array,
        commanded: float,
        efforts: Array | None,
    ) -> JointFault:
        options = self._options
        effort = None if efforts is None or not np.any(efforts) else float(efforts[joint])
        return JointFault(
            joint,
            self._robot.joint_names[joint],
            kind,
            float(positions[joint]),
            commanded,
            effort,
            time,
            effort is not None and abs(effort) < options.slack * self._largest[joint],
        )
