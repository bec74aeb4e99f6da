"""
Where the robot is to go: a plan, or steering, as one step after the other.
"""

from __future__ import annotations

import math

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_gait.behaviours.activity import Activity, Report
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.wishes import ChangeGaits, FollowPlan, Steer
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.faults.commanded_joints import CommandedJoints
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.path_follower import PathFollower
from quad_gait.following.reference_path import Piece
from quad_gait.following.steering import Steering
from quad_gait.following.step import Step
from quad_gait.following.stuck_detector import StuckDetector
from quad_gait.state.robot_state import RobotState

_NOWHERE = Pose2D(0.0, 0.0, 0.0)

_UNFOLLOWED = 0.1
"""Time after which joints that have not followed say nothing of what is in the robot's way [s]."""


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
        self._robot = robot
        self._report = report
        self._joints = joints
        self._progress = StuckDetector(robot.largest_stride)
        self._expected = _NOWHERE
        # Over uneven ground every swing is balanced by itself: there only legs and joints limit.
        self._least_margin = options.least_margin if options.uneven is None else -math.inf
        self._take_gaits(gaits)
        self._new_gaits: ChangeGaits | None = None
        correction = options.follower.largest_correction if options.hold_course else 0.0
        self._steering = Steering(options.twist_timeout, correction)
        self._pieces: list[Piece] | None = None
        self._has_new_plan = False
        self._stopped_goal: Pose2D | None = None
        self._reason_to_stand = ''
        self.wanted_plan: Plan | None = None
        """The plan to follow, also while something blocks the robot; None: there is none."""
        self.plan_waits_for = ''
        """Reason for which the plan waits; empty if it does not."""
        self.is_to_sit = False
        """Whether the robot is to sit, and nothing else."""
        self.gear: MotionLimits | None = None
        """The gait of the cycle that was planned last."""

    @property
    def has_wish(self) -> bool:
        """Whether the robot is to go anywhere."""
        return self._follower.plan is not None or bool(self._steering)

    @property
    def wants_rest(self) -> bool:
        """Whether the next thing to do can only be begun at rest."""
        return self._new_gaits is not None or self.is_to_sit

    def distance_left(self, pose: Pose2D) -> float:
        """Return how far it is along the plan to the goal [m]."""
        return self._follower.distance_left(pose)

    # Wishes

    def take_plan(self, wish: FollowPlan, refusal: str) -> None:
        """Take a plan, or none, from the next cycle on; a refusal is said."""
        plan = wish.plan
        if plan is None and self.wanted_plan is None:
            # There is none to take back: whatever else the robot does goes on.
            return
        if plan is not None and self._stopped_goal is not None:
            if _is_same_goal(plan.poses[-1], self._stopped_goal):
                return
            self._stopped_goal = None
        if plan is not None and refusal:
            self._report.limit = f'the plan is refused: {refusal}'
            return
        self.wanted_plan = plan
        self._pieces = wish.pieces
        self._has_new_plan = True
        self._steering.end()
        self._reason_to_stand = ''

    def take_steering(self, wish: Steer, time: float, refusal: str) -> None:
        """Take a velocity that is wanted from a time [s] on; a refusal is said."""
        if refusal:
            self._report.limit = f'steering is refused: {refusal}'
            return
        self.forget_plan()
        self._reason_to_stand = ''
        self._steering.wish(wish.twist, time)

    def take_gaits(self, wish: ChangeGaits) -> None:
        """Take other gaits, for when the robot is at rest."""
        self._new_gaits = wish

    def stop(self) -> None:
        """Want nothing; a plan to the same goal is no reason to walk again."""
        self.forget_plan()
        self._steering.end()
        self._reason_to_stand = ''

    def forget_plan(self) -> None:
        """Want no plan; a plan to the same goal is no reason to walk again."""
        if self.wanted_plan is not None:
            self._stopped_goal = self.wanted_plan.poses[-1]
            self.wanted_plan = None
            self._has_new_plan = True

    def give_up(self, activity: Activity, reason: str) -> None:
        """Follow the plan no farther, though it is still wanted, and say why."""
        self.halt()
        self._report.say(activity, reason)

    def halt(self) -> None:
        """Follow nothing any more."""
        self._follower.follow(None, _NOWHERE)
        self._steering.end()

    def expire(self) -> None:
        """Let steering time out at once: what was planned for it does not hold."""
        self._steering.expire()

    # Steps

    def use_new_wishes(self, pose: Pose2D) -> None:
        """Go by what was wished for since, at rest."""
        if self._new_gaits is not None:
            is_following = self._follower.plan is not None
            self._take_gaits(self._new_gaits)
            self._new_gaits = None
            self._steering.lose_course()
            if is_following:
                self._follower.follow(self.wanted_plan, pose, self._pieces)
        self.use_new_plan(pose)

    def use_new_plan(self, pose: Pose2D) -> None:
        """Go by a plan that was wished for since."""
        if not self._has_new_plan:
            return
        self._has_new_plan = False
        self._follower.follow(self.wanted_plan, pose, self._pieces)
        self._progress.begin_anew()
        if self._report.activity.is_verdict:
            self._report.say(Activity.STANDING, self.why_standing)
        self._report.limit = ''

    def next_step(self, time: float, pose: Pose2D, odometry: Pose2D, entry: Twist2D) -> Step | None:
        """
        Turn what is wanted into a step.

        Parameters
        ----------
        time : float
            Now [s].
        pose, odometry : Pose2D
            Where the step begins, in the plan's frame and by odometry alone.
        entry : Twist2D
            Speed with which it begins.

        Returns
        -------
        Step or None
            None to stay, or to come to rest; why is said at rest.

        Raises
        ------
        GaitError
            If the plan cannot be followed.
        """
        report = self._report
        if self._steering:
            # A course is kept by odometry: a correction must not steer the robot.
            return self._steer(time, odometry, entry)
        if self._follower.plan is None:
            if not entry and not report.activity.is_verdict:
                report.say(Activity.STANDING, self.why_standing)
            return None
        if self.plan_waits_for:
            if not entry:
                report.say(Activity.WAITING, self.plan_waits_for)
            return None
        step = self._follower.next_step(pose, entry)
        if step is None:
            # Whatever moves the robot from now on, the job is done until a new plan comes.
            self._follower.follow(None, pose)
            self.wanted_plan = self._pieces = None
            report.say(Activity.ARRIVED, 'the goal is reached')
        return step

    # What came of it

    def note_begin(self, state: RobotState, expected: Pose2D) -> None:
        """Note that a motion begins, and where on the plan it is to bring the robot."""
        self._progress.begin(state.pose, state.motion_pose)
        self._expected = expected

    def forget_begin(self) -> None:
        """Expect nothing of what was begun: something else moved the robot."""
        self._progress.forget()

    def lack_of_progress(self, state: RobotState, expected: Pose2D | None = None) -> str | None:
        """Say why the robot is blocked, if it is; expected on the plan now, or at the end."""
        if self._joints.unfollowed > _UNFOLLOWED:
            self._progress.forget()
            return None
        expected = self._expected if expected is None else expected
        return self._progress.problem(state.motion_pose, expected)

    @property
    def why_standing(self) -> str:
        """Reason for which the robot stands, as a sentence."""
        if self._reason_to_stand:
            return self._reason_to_stand
        if self._stopped_goal is not None:
            return 'stopped on request; a plan to another goal makes the robot walk again'
        return 'no plan to follow'

    def say(self, step: Step, motion: BodyMotion, limit: str = '') -> None:
        """Say which step the robot takes, and what keeps it from a larger one."""
        report = self._report
        if not self._steering:
            report.limit = ''
        if limit:
            report.limit = f'a cycle was shortened: {limit}'
        size = math.hypot(motion.forward, motion.left)
        turn = f'turning by {math.degrees(motion.turn):.1f} degrees'
        if step.is_turn or not size > 1e-3:
            report.say(Activity.TURNING, turn)
            return
        turns_too = self._turning != 'in_place' or self._steering
        report.say(
            Activity.WALKING, f'walking {size:.3f} m' + (f' and {turn}' if turns_too else '')
        )

    def _steer(self, time: float, pose: Pose2D, entry: Twist2D) -> Step | None:
        steered = self._steering.next_step(time, pose, entry, self.gait_pair, self.gear)
        self._report.limit = steered.limit
        if not self._steering:
            self._reason_to_stand = steered.reason
        if steered.reason and not entry:
            self._report.say(Activity.STANDING, steered.reason)
        return steered.step

    def _take_gaits(self, wish: ChangeGaits) -> None:
        self.gait_pair = GaitPair(self._robot, wish.gait, wish.turning_gait, self._least_margin)
        """The gaits for walking and for turning."""
        pair = self.gait_pair
        self._turning = wish.follower.turning
        self._follower = PathFollower(pair.walking, pair.turning, wish.follower)


def _is_same_goal(a: Pose2D, b: Pose2D) -> bool:
    return a.distance_to(b) < 1e-3 and abs(wrap_angle(a.yaw - b.yaw)) < 1e-3
