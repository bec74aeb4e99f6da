"""Which activities go on by themselves, and which wait for somebody."""

from quad_gait.behaviours.activity import Activity

TERMINAL = {'arrived', 'stopped', 'blocked', 'fallen', 'lame', 'not executed', 'emergency stop'}


def test_a_robot_that_has_ended_waits_for_a_wish_and_one_that_moves_does_not():
    assert {activity.value for activity in Activity if activity.is_terminal} == TERMINAL


def test_only_a_fallen_lame_or_frozen_robot_cannot_follow_a_new_plan():
    assert {activity for activity in Activity if activity.is_disabled} == {
        Activity.FALLEN,
        Activity.LAME,
        Activity.EMERGENCY_STOP,
    }


def test_a_disabled_robot_has_ended():
    assert all(activity.is_terminal for activity in Activity if activity.is_disabled)
