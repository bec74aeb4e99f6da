"""
A joint that does not answer: the robot comes to a standstill, and stays so until it does.
"""

from __future__ import annotations

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
            self._recovery = self._begin(fault, state)
        return self._go_on(state, self._recovery)

    def _begin(self, fault: JointFault, state: RobotState) -> JointRecovery:
        """Leave everything else."""
        commanded, _ = self._joints.commanded(state)
        standing = self._routine.walk.in_contact_at(state.time)
        is_static = self._guidance.gait_pair.walking.gait.is_static
        options = SafeStopOptions() if is_static else SafeStopOptions.hasty()
        stop = SafeStop(self._robot, fault, commanded.reshape(4, 3), standing, options)
        self._joints.failed = fault
        self._guidance.forget_plan()
        self._guidance.halt()
        self._routine.forget()
        self._report.limit = ''
        return JointRecovery(self._robot, fault, stop)

    def _go_on(self, state: RobotState, recovery: JointRecovery) -> Command:
        report, joints = self._report, self._joints
        if not state.has_joints or state.problem:
            report.limit = state.problem
            self._lacks_sensors = True
            return GO_ON
        if self._lacks_sensors:
            self._lacks_sensors, report.limit = False, ''
        commanded, _ = joints.commanded(state)
        trajectory = recovery.update(state.stance(), commanded.reshape(4, 3))
        joints.busy_until = recovery.stop.end
        report.say(Activity.LAME, str(recovery))
        if recovery.is_over:
            self._recovery = joints.failed = None
            joints.expect_nothing()
            joints.stand()
            report.say(Activity.STANDING, f'{recovery.fault.name} answers again')
        return Command(trajectory)
