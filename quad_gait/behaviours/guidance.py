"""
Where the robot is to go: a plan, or steering, as one step after the other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_gait.behaviours.activity import Activity, Report
from quad_gait.behaviours.gait_choice import GaitChoice
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.wishes import ChangeGaits, FollowPlan, Steer
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.faults.commanded_joints import CommandedJoints
from quad_gait.following.reference_path import Piece
from quad_gait.following.steering import Steering
from quad_gait.following.step import Departure, Step
from quad_gait.following.stuck_detector import Begun, StuckDetector
from quad_gait.state.robot_state import RobotState
from quad_gait.uneven.felt_ground import FeltGround
from quad_gait.uneven.ways_out import WaysOut

_NOWHERE = Pose2D(0.0, 0.0, 0.0)

_UNFOLLOWED = 0.1
"""Time after which joints that have not followed say nothing of what is in the robot's way [s]."""


@dataclass(frozen=True)
class PlannedMotion:
    """What was planned of a step."""

    motion: BodyMotion
    """Motion of the body; as much of the step's as is possible."""
    end: Pose2D
    """Pose at which the robot is to be at rest after it, on the plan."""
    limit: str = ''
    """What keeps it from being more, as a sentence; empty if nothing does."""


class Guidance:
    """
    The plan and the velocity that are wanted, and how far they have come.

    Parameters
    ----------
    robot : Robot
        The robot.
    gaits : ChangeGaits
        The gaits, and how plans are followed.
    options : SupervisorOptions
        Timing and tolerances.
    report : Report
        What the robot says of itself.
    joints : CommandedJoints
        What the joints are commanded.
    """

    def __init__(
        self,
        robot: Robot,
        gaits: ChangeGaits,
        options: SupervisorOptions,
        report: Report,
        joints: CommandedJoints,
    ) -> None:
        self._robot, self._report, self._joints = robot, report, joints
        self._progress = StuckDetector(robot.largest_stride)
        self._is_uneven = options.uneven is not None
        self.ways_out = WaysOut(robot.largest_stride)
        """What is tried where strides over uneven ground lead nowhere."""
        self.felt = FeltGround(robot)
        """Ground as feet have met it."""
        self.impassable: Pose2D | None = None
        """Pose from which no stride ahead was possible; None before there is one."""
        self.gaits = GaitChoice(robot, gaits, options)
        """The gaits, and whether the balance is kept in them."""
        self.gait_pair = self.gaits.pair
        """The gaits for walking and for turning."""
        self._follower = self.gaits.follower()
        self._new_gaits: ChangeGaits | None = None
        correction = options.follower.largest_correction if options.hold_course else 0.0
        self.steering = Steering(options.twist_timeout, correction, options.steps_in_place)
        """Velocity that is wanted, and the course."""
        self._pieces: list[Piece] | None = None
        self.has_new_plan = False
        """Whether another plan, or none, was wished for that is not followed yet."""
        self._stopped_goal: Pose2D | None = None
        self._was_stopped = False
        self._stands: tuple[Activity, str] | None = None
        self.wanted_plan: Plan | None = None
        """The plan to follow, also while something blocks the robot; None: there is none."""
        self.stops = 0
        """Number of stops: from each on nothing that was planned before is wanted."""
        self.plan_waits_for = ''
        """Reason for which the plan waits; empty if it does not."""
        self.is_to_sit = False
        """Whether the robot is to sit, and nothing else."""
        self.begun: Begun | None = None
        """Motion that was begun last; None if nothing is expected of it."""

    def distance_left(self, pose: Pose2D) -> float:
        """Return how far it is along the plan to the goal [m]."""
        return self._follower.distance_left(pose)

    def poses_ahead(self, pose: Pose2D, distances: Sequence[float]) -> list[Pose2D]:
        """Return poses to be at, so far along the plan at most [m]; none without a plan."""
        ahead = [self._follower.pose_ahead(pose, distance) for distance in distances]
        return [place for place in ahead if place is not None]

    # Wishes

    def take_plan(self, wish: FollowPlan, refusal: str) -> None:
        """Take a plan, or none, from the next cycle on; a refusal is said."""
        plan = wish.plan
        if plan and not wish.is_asked and _is_same_goal(plan.poses[-1], self._stopped_goal):
            return
        # A planner that takes its plan back knows of the stop: the next plan was asked for.
        self._stopped_goal = None
        if plan is None and self.wanted_plan is None:
            return  # Whatever else the robot does goes on.
        if plan is not None and refusal:
            self._report.limit = f'the plan is refused: {refusal}'
            self.stops += self.wanted_plan is None
            return
        self.wanted_plan, self._pieces = plan, wish.pieces
        self.has_new_plan, self._was_stopped = True, False
        self.steering.end()
        self._stands = None

    def take_steering(self, wish: Steer, time: float, refusal: str) -> None:
        """Take a velocity that is wanted from a time [s] on; a refusal is said."""
        if refusal:
            self._report.limit = f'steering is refused: {refusal}'
            return
        self.stops += self.steering.twist is None or self.wanted_plan is not None
        self.forget_plan()
        self._stands = None
        self.steering.wish(wish.twist, time)

    def take_gaits(self, wish: ChangeGaits) -> None:
        """Take other gaits, for when the robot is at rest."""
        self._new_gaits = wish

    def stop(self) -> None:
        """Want nothing; a plan to the same goal is no reason to walk again."""
        self.stops += 1
        self.forget_plan()
        self.steering.end()
        self._stands = None

    def forget_plan(self) -> None:
        """Want no plan; a plan to the same goal is no reason to walk again."""
        if self.wanted_plan is not None:
            self._stopped_goal, self._was_stopped = self.wanted_plan.poses[-1], True
            self.wanted_plan = None
            self.has_new_plan = True

    def give_up(self, activity: Activity, reason: str) -> None:
        """Follow the plan no farther, though it is still wanted, and say why until that changes."""
        self._halt()
        self._stands = activity, reason
        self._report.say(activity, reason)

    def give_up_going(self, reason: str) -> bool:
        """Give up, if the robot is to go anywhere; return whether it was."""
        is_to_go = self._follower.plan is not None or self.steering.twist is not None
        if is_to_go:
            self.give_up(Activity.STOPPED, reason)
        return is_to_go

    def abandon(self) -> None:
        """Follow nothing any more, and want nothing."""
        self.forget_plan()
        self._halt()
        self._stands = None

    def _halt(self) -> None:
        self._follower.follow(None, _NOWHERE)
        self.steering.end()

    # Steps

    def next_at_rest(self, state: RobotState, is_ready: bool) -> Step | None:
        """
        Go by what was wished for since; return the step to begin with, if the robot can.

        Parameters
        ----------
        state : RobotState
            The robot at rest.
        is_ready : bool
            Whether it could begin a step.

        Returns
        -------
        Step or None
            None to stay; why is said.

        Raises
        ------
        GaitError
            If the plan cannot be followed.
        """
        self._use_new_plan(state.pose, joins_again=self._use_new_gaits(state))
        if not is_ready or self._is_blocked(state):
            return None
        step = self._next_step(state.time, Departure(state.pose, state.motion_pose))
        if self._is_uneven:
            self.ways_out.left = self._follower.work_left(state.pose)
        return step

    def next_in_motion(self, state: RobotState, expected: Pose2D, start: Departure) -> Step | None:
        """
        Go by a new plan, if there is one; return the step that follows the cycle that runs.

        Parameters
        ----------
        state : RobotState
            The robot now.
        expected : Pose2D
            Pose on the plan at which the cycle should have it by now.
        start : Departure
            Where the step will begin, and how.

        Returns
        -------
        Step or None
            None to come to rest.

        Raises
        ------
        GaitError
            If the plan cannot be followed.
        """
        self._use_new_plan(state.pose)
        # Other gaits, and sitting down, are begun at rest.
        if self._is_blocked(state, expected) or self._new_gaits is not None or self.is_to_sit:
            return None
        return self._next_step(state.time, start)

    def note_begun(self, state: RobotState, step: Step, planned: PlannedMotion) -> None:
        """Note that a step begins, and say which, and what keeps the robot from a larger one."""
        at = state.time, state.pose, state.motion_pose
        self.begun = Begun(*at, planned.end, self._joints.late)
        report, motion, is_steered = self._report, planned.motion, self.steering.twist is not None
        if not is_steered:
            report.limit = ''
        if planned.limit:
            report.limit = f'a cycle was shortened: {planned.limit}'
        size = math.hypot(motion.forward, motion.left)
        turn = f'turning by {math.degrees(motion.turn):.1f} degrees'
        if step.is_turn or size <= 1e-3 < abs(motion.turn):
            report.say(Activity.TURNING, turn)
            return
        turns_too = self.gaits.follower_options.turning != 'in_place' or is_steered
        said = f'walking {_length(size)}' + (f' and {turn}' if turns_too else '')
        report.say(Activity.WALKING, said)

    def _use_new_gaits(self, state: RobotState) -> bool:
        """Take gaits wished for since; return whether they are others, and are to follow a plan."""
        new_gaits, self._new_gaits = self._new_gaits, None
        if new_gaits is not None:
            self.gaits.take(new_gaits)
            self.steering.lose_course()
        if not self.gaits.look_at(state) and new_gaits is None:
            return False
        was_following = self._follower.plan is not None
        self.gait_pair = self.gaits.pair
        self._follower = self.gaits.follower()
        return was_following

    def _use_new_plan(self, pose: Pose2D, joins_again: bool = False) -> None:
        """Go by a plan that was wished for since; or join the one that is followed again."""
        if self.has_new_plan or joins_again:
            self._follower.follow(self.wanted_plan, pose, self._pieces)
        if not self.has_new_plan:
            return
        self.has_new_plan, self._stands = False, None
        self._progress.reset()
        self.ways_out.reset()
        if self._report.activity.is_verdict:
            self._report.say(Activity.STANDING, self.why_standing)
        self._report.limit = ''

    def _is_blocked(self, state: RobotState, expected: Pose2D | None = None) -> bool:
        """Return whether cycles have no effect, and give up then; expected now, or at the end."""
        begun, self.begun = self.begun, None
        if begun is None or self._joints.unfollowed > _UNFOLLOWED:
            return False
        now = state.time, state.motion_pose, self._joints.late
        problem = self._progress.problem(begun, *now, expected)
        return problem is not None and self.give_up_or_try(Activity.BLOCKED, problem)

    def give_up_or_try(self, activity: Activity, problem: str) -> bool:
        """Give up, unless a plan over uneven ground has another way out; return whether it did."""
        self.begun = None
        if self._is_uneven and self._follower.plan is not None and self.ways_out.fail(problem):
            return False
        self.give_up(activity, problem)
        return True

    def _next_step(self, time: float, start: Departure) -> Step | None:
        """Turn what is wanted into a step; say why there is none at rest."""
        report, entry = self._report, start.entry
        if self.steering.twist is not None:
            return self._steer(time, start)
        if self._follower.plan is None:
            if not entry and not report.activity.is_verdict:
                report.say(*(self._stands or (Activity.STANDING, self.why_standing)))
            return None
        if self.plan_waits_for:
            if not entry:
                report.say(Activity.WAITING, self.plan_waits_for)
            return None
        step = self._follower.next_step(start.pose, entry)
        if step is None:
            # Whatever moves the robot from now on, the job is done until a new plan comes.
            self.wanted_plan = self._pieces = None
            remark = self._follower.remark
            report.say(Activity.ARRIVED, f'the goal is reached{remark and ", "}{remark}')
        return step

    @property
    def why_standing(self) -> str:
        """Reason for which the robot stands, as a sentence."""
        if self._stands is not None:
            return self._stands[1]
        if self._was_stopped:
            return 'stopped on request; a new goal makes the robot walk again'
        return 'no plan to follow'

    def _steer(self, time: float, start: Departure) -> Step | None:
        steered = self.steering.next_step(time, start, self.gait_pair)
        self._report.limit = steered.limit
        if self.steering.twist is None:
            self._stands = (Activity.STANDING, steered.reason) if steered.reason else None
        if steered.reason and not start.entry:
            self._report.say(Activity.STANDING, steered.reason)
        return steered.step


def _length(size: float) -> str:
    """Return a length [m] in words; of a speed limit that is next to nothing not much is left."""
    return f'{size:.3f} m' if size > 1e-3 else f'{1e3 * size:.2g} mm'


def _is_same_goal(a: Pose2D, b: Pose2D | None) -> bool:
    return b is not None and a.distance_to(b) < 1e-3 and abs(wrap_angle(a.yaw - b.yaw)) < 1e-3
