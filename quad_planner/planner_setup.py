"""
Makes planners and planning sessions as the parameters of ``planner_node`` say.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from quad_common.errors import FileUnusable, ParameterError
from quad_common.files.bounded_file import is_file, user_path
from quad_common.frames.map_frame import MapFrame
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.walking_time import WalkingTimeModel, load_pace
from quad_planner.costs.cell_costs import (
    ClearanceCost,
    CostLayer,
    GroundCost,
    MapCost,
    UnknownCost,
)
from quad_planner.footing.footing import FootedRobot
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.methods.footed_planner import FootingOptions
from quad_planner.methods.outline_planner import OutlineOptions
from quad_planner.methods.planner import METHODS, Planner, make_planner
from quad_planner.outline.arcs import ArcTurns
from quad_planner.outline.robot_outline import outer_radius, outline_from_text, standing_outline
from quad_planner.parameters import PlannerParameters
from quad_planner.session.planning_map import PlanningMap
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.session_ports import Output, Requests
from quad_planner.session.session_state import SessionOptions


def no_clock() -> float:
    """Return no time: searches are not limited by it."""
    return 0.0


def never() -> bool:
    """Return that a search is not superseded."""
    return False


def session_from_parameters(
    parameters: PlannerParameters,
    robot: Robot,
    frame: MapFrame,
    requests: Requests,
    output: Output,
    clock: Callable[[], float] = no_clock,
) -> PlanningSession:
    """
    Make a planning session.

    Parameters
    ----------
    parameters : PlannerParameters
        Parameters of the node.
    robot : Robot
        The robot.
    frame : MapFrame
        Relation of frames to the map's.
    requests : Requests
        The part that works on searches.
    output : Output
        The receiver of decisions.
    clock : callable
        Returns the time that searches are limited by [s].

    Returns
    -------
    PlanningSession
        The session; it has no map yet.
    """
    p = parameters
    planning_map = PlanningMap(
        planner_from_parameters(p, robot, clock, requests.is_superseded),
        frame,
        GroundLimits.of(robot, p.step_height, p.largest_slope, p.footsteps),
        p.obstacle_threshold,
        steps_over_low=p.low_obstacles == 'step_over',
        warn=output.warn,
    )
    planning_map.outline = outline_for(robot, text=p.outline).outline
    return PlanningSession(planning_map, requests, output, _session_options(p))


def _session_options(parameters: PlannerParameters) -> SessionOptions:
    return SessionOptions(parameters.replan_distance, parameters.odom_timeout)


def change_planner(
    session: PlanningSession,
    before: PlannerParameters,
    parameters: PlannerParameters,
    requests: Requests,
    clock: Callable[[], float],
) -> WalkingTimeModel | None:
    """
    Have a session plan by other parameters, from its next plan on.

    That is at once where other cells are free than before: a plan in force may lead over those
    that are not any more.

    Parameters
    ----------
    session : PlanningSession
        The session; it keeps its map, its goal and its plan.
    before : PlannerParameters
        The parameters up to now.
    parameters : PlannerParameters
        The new parameters.
    requests : Requests
        The part that works on searches.
    clock : callable
        Returns the time that searches are limited by [s].

    Returns
    -------
    WalkingTimeModel or None
        The pace of the gait, where it is known.

    Raises
    ------
    QuadError
        If no planner can be made of them; the session goes on as before.
    """
    pace = pace_from_parameters(parameters)
    robot = load_robot(parameters.robot)
    planner = planner_from_parameters(parameters, robot, clock, requests.is_superseded)
    session.map.use(planner, parameters.obstacle_threshold)
    session.map.outline = outline_for(robot, text=parameters.outline).outline
    session.options = _session_options(parameters)
    session.warm_up(clock)
    if session.map.is_ready and _frees_other_cells(before, parameters):
        session.plan_on_new_map()
    return pace


def _frees_other_cells(a: PlannerParameters, b: PlannerParameters) -> bool:
    names = ('safety_distance', 'obstacle_threshold', 'unknown_is_free', 'footprint', 'outline')
    return any(getattr(a, name) != getattr(b, name) for name in (*names, 'turning'))


def planner_for(
    robot: Robot,
    method: str,
    safety_distance: float = PlannerParameters().safety_distance,
    outline: OutlineOptions | None = None,
    **options: Any,
) -> Planner[Any]:
    """
    Make a planner for a robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    method : str
        Name of the planning method.
    safety_distance : float
        Distance kept free around the circle that holds the robot as it stands [m].
    outline : OutlineOptions, optional
        The robot's outline, to plan by it where that is of use.
    **options
        As :func:`~quad_planner.methods.planner.make_planner` takes them.

    Returns
    -------
    Planner
        The planner; it has no map yet.
    """
    radius = max(robot.standing_radius, 0.0 if outline is None else outline.circle_radius)
    return make_planner(
        method,
        outline,
        mesh_size=robot.mesh_size,
        clearance_radius=radius + safety_distance,
        **options,
    )


def outline_for(
    robot: Robot,
    safety_distance: float = PlannerParameters().safety_distance,
    text: str = '',
    **options: Any,
) -> OutlineOptions:
    """
    Take the outline of a robot, or of a robot with its load.

    Parameters
    ----------
    robot : Robot
        The robot.
    safety_distance : float
        Distance that the outline keeps from obstacles [m].
    text : str
        Corners, as of :func:`~quad_planner.outline.robot_outline.outline_from_text`; empty for
        the robot's own outline, standing.
    **options
        The other fields of `OutlineOptions`.

    Returns
    -------
    OutlineOptions
        What :func:`planner_for` takes.

    Raises
    ------
    ParameterError
        If the corners are not valid.
    """
    if not text.strip():
        return OutlineOptions(standing_outline(robot), safety_distance, **options)
    outline = outline_from_text(text)
    return OutlineOptions(outline, safety_distance, circle_radius=outer_radius(outline), **options)


def _outline_from_parameters(
    parameters: PlannerParameters,
    robot: Robot,
    pace: WalkingTimeModel | None,
    start_tolerance: float,
) -> OutlineOptions:
    p = parameters
    return outline_for(
        robot,
        p.safety_distance,
        p.outline,
        start_tolerance=start_tolerance,
        keeps_heading=p.turning == 'crab',
        arcs=ArcTurns(p.corner_deviation, p.corner_radius) if p.turning == 'arc' else None,
        pace=pace,
    )


def planner_from_parameters(
    parameters: PlannerParameters,
    robot: Robot,
    clock: Callable[[], float] = no_clock,
    is_superseded: Callable[[], bool] = never,
) -> Planner[Any]:
    """
    Make a planner.

    Parameters
    ----------
    parameters : PlannerParameters
        Parameters of the node.
    robot : Robot
        The robot.
    clock : callable
        Returns the time that searches are limited by [s].
    is_superseded : callable
        Returns whether the search that asks may end.

    Returns
    -------
    Planner
        The planner; it has no map yet.
    """
    p = parameters
    pace = pace_from_parameters(p)
    tolerance = p.start_tolerance
    if tolerance < 0.0:
        tolerance = start_tolerance(p.safety_distance, pace)
    by_outline = _outline_from_parameters(p, robot, pace, tolerance)
    return planner_for(
        robot,
        p.method,
        p.safety_distance,
        by_outline if p.footprint == 'outline' else None,
        footing=FootingOptions(FootedRobot.of(robot, p.footsteps), by_outline)
        if p.footing == 'check'
        else None,
        pace=pace,
        any_angle=p.any_angle,
        fewest_turns=p.fewest_turns,
        potential=p.potential,
        influence=p.influence,
        path_deviation=p.path_deviation,
        start_tolerance=tolerance,
        occupied_threshold=p.obstacle_threshold,
        unknown_is_free=p.unknown_is_free,
        time_limit=p.planning_timeout,
        clock=clock,
        costs=_costs(p),
        is_superseded=is_superseded,
    )


def start_tolerance(safety_distance: float, pace: WalkingTimeModel | None) -> float:
    """
    Say by how much a start may be nearer to obstacles than the path.

    Parameters
    ----------
    safety_distance : float
        Distance that the footprint keeps from obstacles [m].
    pace : WalkingTimeModel or None
        The gait's pace; None where it is not known.

    Returns
    -------
    float
        What the gait leaves of the safety distance when the robot sways and turns where it
        stands [m].
    """
    return max(0.0, safety_distance - (pace.sweep if pace else 0.0))


def pace_from_parameters(parameters: PlannerParameters) -> WalkingTimeModel | None:
    """Load the gait's pace, which only ``quickest`` cannot do without."""
    try:
        return load_pace(parameters.robot, parameters.gait)
    except ParameterError:
        if parameters.method == 'quickest':
            raise
        _check_gait(parameters)
        return None


