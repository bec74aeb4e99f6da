"""The quickest path keeps clear, and is never slower than the shortest or the mesh's."""

import math
from itertools import count, pairwise

import numpy as np
import pytest
from test_shortest_planner import BOTH, floor, random_floor

from quad_common.errors import NoPathFound, PlannerError, PlannerTimedOut
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.grid.clearance import segment_clearance
from quad_planner.methods.mesh_planner import MeshPlanner
from quad_planner.methods.quickest_planner import QuickestPlanner
from quad_planner.methods.shortest_planner import ShortestPlanner

CRAWL = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2))
TROT = WalkingTimeModel(cycle_period=0.5, stride=0.17, turn=math.radians(28.0), stopping=0.7)


@pytest.mark.parametrize('seed', range(30))
def test_plans_keep_clear_all_along_and_none_is_slower_than_simpler_ones(seed):
    rng = np.random.default_rng(seed)
    grid = random_floor(rng)
    pace = (CRAWL, TROT)[seed % 2]
    radius = float(rng.choice([0.6, 1.2, 2.3])) * grid.resolution
    shared = {'clearance_radius': radius, 'start_tolerance': 0.5 * radius}
    mesh = MeshPlanner(6.0 * grid.resolution, **shared)
    planners = [
        ShortestPlanner(**shared),
        QuickestPlanner(pace=pace, **shared),
        QuickestPlanner(pace=pace, any_angle=True, **shared),
    ]
    prepared = planners[0].prepare(grid)
    for _ in range(4):
        ends = grid.map_to_world(rng.random((2, 2)) * [grid.width, grid.height])
        start, goal = (Pose2D(*end.tolist(), float(rng.uniform(-3.0, 3.0))) for end in ends)
        try:
            plans = [planner.plan(prepared, start, goal) for planner in planners]
        except PlannerError:
            continue
        for plan in plans:
            assert plan.poses[-1].distance_to(goal) < 1e-9
            assert plan.poses[-1].yaw == goal.yaw
            corners = grid.world_to_map(plan.corners)
            for k, (a, b) in enumerate(pairwise(corners)):
                keep = radius / grid.resolution
                if k == 0:
                    keep = min(keep, segment_clearance(prepared.blocked_bits, a, a))
                assert segment_clearance(prepared.blocked_bits, a, b) >= keep - 1e-6
        shortest, over_cells, at_any_angle = (pace.cycles(start, plan) for plan in plans)
        assert at_any_angle <= over_cells <= shortest
        try:
            on_mesh = mesh.plan(mesh.prepare(grid), start, goal)
        except PlannerError:
            continue
        # Ends join the mesh by segments that are measured exactly; these keep to the cells.
        points = grid.world_to_map(on_mesh.corners)
        keeps_to_cells = all(prepared.is_allowed(point) for point in points) and all(
            prepared.is_reachable_straight(a, b, radius) for a, b in pairwise(points)
        )
        if not keeps_to_cells:
            continue
        # A mesh may turn elsewhere, but hardly to advantage.
        assert at_any_angle <= pace.cycles(start, on_mesh) + 2


@BOTH
def test_a_detour_saves_turns(any_angle):
    # Three walls with gaps that are not in line, and a lane above them all.
    gaps = (8, 14, 8)
    boxes = [(12 + 10 * k, 0, 1, gap) for k, gap in enumerate(gaps)]
    boxes += [(12 + 10 * k, gap + 6, 1, 27 - gap) for k, gap in enumerate(gaps)]
    grid = floor(46, 40, 0.1, boxes=boxes)
    slow = WalkingTimeModel(cycle_period=5.0, stride=0.2, turn=math.radians(5.0))
    start, goal = (
        Pose2D(0.55, 1.05, math.radians(90.0)),
        Pose2D(4.05, 1.05, math.radians(-90.0)),
    )
    shortest = ShortestPlanner(clearance_radius=0.15, any_angle=any_angle)
    quickest = QuickestPlanner(clearance_radius=0.15, pace=slow, any_angle=any_angle)
    prepared = shortest.prepare(grid)
    plans = [planner.plan(prepared, start, goal) for planner in (shortest, quickest)]
    assert plans[1].length > plans[0].length
    assert slow.cycles(start, plans[1]) < slow.cycles(start, plans[0])


@BOTH
def test_start_and_goal_in_one_place_are_a_turn(any_angle):
    planner = QuickestPlanner(clearance_radius=0.2, pace=CRAWL, any_angle=any_angle)
    goal = Pose2D(1.0, 1.0, 2.0)
    plan = planner.plan(planner.prepare(floor()), Pose2D(1.0, 1.0, 0.0), goal)
    assert plan.poses == (goal,)


@BOTH
def test_start_and_goal_in_one_cell_are_a_straight_line(any_angle):
    planner = QuickestPlanner(clearance_radius=0.2, pace=CRAWL, any_angle=any_angle)
    start, goal = Pose2D(1.01, 1.01, 0.0), Pose2D(1.08, 1.05, 2.0)
    plan = planner.plan(planner.prepare(floor()), start, goal)
    assert len(plan.poses) == 2
    assert plan.length == pytest.approx(start.distance_to(goal))


@BOTH
def test_areas_that_are_not_connected_have_no_path(any_angle):
    planner = QuickestPlanner(clearance_radius=0.2, pace=CRAWL, any_angle=any_angle)
    prepared = planner.prepare(floor(boxes=[(20, 0, 1, 30)]))
    with pytest.raises(NoPathFound, match='not connected'):
        planner.plan(prepared, Pose2D(1.0, 1.0, 0.0), Pose2D(3.0, 1.0, 0.0))


@pytest.mark.usefixtures('nothing_is_compiled')
@BOTH
def test_the_time_limit_ends_a_search(any_angle):
    ticks = count()
    planner = QuickestPlanner(
        clearance_radius=0.2,
        pace=CRAWL,
        any_angle=any_angle,
        time_limit=0.5,
        clock=lambda: float(next(ticks)),
    )
    prepared = planner.prepare(floor(boxes=[(20, 0, 1, 20)]))
    with pytest.raises(PlannerTimedOut, match='within the limit'):
        planner.plan(prepared, Pose2D(1.0, 1.0, 0.0), Pose2D(3.0, 1.0, 0.0))
