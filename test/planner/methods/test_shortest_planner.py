"""The shortest path over the cells, and at any angle, keeps clear and is as short as it is."""

import math
from itertools import count, pairwise

import numpy as np
import pytest

from quad_common.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidPose,
    NoPathFound,
    ParameterError,
    PlannerError,
    PlannerTimedOut,
    StartOccupied,
    StartOutsideMap,
)
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.clearance import segment_clearance
from quad_planner.methods.planner import make_planner
from quad_planner.methods.shortest_planner import ShortestPlanner, turns_saved

BOTH = pytest.mark.parametrize('any_angle', [False, True])


def floor(width=40, height=30, resolution=0.1, origin=(0.0, 0.0, 0.0), boxes=()):
    cells = np.zeros((height, width), dtype=np.int8)
    for x, y, w, h in boxes:
        cells[y : y + h, x : x + w] = 100
    return OccupancyGrid(cells, resolution, Pose2D(*origin))


def random_floor(rng):
    height, width = (int(n) for n in rng.integers(15, 45, 2))
    boxes = [
        (rng.integers(0, width), rng.integers(0, height), *rng.integers(1, 8, 2))
        for _ in range(rng.integers(1, 9))
    ]
    resolution = float(rng.choice([0.05, 0.1, 0.3]))
    origin = (*rng.normal(size=2).tolist(), float(rng.choice([0.0, 0.3])))
    return floor(width, height, resolution, origin, boxes)


def length(plan):
    return float(np.hypot(*np.diff(plan.corners, axis=0).T).sum())


@pytest.mark.parametrize('seed', range(40))
def test_plans_keep_clear_all_along_and_any_angle_is_never_longer(seed):
    rng = np.random.default_rng(seed)
    grid = random_floor(rng)
    radius = float(rng.choice([0.6, 1.2, 2.3])) * grid.resolution
    planners = [
        ShortestPlanner(clearance_radius=radius, any_angle=any_angle, start_tolerance=0.5 * radius)
        for any_angle in (False, True)
    ]
    prepared = [planner.prepare(grid) for planner in planners]
    for _ in range(4):
        ends = grid.map_to_world(rng.random((2, 2)) * [grid.width, grid.height])
        start, goal = (Pose2D(float(x), float(y), 0.4) for x, y in ends)
        try:
            plans = [p.plan(m, start, goal) for p, m in zip(planners, prepared)]
        except PlannerError:
            continue
        for plan in plans:
            assert plan.poses[-1].distance_to(goal) < 1e-9
            assert plan.poses[-1].yaw == goal.yaw
            corners = grid.world_to_map(plan.corners)
            blocked = prepared[0].blocked
            for k, (a, b) in enumerate(pairwise(corners)):
                keep = radius / grid.resolution
                if k == 0:
                    keep = min(keep, segment_clearance(blocked, a, a))
                assert segment_clearance(blocked, a, b) >= keep - 1e-6
        assert length(plans[1]) <= length(plans[0]) + 1e-9


@BOTH
def test_where_nothing_is_in_the_way_the_robot_walks_straight(any_angle):
    plan = make_planner('shortest', clearance_radius=0.2, any_angle=any_angle)
    plan.set_map(floor())
    found = plan.plan(Pose2D(0.52, 0.57, 0.0), Pose2D(3.13, 0.57, 1.0))
    assert found.corners == pytest.approx(np.array([[0.52, 0.57], [3.13, 0.57]]))
    assert found.poses[-1].yaw == 1.0


def test_around_a_wall_the_way_over_cells_is_eight_directional_and_shortest():
    # A wall from below, 10 cells high: from its left to its right over its top.
    grid = floor(21, 20, 1.0, boxes=[(10, 0, 1, 10)])
    planner = ShortestPlanner(clearance_radius=0.4)
    plan = planner.plan(planner.prepare(grid), Pose2D(5.5, 4.5, 0.0), Pose2D(15.5, 4.5, 0.0))
    # One cell round the wall is forbidden: to its left by seven up and three across, four
    # over its top, for no corner is cut, and down again.
    steps = np.abs(np.diff(plan.corners, axis=0))
    diagonal = steps.min(axis=1).sum()
    straight = (steps.max(axis=1) - steps.min(axis=1)).sum()
    assert straight + math.sqrt(2.0) * diagonal == pytest.approx(length(plan))
    assert (straight, diagonal) == (12.0, 6.0)
    taut = ShortestPlanner(clearance_radius=0.4, any_angle=True)
    plan = taut.plan(taut.prepare(grid), Pose2D(5.5, 4.5, 0.0), Pose2D(15.5, 4.5, 0.0))
    assert plan.corners == pytest.approx(
        np.array([[5.5, 4.5], [9.0, 11.0], [12.0, 11.0], [15.5, 4.5]])
    )


