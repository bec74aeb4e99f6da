"""Laws of uneven ground: what is simulated is what the map says, and one seed is one ground."""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.errors import MapError, NotSimulated, ParameterError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_file import save_height_map
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import make_simulator
from quad_sim.engines.simulator import Contact
from quad_sim.world import terrain_shapes as shapes
from quad_sim.world.standing import standing_on
from quad_sim.world.terrain import Block, Terrain
from quad_sim.world.terrain_spec import KINDS, TerrainSpec, make_terrain, specs_from_text
from quad_sim.world.world import Obstacle, World

ROBOT = load_robot('titan_viii')
BOUNDS = (-2.0, -1.0, 6.0, 4.0)
START, GOAL = Pose2D(0.2, 0.7, 0.3), Pose2D(4.5, 2.5, 0.0)
LEVEL_AT = ((START.x, START.y), (GOAL.x, GOAL.y))
SUMS = ('slope+bumps', 'cross_slope:angle=-0.1+boxes:height=0.06', 'noise+kerb')
NO_WALLS = np.empty((0, 4, 2))


def terrain_of(text, **numbers):
    return make_terrain(specs_from_text(text, **numbers), BOUNDS, START, LEVEL_AT)


def world_of(text, **fields):
    return World(NO_WALLS, terrain=terrain_of(text), **fields)


def points_in(bounds, count=2000, seed=0):
    return np.random.default_rng(seed).uniform(bounds[:2], bounds[2:], (count, 2))


def around(place, radius, count=400):
    points = np.random.default_rng(3).uniform(-radius, radius, (count, 2))
    return points[np.hypot(*points.T) <= radius] + place


@pytest.fixture
def make():
    """Make simulators that are closed after the test."""
    pytest.importorskip('pybullet')
    made = []

    def make_one(world, robot=ROBOT):
        made.append(make_simulator('bullet', robot, world))
        return made[-1]

    yield make_one
    for simulator in made:
        simulator.close()


