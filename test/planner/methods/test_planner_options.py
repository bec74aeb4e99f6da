"""What every planning method has to honour."""

import math

import numba
import numpy as np
import pytest

from quad_common.errors import PlannerTimedOut, PlanSuperseded
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.methods.planner import METHODS, make_planner
from quad_planner.methods.planner_options import PlannerOptions, within

CRAWL = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2))


def attempt(method, any_angle, **options):
    """Plan over a floor that is large and full enough for a search that takes its time."""
    cells = np.zeros((300, 300), dtype=np.int8)
    cells[np.random.default_rng(1).random(cells.shape) < 0.003] = 100
    cells[:20, :20] = cells[-20:, -20:] = 0
    planner = make_planner(
        method, mesh_size=0.1, clearance_radius=0.1, pace=CRAWL, any_angle=any_angle, **options
    )
    planner.set_map(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)))
    return planner.plan(Pose2D(0.4, 0.4, 0.0), Pose2D(14.6, 14.6, 0.0))


@pytest.mark.parametrize('method', sorted(METHODS))
@pytest.mark.parametrize('any_angle', [False, True])
def test_a_search_ends_when_nobody_waits_for_it(method, any_angle):
    assert attempt(method, any_angle).length > 15.0
    with pytest.raises(PlanSuperseded, match='a newer request'):
        attempt(method, any_angle, is_superseded=lambda: True)


@pytest.mark.usefixtures('nothing_is_compiled')
@pytest.mark.parametrize('method', sorted(METHODS))
def test_a_search_ends_at_its_limit(method):
    ticks = iter(range(10**6))
    with pytest.raises(PlannerTimedOut, match=r'limit of 0\.50 s'):
        attempt(method, False, time_limit=0.5, clock=lambda: float(next(ticks)))


@pytest.mark.usefixtures('nothing_is_compiled')
@pytest.mark.parametrize('method', sorted(METHODS))
def test_who_asks_may_wait_for_less_time_than_the_limit(method):
    ticks = iter(range(10**6))
    options = {'time_limit': 1e9, 'clock': lambda: float(next(ticks))}
    with within(0.5), pytest.raises(PlannerTimedOut, match=r'limit of 0\.50 s'):
        attempt(method, False, **options)
    assert attempt(method, False, **options).length > 15.0


def test_time_in_which_something_is_compiled_counts_for_nothing():
    now = 100.0
    check = PlannerOptions(clearance_radius=0.2, time_limit=5.0, clock=lambda: now).timer()
    now += 4.0
    check()
    numba.njit(lambda number: number + 1)(1)
    now += 30.0
    check()
    now += 0.9
    check()
    now += 0.2
    with pytest.raises(PlannerTimedOut, match=r'limit of 5\.00 s'):
        check()


@pytest.mark.parametrize('method', sorted(METHODS))
def test_warming_up_plans_and_leaves_no_map_behind(method, monkeypatch):
    planner = make_planner(method, mesh_size=0.6, clearance_radius=0.5, pace=CRAWL)
    lengths = []
    plan = METHODS[method].plan
    monkeypatch.setattr(
        METHODS[method], 'plan', lambda *request: lengths.append(plan(*request).length)
    )
    planner.warm_up()
    assert lengths[0] > 7.0
    assert planner.prepared is None
