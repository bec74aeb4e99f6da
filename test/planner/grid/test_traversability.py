"""What is lower than a step is stepped over; what is higher or too steep is walked around."""

import math
from itertools import pairwise

import cv2
import numpy as np
import pytest
from scipy import ndimage

from quad_common.errors import NoPathFound, ParameterError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.grid.cell_overlap import cells_touched
from quad_planner.grid.clearance import segment_clearance
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.ground_shape import high_steps, steep_slopes
from quad_planner.grid.traversability import Ground
from quad_planner.methods.planner import make_planner

ROBOT = load_robot('titan_viii')
LIMITS = GroundLimits.of(ROBOT)
CLEARANCE = ROBOT.footprint_radius + 0.12
STEP = ROBOT.step_height
CRAWL = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2))


def ground(width=6.0, depth=4.0, resolution=0.02, boxes=(), slope=0.0, origin=(0.0, 0.0)):
    """Level ground, or a plane that rises along x, with boxes: x, y, length, width, height."""
    level = HeightMap.level((*origin, origin[0] + width, origin[1] + depth), resolution)
    x, y = np.moveaxis(level.centers, -1, 0)
    heights = slope * x
    for bx, by, length, across, height in boxes:
        inside = (np.abs(x - bx) < length / 2.0) & (np.abs(y - by) < across / 2.0)
        heights = np.where(inside, heights + height, heights)
    return level.with_heights(heights)


def floor(width=6.0, depth=4.0, resolution=0.05, origin=(0.0, 0.0, 0.0)):
    cells = np.zeros((round(depth / resolution), round(width / resolution)), dtype=np.int8)
    return OccupancyGrid(cells, resolution, Pose2D(*origin))


def obstacles(heights, limits=LIMITS):
    return Ground(heights, limits).obstacles


def planned(method, grid, start, goal, **options):
    planner = make_planner(
        method, mesh_size=ROBOT.mesh_size, clearance_radius=CLEARANCE, pace=CRAWL, **options
    )
    planner.set_map(grid)
    return planner, planner.plan(start, goal)


# ---- steps ----


def test_a_box_is_an_obstacle_exactly_if_it_is_higher_than_the_step_height():
    for height in (0.02, STEP - 0.001, STEP, -STEP):
        assert not obstacles(ground(boxes=[(3.0, 2.0, 0.6, 0.4, height)])).any()
    for height in (STEP + 0.001, 0.3, -STEP - 0.001, -0.3):
        assert obstacles(ground(boxes=[(3.0, 2.0, 0.6, 0.4, height)])).any()


def test_of_a_high_box_the_cells_on_both_sides_of_its_faces_are_marked():
    heights = ground(boxes=[(3.0, 2.0, 0.6, 0.4, 0.3)])
    marked = obstacles(heights)
    x, y = np.moveaxis(heights.centers, -1, 0)
    beyond = np.maximum(np.abs(x - 3.0) - 0.3, np.abs(y - 2.0) - 0.2)
    assert (marked == (np.abs(beyond) < 0.02)).all()


def test_marks_do_not_depend_on_how_the_ground_is_turned_or_mirrored_or_how_high_it_lies():
    rng = np.random.default_rng(5)
    boxes = [(*rng.uniform((0.5, 0.5), 3.5), *rng.uniform(0.1, 0.8, 2), 0.2) for _ in range(6)]
    heights = ground(4.0, 4.0, boxes=boxes, slope=0.1)
    marked = obstacles(heights)
    assert marked.any()
    for change in (np.fliplr, np.flipud, np.rot90, np.transpose, np.negative):
        changed = obstacles(heights.with_heights(np.ascontiguousarray(change(heights.heights))))
        assert (changed == (marked if change is np.negative else change(marked))).all()
    assert (obstacles(heights.with_heights(heights.heights + 700.0)) == marked).all()


