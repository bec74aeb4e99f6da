"""
What is planned, and when: as maps, goals, the robot's pose and the plan it follows change.

The session knows no topics and no clock. Its node tells it what was received, and publishes what it
decides; searches run wherever the requests are worked on.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from quad_common.errors import PlannerError, without_frames
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_planner.session.given_goal import GivenGoal, GoalEnd
from quad_planner.session.own_plans import Followed, OwnPlans
from quad_planner.session.planning_map import PlanningMap
from quad_planner.session.session_maps import SessionMaps
from quad_planner.session.session_ports import Output, Requests
from quad_planner.session.session_state import GoalWish, SessionOptions

_TAKEN_OVER = (
    'the robot is on its way to ({goal.x:.2f}, {goal.y:.2f}) m by a plan from before this planner '
    'began: that goal is taken over'
)

_FOLLOWS_ANOTHER = 'the robot follows a plan that another node published'

_CHECK_PERIOD = 0.2
"""Time between two checks whether the robot has left its path [s]."""

_ARRIVED = 0.1
"""Distance from the goal within which a robot whose plan has ended has arrived [m]."""

_ARRIVED_TURN = 0.2
"""Angle from the goal's heading within which it has [rad]."""

_LONG = 3.0
"""Time in which compiled searches are ready at the latest [s]."""


