"""Plans down a potential keep clear, say which potential it was, and say where it sticks."""

import math
from itertools import count, pairwise

import numpy as np
import pytest

from quad_common.errors import (
    DescentStuck,
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
from quad_common.parameters import parameters_of
from quad_common.planar_pose import Pose2D
from quad_gait.following.reference_path import rounded_pieces
from quad_planner.grid.clearance import segment_clearance
from quad_planner.methods.planner import make_planner
from quad_planner.methods.potential_planner import POTENTIALS, PotentialPlanner
from quad_planner.methods.shortest_planner import ShortestPlanner
from quad_planner.parameters import PlannerParameters

EACH = pytest.mark.parametrize('potential', POTENTIALS)


def floor(width=60, height=60, resolution=0.1, origin=(0.0, 0.0, 0.0), boxes=()):
    cells = np.zeros((height, width), dtype=np.int8)
    for x, y, w, h in boxes:
        cells[y : y + h, x : x + w] = 100
    return OccupancyGrid(cells, resolution, Pose2D(*origin))


POCKET = ((30, 15, 3, 30), (15, 15, 18, 3), (15, 42, 18, 3))
"""A U that is open to the left."""

WEST, EAST = Pose2D(1.0, 3.0, 0.3), Pose2D(5.0, 3.1, 1.0)


def circles(rng, size=100, resolution=0.1):
    """Draw twelve discs, in every other map seven of them as a U."""
    centers = (np.indices((size, size)) + 0.5) * resolution
    places = rng.uniform(1.5, size * resolution - 1.5, (12, 2)).tolist()
    if rng.random() < 0.5:
        y = rng.uniform(3.0, 7.0)
        places[:7] = [[6.0, y + 0.7 * k] for k in (-1, 0, 1)]
        places[3:7] = [[6.0 - 0.6 * k, y + 1.4 * side] for k in (0, 1) for side in (-1, 1)]
    occupied = np.zeros((size, size), dtype=bool)
    for x, y in places:
        occupied |= np.hypot(centers[1] - x, centers[0] - y) <= rng.uniform(0.25, 0.45)
    return OccupancyGrid(
        np.where(occupied, 100, 0).astype(np.int8), resolution, Pose2D(0.0, 0.0, 0.0)
    )


def sampled_clearance(prepared, plan, skip=0):
    """Return the least distance of points, a tenth of a cell apart, to an obstacle [cells]."""
    least = math.inf
    corners = prepared.grid.world_to_map(plan.corners)
    for a, b in list(pairwise(corners))[skip:]:
        for t in np.linspace(0.0, 1.0, max(math.ceil(10.0 * np.hypot(*(b - a))), 1) + 1):
            p = a + t * (b - a)
            least = min(least, segment_clearance(prepared.blocked_bits, p, p, 40.0))
    return least


@pytest.mark.sweep(kept=8)
@EACH
@pytest.mark.parametrize('seed', range(12))
def test_every_segment_keeps_the_clearance(seed, potential):
    rng = np.random.default_rng(seed)
    resolution = float(rng.choice([0.05, 0.1, 0.3]))
    boxes = [(*rng.integers(0, 55, 2), *rng.integers(1, 12, 2)) for _ in range(8)]
    origin = (*rng.normal(size=2).tolist(), float(rng.choice([0.0, 0.3])))
    grid = floor(60, 50, resolution, origin, boxes)
    radius = float(rng.choice([0.6, 1.2, 2.3])) * resolution
    deviation = float(rng.choice([0.0, 0.05, 1.0]))
    planner = PotentialPlanner(
        clearance_radius=radius,
        start_tolerance=0.0,
        potential=potential,
        path_deviation=deviation,
        influence=10.0 * resolution,
    )
    prepared = planner.prepare(grid)
    for _ in range(5):
        ends = grid.map_to_world(rng.random((2, 2)) * [60.0, 50.0])
        start, goal = (Pose2D(float(x), float(y), 0.4) for x, y in ends)
        try:
            plan = planner.plan(prepared, start, goal)
        except PlannerError:
            continue
        assert plan.poses[0].distance_to(start) < 1e-9
        assert plan.poses[-1] == goal
        assert sampled_clearance(prepared, plan) >= radius / resolution - 1e-6


def test_in_a_pocket_the_papers_descent_sticks_and_says_where():
    origin = (2.0, -1.0, 0.5)
    grid = floor(origin=origin, boxes=POCKET)
    planner = PotentialPlanner(clearance_radius=0.3, potential='paper')
    start, goal = (grid.origin @ pose for pose in (WEST, EAST))
    with pytest.raises(DescentStuck) as caught:
        planner.plan(planner.prepare(grid), start, goal)
    x, y = grid.world_to_map(np.array(caught.value.place)) * 0.1
    assert (x, y) == pytest.approx((2.4, 3.05), abs=0.3)
    assert caught.value.kind == 'a local minimum'
    assert caught.value.code == 208
    assert f'({caught.value.place[0]:.2f}, {caught.value.place[1]:.2f}) m' in str(caught.value)


@pytest.mark.parametrize('potential', ['navigation', 'either'])
def test_out_of_the_pocket_a_navigation_function_leads_and_the_plan_says_so(potential):
    planner = PotentialPlanner(clearance_radius=0.3, potential=potential)
    prepared = planner.prepare(floor(boxes=POCKET))
    plan = planner.plan(prepared, WEST, EAST)
    assert plan.poses[-1] == EAST
    assert plan.remark.startswith('a navigation function leads to the goal')
    assert ("S1's comes to rest at" in plan.remark) == (potential == 'either')
    assert sampled_clearance(prepared, plan) >= 3.0 - 1e-9


@pytest.mark.parametrize('potential', ['paper', 'either'])
def test_where_the_papers_descent_arrives_it_is_taken(potential):
    planner = PotentialPlanner(clearance_radius=0.3, potential=potential)
    plan = planner.plan(planner.prepare(floor(boxes=[(28, 20, 4, 6)])), WEST, EAST)
    assert plan.remark == "S1's potential leads to the goal"
    assert len(plan.poses) < 10


def test_among_circles_the_navigation_function_arrives_wherever_there_is_a_way():
    rng = np.random.default_rng(0)
    shortest = ShortestPlanner(clearance_radius=0.3)
    navigation = PotentialPlanner(clearance_radius=0.3, potential='navigation')
    paper = PotentialPlanner(clearance_radius=0.3, potential='paper')
    start, goal = Pose2D(0.5, 5.0, 0.0), Pose2D(9.5, 5.2, 0.0)
    solvable = arrived = 0
    for _ in range(100):
        grid = circles(rng)
        try:
            best = shortest.plan(shortest.prepare(grid), start, goal)
        except NoPathFound:
            with pytest.raises(NoPathFound):
                navigation.plan(navigation.prepare(grid), start, goal)
            continue
        solvable += 1
        plan = navigation.plan(navigation.prepare(grid), start, goal)
        assert plan.poses[-1] == goal
        assert plan.length > 0.9 * best.length
        try:
            paper.plan(paper.prepare(grid), start, goal)
            arrived += 1
        except DescentStuck:
            pass
    assert solvable > 80
    assert 0.2 * solvable < arrived < 0.8 * solvable


@pytest.mark.parametrize('seed', range(10))
def test_where_there_is_a_shortest_path_there_is_one_by_navigation(seed):
    rng = np.random.default_rng(seed)
    for _ in range(60):
        boxes = [(*rng.integers(0, 30, 2), *rng.integers(1, 9, 2)) for _ in range(8)]
        grid = floor(*map(int, rng.integers(1, 40, 2)), boxes=boxes)
        options = {'clearance_radius': float(rng.choice([0.02, 0.1, 0.17])), 'start_tolerance': 0.1}
        navigation = PotentialPlanner(potential='navigation', **options)
        ends = grid.map_to_world(np.round(2.0 * rng.random((2, 2)) * [grid.width, grid.height]) / 2)
        start, goal = (Pose2D(float(x), float(y), 0.0) for x, y in ends)
        shortest, found = ShortestPlanner(**options), []
        for planner in (shortest, navigation):
            try:
                found.append(planner.plan(planner.prepare(grid), start, goal).poses[-1] == goal)
            except PlannerError as error:
                found.append(type(error))
        assert found[0] == found[1]


@EACH
def test_where_nothing_is_in_the_way_the_robot_walks_straight(potential):
    planner = PotentialPlanner(clearance_radius=0.2, potential=potential)
    plan = planner.plan(planner.prepare(floor()), WEST, EAST)
    assert plan.corners[[0, -1]] == pytest.approx(np.array([[1.0, 3.0], [5.0, 3.1]]))
    assert plan.length == pytest.approx(math.hypot(4.0, 0.1), abs=0.02)
    assert len(plan.poses) <= 3


def test_a_smaller_deviation_keeps_more_turning_points():
    grid = floor(boxes=POCKET)
    counts = []
    for deviation in (0.0, 0.01, 0.05, 0.2, 1.0):
        planner = PotentialPlanner(
            clearance_radius=0.3, potential='navigation', path_deviation=deviation
        )
        counts.append(len(planner.plan(planner.prepare(grid), WEST, EAST).poses))
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > 40
    assert counts[-1] < 8


def test_a_dense_plan_becomes_circles_for_the_turning_arc():
    planner = PotentialPlanner(clearance_radius=0.3, potential='navigation', path_deviation=0.005)
    plan = planner.plan(planner.prepare(floor(boxes=POCKET)), WEST, EAST)
    pieces = rounded_pieces(plan, deviation=0.05, radius=2.0, stop_angle=math.radians(30.0))
    assert sum(piece.curvature != 0.0 for piece in pieces) > 10
    # It never has to stop on the way.
    assert [piece.ends_in_stop for piece in pieces].count(True) == 1
    assert pieces[-1].end.distance_to(EAST) < 1e-6
    for piece, after in pairwise(pieces):
        assert piece.end.distance_to(after.start) < 1e-6


@EACH
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
def test_ends_that_will_not_do_are_refused_by_name(potential, start, goal, error):
    planner = PotentialPlanner(clearance_radius=0.2, potential=potential)
    prepared = planner.prepare(floor(boxes=[(20, 10, 2, 2)]))
    with pytest.raises(error):
        planner.plan(prepared, Pose2D(*start, 0.0), Pose2D(*goal, 0.0))


@EACH
def test_two_rooms_without_a_door_are_told_as_not_connected(potential):
    planner = PotentialPlanner(clearance_radius=0.2, potential=potential)
    prepared = planner.prepare(floor(boxes=[(30, 0, 1, 60)]))
    with pytest.raises(NoPathFound, match='not connected for a robot that needs'):
        planner.plan(prepared, WEST, EAST)


@EACH
def test_a_robot_that_strayed_joins_the_area_to_which_it_can_go(potential):
    # The allowed cell that is nearest to it lies behind the obstacles, in another area.
    grid = floor(3, 5, 1.0, boxes=[(0, 0, 1, 2), (2, 2, 1, 1)])
    planner = PotentialPlanner(clearance_radius=1.0, start_tolerance=0.5, potential=potential)
    goal = Pose2D(1.5, 4.5, 0.0)
    assert planner.plan(planner.prepare(grid), Pose2D(1.5, 2.0, 0.0), goal).poses[-1] == goal


def test_a_passage_as_wide_as_the_corner_of_a_cell_is_none():
    cells = np.zeros((10, 10), dtype=np.int8)
    cells[:5, 5:] = cells[5:, :5] = 100
    planner = PotentialPlanner(clearance_radius=1e-3, potential='navigation')
    prepared = planner.prepare(OccupancyGrid(cells, 1.0, Pose2D(0.0, 0.0, 0.0)))
    with pytest.raises(NoPathFound):
        planner.plan(prepared, Pose2D(2.5, 2.5, 0.0), Pose2D(7.5, 7.5, 0.0))


@EACH
def test_a_robot_that_strayed_into_the_boundary_is_led_out_of_it(potential):
    planner = PotentialPlanner(clearance_radius=0.3, potential=potential, start_tolerance=0.1)
    prepared = planner.prepare(floor(boxes=[(0, 0, 60, 3)]))
    start = Pose2D(1.0, 0.55, 0.0)
    plan = planner.plan(prepared, start, Pose2D(3.0, 2.5, 0.0))
    assert plan.poses[0].distance_to(start) < 1e-9
    assert sampled_clearance(prepared, plan) >= 2.5 - 1e-9
    assert sampled_clearance(prepared, plan, skip=1) >= 3.0 - 1e-9
    with pytest.raises(StartOccupied):
        planner.plan(prepared, Pose2D(1.0, 0.45, 0.0), Pose2D(3.0, 2.5, 0.0))


@EACH
def test_a_goal_that_just_fits_beside_the_boundary_is_reached(potential):
    # Its cell is not allowed, for another point of it would be too near.
    planner = PotentialPlanner(clearance_radius=0.33, potential=potential, influence=0.1)
    prepared = planner.prepare(floor(boxes=[(0, 0, 60, 3)]))
    goal = Pose2D(3.0, 0.64, 2.0)
    assert not prepared.is_allowed(prepared.grid.world_to_map(np.array([3.0, 0.64])))
    plan = planner.plan(prepared, Pose2D(1.0, 3.0, 0.0), goal)
    assert plan.poses[-1] == goal
    assert sampled_clearance(prepared, plan) >= 3.3 - 1e-6


@pytest.mark.usefixtures('nothing_is_compiled')
@EACH
def test_the_time_limit_ends_a_plan(potential):
    ticks = count()
    planner = PotentialPlanner(
        clearance_radius=0.3, potential=potential, time_limit=0.5, clock=lambda: float(next(ticks))
    )
    with pytest.raises(PlannerTimedOut, match='within the limit'):
        planner.plan(planner.prepare(floor(boxes=POCKET)), WEST, EAST)


@EACH
def test_start_and_goal_in_one_place_are_a_turn(potential):
    planner = PotentialPlanner(clearance_radius=0.2, potential=potential)
    goal = Pose2D(1.0, 1.0, 2.0)
    assert planner.plan(planner.prepare(floor()), Pose2D(1.0, 1.0, 0.0), goal).poses == (goal,)


@EACH
def test_a_mirrored_map_gives_a_plan_as_long(potential):
    grid = floor(boxes=[(25, 5, 3, 30), (40, 25, 3, 30)])
    mirrored = OccupancyGrid(np.ascontiguousarray(grid.cells[::-1]), 0.1, grid.origin)
    planner = PotentialPlanner(clearance_radius=0.3, potential=potential)
    start, goal = Pose2D(1.02, 2.96, 0.0), Pose2D(5.03, 2.64, 0.0)
    found = []
    for each, flip in ((grid, False), (mirrored, True)):
        ends = [Pose2D(p.x, 6.0 - p.y if flip else p.y, 0.0) for p in (start, goal)]
        try:
            found.append(planner.plan(planner.prepare(each), *ends).length)
        except DescentStuck as stuck:
            found.append(-stuck.place[0])
    assert found[0] == pytest.approx(found[1], rel=0.01)


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('potential', 'papers'),
        ('path_deviation', -0.1),
        ('path_deviation', math.inf),
        ('influence', 0.0),
        ('repulsion', -1.0),
        ('attraction', math.nan),
        ('goal_distance', 0.0),
    ],
)
def test_options_must_be_sound(name, value):
    with pytest.raises(ParameterError, match=f"'{name}'"):
        PotentialPlanner(clearance_radius=0.2, **{name: value})


def test_the_nodes_parameters_have_the_methods_defaults():
    parameters = {p.name: p for p in parameters_of(PlannerParameters)}
    planner = PotentialPlanner(clearance_radius=0.3)
    for name in ('potential', 'influence', 'path_deviation'):
        assert parameters[name].default == getattr(planner, name)
    assert parameters['potential'].choices == POTENTIALS


def test_it_is_a_method_by_name():
    planner = make_planner('potential', clearance_radius=0.3, mesh_size=0.6, potential='navigation')
    planner.set_map(floor(boxes=POCKET))
    assert planner.plan(WEST, EAST).poses[-1] == EAST
