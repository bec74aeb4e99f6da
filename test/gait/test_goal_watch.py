"""What is said of trajectories that go to a controller as goals."""

import pytest

from quad_gait.goal_watch import GoalWatch, TrajectoryCode


@pytest.fixture
def watch():
    return GoalWatch('arm/follow')


def test_nothing_is_said_of_goals_that_replace_one_another(watch):
    for now in range(5):
        number = watch.sent(float(now))
        watch.accepted(number)
        watch.given_up(number - 1, TrajectoryCode.INVALID_GOAL, 'replaced', now + 0.5)
        watch.taken_over(number - 1, now + 0.5)
        assert watch.problem(now + 0.9, is_served=True) == ''


def test_a_controller_that_is_not_there_is_missed(watch):
    assert 'arm/follow is not there' in watch.problem(0.0, is_served=False)
    watch.missed(0.0)
    assert 'was lost' in watch.problem(100.0, is_served=True)
    watch.accepted(watch.sent(101.0))
    assert watch.problem(102.0, is_served=True) == ''


def test_a_controller_that_does_not_answer_is_named(watch):
    first, second = watch.sent(0.0), watch.sent(0.5)
    assert watch.problem(0.9, is_served=True) == ''
    assert 'for 3 s' in watch.problem(3.0, is_served=True)
    watch.accepted(second)
    assert watch.problem(3.0, is_served=True) == ''
    watch.accepted(first)
    assert watch.problem(9.0, is_served=True) == ''


def test_goals_that_nobody_answers_are_not_kept_for_good(watch):
    for k in range(1000):
        last = watch.sent(0.02 * k)
    assert len(watch._unanswered) <= 50
    assert 'for 20 s' in watch.problem(20.0, is_served=True)
    watch.accepted(last)
    assert watch.problem(20.0, is_served=True) == ''


@pytest.mark.parametrize('code', [*TrajectoryCode, -17, 99])
def test_a_trajectory_that_was_given_up_is_said_until_another_one_is_followed(watch, code):
    number = watch.sent(0.0)
    watch.accepted(number)
    watch.given_up(number, code, 'knee too far', 1.0)
    said = watch.problem(50.0, is_served=True)
    assert 'knee too far' in said
    assert f'code {int(code)}' in said or TrajectoryCode(code).name in said
    watch.accepted(watch.sent(50.0))
    assert watch.problem(50.1, is_served=True) == ''


def test_trouble_is_said_for_a_while_though_the_next_trajectory_is_followed(watch):
    watch.rejected(watch.sent(0.0), 0.1)
    watch.accepted(watch.sent(0.2))
    assert 'rejected a trajectory' in watch.problem(4.0, is_served=True)
    assert watch.problem(5.2, is_served=True) == ''


def test_a_newest_goal_that_somebody_canceled_is_said(watch):
    number = watch.sent(0.0)
    watch.accepted(number)
    watch.taken_over(number, 1.0)
    assert 'another client' in watch.problem(60.0, is_served=True)
