"""Random rooms: one seed, one room, and always a path through it."""

import itertools
import math

import numpy as np
import pytest
from scipy import ndimage

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_sim.world.random_room import FEWEST, MOST, random_room
from quad_sim.world.world import occupancy_of

CLEARANCE = 0.5


def apart(a, b):
    """Distance between two footprints."""
    return min(
        float(one.distance_to(other.outline(sides=96)).min()) for one, other in ((a, b), (b, a))
    )


def test_one_seed_gives_one_room_and_another_seed_another():
    one, again, other = (random_room(seed) for seed in (7, 7, 8))
    assert one.world.obstacles == again.world.obstacles
    assert one.goal == again.goal
    assert one.world.obstacles != other.world.obstacles


def test_numbers_kinds_sizes_and_gaps_are_part_of_the_draw():
    rooms = [random_room(seed) for seed in range(60)]
    counts = {len(room.world.obstacles) for room in rooms}
    assert counts == set(range(FEWEST, MOST + 1))
    obstacles = [one for room in rooms for one in room.world.obstacles]
    assert {one.kind for one in obstacles} == {'box', 'cylinder'}
    heights = np.array([one.height for one in obstacles])
    assert (heights.min(), heights.max()) == pytest.approx((0.2, 1.0), abs=0.03)
    lengths = np.array([one.length for one in obstacles])
    assert (lengths.min(), lengths.max()) == pytest.approx((0.3, 1.0), abs=0.03)
    assert np.ptp([room.gap for room in rooms]) > 0.5


@pytest.mark.parametrize('count', [0, 3, 8, 12])
def test_obstacles_lie_in_the_room_and_keep_their_distance(count):
    for seed in range(5):
        room = random_room(seed, count)
        assert len(room.world.obstacles) == count
        assert room.gap >= 2.0 * CLEARANCE
        for one in room.world.obstacles:
            outline = one.outline()
            assert outline.min() >= 0.0
            assert outline.max() <= room.size
            for pose in (room.start, room.goal):
                assert one.distance_to(np.array([pose.x, pose.y])) >= CLEARANCE + 0.3
        for a, b in itertools.combinations(room.world.obstacles, 2):
            assert apart(a, b) >= room.gap - 1e-9


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('seed', range(12))
def test_a_disc_as_large_as_the_robot_finds_a_way_from_start_to_goal(seed):
    room = random_room(seed, 12 if seed % 2 else None)
    resolution = 0.02
    grid = occupancy_of(room.world, resolution, room.bounds)
    blocked = np.pad(grid.occupied(), 1, constant_values=True)
    free = resolution * ndimage.distance_transform_edt(~blocked)[1:-1, 1:-1] > CLEARANCE
    labels, _ = ndimage.label(free)
    ends = []
    for pose in (room.start, room.goal):
        column, row = np.floor(grid.world_to_map(np.array([pose.x, pose.y]))).astype(int)
        ends.append(labels[row, column])
    assert ends[0] == ends[1] != 0
    assert room.start.distance_to(room.goal) > 0.3 * room.size


def test_the_start_may_be_given():
    start = Pose2D(1.2, 1.2, 0.5)
    for seed in range(5):
        room = random_room(seed, 10, start)
        assert room.start == start


@pytest.mark.parametrize(
    'start', [Pose2D(0.1, 4.0, 0.0), Pose2D(4.0, 9.0, 0.0), Pose2D(math.nan, 1.0, 0.0)]
)
def test_a_start_outside_the_room_is_refused(start):
    with pytest.raises(ParameterError, match=r"'start_pose' is .* from 0.60 to 7.40 m in x and y"):
        random_room(0, 3, start)


def test_more_obstacles_than_fit_are_refused():
    with pytest.raises(ParameterError, match='do not fit into a room of 3 m'):
        random_room(0, 12, size=3.0)
    with pytest.raises(ParameterError, match="'count' is -1"):
        random_room(0, -1)
