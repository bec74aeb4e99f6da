"""Laws of the mesh planner of S0 section 3."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from quad_common.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidPlanner,
    InvalidPose,
    NoPathFound,
    ParameterError,
    PlannerError,
    PlannerTimedOut,
    StartOccupied,
    StartOutsideMap,
)
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_planner.grid.inflation import inflate
from quad_planner.methods.mesh_planner import MeshPlanner
from quad_planner.methods.planner import make_planner

ROOT = Path(__file__).parents[3]
SHARED = ROOT.parent / 'shared' / 'maps' / 'ros'
UPRIGHT = Pose2D(0.0, 0.0, 0.0)


def grid_of(cells, resolution=0.1, origin=UPRIGHT):
    return OccupancyGrid(np.asarray(cells, dtype=np.int8), resolution, origin)


def random_grid(rng, height=48, width=60, boxes=10, origin=UPRIGHT):
    """Return a map of 0.1 m cells with boxes strewn over it."""
    cells = np.zeros((height, width), np.int8)
    for _ in range(boxes):
        row, column = rng.integers(0, height), rng.integers(0, width)
        h, w = rng.integers(1, 8, 2)
        cells[row : row + h, column : column + w] = rng.choice([100, -1])
    return grid_of(cells, origin=origin)


def random_pose(rng, grid):
    """Return a pose whose position is on the map."""
    cell = rng.uniform((0.0, 0.0), (grid.width, grid.height))
    return Pose2D(*grid.map_to_world(cell), rng.uniform(-math.pi, math.pi))


def random_plans(rng, planner, grid, attempts):
    """Yield start, goal and plan of random pairs that have one."""
    prepared = planner.prepare(grid)
    for _ in range(attempts):
        start, goal = random_pose(rng, grid), random_pose(rng, grid)
        try:
            yield start, goal, planner.plan(prepared, start, goal)
        except PlannerError:
            continue


def least_clearance(grid, plan):
    """Return the least distance of points a tenth of a cell apart to an obstacle [m]."""
    blocked = np.argwhere(grid.occupied() | grid.unknown())[:, ::-1] + 0.5
    corners = grid.world_to_map(plan.corners)
    points = np.concatenate(
        [
            a + np.linspace(0.0, 1.0, 2 + int(10.0 * np.linalg.norm(b - a)))[:, None] * (b - a)
            for a, b in pairwise(corners)
        ]
    )
    # The nearest square is among those whose centers are at most sqrt(1/2) beyond the
    # nearest center, and as much again on the square's side.
    tree = cKDTree(blocked)
    nearest = tree.query(points)[0]
    worst = math.inf
    for point in points[nearest <= nearest.min() + math.sqrt(2.0)]:
        around = blocked[tree.query_ball_point(point, nearest.min() + 2.0 * math.sqrt(2.0))]
        apart = np.maximum(np.abs(around - point) - 0.5, 0.0)
        worst = min(worst, float(np.linalg.norm(apart, axis=1).min()))
    return worst * grid.resolution


def turns_of(plan, start, goal):
    """Return how often the robot turns, from the start's heading to the goal's."""
    headings = [start.yaw, *(pose.yaw for pose in plan.poses[:-1]), goal.yaw]
    changes = (wrap_angle(b - a) for a, b in pairwise(headings))
    return sum(abs(change) > 1e-3 for change in changes)


# ---------------------------------------------------------------- what every plan is


def test_every_point_of_every_segment_keeps_the_distance_from_every_obstacle():
    rng = np.random.default_rng(11)
    plans = 0
    for _ in range(25):
        grid = random_grid(rng, origin=Pose2D(*rng.uniform(-5.0, 5.0, 3)))
        planner = MeshPlanner(
            rng.uniform(0.2, 0.8), clearance_radius=rng.uniform(0.05, 0.5), start_tolerance=0.0
        )
        for _, _, plan in random_plans(rng, planner, grid, 12):
            assert least_clearance(grid, plan) >= planner.clearance_radius - 1e-6
            plans += 1
    assert plans > 60


def test_a_plan_goes_from_the_start_to_the_goal_pose():
    rng = np.random.default_rng(12)
    grid = random_grid(rng)
    for start, goal, plan in random_plans(rng, MeshPlanner(0.5, clearance_radius=0.2), grid, 40):
        assert plan.poses[0].distance_to(start) == 0.0
        assert plan.poses[-1] == goal
        assert plan.length >= start.distance_to(goal) - 1e-9


def test_pose_k_faces_along_segment_k():
    rng = np.random.default_rng(13)
    grid = random_grid(rng, origin=Pose2D(1.0, 2.0, 0.5))
    for _, _, plan in random_plans(rng, MeshPlanner(0.5, clearance_radius=0.2), grid, 40):
        for here, there in pairwise(plan.poses):
            assert here.yaw == pytest.approx(here.heading_to(there))


def test_no_turning_point_can_be_dropped():
    rng = np.random.default_rng(14)
    grid = random_grid(rng)
    for _, _, plan in random_plans(rng, MeshPlanner(0.5, clearance_radius=0.2), grid, 60):
        steps = np.diff(plan.corners, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        assert lengths.min() > 1e-6
        cross = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
        assert (np.abs(cross) > 1e-7 * lengths[:-1] * lengths[1:]).all()


def test_turning_points_are_crossings_of_the_mesh():
    rng = np.random.default_rng(15)
    grid = random_grid(rng, origin=Pose2D(-1.0, 0.5, 0.9))
    for _, _, plan in random_plans(rng, MeshPlanner(0.5, clearance_radius=0.2), grid, 40):
        lines = grid.world_to_map(plan.corners[1:-1]) * grid.resolution / 0.5
        assert lines == pytest.approx(np.round(lines), abs=1e-9)


# ---------------------------------------------------------------- the best of the mesh


def brute_force(grid, mesh, radius, start, goal):
    """
    Return length and turns of the best path over a mesh of whole cells, by scipy.

    Start and goal are crossings, given with bearings as (column, row, k * 45 degrees). The
    segments are sampled at eighths of a cell, which are exact in binary and hit every cell.
    """
    allowed = np.pad(~inflate(grid, radius), 1)

    def stands(x, y):
        around = [(int(np.ceil(y)), int(np.ceil(x))), (int(np.ceil(y)), int(x) + 1)]
        around += [(int(y) + 1, int(np.ceil(x))), (int(y) + 1, int(x) + 1)]
        return any(allowed[r, c] for r, c in around)

    moves = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    columns, rows = grid.width // mesh + 1, grid.height // mesh + 1
    turn = 1e-6
    edges = {}
    for c, r in np.ndindex(columns, rows):
        for k, (dc, dr) in enumerate(moves):
            if not (0 <= c + dc < columns and 0 <= r + dr < rows):
                continue
            eighths = np.arange(8 * mesh + 1) / 8.0
            if all(stands(c * mesh + dc * e, r * mesh + dr * e) for e in eighths):
                u, v = 8 * (c * rows + r), 8 * ((c + dc) * rows + r + dr)
                for arrived in range(8):
                    length = mesh * grid.resolution * math.hypot(dc, dr)
                    edges[u + arrived, v + k] = length + turn * (arrived != k)
    index = np.array(list(edges))
    n = 8 * rows * columns
    graph = csr_matrix((list(edges.values()), index.T), shape=(n, n))
    source, sink = (8 * (c * rows + r) for c, r, _ in (start, goal))
    costs = dijkstra(graph, indices=source + start[2])[sink : sink + 8]
    cost = (costs + turn * (np.arange(8) != goal[2])).min()
    if math.isinf(cost):
        return None
    length = math.floor(cost * 1e4) / 1e4
    return length, round((cost - _mesh_length(cost, mesh * grid.resolution)) / turn)


def _mesh_length(cost, width):
    """Return the length a + b sqrt 2 that a cost of length and a few turns holds."""
    b = np.arange(100) * math.sqrt(2.0) * width
    a = np.floor((cost - b) / width + 1e-9)
    lengths = np.where(a >= 0.0, b + a * width, -1.0)
    return lengths[np.argmin(np.where(lengths <= cost + 1e-9, cost - lengths, np.inf))]


def test_length_and_turns_are_the_least_of_the_whole_mesh():
    rng = np.random.default_rng(16)
    mesh, solved = 6, 0
    for _ in range(12):
        grid = random_grid(rng, 36, 48, boxes=7)
        planner = MeshPlanner(
            0.6, clearance_radius=0.15, connection_radius=1e-6, start_tolerance=0.0
        )
        prepared = planner.prepare(grid)
        crossings = np.argwhere(prepared.candidates)
        for _ in range(3):
            (r0, c0), (r1, c1) = crossings[rng.integers(0, len(crossings), 2)].tolist()
            k0, k1 = rng.integers(0, 8, 2).tolist()
            expected = brute_force(grid, mesh, 0.15, (c0, r0, k0), (c1, r1, k1))
            start = Pose2D(0.6 * c0, 0.6 * r0, k0 * math.pi / 4)
            goal = Pose2D(0.6 * c1, 0.6 * r1, k1 * math.pi / 4)
            if (r0, c0) == (r1, c1):
                continue
            try:
                plan = planner.plan(prepared, start, goal)
            except NoPathFound:
                assert expected is None
                continue
            except PlannerError:
                continue
            assert plan.length == pytest.approx(expected[0], abs=2e-4)
            assert turns_of(plan, start, goal) == expected[1]
            solved += 1
    assert solved > 20


def test_a_mirrored_map_has_a_mirrored_path_of_equal_length_and_turns():
    rng = np.random.default_rng(17)
    width = 60 * 0.1
    for _ in range(10):
        grid = random_grid(rng)
        mirrored = grid_of(grid.cells[:, ::-1])
        planner = MeshPlanner(0.6, clearance_radius=0.15)
        for start, goal, plan in random_plans(rng, planner, grid, 8):
            start_, goal_ = (Pose2D(width - p.x, p.y, math.pi - p.yaw) for p in (start, goal))
            plan_ = planner.plan(mirrored, start_, goal_)
            assert plan_.length == pytest.approx(plan.length, abs=1e-5)
            assert turns_of(plan_, start_, goal_) == turns_of(plan, start, goal)


def test_where_one_path_is_the_best_the_mirrored_map_has_its_mirror_image():
    cells = np.zeros((60, 60), np.int8)
    cells[:42, 28:32] = 100
    planner = MeshPlanner(0.6, clearance_radius=0.5)
    plan = planner.plan(grid_of(cells), Pose2D(1.2, 1.8, 0.0), Pose2D(4.8, 1.2, 0.0))
    plan_ = planner.plan(grid_of(cells[:, ::-1]), Pose2D(4.8, 1.8, 0.0), Pose2D(1.2, 1.2, 0.0))
    assert len(plan.poses) > 3
    assert plan_.length == pytest.approx(plan.length)
    assert plan_.corners[:, 1] == pytest.approx(plan.corners[:, 1])
    assert 6.0 - plan_.corners[:, 0] == pytest.approx(plan.corners[:, 0])


def test_a_map_with_a_moved_and_turned_origin_has_a_moved_and_turned_plan():
    rng = np.random.default_rng(18)
    grid = random_grid(rng)
    origin = Pose2D(1.3, -2.1, 0.7)
    turned = grid_of(grid.cells, origin=origin)
    planner = MeshPlanner(0.5, clearance_radius=0.2)
    for start, goal, plan in random_plans(rng, planner, grid, 30):
        plan_ = planner.plan(turned, origin @ start, origin @ goal)
        assert len(plan_.poses) == len(plan.poses)
        for pose, pose_ in zip(plan.poses, plan_.poses, strict=True):
            expected = origin @ pose
            assert pose_.distance_to(expected) < 1e-6
            assert abs(wrap_angle(pose_.yaw - expected.yaw)) < 1e-6


def test_a_prepared_map_gives_the_same_plan_as_a_bare_one():
    rng = np.random.default_rng(19)
    grid = random_grid(rng)
    planner = MeshPlanner(0.5, clearance_radius=0.2)
    for start, goal, plan in random_plans(rng, planner, grid, 10):
        assert planner.plan(grid, start, goal) == plan


def test_a_near_goal_is_walked_to_straight():
    plan = MeshPlanner(0.6, clearance_radius=0.3).plan(
        grid_of(np.zeros((40, 40))), Pose2D(1.0, 1.0, 2.0), Pose2D(1.7, 1.9, 1.0)
    )
    assert len(plan.poses) == 2
    assert plan.length == pytest.approx(math.hypot(0.7, 0.9))


def test_equal_lengths_are_walked_with_the_fewest_turns():
    # Ten crossings along and four diagonally: one turn between them does.
    planner = MeshPlanner(0.6, clearance_radius=0.1, connection_radius=1e-6)
    grid = grid_of(np.zeros((60, 120)))
    plan = planner.plan(grid, Pose2D(0.6, 0.6, 0.0), Pose2D(9.0, 3.0, math.pi / 4))
    assert plan.corners.tolist() == pytest.approx(np.array([[0.6, 0.6], [6.6, 0.6], [9.0, 3.0]]))


@pytest.mark.parametrize(
    ('start_yaw', 'goal_yaw', 'corner'),
    [(0.0, math.pi / 2, (6.6, 0.6)), (math.pi / 2, 0.0, (3.0, 3.0))],
)
def test_the_headings_at_start_and_goal_count_as_turns(start_yaw, goal_yaw, corner):
    planner = MeshPlanner(0.6, clearance_radius=0.1, connection_radius=1e-6)
    grid = grid_of(np.zeros((60, 120)))
    plan = planner.plan(grid, Pose2D(0.6, 0.6, start_yaw), Pose2D(9.0, 3.0, goal_yaw))
    assert plan.corners[1:-1].tolist() == [pytest.approx(corner)]


@pytest.mark.parametrize('origin', [UPRIGHT, Pose2D(2.0, 1.0, 0.7)])
@pytest.mark.parametrize('side', [1.0, -1.0])
def test_of_two_ways_to_the_mesh_the_one_ahead_is_taken(origin, side):
    planner = MeshPlanner(0.6, clearance_radius=0.1, connection_radius=0.35)
    grid = grid_of(np.zeros((60, 120)), origin=origin)
    start = origin @ Pose2D(0.6, 0.9, side * math.pi / 2)
    goal = origin @ Pose2D(6.0, 0.9, 0.0)
    plan = planner.plan(grid, start, goal)
    rows = grid.world_to_map(plan.corners)[1:-1, 1]
    assert rows == pytest.approx([9.0 + 3.0 * side] * 2)


def test_a_corridor_in_which_one_row_of_cells_is_allowed_is_walked_through():
    cells = np.full((21, 60), 100)
    cells[9:12] = 0
    cells[:, :8] = cells[:, -8:] = 0
    grid = grid_of(cells)
    assert (~inflate(grid, 0.1))[:, 30].sum() == 1
    plan = MeshPlanner(0.35, clearance_radius=0.1).plan(
        grid, Pose2D(0.3, 0.3, 0.0), Pose2D(5.7, 0.3, 0.0)
    )
    assert least_clearance(grid, plan) >= 0.1 - 1e-9


# ---------------------------------------------------------------- start and goal


def test_who_is_there_already_only_turns():
    goal = Pose2D(2.0004, 2.0, 1.0)
    plan = MeshPlanner(0.6, clearance_radius=0.3).plan(
        grid_of(np.zeros((40, 40))), Pose2D(2.0, 2.0, 0.0), goal
    )
    assert plan == Plan((goal,))
    assert plan.length == 0.0


def walled():
    """Return a 6 m x 4 m map with a wall from x = 3.0 to 3.1 that leaves no passage."""
    cells = np.zeros((40, 60))
    cells[:, 30] = 100
    return grid_of(cells)


def test_a_robot_that_strayed_over_the_boundary_leaves_it_without_going_nearer():
    planner = MeshPlanner(0.6, clearance_radius=0.5, start_tolerance=0.1)
    start, goal = Pose2D(2.57, 2.2, 0.0), Pose2D(0.9, 0.7, 0.0)
    plan = planner.plan(walled(), start, goal)
    first = Plan(plan.poses[:2])
    assert least_clearance(walled(), first) == pytest.approx(3.0 - 2.57)
    assert least_clearance(walled(), Plan(plan.poses[1:])) >= 0.5 - 1e-9


def test_a_robot_that_strayed_further_may_not_start():
    planner = MeshPlanner(0.6, clearance_radius=0.5, start_tolerance=0.1)
    sentence = r'start \(2.63, 2.20\) m is 0.37 m from the nearest .* the robot needs 0.40 m'
    with pytest.raises(StartOccupied, match=sentence):
        planner.plan(walled(), Pose2D(2.63, 2.2, 0.0), Pose2D(0.9, 0.7, 0.0))


def test_no_tolerance_lets_a_robot_start_inside_an_obstacle():
    planner = MeshPlanner(0.6, clearance_radius=0.05, start_tolerance=1.0)
    with pytest.raises(StartOccupied, match=r'is 0\.00 m from the nearest'):
        planner.plan(walled(), Pose2D(3.05, 2.2, 0.0), Pose2D(0.9, 0.7, 0.0))


def test_the_goal_has_no_tolerance():
    with pytest.raises(GoalOccupied, match=r'goal \(2.57, 2.20\) m is 0.43 m .* needs 0.50 m'):
        MeshPlanner(0.6, clearance_radius=0.5).plan(
            walled(), Pose2D(0.9, 0.7, 0.0), Pose2D(2.57, 2.2, 0.0)
        )


def test_a_goal_exactly_at_the_clearance_is_reached():
    plan = MeshPlanner(0.6, clearance_radius=0.5).plan(
        walled(), Pose2D(0.9, 0.7, 0.0), Pose2D(2.5, 2.2, 0.0)
    )
    assert plan.poses[-1] == Pose2D(2.5, 2.2, 0.0)


def test_a_start_or_goal_beside_the_map_is_outside():
    inside, outside = Pose2D(1.0, 1.0, 0.0), Pose2D(6.2, 1.0, 0.0)
    spans = r'\(6.20, 1.00\) m is outside the map, which spans x 0.00 to 6.00 m'
    with pytest.raises(StartOutsideMap, match=f'start {spans}'):
        MeshPlanner(0.6, clearance_radius=0.5).plan(walled(), outside, inside)
    with pytest.raises(GoalOutsideMap, match=f'goal {spans}'):
        MeshPlanner(0.6, clearance_radius=0.5).plan(walled(), inside, outside)


@pytest.mark.parametrize('number', [math.nan, math.inf])
def test_a_pose_that_is_not_finite_is_no_pose(number):
    pose = Pose2D(1.0, 1.0, 0.0)
    with pytest.raises(InvalidPose, match=r'the start is not a pose: .* three finite numbers'):
        MeshPlanner(0.6, clearance_radius=0.5).plan(walled(), Pose2D(number, 1.0, 0.0), pose)
    with pytest.raises(InvalidPose, match='the goal is not a pose'):
        MeshPlanner(0.6, clearance_radius=0.5).plan(walled(), pose, Pose2D(1.0, 1.0, number))


# ---------------------------------------------------------------- no path


def test_a_wall_between_start_and_goal_is_named_as_the_reason():
    with pytest.raises(NoPathFound, match=r'are not connected for a robot that needs 0.50 m'):
        MeshPlanner(0.6, clearance_radius=0.5).plan(
            walled(), Pose2D(1.0, 1.0, 0.0), Pose2D(5.0, 1.0, 0.0)
        )


def pocket():
    """Return a map with a niche about x = 2.05, 0.5 m wide, below a hall."""
    cells = np.zeros((60, 60))
    cells[:30] = 100
    cells[:30, 18:23] = 0
    return grid_of(cells)


def test_a_mesh_too_coarse_at_the_start_or_the_goal_is_named_as_the_reason():
    planner = MeshPlanner(0.9, clearance_radius=0.2, connection_radius=0.5)
    niche, hall = Pose2D(2.05, 1.0, 0.0), Pose2D(4.5, 4.5, 0.0)
    coarse = r'the mesh of 0\.90 m may be too coarse for this passage'
    leaves = rf'no mesh crossing is reachable from the start; {coarse}'
    arrives = rf'the goal is reachable from no mesh crossing; {coarse}'
    with pytest.raises(NoPathFound, match=leaves):
        planner.plan(pocket(), niche, hall)
    with pytest.raises(NoPathFound, match=arrives):
        planner.plan(pocket(), hall, niche)
    assert MeshPlanner(0.2, clearance_radius=0.2, connection_radius=0.5).plan(pocket(), niche, hall)


def test_a_mesh_too_coarse_for_a_passage_is_named_as_the_reason():
    cells = np.zeros((40, 60))
    cells[:, 27:33] = 100
    cells[22:27, 27:33] = 0
    start, goal = Pose2D(0.9, 0.9, 0.0), Pose2D(5.1, 0.9, 0.0)
    with pytest.raises(
        NoPathFound, match=r'no path over the mesh connects them; the mesh of 0\.90'
    ):
        MeshPlanner(0.9, clearance_radius=0.2).plan(grid_of(cells), start, goal)
    assert MeshPlanner(0.35, clearance_radius=0.2).plan(grid_of(cells), start, goal)


@pytest.mark.usefixtures('nothing_is_compiled')
def test_a_search_stops_at_its_time_limit():
    ticks = iter(range(10**6))
    planner = MeshPlanner(
        0.1, clearance_radius=0.2, time_limit=0.5, clock=lambda: float(next(ticks))
    )
    with pytest.raises(PlannerTimedOut, match=r'limit of 0\.50 s'):
        planner.plan(grid_of(np.zeros((60, 60))), Pose2D(1.0, 1.0, 0.0), Pose2D(5.0, 5.0, 0.0))


# ---------------------------------------------------------------- parameters and the planner


@pytest.mark.parametrize(
    'options',
    [
        {'mesh_size': 0.0},
        {'mesh_size': math.nan},
        {'clearance_radius': 0.0},
        {'connection_radius': -1.0},
        {'start_tolerance': -0.1},
    ],
)
def test_a_length_that_is_none_is_refused(options):
    (name,) = options
    with pytest.raises(ParameterError, match=rf"'{name}' is .*; it must be a finite length"):
        MeshPlanner(**{'mesh_size': 0.6, 'clearance_radius': 0.5, **options})


def test_a_mesh_that_would_be_too_fine_for_the_map_is_refused():
    with pytest.raises(ParameterError, match=r"'mesh_size' is 0.001; it must be above 0.004 m"):
        MeshPlanner(0.001, clearance_radius=0.5).prepare(grid_of(np.zeros((40, 40))))


def test_an_unknown_method_is_refused_with_the_known_ones():
    with pytest.raises(InvalidPlanner, match="no planning method 'magic'; available: mesh"):
        make_planner('magic')


def test_a_planner_without_a_map_says_so():
    planner = make_planner('mesh', mesh_size=0.6, clearance_radius=0.5)
    with pytest.raises(PlannerError, match='there is no map to plan on yet'):
        planner.plan(Pose2D(1.0, 1.0, 0.0), Pose2D(2.0, 2.0, 0.0))


def test_a_planner_keeps_its_map_when_the_next_one_is_refused():
    planner = make_planner('mesh', mesh_size=0.01, clearance_radius=0.1)
    planner.set_map(grid_of(np.zeros((40, 40)), 0.02))
    before = planner.prepared
    with pytest.raises(ParameterError):
        planner.set_map(grid_of(np.zeros((400, 400)), 1.0))
    assert planner.prepared is before
    assert planner.plan(Pose2D(0.2, 0.2, 0.0), Pose2D(0.5, 0.6, 0.0)).length > 0.0


def test_a_plan_leaves_out_what_is_no_turn():
    plan = Plan.through([(0, 0), (1, 0), (1, 0), (2, 0), (2, 1), (2, 3), (1, 3)], 0.5)
    assert plan.corners.tolist() == [[0, 0], [2, 0], [2, 3], [1, 3]]
    assert [pose.yaw for pose in plan.poses] == pytest.approx([0.0, math.pi / 2, math.pi, 0.5])
    assert plan.length == 6.0


# ---------------------------------------------------------------- whole maps


@pytest.mark.parametrize(
    ('name', 'start', 'goal'),
    [
        ('room', (1.2, 1.2), (6.8, 4.8)),
        ('office', (2.0, 2.4), (12.0, 8.4)),
        ('office', (6.9, 2.2), (3.4, 8.0)),
    ],
)
def test_the_sample_maps_are_walked_with_several_turns(name, start, goal):
    grid = load_map(ROOT / 'maps' / f'{name}.yaml')
    plan = MeshPlanner(0.628, clearance_radius=0.55).plan(
        grid, Pose2D(*start, 0.0), Pose2D(*goal, 0.0)
    )
    assert len(plan.poses) >= 5
    assert least_clearance(grid, plan) >= 0.55 - 1e-9


@pytest.mark.skipif(not SHARED.is_dir(), reason='the shared maps are not here')
@pytest.mark.parametrize('name', ['warehouse/warehouse', 'depot/depot'])
def test_maps_that_others_made_are_walked(name):
    rng = np.random.default_rng(20)
    grid = load_map(SHARED / f'{name}.yaml')
    planner = MeshPlanner(0.628, clearance_radius=0.5, start_tolerance=0.0)
    plans = [plan for _, _, plan in random_plans(rng, planner, grid, 12)]
    assert len(plans) >= 3
    assert all(least_clearance(grid, plan) >= 0.5 - 1e-6 for plan in plans)
