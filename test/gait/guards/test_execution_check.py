"""When nobody carries trajectories out, little is planned until somebody does."""

import numpy as np

from quad_gait.guards.execution_check import ExecutionCheck


def states(check, unfollowed, begin=0.0, seconds=20.0):
    """Return times and what the check says while the joints do not follow."""
    rows = []
    for time in np.arange(begin, begin + seconds, 0.1):
        check.update(float(time), unfollowed(time))
        rows.append((time, check.is_wrong, check.is_pausing))
    return np.array(rows)


def test_joints_that_follow_are_no_reason_to_wait():
    rows = states(ExecutionCheck(), lambda time: 0.0)
    assert not rows[:, 1:].any()


def test_after_three_seconds_nobody_executes_and_pauses_take_turns_with_trials():
    check = ExecutionCheck()
    rows = states(check, lambda time: time)
    wrong = rows[rows[:, 1] == 1.0]
    assert 2.95 < wrong[0, 0] < 3.15
    assert 0.25 < wrong[:, 2].mean() < 0.5
    turns = np.count_nonzero(np.diff(wrong[:, 2]))
    assert turns >= 4
    assert 'no joint has followed a trajectory for 20 s' in str(check)


def test_it_is_over_as_soon_as_the_joints_follow():
    check = ExecutionCheck()
    states(check, lambda time: time, seconds=5.0)
    assert check.is_wrong
    check.update(5.1, 0.0)
    assert not check.is_wrong
    assert not check.is_pausing


def test_a_clock_that_is_set_back_ends_it():
    check = ExecutionCheck()
    states(check, lambda time: 10.0, begin=100.0, seconds=1.0)
    check.update(0.5, 10.0)
    assert not check.is_wrong