def hits(simulator, points, high=3.0, low=-3.0):
    """Bodies and heights that rays from above meet at points (n, 2)."""
    found = []
    for part in np.array_split(points, len(points) // 1000 + 1):
        found += simulator._bullet.rayTestBatch(
            [(x, y, high) for x, y in part], [(x, y, low) for x, y in part]
        )
    return [hit[0] for hit in found], np.array([hit[3][2] for hit in found])


def near_an_edge(blocks, points, distance):
    """Whether points (n, 2) are so near to the outline of a block."""
    near = np.zeros(len(points), dtype=bool)
    for block in blocks:
        half = np.array([block.length, block.width]) / 2.0
        beyond = np.abs(block.pose.inverse().transform(points)) - half
        near |= np.abs(beyond.max(axis=1)) < distance
    return near


@pytest.mark.sweep(kept=5)
@pytest.mark.parametrize('text', [*KINDS, *SUMS])
def test_the_ground_that_is_simulated_is_that_of_the_terrain_and_of_its_map(make, text):
    world = world_of(text)
    simulator = make(world)
    simulator.reset(Pose2D(50.0, 50.0, 0.0))
    points = points_in(world.terrain.field.bounds)
    bodies, heights = hits(simulator, points)
    assert set(bodies) <= simulator._grounds
    # Bullet's rays meet a box from up to a centimetre beside it, and the map knows the edges of
    # blocks to half a cell.
    off_edges = ~near_an_edge(world.terrain.blocks, points, 0.03)
    # The sides of a pit are a cell wide, and of triangles.
    off_edges &= world.terrain.field.step_at(points, 0.03) < 0.1
    assert off_edges.mean() > 0.6
    heights, points = heights[off_edges], points[off_edges]
    assert heights == pytest.approx(world.ground_at(points), abs=1e-3)
    mapped = world.terrain.height_map.height_at(points)
    assert heights == pytest.approx(mapped, abs=1e-3)


@pytest.mark.parametrize('text', ['cross_slope', 'noise', 'bumps'])
def test_beyond_the_field_the_ground_is_level(make, text):
    world = world_of(text)
    simulator = make(world)
    simulator.reset(Pose2D(50.0, 50.0, 0.0))
    points = points_in((-9.0, -9.0, 13.0, 11.0))
    x, y = points.T
    beyond = (x < -2.05) | (x > 6.05) | (y < -1.05) | (y > 4.05)
    bodies, heights = hits(simulator, points[beyond])
    assert set(bodies) <= simulator._grounds
    assert heights == pytest.approx(0.0, abs=1e-6)
    assert (world.ground_at(points[beyond]) == 0.0).all()
    # There is no gap along the border.
    rim = [(x, y) for x in np.linspace(-2.1, 6.1, 500) for y in (-1.01, -1.0, 4.0, 4.01)]
    assert min(hits(simulator, np.array(rim))[0]) >= 0


@pytest.mark.parametrize('kind', ['bumps', 'noise', 'boxes'])
def test_a_seed_gives_its_ground_again_and_another_seed_another(kind):
    one, again = terrain_of(kind, seed=5), terrain_of(kind, seed=5)
    other = terrain_of(kind, seed=6)
    assert (one.height_map.heights == again.height_map.heights).all()
    assert one.blocks == again.blocks
    assert np.abs(one.height_map.heights - other.height_map.heights).max() > 0.01


def test_one_kind_of_ground_does_not_move_another():
    bumps = terrain_of('bumps').field.heights
    assert (terrain_of('bumps+boxes').field.heights == bumps).all()
    both = terrain_of('slope+bumps').field.heights
    assert both == pytest.approx(terrain_of('slope').field.heights + bumps)


@pytest.mark.parametrize('kind', ['bumps', 'noise', 'boxes'])
def test_the_ground_is_level_around_start_and_goal(kind):
    terrain = terrain_of(kind, clear=0.9)
    for place in LEVEL_AT:
        # A cell reaches half its diagonal into what is level.
        assert np.abs(terrain.height_at(around(place, 0.88))).max() < 1e-9
        assert np.abs(terrain.height_at(around(place, 2.0))).max() > 0.005


@pytest.mark.parametrize('kind', ['bumps', 'noise', 'boxes'])
@pytest.mark.parametrize('height', [0.0, 0.02, 0.1])
def test_nothing_is_higher_than_was_asked_for_and_something_nearly_is(kind, height):
    heights = terrain_of(kind, height=height).height_map.heights
    assert np.abs(heights).max() <= height + 1e-12
    assert np.abs(heights).max() >= 0.9 * height
    if kind != 'noise':
        assert heights.min() == 0.0


def test_bumps_are_smooth_round_and_apart():
    level = HeightMap.level(BOUNDS, 0.02)
    made = shapes.bumps(level, np.random.default_rng(0), 0.04, shapes.Scatter(0.4, 0.5, gap=0.0))
    # (1 - u^2)^2 over a radius of 0.12 m is steepest at u^2 = 1/3: 8 / (3 sqrt 3) h / r.
    slopes = np.hypot(*np.moveaxis(made.slope_at(points_in(BOUNDS)), -1, 0))
    assert slopes.max() < 1.54 * 0.04 / 0.12
    assert 0.2 < (made.heights > 0.0).mean() <= 0.5


def test_noise_is_alike_over_its_length_and_not_farther_on():
    level = HeightMap.level((0.0, 0.0, 20.0, 20.0), 0.05)
    heights = shapes.noise(level, np.random.default_rng(0), 0.05, size=0.6).heights
    heights = heights - heights.mean()

    def correlation(distance):
        shift = round(distance / 0.05)
        return np.mean(heights[shift:] * heights[:-shift]) / heights.var()

    assert correlation(0.6) == pytest.approx(math.exp(-1.0), abs=0.08)
    assert correlation(0.3) > 0.7
    assert abs(correlation(2.0)) < 0.15


def test_a_slope_goes_up_is_level_and_goes_down_along_the_heading():
    terrain = terrain_of('slope', angle=0.2, length=1.0, clear=0.5)
    path = np.array([[d, 0.1] for d in (-1.0, 0.45, 1.0, 1.55, 2.45, 3.0, 3.55)])
    heights = terrain.height_at(START.transform(path))
    top = math.tan(0.2)
    expected = [0.0, 0.0, top / 2.0, top, top, top / 2.0, 0.0]
    assert heights == pytest.approx(expected, abs=2e-3)
    hollow = terrain_of('slope', angle=-0.2, length=1.0, clear=0.5)
    assert hollow.field.heights == pytest.approx(-terrain.field.heights)


def test_a_cross_slope_rises_to_the_left_and_is_level_ahead():
    terrain = terrain_of('cross_slope', angle=0.2)
    ahead = START.transform(np.array([[d, 0.0] for d in (-1.0, 0.0, 3.0)]))
    assert terrain.height_at(ahead) == pytest.approx(0.0, abs=1e-9)
    left = START.transform(np.array([[0.0, 0.5], [2.0, 0.5], [1.0, -0.5]]))
    rise = 0.5 * math.tan(0.2)
    assert terrain.height_at(left) == pytest.approx([rise, rise, -rise])


def test_a_kerb_has_upright_sides_across_the_whole_ground():
    terrain = terrain_of('kerb', height=0.06, length=1.2, clear=0.7)
    for lateral in (-0.8, 0.0, 1.5):
        path = np.array([[d, lateral] for d in (0.699, 0.701, 1.899, 1.901)])
        assert terrain.height_at(START.transform(path)).tolist() == [0.0, 0.06, 0.06, 0.0]


def test_edges_of_blocks_are_sharp(make):
    world = world_of('boxes')
    simulator = make(world)
    simulator.reset(Pose2D(50.0, 50.0, 0.0))
    assert len(world.terrain.blocks) > 20
    bullet = simulator._bullet
    shape = bullet.createCollisionShape(bullet.GEOM_SPHERE, radius=0.01)
    probe = bullet.createMultiBody(0, shape)
    for block in world.terrain.blocks[:20]:
        # A ball beside a block is as far from it just below the edge as farther down.
        for side in ((block.length / 2.0 + 0.03, 0.0), (0.0, -block.width / 2.0 - 0.03)):
            x, y = block.pose.transform(np.array(side))
            for z in (0.5 * block.top, block.top - 1e-3):
                assert distance_to_ground(simulator, probe, (x, y, z)) == pytest.approx(
                    0.02, abs=1e-4
                )
        x, y = block.pose.transform(np.array((block.length / 2.0 - 1e-3, 0.0)))
        above = distance_to_ground(simulator, probe, (x, y, block.top + 0.03))
        assert above == pytest.approx(0.02, abs=1e-4)


def distance_to_ground(simulator, probe, place):
    """How far a body is from the nearest block [m]."""
    bullet = simulator._bullet
    bullet.resetBasePositionAndOrientation(probe, place, (0.0, 0.0, 0.0, 1.0))
    bullet.performCollisionDetection()
    # The field is the first of them.
    _, *boxes = sorted(simulator._grounds)
    return min(point[8] for body in boxes for point in bullet.getClosestPoints(body, probe, 0.1))


def test_blocks_do_not_overlap():
    blocks = terrain_of('boxes').blocks
    points = points_in(BOUNDS, 20000)
    covered = np.sum([block.covers(points) for block in blocks], axis=0)
    assert covered.max() == 1
    assert 0.03 < covered.mean() < 0.3


def test_the_map_shows_the_higher_of_field_and_block():
    field = HeightMap.level((0.0, 0.0, 2.0, 1.0), 0.1)
    field = field.with_heights(np.where(field.centers[..., 0] > 1.0, 0.5, 0.0))
    block = Block(Pose2D(1.0, 0.5, 0.0), 1.0, 0.4, 0.2)
    terrain = Terrain(field, (block,))
    assert terrain.height_at([[0.7, 0.5], [1.3, 0.5], [0.7, 0.1]]).tolist() == [0.2, 0.5, 0.0]
    assert terrain.height_map.height_at([[0.75, 0.5], [1.25, 0.5]]).tolist() == [0.2, 0.5]
    assert (terrain.lowest, terrain.highest) == (0.0, 0.5)


def settled(simulator, pose, seconds=2.0):
    simulator.reset(pose)
    first = simulator.observe()
    posture = ROBOT.initial_joint_angles.reshape(-1)
    for _ in range(round(seconds / simulator.time_step)):
        simulator.step(posture, np.zeros(12))
    return first, simulator.observe()


def feet_of(seen):
    """Centers of the feet in the world, shape (4, 3) [m]."""
    x, y, z, w = seen.orientation
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return seen.position + ROBOT.foot_positions(seen.joint_positions.reshape(4, 3)) @ rotation.T


def gap_below(world, foot, radius):
    """How far a foot's ball is above the ground, at least [m]."""
    around_it = foot[:2] + around((0.0, 0.0), radius)
    below = np.sqrt(radius**2 - np.sum((around_it - foot[:2]) ** 2, axis=1))
    return float(np.min(foot[2] - below - world.ground_at(around_it)))


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize(
    ('text', 'place'),
    [
        *((text, START) for text in ('bumps', 'noise', 'slope', 'cross_slope', 'boxes', 'kerb')),
        *((text, Pose2D(2.1, 1.2, 2.0)) for text in ('bumps', 'slope', 'boxes')),
        *((text, Pose2D(1.27, 0.3, -3.0)) for text in ('noise', 'cross_slope', 'kerb')),
    ],
)
def test_the_robot_stands_where_it_is_put_with_its_feet_on_the_ground(make, text, place):
    world = world_of(text)
    simulator = make(world)
    first, last = settled(simulator, place)
    for foot in feet_of(first):
        assert gap_below(world, foot, ROBOT.foot_radius) > -5e-4
    assert not last.has_fallen
    assert last.contacts == ()
    # It falls onto its feet, and on a slope it slides a little.
    assert math.hypot(*(last.position - first.position)[:2]) < 0.03
    assert abs(wrap_angle(last.pose.yaw - place.yaw)) < 0.05
    gaps = np.array([gap_below(world, foot, ROBOT.foot_radius) for foot in feet_of(last)])
    assert gaps.min() > -2e-3
    assert (gaps < 2e-3).sum() >= 3
    # base_link is above the middle of its feet as it is on flat ground.
    ground = world.ground_at(feet_of(last)[:, :2])
    above = last.position[2] - ground.mean()
    assert above == pytest.approx(ROBOT.standing_height, abs=0.02)
    forces = simulator.foot_forces()
    assert (forces >= 0.0).all()
    assert forces.sum() == pytest.approx(ROBOT.mass * 9.80665, rel=0.12)
    assert (forces[gaps > 3e-3] == 0.0).all()


def test_on_level_ground_standing_is_as_without_a_terrain(make):
    flat, level = World(NO_WALLS), World(NO_WALLS, terrain=terrain_of('kerb'))
    _, one = settled(make(flat), START)
    first, other = settled(make(level), START)
    assert first.position[2] == pytest.approx(ROBOT.standing_height)
    assert other.position == pytest.approx(one.position, abs=1e-4)
    assert other.joint_efforts == pytest.approx(one.joint_efforts, abs=0.5)


def test_a_body_on_a_slope_is_parallel_to_it_at_any_heading():
    for yaw in (0.0, 1.0, math.pi, -2.0):
        pose = Pose2D(0.5, 0.5, yaw)
        terrain = make_terrain(
            specs_from_text('cross_slope:angle=0.3'), BOUNDS, Pose2D(0.0, 0.0, 0.0)
        )
        position, rotation = standing_on(ROBOT, terrain, pose)
        normal = np.array([0.0, -math.sin(0.3), math.cos(0.3)])
        assert rotation[:, 2] == pytest.approx(normal)
        assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)
        heading = math.atan2(rotation[1, 0], rotation[0, 0])
        assert wrap_angle(heading - yaw) == pytest.approx(0.0, abs=1e-9)
        height = (position - (0.5, 0.5, 0.5 * math.tan(0.3))) @ normal
        assert height == pytest.approx(ROBOT.standing_height * math.cos(0.3), abs=0.015)


