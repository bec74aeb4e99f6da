"""A planner notices another one that speaks for a robot of the same name."""

import pytest

from quad_common.planar_pose import Pose2D
from quad_planner.traffic.namesake import Namesake


def spoken(seconds, other=None, other_until=100.0):
    """Speak five times a second, and hear oneself, and another one; return what is said."""
    namesake, problems = Namesake('scout'), []
    for k in range(round(seconds / 0.2)):
        time = 0.2 * k
        own = Pose2D(0.01 * k, 0.0, 0.1)
        namesake.say(own)
        # Words come a little late, and their heading is rounded.
        namesake.hear(time, Pose2D(max(0.01 * (k - 1), 0.0), 0.0, 0.1 + 1e-12))
        if other is not None and time < other_until:
            namesake.hear(time, other(k))
        problems.append(namesake.problem(time))
    return problems


def test_its_own_words_are_no_other_robots():
    assert not any(spoken(60.0))


@pytest.mark.parametrize('speed', [0.0, 0.03])
def test_another_robot_of_the_same_name_is_named_within_two_seconds(speed):
    problems = spoken(10.0, lambda k: Pose2D(3.0, 1.0 + speed * k, 0.0))
    assert "another planner speaks for a robot named 'scout'" in problems[-1]
    assert problems[10]


def test_last_words_of_a_planner_that_was_replaced_are_not():
    assert not any(spoken(10.0, lambda k: Pose2D(3.0, 1.0, 0.0), other_until=0.9))


def test_a_planner_that_falls_silent_is_forgotten():
    problems = spoken(30.0, lambda k: Pose2D(3.0, 1.0, 0.0), other_until=10.0)
    assert any(problems)
    assert not problems[-1]
