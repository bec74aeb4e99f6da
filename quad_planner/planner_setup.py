"""
Makes a planner as the parameters of ``planner_node`` say.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from quad_common.errors import ParameterError
from quad_common.robot.robot import Robot
from quad_common.robot.walking_time import WalkingTimeModel, load_pace
from quad_planner.methods.cell_costs import ClearanceCost, CostLayer, UnknownCost
from quad_planner.methods.planner import Planner, make_planner
from quad_planner.parameters import PlannerParameters


def planner_from_parameters(
    parameters: PlannerParameters,
    robot: Robot,
    pace: WalkingTimeModel | None,
    clock: Callable[[], float],
    is_superseded: Callable[[], bool],
) -> Planner[Any]:
    """
    Make the planner of a node.

    Parameters
    ----------
    parameters : PlannerParameters
        Of the node.
    robot : Robot
        The robot.
    pace : Pace or None
        Of the gait; ``quickest`` needs one.
    clock : callable
        Returns the time that searches are limited by [s].
    is_superseded : callable
        Returns whether the search that asks may end.

    Returns
    -------
    Planner
        Without a map.
    """
    p = parameters
    return make_planner(
        p.method,
        pace=pace,
        mesh_size=robot.mesh_size,
        any_angle=p.any_angle,
        fewest_turns=p.fewest_turns,
        potential=p.potential,
        influence=p.influence,
        path_deviation=p.path_deviation,
        clearance_radius=robot.footprint_radius + p.safety_distance,
        start_tolerance=p.safety_distance,
        occupied_threshold=p.occupied_threshold,
        unknown_is_free=p.unknown_is_free,
        time_limit=p.planning_timeout,
        clock=clock,
        costs=_costs(p),
        is_superseded=is_superseded,
    )


def pace_from_parameters(parameters: PlannerParameters) -> WalkingTimeModel | None:
    """Load the gait's pace, which only ``quickest`` cannot do without."""
    try:
        return load_pace(parameters.robot, parameters.gait)
    except ParameterError:
        if parameters.method == 'quickest':
            raise
        return None


def _costs(parameters: PlannerParameters) -> tuple[CostLayer, ...]:
    layers: list[CostLayer] = []
    if parameters.unknown_cost > 1.0:
        layers.append(UnknownCost(parameters.unknown_cost))
    if parameters.clearance_cost > 1.0:
        layers.append(ClearanceCost(parameters.clearance_cost, parameters.clearance_cost_distance))
    return tuple(layers)