@pytest.mark.parametrize('height', [0.06, 0.3])
def test_faces_that_are_blurred_count_as_upright_ones_do(height):
    sharp = ground(boxes=[(3.0, 2.0, 2.0, 2.0, height)])
    # As if it had been interpolated to other cells and back: over three cells.
    at = sharp.centers
    blurred = sharp.with_heights(
        np.mean([sharp.height_at(np.clip(at + d, 0.0, (6.0, 4.0))) for d in (-0.013, 0.013)], 0)
    )
    assert obstacles(blurred).any() == (height > STEP)
    if height > STEP:
        away = np.abs(np.maximum(*np.moveaxis(np.abs(at - (3.0, 2.0)), -1, 0)) - 1.0)
        assert (away[obstacles(blurred)] < 0.05).all()
        # Closed all around: nobody slips in between marked cells.
        areas, _ = ndimage.label(~obstacles(blurred))
        assert areas[100, 150] not in (0, areas[0, 0])


def test_noise_of_some_millimetres_changes_nothing_for_what_is_clearly_low_or_high():
    rng = np.random.default_rng(1)
    boxes = [(1.5, 2.0, 0.5, 0.5, 0.05), (4.5, 2.0, 0.5, 0.5, 0.15)]
    heights = ground(boxes=boxes)
    noisy = heights.with_heights(heights.heights + rng.normal(0.0, 0.003, heights.heights.shape))
    marked = obstacles(noisy)
    left = heights.centers[..., 0] < 3.0
    assert not marked[left].any()
    assert marked[obstacles(heights)].all()


def test_a_plateau_that_is_reached_by_a_ramp_is_free_and_walled_elsewhere():
    heights = ground()
    x, y = np.moveaxis(heights.centers, -1, 0)
    # 0.3 m high from x = 3.5 m on, with a ramp of 11 degrees up to it in the lower half.
    ramp = np.clip((x - 2.0) / 1.5, 0.0, 1.0) * 0.3
    plateau = np.where(y < 2.0, ramp, np.where(x > 3.5, 0.3, 0.0))
    grid = Ground(heights.with_heights(plateau), LIMITS).added_to(floor())
    assert grid.occupied()[60, 69:71].all()
    assert not grid.occupied()[:20].any()
    _, plan = planned(
        'shortest', grid, Pose2D(0.8, 3.2, 0.0), Pose2D(5.2, 3.2, 0.0), any_angle=True
    )
    # Down, up the ramp and along the plateau.
    assert plan.corners[:, 1].min() < 2.0 - CLEARANCE + 0.05
    walled = Ground(heights.with_heights(np.where(x > 3.5, 0.3, 0.0)), LIMITS).added_to(floor())
    with pytest.raises(NoPathFound):
        planned('shortest', walled, Pose2D(0.8, 3.2, 0.0), Pose2D(5.2, 3.2, 0.0))


@pytest.mark.parametrize('name', available_robots())
def test_a_kerb_of_the_step_height_across_a_room_is_crossed_and_a_higher_one_is_not(name):
    robot = load_robot(name)
    limits = GroundLimits.of(robot)
    clearance = robot.footprint_radius + 0.05
    for height, is_crossed in ((robot.step_height, True), (robot.step_height * 1.02, False)):
        heights = ground(boxes=[(4.5, 2.0, 3.0, 6.0, height)], resolution=0.01)
        planner = make_planner('shortest', clearance_radius=clearance)
        planner.set_map(Ground(heights, limits).added_to(floor()))
        if is_crossed:
            assert len(planner.plan(Pose2D(1.0, 2.0, 0.0), Pose2D(5.0, 2.0, 0.0)).poses) <= 2
        else:
            with pytest.raises(NoPathFound):
                planner.plan(Pose2D(1.0, 2.0, 0.0), Pose2D(5.0, 2.0, 0.0))


# ---- slopes ----