def test_the_forces_on_the_feet_hold_the_weight_and_only_on_feet_that_stand(make):
    simulator = make(World(NO_WALLS))
    settled(simulator, START)
    forces = simulator.foot_forces()
    assert forces.sum() == pytest.approx(ROBOT.mass * 9.80665, rel=1e-3)
    assert forces == pytest.approx(np.full(4, forces.mean()), rel=0.1)
    lifted = ROBOT.initial_joint_angles.copy()
    lifted[0, 1] -= 0.3
    for _ in range(200):
        simulator.step(lifted.reshape(-1), np.zeros(12))
    forces = simulator.foot_forces()
    assert forces[0] == 0.0 or forces[3] == 0.0
    assert forces.sum() == pytest.approx(ROBOT.mass * 9.80665, rel=0.05)


def test_joint_efforts_are_the_torques_that_hold_the_robot(make):
    """
    They do the work of the weight and of the forces on the feet.

    With the energy V(q), the Jacobian J of the feet, and W that of the calves' turning:
    tau = dV/dq - J^T f - W^T (r x f), the force being r = a ball's radius below the foot.
    """
    simulator = make(World(NO_WALLS))
    angles = ROBOT.initial_joint_angles.copy()
    angles[0] += (0.1, -0.1, 0.05)
    simulator.reset(START)
    for _ in range(1000):
        simulator.step(angles.reshape(-1), np.zeros(12))
    seen = simulator.observe()
    bullet = simulator._bullet
    to_world = np.reshape(bullet.getMatrixFromQuaternion(seen.orientation), (3, 3))
    forces = np.zeros((4, 3))
    legs = [f'{leg}_foot' for leg in ('lf', 'rf', 'lh', 'rh')]
    for point in bullet.getContactPoints(bodyA=simulator._body):
        pairs = ((point[9], point[7]), (point[10], point[11]), (point[12], point[13]))
        index = legs.index(simulator._link_names[point[3]])
        forces[index] += sum(size * np.array(direction) for size, direction in pairs)
    forces = forces @ to_world
    up = to_world.T @ (0.0, 0.0, 1.0)
    q = seen.joint_positions.reshape(4, 3)
    weight = np.empty(12)
    turning = np.empty((4, 3, 3))
    for k in range(12):
        d = np.zeros(12)
        d[k] = 1e-5
        ends = (ROBOT.center_of_mass(q + sign * d.reshape(4, 3)) @ up for sign in (1, -1))
        weight[k] = ROBOT.mass * 9.80665 * np.subtract(*ends) / 2e-5
    for joint in range(3):
        speeds = np.zeros((4, 3))
        speeds[:, joint] = 1.0
        turning[:, :, joint] = ROBOT.calf_angular_velocities(q, speeds)
    moments = np.cross(-ROBOT.foot_radius * up, forces)
    expected = (
        weight.reshape(4, 3)
        - np.einsum('lij,li->lj', ROBOT.foot_jacobians(q), forces)
        - np.einsum('lij,li->lj', turning, moments)
    )
    assert np.abs(expected).max() > 15.0
    assert seen.joint_efforts.reshape(4, 3) == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize('text', ['noise', 'slope', 'cross_slope', 'kerb'])