class PlanningSession(SessionMaps):
    """
    Plans when a goal comes, when a map changes, and when the robot leaves its path.

    Parameters
    ----------
    planning_map : PlanningMap
        The map, and the planning method that works on it.
    requests : Requests
        The part that works on searches.
    output : Output
        The receiver of decisions.
    options : SessionOptions
        Conditions under which to plan.
    """

    def __init__(
        self,
        planning_map: PlanningMap,
        requests: Requests,
        output: Output,
        options: SessionOptions,
    ) -> None:
        super().__init__(planning_map, requests, options)
        self._output = output
        self._checked_at, self._is_plan_void = 0.0, False
        self._given, self._own, self._is_new = GivenGoal(), OwnPlans(), True

    def plan_on_new_map(self) -> None:
        """Show the map, and plan on it to the goal in force."""
        self.problem = None
        assert self.map.planner.prepared is not None
        self._output.show_map(self.map.planner.prepared)
        wish = self._pending
        if wish is None and self._goal is not None:
            wish = GoalWish(self.map.frame.name, self._goal, is_given=False)
        if self.hold_reason and not (wish and wish.is_given):
            # A path to give way by is no longer known to be free.
            self.hold(self.hold_reason)
        elif self._waiting is None and wish is not None and self._pose is not None:
            self._search(wish, is_plan_void=True)
        self._try_waiting_goal()
        self._output.update_status()

    # Goals

    def give_goal(self, frame: str, goal: Pose2D) -> GivenGoal:
        """Plan to a goal as soon as map and pose are known; return what will become of it."""
        self._is_new = False
        self._given.conclude(GoalEnd.REPLACED, 'a newer goal has taken its place')
        self._given = given = GivenGoal()
        self.hold_reason, self.problem = '', None
        self.map.open_all()
        self._waiting = GoalWish(frame, goal, is_given=True)
        self._try_waiting_goal()
        self._output.update_status()
        return given

    def withdraw_goal(self) -> None:
        """Give up the goal in force, and what is planned: the robot stands."""
        self._waiting = self._goal = self._void_at = None
        self.hold_reason = ''
        self._give_up_search()
        self._own.begin_goal()
        self._given.conclude(GoalEnd.WITHDRAWN, 'it was withdrawn')
        if self.plan is not None:
            self._publish(None)
        self._output.update_status()

    def give_up_goal(self, error: PlannerError) -> None:
        """Give up the goal in force for a reason, which is said: the robot stands."""
        self._given.conclude(GoalEnd.REFUSED, str(error), error)
        self.problem = error
        self.withdraw_goal()

    def plan_again(self) -> None:
        """Plan to the goal in force from where the robot is, unless that is under way."""
        if self._goal is not None and self._pending is None:
            self._search(GoalWish(self.map.frame.name, self._goal, is_given=False))

    # Other robots

    def hold(self, reason: str) -> None:
        """Stand, and keep the goal, until :meth:`resume`; the reason is a sentence's end."""
        is_news, self.hold_reason = reason != self.hold_reason, reason
        if self._pending is not None and not self._pending.is_given:
            self._give_up_search()
        if self.plan is not None:
            self._publish(None)
        if is_news:
            self._output.update_status()

    def detour(self, place: Pose2D, reason: str) -> None:
        """Go to a place, and keep the goal, until :meth:`resume`; reasons as of :meth:`hold`."""
        if self._pending is not None or not self.is_detour:
            self.hold(reason)
        if self._pending is not None:
            # A goal that was just given is not given up for it.
            return
        self.hold_reason = reason
        self._search(GoalWish(self.map.frame.name, place, is_given=False, is_detour=True))
        self._output.update_status()

    def resume(self) -> None:
        """Go on to the goal in force."""
        self.hold_reason = ''
        self.plan_again()

    def _try_waiting_goal(self) -> None:
        """Plan to the goal that came last, as soon as map and pose are known."""
        wish = self._waiting
        if wish is None or not self.map.is_ready or self._pose is None or self.silence:
            return
        self._waiting = None
        try:
            goal = self.map.pose_on_map(wish.frame, wish.goal, 'goal')
        except PlannerError as error:
            self._refuse(wish, error)
            return
        self._search(GoalWish(self.map.frame.name, goal, wish.is_given))

    def _refuse(self, wish: GoalWish, error: PlannerError) -> None:
        self.problem = problem = without_frames(error)
        if wish.is_given:
            self._given.conclude(GoalEnd.REFUSED, str(problem), problem)
            if self.plan is None and self._void_at is None:
                # It waited for other robots, on its way to the goal that stays.
                self.plan_again()

    # The robot

    def take_pose(self, time: float, pose: Pose2D) -> None:
        """Take where base_link is in the map at a time [s]; look whether it has left its path."""
        is_first, was_silent = self._pose is None, bool(self.silence)
        self._pose = pose
        self._age.receive(time)
        if is_first or was_silent:
            self._try_waiting_goal()
            self._output.update_status()
        if self._pending is None and abs(time - self._checked_at) >= _CHECK_PERIOD:
            self._checked_at = time
            self._look_where_it_is(pose)

    def take_impassable(self, frame: str, place: Pose2D) -> None:
        """Plan again, around where the robot, heading there, found no footing."""
        if self._goal is None or not self.map.close_ahead(frame, place):
            return
        if self.hold_reason:
            self.hold(self.hold_reason)
        else:
            self._output.say('the robot finds no footing on its path: planning another one')
            self._search(GoalWish(self.map.frame.name, self._goal, is_given=False))

    def _look_where_it_is(self, pose: Pose2D) -> None:
        """Plan again for a robot that has left its path, if it is still to get to its goal."""
        farthest = self.options.replan_distance
        if self.hold_reason:
            return
        if self.plan is None:
            # Its plan was taken back, for the map left no path: until then the robot stands.
            if self._void_at is not None and pose.distance_to(self._void_at) > farthest:
                self._output.say('the robot was moved meanwhile: its goal is given up')
                self._given.conclude(GoalEnd.ENDED, 'the robot was moved meanwhile')
                self._goal = self._void_at = None
                self.hold_reason = ''
            return
        distance = distance_to_polyline((pose.x, pose.y), self.plan.corners)
        if distance <= farthest:
            return
        if self._goal is not None:
            self._output.say(f'the robot is {distance:.2f} m from its path: planning again')
            self._search(GoalWish(self.map.frame.name, self._goal, is_given=False))
        else:
            # A late subscriber must not walk to it again.
            self._publish(None)

    def tick(self, wall: float, clock: float) -> None:
        """Let time go on: the wall clock's, and that of the node [s]."""
        was_silent = bool(self.silence)
        self._age.tick(wall, clock)
        if bool(self.silence) != was_silent:
            self._output.update_status()

    def take_followed(self, stamp: int, frame: str, plan: Plan | None) -> None:
        """
        Take note of the plan that the robot wants to follow.

        Parameters
        ----------
        stamp : int
            Of that plan, or the one that has ended; after a stop of what came last as one [ns].
        frame : str
            Of the plan; empty if the robot was stopped.
        plan : Plan or None
            None: the plan of that stamp has ended.
        """
        followed = self._own.judge(stamp, plan is None, was_stopped=plan is None and not frame)
        if followed is Followed.STOPPED:
            self._stop()
        elif followed is Followed.GOAL_ENDED:
            self._end_goal()
        if plan is None or followed is not Followed.FOREIGN:
            return
        if self._is_new:
            self._is_new = False
            goal = plan.poses[-1]
            self._output.say(_TAKEN_OVER.format(goal=goal))
            self._own.add(stamp)
            self._waiting = GoalWish(frame, goal, is_given=False)
            self._try_waiting_goal()
            self._output.update_status()
        elif self._goal is not None and self._pending is None:
            self._output.say(f'{_FOLLOWS_ANOTHER}: the goal given to this planner is dropped')
            self._given.conclude(GoalEnd.ENDED, _FOLLOWS_ANOTHER)
            self._goal, self.hold_reason = None, ''
            self._output.update_status()

    def _stop(self) -> None:
        """Give up the goal in force, and one that is searched: the robot was stopped."""
        if any((self._goal, self._waiting, self._pending)):
            self._output.say('the robot was stopped: its goal is given up')
        self._given.conclude(GoalEnd.ENDED, 'the robot was stopped')
        # What is published takes its last plan back: the same goal may be given again.
        self.withdraw_goal()

    def _end_goal(self) -> None:
        """Plan no more, whatever moves the robot, until a new goal comes."""
        goal, self._goal, self.hold_reason = self._goal, None, ''
        self._own.begin_goal()
        if self._waiting is not None and not self._waiting.is_given:
            self._waiting = None
        if self._pending is not None and not self._pending.is_given:
            # It was planned to again: the answer is not wanted any more.
            self._give_up_search()
        has_arrived = goal is not None and self._pose is not None and _is_at(self._pose, goal)
        if not any(wish and wish.is_given for wish in (self._waiting, self._pending)):
            end = GoalEnd.ARRIVED if has_arrived else GoalEnd.ENDED
            self._given.conclude(end, 'the robot does not follow its plan any more')
        if self.plan is not None and not has_arrived and self._pending is None:
            # A late subscriber must not walk to it again.
            self._publish(None)
        self._output.update_status()

    # Searches

    def warm_up(self, clock: Callable[[], float]) -> None:
        """Get the searches ready; one that is under way is not given up for it."""
        if not self.is_busy:
            warm_up = partial(self.map.warm_up, clock)
            self._requests.submit(warm_up, partial(_note_warm, self._output))

    def _search(self, wish: GoalWish, is_plan_void: bool = False) -> None:
        """
        Begin to search a plan; searches before it are given up.

        If it fails the last goal and plan stay, unless the plan led through a map that is
        no longer true: then it is taken back.
        """
        self._is_plan_void = self._is_plan_void or is_plan_void
        if self.silence:
            # Where the robot is now is not known: the plan waits for its pose.
            self._give_up_search()
            self._waiting = wish
            return
        assert self._pose is not None
        self._pending, start, goal = wish, self._pose, wish.goal
        receive = partial(self._on_result, start, wish)
        self._requests.submit(self.map.search(start, goal, start), receive)

    def _on_result(self, start: Pose2D, wish: GoalWish, result: Callable[[], Plan]) -> None:
        self._pending = None
        try:
            plan = result()
        except PlannerError as error:
            if not wish.is_detour:
                self._refuse(wish, error)
            if self._is_plan_void or wish.is_detour:
                self._publish(None)
                self._void_at = None if wish.is_detour else start
        else:
            if wish.is_given:
                self._own.begin_goal()
            self.planned_from = start
            self._goal = self._goal if wish.is_detour else wish.goal
            self._void_at = None
            self.problem = None
            if plan.remark:
                self._output.say(plan.remark)
            self._publish(plan, is_to_goal=not wish.is_detour)
        self._is_plan_void = False
        self._output.update_status()

    def _publish(self, plan: Plan | None, is_to_goal: bool = True) -> None:
        self.plan, self.is_detour = plan, not is_to_goal
        stamp = self._output.publish_plan(plan)
        if plan is None:
            self._own.take_back(stamp)
        else:
            self._own.add(stamp, is_to_goal)


def _note_warm(output: Output, result: Callable[[], float]) -> None:
    """Say how long it took to compile the searches, if it did."""
    took = result()
    if took > _LONG:
        output.say(f'the searches were compiled in {took:.0f} s; they are kept')
    output.update_status()


def _is_at(pose: Pose2D, goal: Pose2D) -> bool:
    turn = abs(wrap_angle(pose.yaw - goal.yaw))
    return pose.distance_to(goal) <= _ARRIVED and turn <= _ARRIVED_TURN
