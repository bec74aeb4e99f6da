"""
Experiments: closed loops without topics, walks over topics, benchmarks, and papers drawn again.
"""

from quad_common.lazy_names import lazy_names

TYPE_CHECKING = False

if TYPE_CHECKING:
    from quad_lab.closed_loop.direct_walk import DirectWalk as DirectWalk
    from quad_lab.closed_loop.direct_walk import Record as Record
    from quad_lab.closed_loop.gait_measures import PlanWalk as PlanWalk
    from quad_lab.closed_loop.gait_measures import SteadyWalk as SteadyWalk
    from quad_lab.closed_loop.gait_measures import make_controller as make_controller
    from quad_lab.closed_loop.gait_measures import plan_walk as plan_walk
    from quad_lab.closed_loop.gait_measures import steady_walk as steady_walk
else:
    __getattr__, __dir__, __all__ = lazy_names(
        __name__,
        {
            'quad_lab.closed_loop.direct_walk': ('DirectWalk', 'Record'),
            'quad_lab.closed_loop.gait_measures': (
                'PlanWalk',
                'SteadyWalk',
                'make_controller',
                'plan_walk',
                'steady_walk',
            ),
        },
    )
