"""Who has the right of way, and what follows for the other one."""

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_planner.traffic.right_of_way import (
    Distances,
    Duty,
    duty_towards,
    is_body_ahead,
    is_clear_of,
    sampled,
)
from quad_planner.traffic.robot_on_map import RobotOnMap, precedes

ROOM = Distances()


def robot(name, *path, radius=0.3, goes_first=False):
    """A robot at the first point, on its way through the others."""
    x, y = path[0]
    line = np.array(path[1:], dtype=float).reshape(-1, 2)
    return RobotOnMap(name, Pose2D(x, y, 0.0), radius, line, goes_first)


def test_of_any_two_robots_just_one_has_the_right_of_way():
    names = ('a', 'b', 'robot1', 'robot2', 'robot10', 'robot2b', 'robot02', '1²')
    robots = [robot(name, (0, 0), goes_first=first) for name in names for first in (True, False)]
    for a in robots:
        for b in robots:
            same = (a.name, a.goes_first) == (b.name, b.goes_first)
            assert precedes(a, b) + precedes(b, a) == (0 if same else 1)
    ordered = [robot('robot10', (0, 0)), robot('robot2', (0, 0)), robot('robot1', (0, 0))]
    assert precedes(ordered[2], ordered[1])
    assert precedes(ordered[1], ordered[0])
    assert precedes(robot('z', (0, 0), goes_first=True), robot('a', (0, 0)))


def test_a_crossing_is_waited_at_when_it_is_near_and_walked_to_while_it_is_far():
    first = robot('a', (2.0, -1.5), (2.0, 3.0))
    far, near = robot('b', (0.0, 0.0), (4.0, 0.0)), robot('b', (0.9, 0.0), (4.0, 0.0))
    assert duty_towards(far, first, ROOM) is Duty.NONE
    assert duty_towards(near, first, ROOM) is Duty.WAIT
    past = robot('a', (2.0, 1.0), (2.0, 3.0))
    assert duty_towards(near, past, ROOM) is Duty.NONE


def test_a_crossing_is_walked_over_if_it_is_left_long_before_the_other_robot_is_there():
    own = robot('b', (1.1, 0.0), (4.0, 0.0))
    assert duty_towards(own, robot('a', (2.0, -9.0), (2.0, 3.0)), ROOM) is Duty.NONE
    assert duty_towards(own, robot('a', (2.0, -3.0), (2.0, 3.0)), ROOM) is Duty.WAIT
    fast = robot('a', (2.0, -9.0), (2.0, 3.0))
    assert duty_towards(own, fast, ROOM, faster=6.0) is Duty.WAIT


def test_a_fast_robot_looks_farther_ahead():
    slow, fast = ROOM.at(0.0), ROOM.at(1.0)
    assert (slow.stop, slow.look) == (ROOM.stop, ROOM.look)
    own, other = robot('a', (0.0, 0.0), (5.0, 0.0)), robot('b', (2.5, 0.0))
    assert is_body_ahead(own, other, fast)
    assert not is_body_ahead(own, other, slow)


def test_a_robot_on_the_path_of_one_that_comes_has_to_leave_it():
    own = robot('b', (3.0, 0.0), (0.0, 0.0))
    assert duty_towards(own, robot('a', (0.0, 0.0), (6.0, 0.0)), ROOM) is Duty.LEAVE
    beside = robot('b', (3.0, 0.85), (0.0, 0.85))
    assert duty_towards(beside, robot('a', (0.0, 0.0), (6.0, 0.0)), ROOM) is Duty.NONE


def test_who_waits_goes_on_a_little_later_than_it_stopped():
    first = robot('a', (2.0, -1.5), (2.0, 3.0))
    own = robot('b', (0.65, 0.0), (4.0, 0.0))
    assert duty_towards(own, first, ROOM) is Duty.NONE
    assert duty_towards(own, first, ROOM, True) is Duty.WAIT


def test_a_body_on_the_next_part_of_the_path_stops_and_one_behind_does_not():
    own = robot('a', (0.0, 0.0), (5.0, 0.0))
    assert is_body_ahead(own, robot('b', (1.2, 0.0)), ROOM)
    assert not is_body_ahead(own, robot('b', (3.0, 0.0)), ROOM)
    assert not is_body_ahead(own, robot('b', (-0.62, 0.0)), ROOM)
    assert not is_body_ahead(own, robot('b', (0.8, 0.75)), ROOM)


def test_a_place_is_clear_if_both_bodies_and_the_margin_fit():
    other = robot('a', (0.0, 0.0), (4.0, 0.0))
    places = np.array([[2.0, 0.79], [2.0, 0.81], [-0.81, 0.0]])
    assert is_clear_of(places, 0.3, other, ROOM).tolist() == [False, True, True]


@pytest.mark.parametrize('line', [[[1.0, 2.0]], [[0.0, 0.0], [1.0, 0.0], [1.0, 0.52]]])
def test_a_line_is_sampled_from_end_to_end(line):
    places, along = sampled(np.array(line))
    assert places[0].tolist() == line[0]
    assert places[-1] == pytest.approx(line[-1])
    assert np.all(np.diff(along) <= 0.05 + 1e-9)
