"""
Plans by the outline: they go where brute force goes, and the robot fits all along.
"""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.errors import GoalOccupied, NoPathFound, ParameterError, PlannerError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_gait.following.reference_path import rounded_pieces
from quad_lab.benchmarks.planning.footprint_maps import free_classes, office, reachable
from quad_planner.methods.outline_planner import BY_OUTLINE, OutlinePlanner
from quad_planner.methods.shortest_planner import ShortestPlanner
from quad_planner.outline.arcs import ArcTurns
from quad_planner.outline.heading_kernels import STEP
from quad_planner.outline.heading_moves import moves_from
from quad_planner.outline.robot_outline import outer_radius
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import outline_for, planner_for, planner_from_parameters

CELL = 0.05
LONG = '[[0.3, 0.15], [-0.45, 0.15], [-0.45, -0.15], [0.3, -0.15]]'
OUTLINE = np.array([[0.3, 0.15], [-0.45, 0.15], [-0.45, -0.15], [0.3, -0.15]])
SAFETY = 0.05
ROBOT = load_robot('titan_viii')


def two_rooms(door, height=60):
    """Return two rooms of 2.5 m with a door of so many cells in the wall between them."""
    cells = np.zeros((height, 104), dtype=np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    cells[:, 51:53] = 100
    low = (height - door) // 2
    cells[low : low + door, 51:53] = 0
    return OccupancyGrid(cells, CELL, Pose2D(0.0, 0.0, 0.0))


def planner_on(grid, method='shortest', tolerance=0.0, text=LONG, any_angle=True, **options):
    outline = outline_for(ROBOT, SAFETY, text, start_tolerance=tolerance, **options)
    planner = planner_for(
        ROBOT, method, SAFETY, outline, start_tolerance=tolerance, any_angle=any_angle
    )
    planner.set_map(grid)
    return planner


def clearance(grid, pose):
    """Return how far the outline at a pose is from the nearest obstacle, by a millimetre [m]."""
    ends = np.roll(OUTLINE, -1, axis=0)
    edge = np.concatenate(
        [a + (b - a) * np.linspace(0.0, 1.0, 100)[:, None] for a, b in zip(OUTLINE, ends)]
    )
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    points = edge @ np.array([[cos, sin], [-sin, cos]]) + (pose.x, pose.y)
    rows, columns = np.nonzero(grid.cells)
    near = np.hypot(columns * CELL - pose.x, rows * CELL - pose.y) < 0.8
    low = np.column_stack((columns, rows))[near][:, None] * CELL
    apart = np.maximum(np.maximum(low - points, points - low - CELL), 0.0)
    return float(np.hypot(*np.moveaxis(apart, -1, 0)).min()) if near.any() else math.inf


def poses_along(start, plan):
    """Return the poses of a robot that turns on the spot and walks ahead, finely."""
    heading = start.yaw
    for here, there in pairwise([*plan.poses, None]):
        turn = wrap_angle(here.yaw - heading)
        for part in np.linspace(0.0, 1.0, 8):
            yield Pose2D(here.x, here.y, heading + part * turn)
        heading = here.yaw
        for part in np.linspace(0.0, 1.0, 20) if there else ():
            x, y = here.x + part * (there.x - here.x), here.y + part * (there.y - here.y)
            yield Pose2D(x, y, heading)


@pytest.mark.parametrize('door', [10, 11, 14])
def test_the_outline_fits_all_along_its_plans(door):
    grid = two_rooms(door)
    planner = planner_on(grid)
    rng = np.random.default_rng(door)
    for _ in range(4):
        start, goal = (
            Pose2D(*rng.uniform((x, 0.8), (x + 0.9, 2.2)), rng.uniform(-3, 3)) for x in (0.8, 3.5)
        )
        if door == 10:
            # 0.5 m: the outline needs 0.44 m at all headings of a class, in whole cells.
            with pytest.raises(NoPathFound):
                planner.plan(start, goal)
            continue
        plan = planner.plan(start, goal)
        assert plan.remark == BY_OUTLINE
        assert min(clearance(grid, pose) for pose in poses_along(start, plan)) > SAFETY - 2e-3


def test_goals_are_reached_if_brute_force_reaches_them_and_no_others():
    circle = ShortestPlanner(clearance_radius=outer_radius(OUTLINE) + SAFETY)
    planner = OutlinePlanner(circle, outline_for(ROBOT, SAFETY, LONG))
    answers = []
    for seed in range(6):
        rng = np.random.default_rng(seed)
        prepared = planner.prepare(office(120, CELL, rng))
        free = free_classes(prepared.blocked, prepared.allowed, prepared.kernels[0])
        states = np.argwhere(free)
        start, *goals = (tuple(map(int, states[rng.integers(len(states))])) for _ in range(9))
        ends = reachable(free, moves_from(0.5, 0.5), start)
        for goal in goals:
            poses = [
                Pose2D((x + 0.5) * CELL, (y + 0.5) * CELL, k * STEP) for k, y, x in (start, goal)
            ]
            found = planner.plan_by_outline(prepared, *poses) is not None
            assert found == bool(ends[goal])
            answers.append(found)
    assert 0.1 < np.mean(answers) < 0.95


@pytest.mark.parametrize('method', ['mesh', 'shortest', 'quickest'])
def test_a_plan_by_the_circle_is_neither_refused_nor_quicker(method):
    pace = WalkingTimeModel(cycle_period=5.0, stride=0.2, turn=0.7)
    outline = outline_for(ROBOT, SAFETY, pace=pace)
    ours, circles = (
        planner_for(ROBOT, method, SAFETY, footprint, start_tolerance=0.0, pace=pace)
        for footprint in (outline, None)
    )
    plans = 0
    for seed in range(3):
        rng = np.random.default_rng(seed)
        grid = office(120, CELL, rng)
        for planner in (ours, circles):
            planner.set_map(grid)
        cells = np.argwhere(circles.prepared.allowed)
        for _ in range(5):
            start, goal = (
                Pose2D(CELL * (x + 0.4), CELL * (y + 0.7), rng.uniform(-3, 3))
                for y, x in cells[rng.integers(len(cells), size=2)]
            )
            try:
                known = circles.plan(start, goal)
            except NoPathFound:
                continue
            plans += 1
            assert pace.cycles(start, ours.plan(start, goal)) <= pace.cycles(start, known)
    assert plans > 5


def test_a_crab_keeps_the_heading_of_its_start():
    # Sideways the outline is 0.75 m wide, ahead 0.3 m.
    planner = planner_on(two_rooms(11), keeps_heading=True)
    goal = Pose2D(4.0, 1.5, 0.1)
    assert planner.plan(Pose2D(1.0, 1.2, 0.0), goal).remark == BY_OUTLINE
    with pytest.raises(NoPathFound):
        planner.plan(Pose2D(1.0, 1.2, math.pi / 2.0), goal)


def test_arcs_round_corners_only_as_far_as_the_outline_fits():
    grid = two_rooms(11)
    arcs = ArcTurns(corner_deviation=0.3, corner_radius=1.0)
    planner = planner_on(grid, arcs=arcs)
    for y, yaw in ((0.9, 1.5), (2.2, -1.0), (1.5, 0.0)):
        start = Pose2D(1.9, y, yaw)
        plan = planner.plan(start, Pose2D(3.6, 3.1 - y, yaw))
        pieces = rounded_pieces(plan, arcs.corner_deviation, arcs.corner_radius, 0.2)
        for piece in pieces:
            for part in np.linspace(0.0, piece.length, 15):
                # The smallest arcs are a turn on the spot, to half a cell.
                assert clearance(grid, piece.at(part)) > SAFETY - CELL / 2.0


def test_goals_near_walls_and_starts_that_strayed():
    grid, there = two_rooms(11), Pose2D(4.0, 2.0, 0.0)
    planner = planner_on(grid)
    # Ahead the outline reaches 0.3 m, behind 0.45 m.
    facing = Pose2D(1.2, 0.05 + 0.3 + SAFETY + 0.07, -math.pi / 2.0)
    assert planner.plan(Pose2D(1.3, 1.5, 0.0), facing).remark == BY_OUTLINE
    with pytest.raises(GoalOccupied):
        planner.plan(Pose2D(1.3, 1.5, 0.0), Pose2D(facing.x, facing.y, math.pi / 2.0))
    strayed = Pose2D(1.2, 0.05 + 0.45 + 0.06, math.pi / 2.0)
    with pytest.raises(PlannerError):
        planner.plan(strayed, there)
    assert planner_on(grid, tolerance=SAFETY).plan(strayed, there).remark == BY_OUTLINE


def test_a_turn_where_the_robot_stands_is_made_if_it_fits():
    planner = planner_on(two_rooms(11, height=20))
    here = Pose2D(1.2, 0.5, 0.0)
    # Along the room it fits, across it does not.
    assert len(planner.plan(here, Pose2D(here.x, here.y, 0.1)).poses) == 1
    with pytest.raises(PlannerError):
        planner.plan(here, Pose2D(here.x, here.y, math.pi))


def test_a_map_that_changes_in_part_is_planned_on_as_a_new_one():
    planner = planner_on(two_rooms(11))
    start, goal = Pose2D(1.0, 1.0, 0.0), Pose2D(4.0, 2.0, 0.0)
    before = planner.plan(start, goal)
    planner.set_map(two_rooms(0))
    with pytest.raises(NoPathFound):
        planner.plan(start, goal)
    planner.set_map(two_rooms(11))
    assert planner.plan(start, goal) == before


def test_the_node_plans_by_the_outline_if_it_is_set():
    def planned(**values):
        parameters = PlannerParameters(method='shortest', safety_distance=SAFETY, **values)
        planner = planner_from_parameters(parameters, ROBOT)
        planner.set_map(two_rooms(17))
        return planner.plan(Pose2D(1.0, 1.2, 0.0), Pose2D(4.0, 1.5, 0.0))

    # A door of 0.85 m, for 0.65 m between the feet and 0.75 m across.
    with pytest.raises(NoPathFound):
        planned()
    assert planned(footprint='outline').remark == BY_OUTLINE
    with pytest.raises(ParameterError, match='outline'):
        planned(footprint='outline', outline='wide')
