"""
Experiments: closed loops without topics, walks over topics, benchmarks, and papers drawn again.
"""

from quad_common.lazy_names import lazy_names

TYPE_CHECKING = False

if TYPE_CHECKING:
    from quad_lab.closed_loop.closed_loop import ClosedLoop as ClosedLoop
    from quad_lab.closed_loop.controllers import controller_for as controller_for
    from quad_lab.closed_loop.controllers import measuring_controller as measuring_controller
    from quad_lab.closed_loop.gait_measures import PlanWalk as PlanWalk
    from quad_lab.closed_loop.gait_measures import SteadyWalk as SteadyWalk
    from quad_lab.closed_loop.gait_measures import plan_walk as plan_walk
    from quad_lab.closed_loop.gait_measures import steady_walk as steady_walk
    from quad_lab.closed_loop.loop_record import Record as Record
else:
    __getattr__, __dir__, __all__ = lazy_names(
        __name__,
        {
            'quad_lab.closed_loop.closed_loop': ('ClosedLoop',),
            'quad_lab.closed_loop.loop_record': ('Record',),
            'quad_lab.closed_loop.controllers': ('controller_for', 'measuring_controller'),
            'quad_lab.closed_loop.gait_measures': (
                'PlanWalk',
                'SteadyWalk',
                'plan_walk',
                'steady_walk',
            ),
        },
    )