def test_turns_are_saved_where_a_leg_can_be_moved():
    forbidden = np.zeros((20, 20), dtype=bool)
    cells = np.array([[0, 0], [3, 3], [6, 3], [9, 6]])
    saved = turns_saved(cells, BitMask.of(forbidden).words)
    assert len(saved) == 3
    assert saved[[0, -1]].tolist() == [[0, 0], [9, 6]]
    # A wall on either side keeps the leg where it is.
    forbidden[0:2, 3:] = True
    forbidden[7:, 3:6] = True
    forbidden[4:, 0:5] = True
    assert turns_saved(cells, BitMask.of(forbidden).words).tolist() == cells.tolist()


@BOTH
@pytest.mark.parametrize(
    ('start', 'goal', 'error'),
    [
        ((9.0, 1.0), (1.0, 1.0), StartOutsideMap),
        ((1.0, 1.0), (1.0, -1.0), GoalOutsideMap),
        ((2.05, 1.05), (1.0, 1.0), StartOccupied),
        ((1.0, 1.0), (2.05, 1.05), GoalOccupied),
        ((math.nan, 1.0), (1.0, 1.0), InvalidPose),
    ],
)
def test_ends_that_will_not_do_are_refused_by_name(any_angle, start, goal, error):
    planner = ShortestPlanner(clearance_radius=0.2, any_angle=any_angle)
    prepared = planner.prepare(floor(boxes=[(20, 10, 2, 2)]))
    with pytest.raises(error):
        planner.plan(prepared, Pose2D(*start, 0.0), Pose2D(*goal, 0.0))


@BOTH
def test_two_rooms_without_a_door_are_told_as_not_connected(any_angle):
    planner = ShortestPlanner(clearance_radius=0.2, any_angle=any_angle)
    prepared = planner.prepare(floor(boxes=[(20, 0, 1, 30)]))
    with pytest.raises(NoPathFound, match='not connected for a robot that needs'):
        planner.plan(prepared, Pose2D(1.0, 1.0, 0.0), Pose2D(3.0, 1.0, 0.0))


@BOTH
def test_a_robot_that_strayed_into_the_boundary_is_led_out_of_it(any_angle):
    planner = ShortestPlanner(clearance_radius=0.3, any_angle=any_angle, start_tolerance=0.1)
    prepared = planner.prepare(floor(boxes=[(0, 0, 40, 3)]))
    start = Pose2D(1.0, 0.55, 0.0)
    plan = planner.plan(prepared, start, Pose2D(3.0, 1.5, 0.0))
    corners = prepared.grid.world_to_map(plan.corners)
    assert segment_clearance(prepared.blocked, corners[0], corners[1]) >= 2.5 - 1e-9
    # Farther inside it does not start.
    with pytest.raises(StartOccupied):
        planner.plan(prepared, Pose2D(1.0, 0.45, 0.0), Pose2D(3.0, 1.5, 0.0))


@pytest.mark.usefixtures('nothing_is_compiled')
@BOTH
def test_the_time_limit_ends_a_search(any_angle):
    ticks = count()
    planner = ShortestPlanner(
        clearance_radius=0.2, any_angle=any_angle, time_limit=0.5, clock=lambda: float(next(ticks))
    )
    prepared = planner.prepare(floor(boxes=[(20, 0, 1, 20)]))
    with pytest.raises(PlannerTimedOut, match='within the limit'):
        planner.plan(prepared, Pose2D(1.0, 1.0, 0.0), Pose2D(3.0, 1.0, 0.0))


@BOTH
def test_start_and_goal_in_one_place_are_a_turn(any_angle):
    planner = ShortestPlanner(clearance_radius=0.2, any_angle=any_angle)
    goal = Pose2D(1.0, 1.0, 2.0)
    assert planner.plan(planner.prepare(floor()), Pose2D(1.0, 1.0, 0.0), goal).poses == (goal,)


@pytest.mark.parametrize('radius', [0.0, -1.0, math.nan, math.inf])
def test_lengths_must_be_sound(radius):
    with pytest.raises(ParameterError, match='clearance_radius'):
        ShortestPlanner(clearance_radius=radius)
    with pytest.raises(ParameterError, match='start_tolerance'):
        ShortestPlanner(clearance_radius=0.2, start_tolerance=math.nan)


def test_options_of_other_methods_are_left_aside_and_unknown_ones_refused():
    make_planner('shortest', clearance_radius=0.2, mesh_size=0.6)
    make_planner('mesh', clearance_radius=0.2, mesh_size=0.6, any_angle=True)
    with pytest.raises(TypeError, match=r"\['mesh_sise'\]"):
        make_planner('shortest', clearance_radius=0.2, mesh_sise=0.6)
