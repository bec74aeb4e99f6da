"""A walk that a planner guides ends when no plan is to be expected any more."""

import pytest

from quad_gait.behaviours.activity import Activity
from quad_lab.closed_loop.guided_end import GuidedEnd

AT_ONCE = [activity for activity in Activity if activity.is_disabled] + [Activity.ARRIVED]
LATER = [activity for activity in Activity if activity.is_terminal and activity not in AT_ONCE]


@pytest.mark.parametrize('activity', AT_ONCE)
def test_where_no_plan_can_help_it_ends_at_once(activity):
    assert GuidedEnd().is_over(1.0, activity)


@pytest.mark.parametrize('activity', LATER)
def test_a_robot_that_a_plan_may_move_is_waited_for_but_not_for_long(activity):
    end = GuidedEnd(patience=2.0)
    assert [end.is_over(time, activity) for time in (1.0, 2.9, 3.1)] == [False, False, True]


def test_a_robot_that_walks_again_is_given_the_same_time_again():
    end = GuidedEnd(patience=2.0)
    assert not end.is_over(1.0, Activity.STOPPED)
    assert not end.is_over(2.5, Activity.WALKING)
    assert not end.is_over(4.0, Activity.STOPPED)


@pytest.mark.parametrize('activity', [None, Activity.WAITING, Activity.STANDING, Activity.WALKING])
def test_others_go_on(activity):
    end = GuidedEnd()
    assert not any(end.is_over(time, activity) for time in (0.0, 1e6))
