"""Reasons why paths cost more, one by one and together, and what plans make of them."""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.costs.cell_costs import ClearanceCost, UnknownCost, cell_costs
from quad_planner.grid.clearance import segment_clearance
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.planner import make_planner

WALL = np.zeros((60, 80), dtype=np.int8)
WALL[20:40, 30:50] = 100
BESIDE_A_WALL = OccupancyGrid(WALL, 0.1, Pose2D(0.0, 0.0, 0.0))
PACE = WalkingTimeModel(cycle_period=5.0, stride=0.2, turn=0.7)
START, GOAL = Pose2D(1.0, 2.6, 0.0), Pose2D(7.0, 2.6, 0.0)


def with_unknown():
    cells = np.zeros((40, 80), dtype=np.int8)
    cells[:32, 30:50] = -1
    return OccupancyGrid(cells, 0.1, Pose2D(0.0, 0.0, 0.0))


def plan(method, grid, **options):
    planner = make_planner(method, mesh_size=0.5, clearance_radius=0.3, **options)
    planner.set_map(grid)
    return planner.plan(START, GOAL), planner.prepared


def least_clearance(plan, prepared):
    points = prepared.grid.world_to_map(plan.corners)
    return min(segment_clearance(prepared.blocked_bits, a, b) for a, b in pairwise(points))


def test_unknown_cells_have_their_factor():
    grid = with_unknown()
    factors = UnknownCost(3.0).factors(InflatedMap.of(grid, 0.3, 65, True))
    assert np.array_equal(factors == 3.0, grid.unknown())
    assert np.array_equal(factors == 1.0, ~grid.unknown())


def test_the_clearance_cost_falls_with_the_distance():
    safety = InflatedMap.of(BESIDE_A_WALL, 0.3, 65, False)
    factors = ClearanceCost(5.0, 0.5).factors(safety)
    # Along a row that leads straight away from the box: from the boundary on.
    row = factors[30, 53:70]
    assert (np.diff(row) <= 0.0).all()
    assert 3.0 < row[0] <= 5.0
    assert row[-1] == 1.0


def test_layers_are_multiplied():
    safety = InflatedMap.of(with_unknown(), 0.3, 65, True)
    assert cell_costs((), safety) is None
    both = cell_costs((UnknownCost(2.0), UnknownCost(3.0)), safety)
    assert np.array_equal(both, UnknownCost(6.0).factors(safety))
    with pytest.raises(ParameterError, match='from 1 to 250'):
        cell_costs((UnknownCost(20.0), UnknownCost(20.0)), safety)


@pytest.mark.parametrize(
    'make',
    [
        lambda: UnknownCost(0.5),
        lambda: UnknownCost(math.nan),
        lambda: UnknownCost(1000.0),
        lambda: ClearanceCost(2.0, 0.0),
        lambda: ClearanceCost(math.inf, 0.5),
    ],
)
def test_numbers_that_are_not_valid_are_refused(make):
    with pytest.raises(ParameterError):
        make()


@pytest.mark.sweep(kept=3)
@pytest.mark.parametrize(
    ('method', 'options'),
    [
        ('shortest', {}),
        ('shortest', {'any_angle': True}),
        ('potential', {'potential': 'navigation', 'influence': 0.1}),
        ('quickest', {'pace': PACE}),
        ('quickest', {'pace': PACE, 'any_angle': True}),
    ],
)
def test_plans_keep_away_from_obstacles_where_that_is_cheaper(method, options):
    plain, prepared = plan(method, BESIDE_A_WALL, **options)
    away, _ = plan(method, BESIDE_A_WALL, costs=(ClearanceCost(20.0, 0.6),), **options)
    # In cells of 0.1 m.
    assert least_clearance(plain, prepared) >= 3.0 - 1e-6
    assert least_clearance(away, prepared) > least_clearance(plain, prepared) + 2.0
    assert away.length > plain.length


@pytest.mark.parametrize('any_angle', [False, True])
def test_plans_lead_around_unknown_cells_if_these_are_dear(any_angle):
    grid = with_unknown()
    shared = {'unknown_is_free': True, 'any_angle': any_angle}
    through, _ = plan('shortest', grid, costs=(UnknownCost(1.05),), **shared)
    around, _ = plan('shortest', grid, costs=(UnknownCost(4.0),), **shared)
    assert through.length == pytest.approx(START.distance_to(GOAL))
    assert around.length > through.length + 0.05
    assert around.corners[:, 1].max() >= 3.2


def test_methods_that_compare_other_things_say_so():
    with pytest.raises(ParameterError, match='UnknownCost'):
        plan('mesh', with_unknown(), costs=(UnknownCost(2.0),))


def test_the_papers_potential_knows_no_costs():
    with pytest.raises(ParameterError, match="'navigation' where there are costs"):
        plan('potential', BESIDE_A_WALL, costs=(ClearanceCost(2.0, 0.6),))
