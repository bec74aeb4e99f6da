"""
What a planning session is doing, or what it waits for, as a status.
"""

from __future__ import annotations

from typing import NamedTuple

from quad_common.errors import QuadError
from quad_common.plan import Plan
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_common.status import Level, Status
from quad_planner.methods.outline_planner import BY_OUTLINE
from quad_planner.parameters import PlannerParameters
from quad_planner.session.planning_session import PlanningSession


class SessionProblems(NamedTuple):
    """What is wrong around a session, as sentences; empty where nothing is."""

    old_correction: str = ''
    """That corrections of odometry have grown old."""
    lost_gait: str = ''
    """That the gait node that followed plans is gone."""
    refused_map: str = ''
    """Why the last map was refused."""
    namesake: str = ''
    """That another planner speaks for a robot of the same name."""


NO_PROBLEMS = SessionProblems()
"""Nothing is wrong."""


def session_status(
    session: PlanningSession,
    parameters: PlannerParameters,
    pace: WalkingTimeModel | None,
    problems: SessionProblems = NO_PROBLEMS,
) -> Status | QuadError:
    """
    Return what a session does, or what it waits for.

    Parameters
    ----------
    session : PlanningSession
        The session.
    parameters : PlannerParameters
        Parameters of its node.
    pace : WalkingTimeModel or None
        Times of the gait, for the time that a plan takes.
    problems : SessionProblems
        What is wrong around the session.

    Returns
    -------
    Status or QuadError
        The error if the last goal was refused.
    """
    topic, goal = parameters.odom_topic, session.pending_goal
    if session.problem is not None:
        # First: an earlier goal may be searched meanwhile, or searches compile.
        return session.problem
    if not session.map.is_ready:
        if problems.refused_map:
            return Status(
                Level.ERROR, f"no map: the one on 'map' is refused: {problems.refused_map}"
            )
        return Status(Level.WARN, "no map: waiting for one on 'map'", is_waiting=True)
    if session.is_busy and goal is None:
        return Status(
            Level.OK, 'getting the searches ready: once after an installation they compile'
        )
    if goal is not None:
        return Status(Level.OK, f'searching a path to ({goal.x:.2f}, {goal.y:.2f}) m')
    if not session.has_pose:
        return Status(Level.WARN, f"no odometry: waiting for it on '{topic}'", is_waiting=True)
    if session.silence:
        return Status(
            Level.WARN,
            f"silent odometry: none on '{topic}' for {session.silence:.0f} s; "
            'plans wait for the robot to say where it is',
        )
    if problems.namesake:
        return Status(Level.WARN, problems.namesake)
    if problems.old_correction:
        return Status(Level.WARN, f'old localisation: {problems.old_correction}')
    if session.hold_reason:
        return Status(Level.OK, session.hold_reason)
    if session.plan is None:
        return Status(Level.OK, "ready: waiting for a goal on 'goal_pose'")
    values = {'error_code': 0, 'footprint': footprint_of(session.plan)}
    described = _described(session, session.plan, parameters.gait, pace)
    if problems.lost_gait and not session.has_ended:
        return Status(Level.WARN, f'{described}; {problems.lost_gait}', values)
    return Status(Level.OK, described, values)


def footprint_of(plan: Plan) -> str:
    """Return by which footprint a plan was made: ``circle`` or ``outline``."""
    return 'outline' if plan.remark == BY_OUTLINE else 'circle'


def _described(
    session: PlanningSession, plan: Plan, gait: str, pace: WalkingTimeModel | None
) -> str:
    text = f'plan of {len(plan.poses)} turning points, {plan.length:.2f} m'
    if footprint_of(plan) == 'outline':
        text += ', by the outline'
    if session.planned_from is not None and pace is not None:
        text += f', {pace.walking_time(session.planned_from, plan):.0f} s to walk ({gait})'
    return f'{text}: it has ended' if session.has_ended else text
