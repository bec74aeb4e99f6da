"""
A joint that does not answer: the robot comes to a standstill, and stays so until it does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import RobotIsLame
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, PASS, Command, Done, Shared
from quad_gait.behaviours.routine import Routine
from quad_gait.behaviours.wishes import Freeze, Sit, Stand, Wish
from quad_gait.faults.joint_fault import JointFault
from quad_gait.faults.joint_trial import JointRecovery
from quad_gait.faults.safe_stop import SafeStop
from quad_gait.faults.safe_stop_options import SafeStopOptions
from quad_gait.guards.guard import Guard
from quad_gait.state.robot_state import RobotState

Array = NDArray[np.float64]


class Lame(Guard):
    """Brings the robot to a standstill on the legs that it has, and tries the joint on request."""

    def __init__(self, shared: Shared, routine: Routine) -> None:
        super().__init__(shared, routine)
        self._recovery: JointRecovery | None = None
        self._lacks_sensors = False

    @property
    def refusal(self) -> str:
        """Why nothing new is to be begun."""
        recovery = self._recovery
        return '' if recovery is None else f'{recovery.fault.name} does not answer'

    def take(self, wish: Wish) -> str:
        """Try the joint when the robot is to stand; leave everything as it is when frozen."""
        recovery = self._recovery
        if recovery is None:
            return ''
        if isinstance(wish, Sit):
            raise RobotIsLame(str(recovery.fault))
        if isinstance(wish, Freeze):
            recovery.stop.hold()
        elif isinstance(wish, Stand):
            recovery.try_again()
            return f'{recovery.fault.name} is tried first; if it answers the robot stands up'
        return ''

    def update(self, state: RobotState) -> Command | Done:
        """Come to a standstill; be done when the joint answers again."""
        if state.tilt > self._options.largest_tilt:
            if self._recovery is not None:
                self._recovery.stop.give_up()
            return PASS
        fault = self._joints.fault
        if self._recovery is None:
            # Of a robot that lies on the ground little is known.
            if fault is None or self._report.activity is Activity.FALLEN:
                return PASS
            commanded = self._commanded(state)
            self._recovery = self._begin(fault, state, commanded)
            return self._go_on(state, self._recovery, commanded)
        return self._go_on(state, self._recovery)

    def _begin(self, fault: JointFault, state: RobotState, commanded: Array) -> JointRecovery:
        """Leave everything else."""
        standing = self._routine.walk.in_contact_at(state.time)
        is_static = self._guidance.gait_pair.walking.gait.is_static
        hasty = SafeStopOptions.hasty(self._robot.relative_size)
        options = SafeStopOptions() if is_static else hasty
        stop = SafeStop(self._robot, fault, commanded, standing, options)
        self._joints.failed = fault
        self._guidance.abandon()
        self._routine.forget()
        self._report.limit = ''
        return JointRecovery(self._robot, fault, stop)

    def _commanded(self, state: RobotState) -> Array:
        positions, _ = self._joints.gate.command(state.time, state.joints.reshape(-1))
        return positions.reshape(4, 3)

    def _go_on(
        self, state: RobotState, recovery: JointRecovery, commanded: Array | None = None
    ) -> Command:
        report, joints = self._report, self._joints
        if not state.has_joints or state.problem:
            report.limit = state.problem
            self._lacks_sensors = True
            return GO_ON
        if self._lacks_sensors:
            self._lacks_sensors, report.limit = False, ''
        commanded = self._commanded(state) if commanded is None else commanded
        trajectory = recovery.update(state.stance(), commanded)
        joints.busy_until = recovery.stop.end
        report.say(Activity.LAME, str(recovery))
        if recovery.is_over:
            self._recovery = None
            joints.recover()
            report.say(Activity.STANDING, f'{recovery.fault.name} answers again')
        return Command(trajectory)
