"""A map of which a part has changed is made ready as a new one would be."""

import math
from dataclasses import fields

import numpy as np
import pytest

from quad_common.errors import PlannerError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.costs.cell_costs import ClearanceCost
from quad_planner.grid.bit_grid import changed_rows
from quad_planner.methods.planner import METHODS, make_planner

ORIGIN = Pose2D(-1.0, 2.0, 0.3)
OPTIONS = {
    'mesh_size': 0.45,
    'pace': WalkingTimeModel(cycle_period=5.0, stride=0.2, turn=math.radians(44.0)),
    'influence': 0.6,
}


def method_of(name, radius, **options):
    return make_planner(name, clearance_radius=radius, **OPTIONS, **options)._method


def random_cells(rng, height, width):
    cells = np.zeros((height, width), dtype=np.int8)
    for _ in range(rng.integers(0, 12)):
        x, y = rng.integers(0, width), rng.integers(0, height)
        w, h = rng.integers(1, 9, 2)
        cells[y : y + h, x : x + w] = rng.choice([100, -1, 50])
    return cells


def assert_same(a, b):
    """Compare two prepared maps in all that a plan may ask of them."""
    assert type(a) is type(b)
    for field in fields(a):
        left, right = getattr(a, field.name), getattr(b, field.name)
        if field.name in ('grid', 'search'):
            continue
        if field.name.endswith('_bits'):
            assert np.array_equal(left.unpacked(), right.unpacked())
        elif isinstance(left, np.ndarray):
            # Distances are measured in single precision, of some tens of cells at most.
            np.testing.assert_allclose(left, right, rtol=1e-6, atol=2e-7)
        else:
            assert left == right
    if hasattr(a, 'search'):
        assert np.array_equal(a.search.grid.rows, b.search.grid.rows)
        assert np.array_equal(a.search.grid.columns, b.search.grid.columns)


@pytest.mark.parametrize('name', sorted(METHODS))
@pytest.mark.parametrize('seed', range(12))
def test_an_update_equals_a_new_start(name, seed):
    rng = np.random.default_rng(seed)
    height, width = (int(n) for n in rng.integers(20, 160, 2))
    resolution = float(rng.choice([0.05, 0.1]))
    method = method_of(name, float(rng.choice([0.04, 0.17, 0.5])))
    cells = random_cells(rng, height, width)
    prepared = method.prepare(OccupancyGrid(cells, resolution, ORIGIN))
    for _ in range(6):
        cells = cells.copy()
        y, x = int(rng.integers(0, height)), int(rng.integers(0, width))
        h, w = (int(n) for n in rng.integers(1, 15, 2))
        cells[y : y + h, x : x + w] = rng.choice([0, 100, -1])
        grid = OccupancyGrid(cells, resolution, ORIGIN)
        changed = changed_rows(prepared.grid.cells, grid.cells)
        if changed is None:
            continue
        prepared = method.update(prepared, grid, changed)
        assert prepared.grid is grid
        assert_same(prepared, method.prepare(grid))


@pytest.mark.parametrize(
    ('name', 'more'), [('shortest', {}), ('potential', {'potential': 'navigation'})]
)
def test_costs_are_updated_too(name, more):
    rng = np.random.default_rng(0)
    method = method_of(name, 0.2, costs=(ClearanceCost(3.0, 0.4),), **more)
    cells = random_cells(rng, 60, 60)
    before = method.prepare(OccupancyGrid(cells, 0.1, ORIGIN))
    cells = cells.copy()
    cells[20:24, 30:40] = 100
    grid = OccupancyGrid(cells, 0.1, ORIGIN)
    assert_same(method.update(before, grid, (20, 24)), method.prepare(grid))


@pytest.mark.parametrize('name', sorted(METHODS))
def test_plans_know_what_has_changed(name):
    cells = np.zeros((60, 60), dtype=np.int8)
    planner = make_planner(name, clearance_radius=0.2, **OPTIONS)
    ends = Pose2D(0.75, 2.75, 0.0), Pose2D(5.25, 2.75, 0.0)
    planner.set_map(OccupancyGrid(cells, 0.1, Pose2D(0.0, 0.0, 0.0)))
    direct = planner.plan(*ends).length
    wall = cells.copy()
    wall[20:, 28:32] = 100
    planner.set_map(OccupancyGrid(wall[::1], 0.1, Pose2D(0.0, 0.0, 0.0)))
    assert planner.plan(*ends).length > direct + 0.5
    closed = wall.copy()
    closed[:20, 28:32] = 100
    planner.set_map(OccupancyGrid(closed, 0.1, Pose2D(0.0, 0.0, 0.0)))
    with pytest.raises(PlannerError):
        planner.plan(*ends)
    planner.set_map(OccupancyGrid(cells, 0.1, Pose2D(0.0, 0.0, 0.0)))
    assert planner.plan(*ends).length == pytest.approx(direct)


def test_an_equal_map_changes_nothing():
    cells = np.zeros((60, 60), dtype=np.int8)
    planner = make_planner('shortest', clearance_radius=0.2, **OPTIONS)
    planner.set_map(OccupancyGrid(cells, 0.1, ORIGIN))
    before = planner.prepared
    planner.set_map(OccupancyGrid(cells.copy(), 0.1, ORIGIN))
    assert planner.prepared is before


@pytest.mark.parametrize(
    'other',
    [
        OccupancyGrid(np.zeros((60, 61), dtype=np.int8), 0.1, ORIGIN),
        OccupancyGrid(np.zeros((60, 60), dtype=np.int8), 0.2, ORIGIN),
        OccupancyGrid(np.zeros((60, 60), dtype=np.int8), 0.1, Pose2D(0.0, 0.0, 0.0)),
    ],
)
def test_a_map_elsewhere_is_a_new_one(other):
    planner = make_planner('shortest', clearance_radius=0.2, **OPTIONS)
    planner.set_map(OccupancyGrid(np.zeros((60, 60), dtype=np.int8), 0.1, ORIGIN))
    planner.set_map(other)
    assert planner.prepared.grid is other


def test_rows_that_changed_are_found():
    before = np.zeros((9, 5), dtype=np.int8)
    after = before.copy()
    assert changed_rows(before, after) is None
    after[3, 1] = after[6, 4] = 100
    assert changed_rows(before, after) == (3, 7)
