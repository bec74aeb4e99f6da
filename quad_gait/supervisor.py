"""
Decides, measurement by measurement, what the robot does, and answers with joint trajectories.

The supervisor knows no clock and no topics: it is told the time with each state of the robot.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import TrajectoryError
from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity, Report
from quad_gait.behaviours.behaviour import Command, Shared
from quad_gait.behaviours.guidance import Guidance
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.routine import Routine
from quad_gait.behaviours.wishes import (
    ChangeGaits,
    FollowPlan,
    Freeze,
    HoldPlan,
    Release,
    Sit,
    Stand,
    Steer,
    Stop,
    UseHeightMap,
    Wish,
)
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait import Gait
from quad_gait.faults.commanded_joints import CommandedJoints
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.motion_sequence import MotionSequence, ScheduledCycle
from quad_gait.following.planned_support import PlannedSupport
from quad_gait.following.reference_path import Piece
from quad_gait.following.slip_compensation import NO_SLIP, SlipCompensation, compensation_for
from quad_gait.guards.frozen import Frozen
from quad_gait.parameters import GaitParameters
from quad_gait.state.robot_state import RobotState
from quad_gait.state.support import Support
from quad_gait.transitions import GUARDS, ROUTINE
from quad_gait.uneven.felt_ground import FeltGround


class Supervisor:
    """
    Lets one behaviour of the table of transitions act at a time.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        For walking; fitted to the robot.
    turning_gait : Gait
        For turning on the spot; may be the same.
    options : SupervisorOptions
        Timing and tolerances.
    compensation : SlipCompensation
        Factors by which more is commanded than is wanted; see ``quadwalk calibrate``.
    """

    def __init__(
        self,
        robot: Robot,
        gait: Gait,
        turning_gait: Gait,
        options: SupervisorOptions,
        compensation: SlipCompensation = NO_SLIP,
    ) -> None:
        self._report = report = Report()
        self._joints = joints = CommandedJoints(robot, options.watches_joints)
        gaits = ChangeGaits(gait, turning_gait, options.follower)
        self._guidance = Guidance(robot, gaits, options, report, joints)
        self._cycles = MotionSequence()
        shared = Shared(robot, options, compensation, report, joints, self._guidance, self._cycles)
        self._routine = Routine(ROUTINE, shared)
        self._guards = [row.guard(shared, self._routine) for row in GUARDS]
        self._last: RobotState | None = None
        self.support = PlannedSupport(robot, self._cycles)
        """Support polygon and stability margin as planned."""

    @classmethod
    def from_parameters(cls, parameters: GaitParameters, robot: Robot) -> Supervisor:
        """Return the supervisor that the parameters of ``gait_node`` describe."""
        return cls(
            robot,
            *parameters.gaits(robot),
            parameters.supervisor_options,
            compensation_for(parameters.robot, parameters.calibration),
        )

    # What it says

    @property
    def activity(self) -> Activity:
        """What the robot is doing."""
        return self._report.activity

    @property
    def reason(self) -> str:
        """The same as a sentence."""
        return self._report.reason

    @property
    def limit(self) -> str:
        """What keeps the robot from doing all that was requested; empty if nothing does."""
        return self._report.limit

    @property
    def unbalanced(self) -> str:
        """Reason why it walks without keeping its balance; empty if it need not."""
        return self._guidance.gaits.unbalanced

    @property
    def wanted_plan(self) -> Plan | None:
        """The plan to follow, also while something blocks the robot; None: there is none."""
        return self._guidance.wanted_plan

    @property
    def stops(self) -> int:
        """Number of times that nothing planned so far was wanted any more, as by a stop."""
        return self._guidance.stops

    @property
    def impassable(self) -> Pose2D | None:
        """Pose, heading to where there was no footing, from which another path was asked for."""
        return self._guidance.impassable

    @property
    def felt_ground(self) -> FeltGround:
        """Ground as feet have met it, and what it says of the height map."""
        return self._guidance.felt

    @property
    def gait_pair(self) -> GaitPair:
        """The gaits for walking and for turning."""
        return self._guidance.gait_pair

    @property
    def gait(self) -> Gait:
        """The gait for walking."""
        return self.gait_pair.walking.gait

    @property
    def cycle(self) -> Cycle | None:
        """The cycle that was planned last."""
        last = self._cycles.last
        return None if last is None else last.cycle

    def cycle_at(self, time: float) -> ScheduledCycle | None:
        """Return the cycle that runs at a time [s]; None while the robot rests."""
        return self._cycles.at(time)

    def in_contact_at(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are planned to be down at a time [s], shape (4,)."""
        return self._routine.walk.in_contact_at(time)

    def support_at(self, time: float) -> Support:
        """Return what is known at a time [s] of feet and body that their heights do not tell."""
        return self._routine.walk.support_at(time)

    def footholds(self) -> NDArray[np.float64]:
        """Return the footholds at the end of what is planned, (4, 3) [m]; (0, 3) for none."""
        return self._routine.walk.footholds()

    def distance_left(self, pose: Pose2D) -> float:
        """Return how far it is along the plan to the goal [m]."""
        return self._guidance.distance_left(pose)

    # What it does

    def prepare(self) -> None:
        """Do beforehand what takes a while: cycles and footsteps are awaited."""
        self._guidance.gaits.prepare()
        self._routine.walk.prepare()

    def update(self, state: RobotState) -> JointTrajectory | None:
        """
        Decide what the robot does now.

        Parameters
        ----------
        state : RobotState
            What is known of the robot.

        Returns
        -------
        JointTrajectory or None
            The next trajectory; None while the last one runs, or if there is nothing
            to do: :attr:`activity` and :attr:`reason` say why.
        """
        if state.was_moved:
            # Something else moved the robot, or the clock was set: what was planned is void.
            self._routine.forget()
        self._last = state
        if self._report.activity is not Activity.EMERGENCY_STOP:
            self._joints.watch(state)
        elif state.was_moved:
            self._joints.forget()
        for guard in self._guards:
            outcome = guard.update(state)
            if isinstance(outcome, Command):
                break
        else:
            outcome = self._routine.update(state)
        trajectory = outcome.trajectory
        if trajectory is None:
            return None
        return self._given(trajectory, state.time, state.joint_positions)

    def _given(
        self, trajectory: JointTrajectory, time: float, measured: NDArray[np.float64] | None
    ) -> JointTrajectory | None:
        """Let a trajectory through the last gate; what does not pass stops the robot."""
        try:
            return self._joints.give(trajectory, time, measured)
        except TrajectoryError as error:
            self._routine.forget()
            # The last one that passed ends at rest.
            self._joints.busy_until = self._joints.gate.end
            if not self.activity.is_disabled:
                self._guidance.give_up(Activity.STOPPED, f'{error}; the robot stops')
            self._report.limit = str(error)
            return None

    # What is wished for

    def wish(self, wish: Wish) -> str:
        """
        Take a wish.

        Parameters
        ----------
        wish : Wish
            What the robot is to do from now on.

        Returns
        -------
        str
            What will happen, as a sentence; empty if that shows.

        Raises
        ------
        GaitError
            If the wish cannot be granted.
        """
        guidance = self._guidance
        answer = ''
        for guard in self._guards:
            answer = guard.take(wish) or answer
        self._routine.take(wish)
        match wish:
            case FollowPlan():
                guidance.take_plan(wish, self._refusal())
            case HoldPlan(reason):
                guidance.plan_waits_for = reason
            case Steer():
                if self._last is not None:
                    guidance.take_steering(wish, self._last.time, self._refusal())
            case ChangeGaits():
                guidance.take_gaits(wish)
            case Stop():
                guidance.stop()
            case Stand():
                guidance.stop()
                guidance.is_to_sit = False
                self._joints.stand()
            case Sit():
                guidance.stop()
                guidance.is_to_sit = True
        return answer or getattr(wish, 'answer', '')

    def _refusal(self) -> str:
        """Return why nothing new is to be begun, by the most urgent guard; empty if it may."""
        return next((guard.refusal for guard in self._guards if guard.refusal), '')

    def set_plan(self, plan: Plan | None, pieces: list[Piece] | None = None) -> None:
        """Follow a plan; see :class:`FollowPlan`. After a stop one to the same goal is none."""
        self.wish(FollowPlan(plan, pieces))

    def set_twist(self, twist: Twist2D) -> None:
        """Walk with this velocity until the steering times out; ends the following of a plan."""
        self.wish(Steer(twist))

    def set_gaits(self, gait: Gait, turning_gait: Gait, follower: FollowerOptions) -> None:
        """Change gaits and how plans are followed, once the robot is at rest."""
        self.wish(ChangeGaits(gait, turning_gait, follower))

    def set_height_map(self, height_map: HeightMap | None) -> None:
        """Take a map of the ground, in the plan's frame, for walking where it is uneven."""
        self.wish(UseHeightMap(height_map))

    def hold_plan(self, reason: str) -> None:
        """Let the plan wait from the next cycle on, for a reason; none: go on with it."""
        if reason != self._guidance.plan_waits_for:
            self.wish(HoldPlan(reason))

    def stop(self) -> str:
        """Stop at the end of the cycle; return what will happen."""
        return self.wish(Stop())

    def stand(self) -> str:
        """Stop, and regain the initial posture; return what will happen."""
        return self.wish(Stand())

    def sit(self) -> str:
        """Stop, and lower the body as far as it goes; return what will happen."""
        return self.wish(Sit())

    def release(self) -> str:
        """End the emergency stop; the robot stays as it is until :meth:`stand`."""
        return self.wish(Release())

    def freeze(
        self, time: float | None = None, measured: NDArray[np.float64] | None = None
    ) -> JointTrajectory | None:
        """
        Stop all joints at once, and keep them as they are until :meth:`release`.

        Parameters
        ----------
        time : float, optional
            Now [s]; that of the last state if not given, which is old when odometry is silent.
        measured : ndarray, shape (12,), optional
            Where the joints are [rad]; as in the last state if not given.

        Returns
        -------
        JointTrajectory or None
            It starts on arrival; None if nothing is known of the joints.
        """
        self.wish(Freeze())
        last = self._last
        if last is not None:
            time = last.time if time is None else time
            measured = last.joint_positions if measured is None else measured
        if time is None or measured is None:
            return None
        frozen = next(guard for guard in self._guards if isinstance(guard, Frozen))
        return self._given(frozen.hold(time, measured), time, measured)