def test_obstacles_stand_on_the_ground(make, text):
    box = Obstacle.box(Pose2D(2.3, 1.4, 0.5), 0.6, 0.3, 0.4)
    cylinder = Obstacle.cylinder(3.0, 0.5, 0.2, 0.5)
    world = world_of(text, obstacles=(box, cylinder))
    simulator = make(world)
    simulator.reset(Pose2D(50.0, 50.0, 0.0))
    for obstacle in (box, cylinder):
        middle = np.array([obstacle.pose.x, obstacle.pose.y])
        bodies, heights = hits(simulator, np.array([middle]))
        assert bodies[0] not in simulator._grounds
        assert heights[0] == pytest.approx(world.ground_at(middle) + obstacle.height, abs=1e-3)
        # There is no gap below it: its lower face is in the ground everywhere.
        bottom, _ = world.span_of(obstacle)
        assert (bottom <= world.ground_at(obstacle.outline()) + 1e-9).all()


def test_walls_stand_on_the_ground_and_are_nowhere_lower_than_on_flat_ground(make):
    wall = np.array([[2.0, 0.0], [2.1, 0.0], [2.1, 2.0], [2.0, 2.0]])
    world = World(wall[None], terrain=terrain_of('slope'))
    simulator = make(world)
    simulator.reset(Pose2D(50.0, 50.0, 0.0))
    along = np.array([[2.05, y] for y in np.linspace(0.1, 1.9, 20)])
    _, heights = hits(simulator, along)
    bottom, top = world.span_of_wall(wall)
    assert heights == pytest.approx(top, abs=1e-4)
    assert (heights - world.ground_at(along) >= 0.5 - 1e-6).all()
    assert bottom <= world.ground_at(along).min()