@pytest.mark.parametrize('resolution', [0.005, 0.02, 0.05, 0.1])
def test_slopes_are_obstacles_exactly_beyond_the_limit_whatever_the_cells(resolution):
    for degrees, is_too_steep in ((14.5, False), (15.5, True), (-14.5, False), (-15.5, True)):
        heights = ground(3.0, 3.0, resolution, slope=math.tan(math.radians(degrees)))
        assert not high_steps(heights, LIMITS).any()
        assert steep_slopes(heights, LIMITS)[len(heights.heights) // 2].any() == is_too_steep
        across = heights.with_heights(np.ascontiguousarray(heights.heights.T))
        assert steep_slopes(across, LIMITS).any() == is_too_steep


def test_a_slope_is_that_of_the_plane_which_fits_the_known_heights():
    limits = GroundLimits(1.0, 0.01, 0.4, 0.5)
    rng = np.random.default_rng(2)
    heights = ground(0.5, 0.5, 0.1)
    for _ in range(200):
        z = rng.normal(0.0, 0.08, (5, 5))
        z[tuple(rng.integers(0, 5, (2, 4)))] = np.nan
        known = ~np.isnan(z)
        terms = np.column_stack((heights.centers[known], np.ones(known.sum())))
        plane = np.linalg.lstsq(terms, z[known], rcond=None)[0]
        wanted = math.hypot(plane[0], plane[1]) > math.tan(0.4) and known[2, 2]
        assert steep_slopes(heights.with_heights(z), limits)[2, 2] == wanted


def test_single_bumps_and_low_boxes_on_gentle_ground_are_no_slope():
    rng = np.random.default_rng(3)
    boxes = [
        (*rng.uniform((0.0, 0.0), (6.0, 4.0)), *rng.uniform(0.1, 0.5, 2), 0.5 * STEP)
        for _ in range(40)
    ]
    heights = ground(boxes=boxes, slope=math.tan(math.radians(5.0)))
    # They lie on each other here and there.
    tame = heights.heights - np.maximum(
        heights.heights - 0.0875 * heights.centers[..., 0] - 0.9 * STEP, 0.0
    )
    assert not obstacles(heights.with_heights(tame)).any()


def test_beside_a_high_block_nothing_is_steep():
    heights = ground(boxes=[(3.0, 2.0, 1.0, 1.0, 0.5)])
    assert high_steps(heights, LIMITS).any()
    assert not steep_slopes(heights, LIMITS).any()


# ---- unknown ground ----


def test_unknown_heights_are_no_obstacles():
    heights = ground(boxes=[(3.0, 2.0, 1.0, 1.0, math.nan), (1.0, 1.0, 0.02, 0.02, math.nan)])
    assert not obstacles(heights).any()
    assert not obstacles(heights.with_heights(np.full((200, 300), math.nan))).any()
    single = HeightMap(np.zeros((1, 1)), 0.02, (0.0, 0.0))
    assert not obstacles(single).any()


def test_a_face_beside_a_narrow_unknown_strip_is_found():
    heights = ground(boxes=[(4.5, 2.0, 3.0, 4.0, 0.3)])
    holes = np.array(heights.heights)
    holes[:, 149:151] = math.nan
    marked = obstacles(heights.with_heights(holes))
    assert marked[:, 148:152].all()


# ---- on the grid ----


@pytest.mark.parametrize('side', [0.013, 0.02, 0.05, 0.17])
@pytest.mark.parametrize('pose', [(0.0, 0.0, 0.0), (0.31, -0.2, 0.4), (1.7, 0.4, 2.5)])
def test_a_cell_is_touched_exactly_if_it_shares_area_with_a_marked_one(side, pose):
    rng = np.random.default_rng(7)
    heights = HeightMap(np.zeros((23, 31)), side, (0.23, -0.11))
    marked = rng.random((23, 31)) < 0.03
    grid = floor(1.5, 1.2, 0.05, pose)
    touched = cells_touched(heights, marked, grid)
    # By many points of each marked cell, none on its edge.
    parts = (np.arange(60) + 0.5) / 60.0
    rows, columns = np.nonzero(marked)
    u, v = np.meshgrid(parts, parts)
    points = np.stack((columns[:, None] + u.ravel(), rows[:, None] + v.ravel()), axis=-1)
    cells = np.floor(grid.world_to_map(points.reshape(-1, 2) * side + heights.origin)).astype(int)
    on_grid = np.all((cells >= 0) & (cells < (grid.width, grid.height)), axis=1)
    sampled = np.zeros_like(touched)
    sampled[cells[on_grid, 1], cells[on_grid, 0]] = True
    assert not (sampled & ~touched).any()
    # Points miss slivers: those are looked at as polygons.
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    squares = grid.world_to_map(
        (np.column_stack((columns, rows))[:, None] + corners) * side + heights.origin
    ).astype(np.float32)
    for row, column in np.argwhere(touched & ~sampled):
        cell = (corners + (column, row)).astype(np.float32)
        assert max(cv2.intersectConvexConvex(cell, square)[0] for square in squares) > 0.0


def test_cells_that_lie_alike_are_those_of_the_height_map():
    rng = np.random.default_rng(8)
    heights = HeightMap(np.zeros((40, 50)), 0.05, (-3.1, 2.7))
    marked = rng.random((40, 50)) < 0.2
    grid = floor(2.5, 2.0, 0.05, (-3.1, 2.7, 0.0))
    assert (cells_touched(heights, marked, grid) == marked).all()
    turned = floor(2.0, 2.5, 0.05, (-3.1 + 2.5, 2.7, math.pi / 2.0))
    assert (cells_touched(heights, marked, turned) == np.rot90(marked)).all()


@pytest.mark.parametrize('yaw', [0.0, 0.4, -2.0])
def test_a_turned_map_walks_around_the_same_block(yaw):
    middle = np.array([3.0, 2.0])
    corner = middle - Pose2D(0.0, 0.0, yaw).transform(np.array([3.0, 2.0]))
    grid = floor(origin=(*corner.tolist(), yaw))
    heights = ground(8.0, 8.0, boxes=[(3.0, 2.0, 0.3, 0.3, 0.25)], origin=(-1.0, -2.0))
    combined = Ground(heights, LIMITS).added_to(grid)
    centers = combined.map_to_world(np.argwhere(combined.occupied())[:, ::-1] + 0.5)
    away = np.abs(centers - middle).max(axis=1)
    assert len(centers)
    assert away.max() < 0.15 + 0.02 + 0.05
    _, plan = planned(
        'shortest',
        combined,
        Pose2D(*grid.map_to_world(np.array([16.0, 40.0])).tolist(), 0.0),
        Pose2D(*grid.map_to_world(np.array([104.0, 40.0])).tolist(), 0.0),
        any_angle=True,
    )
    assert plan.length > 4.42


def test_without_obstacles_of_the_ground_the_map_is_the_map_itself():
    grid = floor()
    level = Ground(ground(), LIMITS)
    assert level.added_to(grid) is grid
    elsewhere = ground(boxes=[(13.0, 12.0, 1.0, 1.0, 0.5)], origin=(10.0, 10.0))
    assert Ground(elsewhere, LIMITS).obstacles.any()
    assert Ground(elsewhere, LIMITS).added_to(grid) is grid


def test_what_the_map_says_stays_where_the_ground_is_low_unless_it_is_told_otherwise():
    cells = np.zeros((80, 120), dtype=np.int8)
    # A low box and a pillar, both on the map; the pillar is not in the height map.
    cells[38:44, 56:64] = 100
    cells[10:14, 20:24] = 100
    cells[0, 0] = -1
    grid = OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0))
    heights = ground(boxes=[(3.0, 2.0, 0.3, 0.2, 0.05), (1.0, 3.0, 0.3, 0.3, 0.3)])
    kept = Ground(heights, LIMITS).added_to(grid)
    assert kept.occupied()[grid.occupied()].all()
    assert kept.occupied()[60, 17]
    assert kept.cells[0, 0] == -1
    # Who says that all that stands is in the height map loses the pillar.
    freed = Ground(heights, LIMITS).added_to(grid, steps_over_low=True)
    assert not freed.occupied()[grid.occupied()].any()
    assert freed.occupied()[60, 17]
    assert freed.cells[0, 0] == -1


