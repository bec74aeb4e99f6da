"""
Has a planning session wait for other robots, and give way to them.

The rule is that of :mod:`quad_planner.traffic.right_of_way`. What it needs to know each robot tells
the others: where it is, and the path that it wants to walk. There is no center, and nobody decides
for another one.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.errors import (
    PlannerError,
    PlannerTimedOut,
    PlanSuperseded,
    QuadError,
    RobotsInTheWay,
)
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_planner.grid.array_types import Points
from quad_planner.methods.planner_options import within
from quad_planner.navigation.remaining_plan import remaining_plan
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.session_ports import Requests
from quad_planner.traffic.blockers import Blockers
from quad_planner.traffic.detour_progress import DetourProgress
from quad_planner.traffic.other_robots import OtherRobots
from quad_planner.traffic.right_of_way import Distances, Duty, duty_towards, is_body_ahead
from quad_planner.traffic.robot_on_map import RobotOnMap, precedes
from quad_planner.traffic.standing_bodies import StandingBodies
from quad_planner.traffic.waiting_place import waiting_place

_PERIOD = 0.2
"""Time between two looks at the traffic [s]."""

_HOPELESS = 120.0
"""Time after which a goal is given up to which robots that stay leave no path [s]."""

_FALLEN = math.radians(30.0)
"""Tilt from which on a robot lies on the ground, as the gait has it [rad]."""

_BLOCKED = 20.0
"""Time for which a body on the path is waited for; then a path around it is looked for [s]."""

_TRIES = 3
"""Looks without a place to give way at, after which a robot goes first."""


_RETRY = 2.0
"""Time for which a robot that gives way stands before a body on its way [s]."""


_UNSEEN, _SLOWEST = 1.0, 0.1
"""Speed of another robot, and of this one, as long as they were not seen to walk [m/s]."""

_LONGEST_ROUTE = 1.0
"""Time that the search for a waiting robot's path may take: the node does nothing else [s]."""

_MOVED = 0.15
"""Distance by which a robot that stands has to move for another route to be planned [m]."""