def _check_gait(parameters: PlannerParameters) -> None:
    """Refuse what is neither the name of a gait nor a file."""
    known = {*load_robot(parameters.robot).gaits, PlannerParameters().gait}
    valid = f'one of {", ".join(sorted(known))}, or the path of a gait file'
    try:
        if parameters.gait in known or is_file(user_path(parameters.gait)):
            return
    except FileUnusable as error:
        raise ParameterError('gait', parameters.gait, f'{valid} ({error.reason})') from error
    raise ParameterError('gait', parameters.gait, valid)


def _costs(parameters: PlannerParameters) -> tuple[CostLayer, ...]:
    layers: list[CostLayer] = []
    if parameters.unknown_cost > 1.0:
        layers.append(UnknownCost(parameters.unknown_cost))
    if parameters.clearance_cost > 1.0:
        layers.append(ClearanceCost(parameters.clearance_cost, parameters.clearance_cost_distance))
    if max(parameters.roughness_cost, parameters.slope_cost) > 1.0:
        layers.append(GroundCost(parameters.roughness_cost, parameters.slope_cost))
    if parameters.map_values == 'costmap' and _takes_costs(parameters):
        layers.append(MapCost(parameters.map_cost))
    return tuple(layers)


def unheeded_costs(parameters: PlannerParameters) -> str:
    """Return that the method heeds no costs of a costmap, as a sentence; empty if it does."""
    if parameters.map_values != 'costmap' or _takes_costs(parameters):
        return ''
    return (
        f"map_values is 'costmap', but method '{parameters.method}' ignores costs and avoids only "
        "lethal cells (100); to use costs, set method to 'shortest' or 'quickest', or to "
        "'potential' with potential 'navigation'"
    )


def _takes_costs(parameters: PlannerParameters) -> bool:
    """Return whether the method compares paths by costs; others go by the obstacles alone."""
    is_any_potential = parameters.method == 'potential' and parameters.potential != 'navigation'
    return bool(getattr(METHODS[parameters.method], 'knows_costs', False)) and not is_any_potential