@pytest.mark.parametrize('what', ['high', 'unknown', 'beside', 'beyond'])
def test_an_obstacle_is_freed_as_a_whole_or_not_at_all(what):
    cells = np.zeros((80, 120), dtype=np.int8)
    cells[30:50, 50:70] = 100
    boxes = {
        'high': [(2.6, 1.6, 0.1, 0.1, 0.2)],
        'unknown': [(2.6, 1.6, 0.03, 0.03, math.nan)],
        'beside': [(3.6, 2.0, 0.1, 0.1, 0.2)],
        'beyond': [],
    }
    heights = ground(3.4 if what == 'beyond' else 6.0, boxes=boxes[what])
    grid = OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0))
    combined = Ground(heights, LIMITS).added_to(grid, steps_over_low=True)
    assert combined.occupied()[30:50, 50:70].all()


# ---- plans ----


def field():
    """Low boxes everywhere, and large obstacles: some on the map, some in the height map alone."""
    rng = np.random.default_rng(11)
    low = [
        (0.5 * column + 0.25, 0.5 * row + 0.25, *rng.uniform(0.15, 0.45, 2), h)
        for row in range(12)
        for column in range(16)
        for h in [rng.uniform(0.3, 0.97) * STEP]
    ]
    level = ground(8.0, 6.0, boxes=low)
    x, y = np.moveaxis(level.centers, -1, 0)
    heights = np.array(level.heights)
    high = [(4.0, 3.0, 0.5, 0.6), (2.3, 4.9, 0.4, 0.4), (5.9, 1.6, 0.3, 0.5)]
    for bx, by, length, across in high:
        heights[(np.abs(x - bx) < length / 2.0) & (np.abs(y - by) < across / 2.0)] = 0.4
    cells = np.zeros((120, 160), dtype=np.int8)
    cells[20:26, 50:56] = cells[88:94, 100:106] = 100
    return OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), level.with_heights(heights), high