class Traffic:
    """
    What one robot does because of others.

    Parameters
    ----------
    session : PlanningSession
        Its planning session.
    name : str
        Name of the robot; see :class:`RobotOnMap`.
    radius : float
        Radius of the circle that it needs to stand, as the robot's `standing_radius` [m].
    requests : Requests
        The part that works on searches which are not for the robot.
    room : Distances
        How much room robots leave each other.
    """

    def __init__(
        self,
        session: PlanningSession,
        name: str,
        radius: float,
        requests: Requests,
        room: Distances | None = None,
    ) -> None:
        self._session = session
        session.when_moved = self._follow_map
        self._name = name
        self._radius = radius
        self._room = self._room_at_rest = room or Distances()
        self._others = OtherRobots(name)
        self._blockers = Blockers(session.map, requests)
        self._bodies = StandingBodies()
        self._speeds = self._others.speeds
        self._looked_at = -math.inf
        self._route: Plan | None = None
        self._routed_from: Pose2D | None = None
        self._routed_on: object = None
        self._goal: Pose2D | None = None
        self._refuge: Pose2D | None = None
        self._progress = DetourProgress()
        self._blocked_since = math.inf
        self._lost = 0
        self._stopped_at = -math.inf
        self._in_way: set[str] = set()
        self._hopeless_since = math.inf
        self._has_route = True
        self._has_fallen = False
        self.goes_first = False
        """Whether there is no place to give way at, so that others give way."""

    @property
    def others(self) -> dict[str, RobotOnMap]:
        """Robots that were heard of, by their names."""
        return self._others.robots

    def take_robot(self, time: float, robot: RobotOnMap) -> None:
        """Take what a robot says of itself at a time [s]; see :meth:`OtherRobots.take`."""
        self._others.take(time, robot)

    def forget_robot(self, name: str) -> None:
        """Forget a robot that has left."""
        self._others.forget(name)

    def take_tilt(self, tilt: float) -> None:
        """Take how far the robot's own body is tilted [rad]: one that has fallen says so."""
        self._has_fallen = tilt > _FALLEN

    def own_word(self) -> RobotOnMap | None:
        """Return what others are told; None while the robot does not know where it is."""
        pose = self._session.pose
        if pose is None:
            return None
        path: Points = np.empty((0, 2))
        if self._has_fallen:
            return RobotOnMap(self._name, pose, self._radius, path, has_fallen=True)
        if self._route is not None and self._session.goal is not None:
            path = remaining_plan(self._route, pose).corners
        return RobotOnMap(self._name, pose, self._radius, path, self.goes_first)

    def update(self, time: float) -> None:
        """Look at the traffic at a time [s], if it is time to."""
        if abs(time - self._looked_at) < _PERIOD:
            return
        self._looked_at = time
        self._others.look(time)
        session = self._session
        if session.pose is None or session.goal is None or not session.map.is_ready:
            self._end()
            self._bodies.clear()
            session.map.put_bodies(())
            return
        if session.pending_goal is not None and (session.plan is None or session.is_detour):
            return
        self._speeds.take(self._name, time, session.pose)
        self._room = self._room_at_rest.at(self._speeds.of(self._name, 0.0))
        self._note_route(session.pose, session.goal)
        own = self.own_word()
        assert own is not None
        self._look_at_bodies(time, own)
        if self._route is not None:
            self._do_duty(time, own)
        self._look_whether_it_is_hopeless(time, own)

    def _follow_map(self, before: Pose2D | None) -> None:
        """Go on on a map in another frame, in which that of the map before has a pose."""
        self._others.bring_over(before)
        self._end()

    def _end(self) -> None:
        """Have nothing to do with anybody: the robot wants to go nowhere."""
        self._route = self._refuge = self._goal = None
        self._in_way = set()
        self.goes_first = False
        self._blocked_since = self._hopeless_since = math.inf

    def _note_route(self, pose: Pose2D, goal: Pose2D) -> None:
        """Know the path to the goal, also while the robot waits or is giving way."""
        session = self._session
        if goal is not self._goal:
            self._end()
            self._goal = goal
        if not session.hold_reason:
            self._route, self._routed_from = session.plan, pose
            # A search under way may be for a map that is newer than the plan.
            is_searching = session.pending_goal is not None
            self._routed_on = None if is_searching else session.map.planner.prepared
            self._has_route = session.plan is not None or not _means_no_path(session.problem)
            return
        is_old = self._routed_from is None or pose.distance_to(self._routed_from) > _MOVED
        is_old = is_old or self._routed_on is not session.map.planner.prepared
        if self._refuge is None and (is_old or self._route is None):
            self._plan_route(pose, goal)

    def _plan_route(self, pose: Pose2D, goal: Pose2D) -> bool:
        planner = self._session.map.planner
        self._routed_from, self._routed_on = pose, planner.prepared
        try:
            with within(_LONGEST_ROUTE):
                self._route = planner.plan(pose, goal)
            self._has_route = True
        except PlannerError as error:
            # The path from before still says where the robot wants to go.
            self._has_route = not _means_no_path(error)
        return self._has_route

    def _look_at_bodies(self, time: float, own: RobotOnMap) -> None:
        """Plan around robots that stay where they are."""
        assert self._goal is not None
        session, planner, bodies = self._session, self._session.map.planner, []
        clearance, prepared = planner.clearance_radius, planner.prepared
        assert prepared is not None
        for name, other in sorted(self.others.items()):
            is_settled = self._others.has_settled(name, time)
            is_in_way = time - self._blocked_since > _BLOCKED and self._stops(own, other)
            # A path around a body does not run into it: that is no reason to forget it.
            is_known = self._has_route and self._bodies.holds(other)
            is_in_way = is_in_way or is_known or name in self._in_way
            at_goal = self._goal.distance_to(other.pose) < clearance + other.radius
            if (is_settled or is_in_way) and not at_goal:
                bodies.append(other)
        is_more = self._bodies.place(own.pose, bodies, clearance, prepared.grid.resolution)
        discs = self._bodies.discs
        if not session.map.put_bodies(discs):
            return
        if self._has_route and not is_more and self._routed_on is prepared:
            # There is less in the way than there was: the path keeps off all of it.
            self._routed_on = planner.prepared
            return
        # While the robot waits, its route is planned again at the next look.
        self._routed_from = None
        if session.plan is None and not session.hold_reason:
            session.plan_again()
            return
        near = [distance_to_polyline(disc[:2], own.line) < clearance + disc[2] for disc in discs]
        if any(near) and not session.hold_reason:
            session.plan_on_new_map()

    def _look_whether_it_is_hopeless(self, time: float, own: RobotOnMap) -> None:
        """Give the goal up to which robots that stay have left no path for long."""
        assert self._goal is not None
        session = self._session
        settled = [o for name, o in self.others.items() if self._others.has_settled(name, time)]
        at_goal = session.map.planner.clearance_radius
        near = [o for o in settled if self._goal.distance_to(o.pose) < at_goal + o.radius]
        names: list[str] | None = sorted(o.name for o in near if self._stops(own, o))
        if not names and not self._has_route:
            names = self._blockers.names(own.pose, self._goal, settled)
        if not names:
            # None: it is not known yet.
            self._hopeless_since = self._hopeless_since if names is None else math.inf
            return
        self._hopeless_since = min(self._hopeless_since, time)
        waited = time - self._hopeless_since
        if waited <= _HOPELESS:
            return
        if not self._has_route and self._plan_route(own.pose, self._goal):
            self._hopeless_since = math.inf
            # While it waits, its duty says when it goes on.
            if not session.hold_reason:
                session.plan_again()
            return
        self._end()
        session.give_up_goal(RobotsInTheWay(names, waited))

    def _do_duty(self, time: float, own: RobotOnMap) -> None:
        others = self.others.values()
        waits = bool(self._session.hold_reason)
        before = [other for other in others if precedes(other, own) and not other.is_staying]
        duties = {other.name: self._duty(own, other, waits) for other in before}
        worst = max(duties.values(), default=Duty.NONE)
        names = ', '.join(sorted(name for name, duty in duties.items() if duty is worst))
        if worst is Duty.LEAVE and self._has_fallen:
            self._refuge = None
            self._session.hold('the robot has fallen')
            return
        if worst is Duty.LEAVE and not self.goes_first:
            self._leave(time, own, before, names)
            return
        self._in_way = set()
        if self._refuge is not None:
            # It is off the path: from here on it waits, or goes on.
            self._refuge = None
            self._note_route_again(own)
            return
        self._lost = 0
        if self.goes_first and all(self._duty(own, other, waits) is Duty.NONE for other in others):
            self.goes_first = False
        blocking = sorted(other.name for other in others if self._stops(own, other))
        if not blocking:
            self._blocked_since = math.inf
        if worst is Duty.WAIT:
            self._session.hold(f'waiting for {names} to pass')
        elif blocking:
            self._blocked_since = min(self._blocked_since, time)
            self._session.hold(f'waiting for {", ".join(blocking)} to get out of the way')
        elif waits:
            self._session.resume()

    def _duty(self, own: RobotOnMap, other: RobotOnMap, waits: bool = False) -> Duty:
        faster = self._speeds.of(other.name, _UNSEEN) / self._speeds.of(self._name, _SLOWEST)
        return duty_towards(own, other, self._room, waits, max(1.5, 1.5 * faster))

    def _stops(self, own: RobotOnMap, other: RobotOnMap) -> bool:
        """Return whether a body is on the robot's path: one that leads around it keeps off it."""
        is_around = self._has_route and other.name in self._bodies
        if is_around and self._routed_on is self._session.map.planner.prepared:
            return False
        return is_body_ahead(own, other, self._room)

    def _leave(self, time: float, own: RobotOnMap, before: list[RobotOnMap], names: str) -> None:
        """Go to the nearest place off the others' paths; or stop, if a body is in the way."""
        session = self._session
        reason = f'giving way to {names}'
        refuge = self._refuge
        if 0.0 <= time - self._stopped_at < _RETRY:
            session.hold(reason)
            return
        if refuge is not None and session.is_detour and session.plan is not None:
            at = RobotOnMap(own.name, refuge, own.radius, np.empty((0, 2)))
            is_good = all(self._duty(at, other) is Duty.NONE for other in before)
            way = RobotOnMap(
                own.name, own.pose, own.radius, remaining_plan(session.plan, own.pose).corners
            )
            is_on_way = not self._progress.has_strayed(time, own.pose, session.plan)
            in_way = self._bodies.ahead(way, self.others.values(), self._room)
            if in_way:
                # It lets them pass; if they are still there then, it goes around them.
                self._stopped_at, self._in_way = time, in_way
                session.hold(reason)
                return
            if is_good and is_on_way:
                return
            if not is_on_way:
                refuge = None
        prepared = session.map.planner.prepared
        assert prepared is not None
        bodies = list(self.others.values())
        place = waiting_place(prepared, own, bodies, before, self._room, self._goal)
        if place is None:
            self._refuge = None
            session.hold(f'{reason}, but no free place to wait was found')
            self._lost += 1
            self.goes_first = self._lost >= _TRIES
            return
        self._lost = 0
        if refuge is None or place.distance_to(refuge) > _MOVED or session.plan is None:
            self._refuge = place
            self._progress.begin(time, own.pose)
            session.detour(place, reason)

    def _note_route_again(self, own: RobotOnMap) -> None:
        """Wait at the place that was gone to, and plan from there."""
        assert self._goal is not None
        self._session.hold(self._session.hold_reason or 'waiting')
        self._routed_from = None
        self._note_route(own.pose, self._goal)


def _means_no_path(problem: QuadError | None) -> bool:
    """Return whether a search has ended without a path: one that was cut short has not."""
    return problem is not None and not isinstance(problem, (PlannerTimedOut, PlanSuperseded))
