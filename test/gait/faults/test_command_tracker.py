"""Which trajectory the joints follow, where some have come late and others never."""

import numpy as np

from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.faults.command_tracker import CommandTracker, TrackerOptions
from quad_gait.faults.joint_path import JointPath

OPTIONS = TrackerOptions()
STEP = 0.02
NAMES = ('a', 'b', 'c')


def path(given, times, positions, stamp=0.0):
    """Return a trajectory through points, with straight lines between them."""
    times, positions = np.asarray(times), np.asarray(positions, dtype=float)
    velocities = np.gradient(positions, times, axis=0)
    velocities[[0, -1]] = 0.0
    trajectory = JointTrajectory(NAMES, stamp, times, positions, velocities)
    return JointPath(trajectory, given, OPTIONS.tolerance, OPTIONS.lag)


def off_while(tracker, begin, end, positions_at):
    """Return the joints that are off at any measurement; None among them: nothing fits."""
    off = []
    for time in np.arange(begin, end, STEP):
        found = tracker.explain(float(time), positions_at(float(time)))
        off += [None] if found is None else np.flatnonzero(found.off).tolist()
    return off


def test_joints_that_pass_by_a_trajectory_on_their_way_into_another_do_not_follow_it():
    still, far, near = np.zeros(3), np.array([0.6, -0.6, 0.4]), np.array([0.3, -0.3, 0.2])
    tracker = CommandTracker(OPTIONS)
    tracker.hold(0.0, still)
    # The first is followed, but late; the joints pass by where the second, which is lost, rests.
    tracker.add(path(0.1, [0.0, 0.5, 3.0], [far, far, far], stamp=0.2))
    tracker.add(path(0.2, [0.0, 0.5, 3.0], [near, near, near], stamp=0.3))

    def late(time):
        return far * np.clip((time - 1.0) / 0.4, 0.0, 1.0)

    assert off_while(tracker, 0.4, 2.5, late) == []


def test_joints_that_rest_near_where_a_later_trajectory_begins_may_still_follow_an_earlier_one():
    still, first, second = np.zeros(3), np.array([0.13, 0.1, -0.1]), np.array([0.04, 0.04, 0.0])
    tracker = CommandTracker(OPTIONS)
    tracker.hold(0.0, still)
    # They start on arrival: one arrives late, the next one never.
    tracker.add(path(0.1, [0.06, 0.3, 0.5], [first, first, first]))
    tracker.add(path(0.2, [0.06, 0.3, 0.5], [second, second, second]))

    def late(time):
        return first * np.clip((time - 1.0) / 0.2, 0.0, 1.0)

    assert off_while(tracker, 0.4, 2.5, late) == []


def test_what_the_joints_have_left_for_good_explains_nothing_any_more():
    first, second = np.zeros(3), np.full(3, 0.5)
    tracker = CommandTracker(OPTIONS)
    tracker.hold(0.0, first)
    tracker.add(path(0.1, [0.0, 0.5, 5.0], [second, second, second], stamp=0.2))
    assert off_while(tracker, 0.7, 1.2, lambda time: second) == []
    # A joint that falls back to where it was does not hold.
    fallen = np.array([0.0, 0.5, 0.5])
    assert set(off_while(tracker, 1.2, 1.4, lambda time: fallen)) == {0}
    # All of them there: nothing fits.
    assert set(off_while(tracker, 1.4, 1.6, lambda time: first)) == {None}