@pytest.mark.parametrize(
    ('method', 'any_angle'),
    [
        ('mesh', False),
        ('shortest', False),
        ('shortest', True),
        ('quickest', False),
        ('potential', False),
    ],
)
def test_plans_go_over_low_boxes_and_around_large_ones(method, any_angle):
    grid, heights, high = field()
    start, goal = Pose2D(1.0, 3.0, 0.0), Pose2D(7.0, 3.0, 0.0)
    planner, plan = planned(
        method, Ground(heights, LIMITS).added_to(grid), start, goal, any_angle=any_angle
    )
    # The navigation function keeps to the middle.
    assert plan.length < (11.0 if method == 'potential' else 8.0)
    blocked = planner.prepared.blocked
    expected = np.array(grid.occupied())
    for x, y, length, across in high:
        rows = slice(math.floor((y - across / 2) / 0.05), math.ceil((y + across / 2) / 0.05))
        columns = slice(math.floor((x - length / 2) / 0.05), math.ceil((x + length / 2) / 0.05))
        expected[rows, columns] = True
    # Only large obstacles block the way, and all of them do.
    for a, b in pairwise(grid.world_to_map(plan.corners)):
        assert segment_clearance(blocked, a, b) >= CLEARANCE / 0.05 - 1e-6
        assert segment_clearance(expected, a, b) >= CLEARANCE / 0.05 - 1e-6
    near = np.zeros_like(blocked)
    for row, column in np.argwhere(expected):
        near[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2] = True
    assert not (blocked & ~near).any()


def test_limits_that_make_no_sense_are_refused():
    for change in ({'step_height': -0.1}, {'largest_slope': 0.0}, {'largest_slope': 1.5}):
        with pytest.raises(ParameterError):
            GroundLimits.of(ROBOT, **change)
    with pytest.raises(ParameterError, match='slope_length'):
        GroundLimits(0.1, 0.1, 0.3, math.inf)
    assert GroundLimits.of(ROBOT, step_height=0.05).step_height == 0.05
