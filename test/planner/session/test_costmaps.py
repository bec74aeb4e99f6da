"""Updates of maps, Nav2's costmaps, and zones to keep out of."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_planning_session import GOAL, START, Room, room

from quad_common.errors import GoalOccupied, InvalidMessage, MapError, ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.grid.grid_update import GridUpdate
from quad_planner.grid.keepout_mask import KeepoutMask
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters

ORIGIN = Pose2D(0.0, 0.0, 0.0)


def filled(height, width, value):
    return np.full((height, width), value, np.int8)


def test_an_update_changes_its_cells_and_no_others():
    grid = room()
    after = GridUpdate(10, 20, filled(2, 3, 100)).applied_to(grid)
    changed = np.argwhere(after.cells != grid.cells)
    assert changed.min(axis=0).tolist() == [20, 10]
    assert changed.max(axis=0).tolist() == [21, 12]
    assert len(changed) == 6
    assert after.is_aligned_with(grid)


@pytest.mark.parametrize(
    ('column', 'row'), [(-1, 0), (0, -1), (79, 0), (0, 78), (2**31 - 1, 0)]
)  # fmt: skip
def test_an_update_that_is_not_on_the_map_is_refused(column, row):
    with pytest.raises(InvalidMessage, match='80 columns and 80 rows'):
        GridUpdate(column, row, filled(3, 2, 0)).applied_to(room())


def test_an_update_with_a_value_of_no_map_is_refused_and_the_map_stays():
    told = Room()
    with pytest.raises(MapError):
        told.session.take_update(GridUpdate(0, 0, filled(1, 1, 101)), 'map')
    told.give(GOAL)
    assert told.goals() == [GOAL]


def test_an_update_makes_the_session_plan_again_as_a_map_does():
    told = Room()
    told.give(GOAL)
    told.session.take_update(GridUpdate(40, 0, filled(30, 1, 100)), 'map')
    told.requests.work()
    assert len(told.plans) == 2
    assert told.plans[-1].length > told.plans[0].length + 0.5
    # The same once more changes nothing.
    told.session.take_update(GridUpdate(40, 0, filled(30, 1, 100)), 'map')
    told.requests.work()
    assert len(told.plans) == 2
    told.session.take_update(GridUpdate(40, 0, filled(80, 1, 100)), 'map')
    told.requests.work()
    assert told.plans[-1] is None


def test_an_update_needs_its_map():
    with pytest.raises(InvalidMessage, match='there is none'):
        Room(grid=False).session.take_update(GridUpdate(0, 0, filled(1, 1, 0)), 'map')
    with pytest.raises(InvalidMessage, match='moon'):
        Room().session.take_update(GridUpdate(0, 0, filled(1, 1, 0)), 'moon')


def test_a_zone_to_keep_out_of_is_walked_around_and_left_free_again():
    told = Room()
    told.give(GOAL)
    mask = OccupancyGrid(filled(6, 1, 100), 0.25, Pose2D(2.0, 0.0, 0.0))
    told.session.take_mask(mask, 'map')
    told.requests.work()
    assert told.plans[-1].length > told.plans[0].length + 0.5
    told.session.take_mask(OccupancyGrid(filled(6, 1, 0), 0.25, mask.origin), 'map')
    told.requests.work()
    assert told.plans[-1].length == pytest.approx(told.plans[0].length)


def test_a_goal_in_a_zone_is_refused_and_a_mask_may_come_before_the_map():
    told = Room(grid=False)
    told.session.take_mask(OccupancyGrid(filled(4, 4, 100), 0.25, Pose2D(2.5, 0.5, 0.0)), 'map')
    told.session.take_grid(room(), 'map')
    told.give(GOAL)
    assert isinstance(told.session.problem, GoalOccupied)
    with pytest.raises(InvalidMessage, match='moon'):
        told.session.take_mask(room(), 'moon')
    # In another frame the zones are nowhere.
    told.session.take_grid(room(), 'moon')
    assert any('keepout mask is left out' in warning for warning in told.warnings)


ZONE = OccupancyGrid(filled(4, 4, 100), 0.25, Pose2D(2.5, 0.5, 0.0))
"""A mask whose zone the goal lies in."""


def too_large():
    """Make a map that has more crossings of the mesh than can be searched."""
    return OccupancyGrid(filled(80, 80, 0), 10.0, ORIGIN)


def test_a_map_in_another_frame_that_is_refused_leaves_the_mask_in_force():
    told = Room()
    told.session.take_mask(ZONE, 'map')
    with pytest.raises(ParameterError):
        told.session.take_grid(too_large(), 'moon')
    assert told.warnings == []
    # Whatever has the map prepared again.
    told.session.map.put_bodies(((1.0, 3.0, 0.1),))
    told.give(GOAL)
    assert isinstance(told.session.problem, GoalOccupied)


def test_what_a_planner_does_not_take_is_not_added_to_the_map(monkeypatch):
    told = Room()

    def refuse(grid):
        raise MapError('no')

    with monkeypatch.context() as patched:
        patched.setattr(told.session.map.planner, 'set_map', refuse)
        with pytest.raises(MapError):
            told.session.take_mask(ZONE, 'map')
        with pytest.raises(MapError):
            told.session.map.put_bodies(((3.0, 1.0, 0.3),))
    told.session.take_grid(room(wall=True), 'map')
    told.session.take_grid(room(), 'map')
    told.give(GOAL)
    assert told.goals() == [GOAL]


def test_a_mask_raises_cells_below_its_centers_and_lowers_none():
    rng = np.random.default_rng(1)
    grid = OccupancyGrid(rng.integers(-1, 101, (300, 50)).astype(np.int8), 0.1, ORIGIN)
    place = Pose2D(1.0, 4.0, math.radians(30.0))
    mask = OccupancyGrid(rng.integers(-1, 101, (40, 30)).astype(np.int8), 0.07, place)
    after = KeepoutMask(mask).added_to(grid)
    assert np.all(after.cells >= grid.cells)
    # Unknown cells stay so where the mask says that they are free.
    for row, column in rng.integers(0, (300, 50), (500, 2)):
        center = grid.map_to_world(np.array([column + 0.5, row + 0.5]))
        x, y = np.floor(mask.world_to_map(center)).astype(int)
        on_mask = 0 <= x < 30 and 0 <= y < 40
        value = int(mask.cells[y, x]) if on_mask else -1
        expected = max(int(grid.cells[row, column]), value if value > 0 else -1)
        assert after.cells[row, column] == expected
    aligned = KeepoutMask(OccupancyGrid(filled(300, 50, 0), 0.1, ORIGIN))
    assert np.array_equal(aligned.added_to(grid).cells, grid.cells)


def costmap():
    """Make a room whose cells are free but for a band of high cost that crosses most of it."""
    cells = np.zeros((80, 80), np.int8)
    cells[:48, 38:42] = 98
    return OccupancyGrid(cells, 0.05, ORIGIN)


def planned(**parameters):
    planner = planner_from_parameters(PlannerParameters(**parameters), load_robot('titan_viii'))
    planner.set_map(costmap())
    return planner.plan(START, GOAL)


def test_values_of_a_costmap_are_no_obstacles_but_costs_for_methods_that_know_them():
    cheap = planned(method='shortest', map_values='costmap', map_cost=1.0)
    assert cheap.length == pytest.approx(START.distance_to(GOAL), abs=0.1)
    # Twice along the band and around its end costs less than its four cells.
    costly = planned(method='shortest', map_values='costmap', map_cost=15.0)
    assert costly.length > cheap.length + 1.0
    assert costly.corners[:, 1].max() > 2.3
    # The mesh compares lengths and turns: it goes by the obstacles alone.
    mesh = planned(method='mesh', map_values='costmap', map_cost=15.0)
    assert mesh.length == pytest.approx(cheap.length, abs=0.1)
    with_navigation = planned(
        method='potential', potential='navigation', map_values='costmap', map_cost=15.0
    )
    without = planned(method='potential', potential='navigation', map_values='costmap', map_cost=1)
    assert with_navigation.length > without.length + 0.5


def test_the_same_values_are_obstacles_of_an_occupancy_grid():
    around = planned(method='shortest')
    assert around.corners[:, 1].max() > 2.6