def test_on_flat_ground_obstacles_and_walls_are_as_high_as_they_are():
    world = World(NO_WALLS)
    assert world.span_of(Obstacle.cylinder(0.0, 0.0, 0.2, 0.5)) == (0.0, 0.5)
    assert world.span_of_wall(np.zeros((4, 2))) == (0.0, 0.5)
    assert world.ground_at(np.zeros((3, 2, 2))).tolist() == [[0.0, 0.0]] * 3


def test_what_lies_on_the_ground_touches_the_ground(make):
    for text in ('kerb', 'noise'):
        simulator = make(world_of(text))
        simulator.reset(START)
        upside_down = (1.0, 0.0, 0.0, 0.0)
        place = (1.63, 1.14, 0.4)
        simulator._bullet.resetBasePositionAndOrientation(simulator._body, place, upside_down)
        for _ in range(200):
            simulator.step(ROBOT.initial_joint_angles.reshape(-1), np.zeros(12))
        seen = simulator.observe()
        assert seen.has_fallen
        assert Contact('base_link', 'ground') in seen.contacts
        assert 'obstacle' not in {contact.other for contact in seen.contacts}


def test_a_picture_shows_the_ground(make):
    views = []
    for text in ('bumps', 'boxes', 'cross_slope'):
        simulator = make(world_of(text))
        view, projection = camera(simulator._bullet)
        views.append(simulator.render(view, projection, 64, 64).astype(int))
    for one, other in pairwise(views):
        assert np.abs(one - other).max() > 20


