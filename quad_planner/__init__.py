"""
Planning: from a map, a start and a goal to the turning points of a walk.

Obstacles get a boundary at the safety distance (S0 section 3). Within what is left the
shortest path is found: over a mesh as wide as the robot needs for its turns, by Dijkstra's
algorithm, over the cells of the map, or at any angle.
"""

from quad_common.lazy_names import lazy_names

TYPE_CHECKING = False

if TYPE_CHECKING:
    from quad_planner.costs.cell_costs import ClearanceCost as ClearanceCost
    from quad_planner.costs.cell_costs import UnknownCost as UnknownCost
    from quad_planner.methods.planner import Planner as Planner
    from quad_planner.methods.planner import PlanningMethod as PlanningMethod
    from quad_planner.methods.planner import make_planner as make_planner
    from quad_planner.planner_setup import planner_for as planner_for
else:
    __getattr__, __dir__, __all__ = lazy_names(
        __name__,
        {
            'quad_planner.planner_setup': ('planner_for',),
            'quad_planner.methods.planner': ('Planner', 'PlanningMethod', 'make_planner'),
            'quad_planner.costs.cell_costs': ('ClearanceCost', 'UnknownCost'),
        },
    )
