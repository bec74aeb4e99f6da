"""
Has a planning session wait for other robots, and give way to them.

The rule is that of :mod:`quad_planner.traffic.right_of_way`. What it needs to know each robot tells
the others: where it is, and the path that it wants to walk. There is no center, and nobody decides
for another one.
"""

from __future__ import annotations

import contextlib
import math

import numpy as np

from quad_common.errors import PlannerError, RobotLeftOut
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_planner.grid.array_types import Points
from quad_planner.navigation.remaining_plan import remaining_plan
from quad_planner.session.planning_session import PlanningSession
from quad_planner.traffic.right_of_way import Distances, Duty, duty_towards, is_body_ahead
from quad_planner.traffic.robot_on_map import RobotOnMap, precedes
from quad_planner.traffic.speeds import Speeds
from quad_planner.traffic.waiting_place import waiting_place

_PERIOD = 0.2
"""Time between two looks at the traffic [s]."""

_FORGOTTEN = 10.0
"""Time without a word after which a robot is taken to be gone [s]."""

_SETTLED = 5.0
"""Time after which a robot that wants to go nowhere is an obstacle that paths lead around [s]."""

_BLOCKED = 20.0
"""Time for which a body on the path is waited for; then a path around it is looked for [s]."""

_TRIES = 3
"""Looks without a place to give way at, after which a robot goes first."""

_STRAYED = 0.2
"""Distance from the path to its place from which on a robot that gives way plans again [m]."""

_RETRY = 2.0
"""Time for which a robot that gives way stands before a body on its way [s]."""

_STUCK = 4.0
"""Time without a movement after which it does so, too [s]."""

_STEP, _TURN = 0.02, 0.05
"""Least movement [m, rad]."""

_UNSEEN, _SLOWEST = 1.0, 0.1
"""Speed of another robot, and of this one, as long as they were not seen to walk [m/s]."""

_MOVED = 0.15
"""Distance by which a robot that stands has to move for another route to be planned [m]."""