def camera(bullet):
    matrices = (
        bullet.computeViewMatrix((2.0, 1.5, 6.0), (2.0, 1.5, 0.0), (0.0, 1.0, 0.0)),
        bullet.computeProjectionMatrixFOV(60.0, 1.0, 0.1, 50.0),
    )
    return (np.reshape(matrix, (4, 4)).T for matrix in matrices)


def test_text_is_read_with_numbers_for_all_and_numbers_of_its_own():
    assert specs_from_text('') == specs_from_text('flat') == specs_from_text('flat + flat') == ()
    assert specs_from_text('flat+bumps') == specs_from_text('bumps')
    assert make_terrain((), BOUNDS, START) is None
    one, other = specs_from_text('slope:angle=-0.1 + bumps:height=0.02,seed=3', height=0.05, seed=1)
    assert one == TerrainSpec('slope', height=0.05, angle=-0.1, seed=1)
    assert other == TerrainSpec('bumps', height=0.02, seed=3)


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        ('hills', "'terrain' is 'hills'; it must be flat, one of bumps, slope, "),
        ('bumps+', "'terrain' is ''"),
        ('bumps:weight=2', 'it must be with numbers named height, angle'),
        ('bumps:height', "'terrain_height' is ''; it must be a number"),
        ('bumps:seed=1.5', "'terrain_seed' is '1.5'; it must be a whole number"),
        ('bumps:height=2', "'terrain_height' is 2.0; it must be from 0 to 1"),
        ('slope:angle=nan', "'terrain_angle' is nan; it must be from -0.6 to 0.6"),
        ('boxes:seed=-1', "'terrain_seed' is -1"),
        ('noise:size=0', "'terrain_size' is 0.0; it must be from 0.1 to 10"),
    ],
)
def test_what_is_no_ground_is_refused_in_a_sentence(text, told):
    with pytest.raises(ParameterError) as caught:
        specs_from_text(text)
    assert told in str(caught.value)


