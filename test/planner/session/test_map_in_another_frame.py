"""A map in another frame than the one before moves no goal, no robot and no place."""

import math

import numpy as np
import pytest
from test_planning_session import GOAL, OTHER, START, Room, room

from quad_common.errors import ParameterError, WrongFrame
from quad_common.frames.frame_tree import FrameTransform
from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.session.given_goal import GoalEnd

TURNED = Pose2D(4.0, 0.0, math.pi / 2.0)
"""The other frame in the map: the room is the same there."""


def turned(child='other'):
    turn = 0.0, 0.0, math.sin(TURNED.yaw / 2.0), math.cos(TURNED.yaw / 2.0)
    return FrameTransform('map', child, (TURNED.x, TURNED.y, 0.0), turn)


def there(pose):
    return TURNED.inverse() @ pose


def assert_same(pose, expected):
    assert pose.distance_to(expected) < 1e-9
    assert math.isclose(pose.yaw, expected.yaw, abs_tol=1e-9)


def related():
    """Return a walk on a map to which another frame is related."""
    walk = Room(pose=None)
    walk.frame.add([turned()])
    walk.frame.add([FrameTransform('map', 'odom', (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))])
    walk.move(START)
    return walk


def test_the_goal_in_force_stays_where_it_is():
    walk = related()
    walk.give(GOAL)
    walk.follow()
    walk.session.take_grid(room(), 'other')
    assert_same(walk.session.goal, there(GOAL))
    assert_same(walk.session.plan.poses[-1], there(GOAL))
    walk.requests.work()
    assert len(walk.plans) == 2
    assert_same(walk.plans[-1].poses[-1], there(GOAL))
    assert walk.plans[-1].poses[0].distance_to(there(START)) < 1e-9
    # Odometry goes on to say where the robot is, in that frame by now.
    walk.move(Pose2D(1.5, 1.0, 0.0))
    assert_same(walk.session.pose, there(Pose2D(1.5, 1.0, 0.0)))
    walk.requests.work()
    assert len(walk.plans) == 2


def test_odometrys_frame_may_be_the_maps():
    walk = Room(pose=None)
    walk.frame.add([turned('odom')])
    walk.move(there(START))
    assert_same(walk.session.pose, START)
    walk.give(GOAL)
    walk.session.take_grid(room(), 'odom')
    walk.requests.work()
    assert_same(walk.plans[-1].poses[-1], there(GOAL))
    # Without a localiser both frames coincide.
    plain = Room()
    plain.give(GOAL)
    plain.session.take_grid(room(), 'odom')
    plain.requests.work()
    assert plain.goals() == [GOAL, GOAL]


def test_a_goal_that_is_searched_for_stays_where_it_is():
    walk = related()
    walk.session.give_goal('map', GOAL)
    walk.session.take_grid(room(), 'other')
    assert_same(walk.session.pending_goal, there(GOAL))
    walk.requests.work()
    assert len(walk.plans) == 1
    assert_same(walk.plans[0].poses[-1], there(GOAL))


def test_a_goal_that_waits_for_odometry_stays_where_it_is():
    walk = Room()
    walk.session.give_goal('map', OTHER)
    walk.session.tick(walk.time + 3.0, walk.time + 3.0)
    walk.session.give_goal('map', GOAL)
    # By the frames' coincidence alone; the search to the goal before is not for this map.
    walk.session.take_grid(room(), 'odom')
    walk.requests.work()
    assert walk.plans == []
    walk.move(START)
    walk.requests.work()
    assert walk.goals() == [GOAL]


def test_a_goal_without_a_path_is_known_where_the_robot_stands():
    walk = related()
    walk.give(GOAL)
    walk.session.take_grid(room(wall=True), 'map')
    walk.requests.work()
    walk.session.take_grid(room(), 'other')
    walk.requests.work()
    assert walk.plans[1] is None
    assert_same(walk.plans[2].poses[-1], there(GOAL))


def occupied(walk):
    """Return the places that the planner takes for occupied, as sorted pairs [m]."""
    grid = walk.session.map.planner.prepared.grid
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    return grid.map_to_world(np.column_stack([columns, rows]) + 0.5)


def test_places_without_footing_and_other_robots_stay_where_they_are():
    walk = related()
    walk.give(GOAL)
    walk.session.map.close_ahead('map', Pose2D(1.5, 1.02, 0.0))
    walk.session.map.put_bodies(((2.02, 3.02, 0.2),))
    before = occupied(walk)
    walk.session.take_grid(room(), 'other')
    after = occupied(walk)
    assert len(after) == pytest.approx(len(before), abs=2)
    expected = TURNED.inverse().transform(before.mean(axis=0))
    assert np.allclose(after.mean(axis=0), expected, atol=0.05)


def test_a_goal_in_a_frame_that_nothing_relates_to_the_new_one_is_given_up():
    walk = Room()
    given = walk.session.give_goal('map', GOAL)
    walk.requests.work()
    walk.follow()
    walk.session.map.put_bodies(((2.0, 3.0, 0.2),))
    walk.session.take_grid(room(), 'moon')
    assert walk.goals() == [GOAL, None]
    assert walk.session.goal is None
    assert isinstance(walk.session.problem, WrongFrame)
    assert "'map', which cannot be related to 'moon'" in str(walk.session.problem)
    assert (given.end, given.error.code) == (GoalEnd.REFUSED, 202)
    assert len(occupied(walk)) == 0
    walk.move(Pose2D(2.0, 2.0, 0.0))
    walk.requests.work()
    assert walk.goals() == [GOAL, None]
    walk.give(OTHER, 'moon')
    assert walk.goals()[-1] == OTHER


def test_a_goal_that_is_searched_for_on_a_map_that_nothing_relates_is_given_up():
    walk = Room()
    given = walk.session.give_goal('map', GOAL)
    walk.session.take_grid(room(), 'moon')
    walk.requests.work()
    walk.move(START)
    walk.requests.work()
    assert (given.end, walk.plans) == (GoalEnd.REFUSED, [])


def test_a_goal_that_waits_for_the_first_map_is_in_its_own_frame():
    walk = Room(grid=False)
    walk.give(GOAL, 'floor')
    walk.session.take_grid(room(), 'floor')
    assert walk.session.problem is None
    walk.move(START)
    walk.requests.work()
    assert walk.goals() == [GOAL]


@pytest.mark.parametrize('frame', ['other', 'moon'])
def test_a_plan_that_has_ended_is_not_shown_on_a_map_in_another_frame(frame):
    walk = related()
    walk.give(GOAL)
    walk.follow()
    walk.move(GOAL)
    walk.end()
    assert walk.session.has_ended
    walk.session.take_grid(room(), frame)
    assert walk.goals() == [GOAL, None]
    assert walk.session.problem is None


def test_a_map_that_is_refused_leaves_all_where_it_is():
    walk = related()
    walk.give(GOAL)
    cells = np.zeros((80, 80), np.int8)
    with pytest.raises(ParameterError):
        walk.session.take_grid(OccupancyGrid(cells, 10.0, Pose2D(0.0, 0.0, 0.0)), 'other')
    assert walk.session.goal == GOAL
    assert walk.session.pose == START
    assert walk.frame.name == 'map'