MOST_ROBOTS = 64
"""Number of other robots that are reckoned with."""


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
        Radius of the circle that holds its feet [m].
    room : Distances
        How much room robots leave each other.
    """

    def __init__(
        self, session: PlanningSession, name: str, radius: float, room: Distances | None = None
    ) -> None:
        self._session = session
        self._name = name
        self._radius = radius
        self._room = self._room_at_rest = room or Distances()
        self._speeds = Speeds()
        self._others: dict[str, tuple[float, RobotOnMap]] = {}
        self._staying: dict[str, float] = {}
        self._looked_at = -math.inf
        self._route: Plan | None = None
        self._routed_from: Pose2D | None = None
        self._goal: Pose2D | None = None
        self._refuge: Pose2D | None = None
        self._moved = (-math.inf, Pose2D(0.0, 0.0, 0.0))
        self._blocked_since = math.inf
        self._lost = 0
        self._stopped_at = -math.inf
        self._in_way: set[str] = set()
        self.goes_first = False
        """Whether there is no place to give way at, so that others give way."""

    @property
    def others(self) -> dict[str, RobotOnMap]:
        """Robots that were heard of, by their names."""
        return {name: robot for name, (_, robot) in self._others.items()}

    def take_robot(self, time: float, robot: RobotOnMap) -> None:
        """
        Take what another robot says of itself at a time [s]; one's own word is left out.

        Raises
        ------
        RobotLeftOut
            If as many as can be are known already.
        """
        if robot.name == self._name:
            return
        if robot.name not in self._others and len(self._others) >= MOST_ROBOTS:
            raise RobotLeftOut(robot.name, MOST_ROBOTS)
        self._others[robot.name] = time, robot
        self._speeds.take(robot.name, time, robot.pose)
        if robot.is_staying:
            self._staying.setdefault(robot.name, time)
        else:
            self._staying.pop(robot.name, None)

    def forget_robot(self, name: str) -> None:
        """Forget a robot that has left."""
        self._others.pop(name, None)
        self._staying.pop(name, None)
        self._speeds.forget(name)

    def own_word(self) -> RobotOnMap | None:
        """Return what others are told; None while the robot does not know where it is."""
        pose = self._session.pose
        if pose is None:
            return None
        path: Points = np.empty((0, 2))
        if self._route is not None and self._session.goal is not None:
            path = remaining_plan(self._route, pose).corners
        return RobotOnMap(self._name, pose, self._radius, path, self.goes_first)

    def update(self, time: float) -> None:
        """Look at the traffic at a time [s], if it is time to."""
        if abs(time - self._looked_at) < _PERIOD:
            return
        self._looked_at = time
        # Time goes back when a simulator is started again.
        gone = [n for n, (at, _) in self._others.items() if not 0.0 <= time - at <= _FORGOTTEN]
        for name in gone:
            self.forget_robot(name)
        session = self._session
        if session.pose is None or session.goal is None or not session.map.is_ready:
            self._end()
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

    def _end(self) -> None:
        """Have nothing to do with anybody: the robot wants to go nowhere."""
        self._route = self._refuge = self._goal = None
        self._in_way = set()
        self.goes_first = False
        self._blocked_since = math.inf

    def _note_route(self, pose: Pose2D, goal: Pose2D) -> None:
        """Know the path to the goal, also while the robot waits or is giving way."""
        session = self._session
        if goal is not self._goal:
            self._end()
            self._goal = goal
        if not session.hold_reason:
            self._route, self._routed_from = session.plan, pose
            return
        is_old = self._routed_from is None or pose.distance_to(self._routed_from) > _MOVED
        if self._refuge is None and (is_old or self._route is None):
            self._routed_from = pose
            # Without one the path from before still says where the robot wants to go.
            with contextlib.suppress(PlannerError):
                self._route = session.map.planner.plan(pose, goal)

    def _look_at_bodies(self, time: float, own: RobotOnMap) -> None:
        """Plan around robots that stay where they are."""
        assert self._goal is not None
        session, bodies = self._session, []
        clearance = session.map.planner.clearance_radius
        for name, (_, other) in sorted(self._others.items()):
            is_settled = time - self._staying.get(name, time) > _SETTLED
            is_in_way = time - self._blocked_since > _BLOCKED and self._stops(own, other)
            is_in_way = is_in_way or name in self._in_way
            at_goal = self._goal.distance_to(other.pose) < clearance + other.radius
            if (is_settled or is_in_way) and not at_goal:
                # The robot itself stays free, however near it stands.
                apart = own.pose.distance_to(other.pose)
                radius = min(other.radius, apart - clearance - 0.02)
                bodies.append((round(other.pose.x, 1), round(other.pose.y, 1), round(radius, 2)))
        bodies = [body for body in bodies if body[2] > 0.0]
        if not session.map.put_bodies(tuple(bodies)):
            return
        # While the robot waits, its route is planned again at the next look.
        self._routed_from = None
        if session.plan is None and not session.hold_reason:
            session.plan_again()
            return
        near = [distance_to_polyline(body[:2], own.line) < clearance + body[2] for body in bodies]
        if any(near) and not session.hold_reason:
            session.plan_on_new_map()

    def _do_duty(self, time: float, own: RobotOnMap) -> None:
        others = self.others.values()
        waits = bool(self._session.hold_reason)
        before = [other for other in others if precedes(other, own) and not other.is_staying]
        duties = {other.name: self._duty(own, other, waits) for other in before}
        worst = max(duties.values(), default=Duty.NONE)
        names = ', '.join(sorted(name for name, duty in duties.items() if duty is worst))
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
            is_on_way = not self._strays(time, own.pose, session.plan)
            in_way = {other.name for other in self.others.values() if self._stops(way, other)}
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
            session.hold(f'{reason}, and there is no place for it')
            self._lost += 1
            self.goes_first = self._lost >= _TRIES
            return
        self._lost = 0
        if refuge is None or place.distance_to(refuge) > _MOVED or session.plan is None:
            self._refuge = place
            self._moved = time, own.pose
            session.detour(place, reason)

    def _strays(self, time: float, pose: Pose2D, plan: Plan) -> bool:
        """Return whether the robot is not on its way: beside it, or without a movement."""
        since, last = self._moved
        turned = abs(wrap_angle(pose.yaw - last.yaw))
        if pose.distance_to(last) > _STEP or turned > _TURN:
            self._moved = time, pose
        is_stuck = time - since > _STUCK
        return is_stuck or distance_to_polyline((pose.x, pose.y), plan.corners) > _STRAYED

    def _note_route_again(self, own: RobotOnMap) -> None:
        """Wait at the place that was gone to, and plan from there."""
        assert self._goal is not None
        self._session.hold(self._session.hold_reason or 'waiting')
        self._routed_from = None
        self._note_route(own.pose, self._goal)