def test_a_file_is_a_ground_of_its_own_or_a_part_of_one(tmp_path):
    heights = HeightMap.level((0.0, 0.0, 1.0, 1.0), 0.1, 0.03)
    path = tmp_path / 'hills.yaml'
    save_height_map(heights, path)
    alone = make_terrain(specs_from_text(str(path)), BOUNDS, START)
    assert alone.field.bounds == pytest.approx(heights.bounds)
    both = make_terrain(specs_from_text(f'{path}+slope'), BOUNDS, START)
    slope = terrain_of('slope').field
    inside = slope.centers[(np.abs(slope.centers - 0.5) < 0.45).all(axis=-1)]
    expected = slope.height_at(inside) + 0.03
    assert both.field.height_at(inside) == pytest.approx(expected, abs=1e-5)


def test_ground_that_is_not_known_everywhere_is_refused():
    field = HeightMap(np.array([[0.0, math.nan]]), 0.1, (0.0, 0.0))
    with pytest.raises(MapError, match='the ground is unknown in 1 of 2 cells'):
        Terrain(field)


@pytest.mark.parametrize(
    ('fields', 'told'),
    [
        ((Pose2D(math.nan, 0.0, 0.0), 1.0, 1.0, 0.1), "'pose' is"),
        ((START, 0.0, 1.0, 0.1), "'length' is 0.0"),
        ((START, 1.0, math.inf, 0.1), "'width' is inf"),
        ((START, 1.0, 1.0, math.nan), "'top' is nan"),
    ],
)
def test_what_is_no_block_is_refused(fields, told):
    with pytest.raises(ParameterError, match=told):
        Block(*fields)


def test_the_kinematic_simulator_has_flat_ground_only():
    with pytest.raises(NotSimulated, match=r"does not support uneven ground.*'bullet' or 'mujoco'"):
        make_simulator('kinematic', ROBOT, world_of('bumps'))


@pytest.mark.slow
@pytest.mark.parametrize('name', ['pukyong', 'cuhk', 'genibo'])
def test_every_robot_stands_on_bumps_of_its_size(make, name):
    robot = load_robot(name)
    high = 0.1 * robot.standing_height
    specs = specs_from_text('noise', height=high, size=0.3, clear=0.0)
    world = World(NO_WALLS, terrain=make_terrain(specs, BOUNDS, START))
    simulator = make(world, robot)
    simulator.reset(START)
    for _ in range(400):
        simulator.step(robot.initial_joint_angles.reshape(-1), np.zeros(12))
    seen = simulator.observe()
    assert not seen.has_fallen
    assert seen.position[2] == pytest.approx(robot.standing_height, abs=1.5 * high)
