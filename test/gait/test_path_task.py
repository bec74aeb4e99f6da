"""How a path that somebody asked the robot to follow ends."""

from __future__ import annotations

import math
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from walk_scenes import CORNER, FLAT, ORIGIN, Traced

from quad_common.plan import Plan, turning_points
from quad_common.planar_pose import Pose2D, Twist2D, distances_to_polyline
from quad_common.task_result import FollowCode, TaskOutcome
from quad_gait.behaviours.activity import Activity
from quad_gait.path_task import PathTask

STRAIGHT = Plan.through([[0.0, 0.0], [0.5, 0.0]], 0.0)


class Walk(Traced):
    """A robot that is given paths."""

    def __init__(self):
        super().__init__(FLAT)
        self.task = PathTask(self.supervisor)

    def until_its_end(self, seconds=90.0):
        """Walk until the task ends; return its end and when it came."""
        for _ in range(round(seconds / 0.02)):
            self.run(0.02)
            result = self.task.update(self.simulation.time)
            if result is not None:
                return result
        return None


def test_a_path_is_followed_to_its_end_and_may_be_asked_for_again():
    walk = Walk()
    assert walk.task.begin(CORNER) is None
    assert walk.task.is_followed
    assert walk.until_its_end().outcome is TaskOutcome.SUCCEEDED
    assert walk.simulation.observe().pose.distance_to(CORNER.poses[-1]) < 0.02
    assert walk.task.update(walk.simulation.time) is None
    again = Plan(CORNER.poses)
    assert walk.task.begin(again) is None
    assert walk.until_its_end().outcome is TaskOutcome.SUCCEEDED


def test_a_canceled_path_ends_when_the_robot_stands_within_a_cycle():
    walk = Walk()
    walk.task.begin(STRAIGHT)
    walk.run(1.0)
    walk.task.cancel()
    began = walk.simulation.time
    assert walk.until_its_end().outcome is TaskOutcome.CANCELED
    assert walk.supervisor.activity is Activity.STANDING
    assert walk.simulation.time - began <= walk.supervisor.gait.cycle_period + 0.02
    here = walk.simulation.observe().pose
    walk.run(2.0)
    assert walk.simulation.observe().pose == here


def test_a_stop_ends_a_path_and_the_same_one_is_followed_when_it_is_asked_for():
    walk = Walk()
    walk.task.begin(STRAIGHT)
    walk.run(1.0)
    walk.supervisor.stop()
    result = walk.until_its_end()
    assert (result.outcome, result.code) == (TaskOutcome.ABORTED, FollowCode.UNKNOWN)
    walk.run(8.0)
    walk.supervisor.set_plan(STRAIGHT)
    assert walk.supervisor.wanted_plan is None
    assert walk.task.begin(STRAIGHT) is None
    assert walk.until_its_end().outcome is TaskOutcome.SUCCEEDED


def test_another_plan_preempts_it_and_is_not_taken_back_with_it():
    walk = Walk()
    walk.task.begin(STRAIGHT)
    walk.run(1.0)
    walk.supervisor.set_plan(CORNER)
    result = walk.until_its_end()
    assert (result.outcome, result.code) == (TaskOutcome.ABORTED, FollowCode.NONE)
    assert 'preempted' in result.message
    walk.task.cancel()
    assert walk.supervisor.wanted_plan is CORNER


def test_steering_ends_it():
    walk = Walk()
    walk.task.begin(STRAIGHT)
    walk.run(1.0)
    walk.supervisor.set_twist(Twist2D(0.02))
    assert walk.until_its_end().code == FollowCode.UNKNOWN


@pytest.mark.parametrize('activity', [a for a in Activity if a.is_moving])
def test_a_robot_that_moves_in_any_manner_is_waited_for(activity):
    robot = SimpleNamespace(activity=activity, reason='', wanted_plan=None)
    robot.wish = lambda wish: setattr(robot, 'wanted_plan', wish.plan)
    robot.set_plan = lambda plan: setattr(robot, 'wanted_plan', plan)
    task = PathTask(robot)
    assert task.begin(STRAIGHT) is None
    assert [task.update(time) for time in (0.0, 15.0, 60.0)] == [None] * 3
    task.cancel()
    assert task.update(61.0) is None
    robot.activity = Activity.STANDING
    assert task.update(62.0).outcome is TaskOutcome.CANCELED


def test_where_nothing_tells_where_the_robot_is_it_ends_after_a_while_or_when_it_is_canceled():
    silent = Walk()
    silent.task.begin(STRAIGHT)
    silent.run(1.0)
    assert silent.task.wait(9.0) is None
    result = silent.task.wait(10.5)
    assert (result.outcome, result.code) == (TaskOutcome.ABORTED, FollowCode.PATIENCE_EXCEEDED)
    # It is not followed when odometry is back.
    assert silent.supervisor.wanted_plan is None
    assert silent.task.wait(11.0) is None

    canceled = Walk()
    canceled.task.begin(STRAIGHT)
    canceled.run(1.0)
    canceled.task.cancel()
    assert canceled.task.wait(1.5).outcome is TaskOutcome.CANCELED


def test_trouble_ends_it_with_its_code():
    blocked = Walk()
    blocked.change = {'pose': ORIGIN}
    blocked.task.begin(Plan.through([[0.0, 0.0], [2.0, 0.0]], 0.0))
    assert blocked.until_its_end().code == FollowCode.NO_PROGRESS

    fallen = Walk()
    fallen.task.begin(STRAIGHT)
    fallen.run(1.0)
    fallen.change = {'tilt': 1.0}
    assert fallen.until_its_end().code == FollowCode.NO_CONTROL
    # Nor is another path followed until somebody helps.
    assert fallen.task.begin(CORNER) is None
    assert fallen.until_its_end(0.1).code == FollowCode.NO_CONTROL

    frozen = Walk()
    frozen.run(0.1)
    frozen.supervisor.freeze()
    refused = frozen.task.begin(CORNER)
    assert refused.code == FollowCode.NO_CONTROL
    assert 'refused' in refused.message
    assert frozen.until_its_end(0.1) is None

    held = Walk()
    held.run(0.1)
    held.supervisor.hold_plan('the planner is gone')
    held.task.begin(STRAIGHT)
    result = held.until_its_end(11.0)
    assert result.code == FollowCode.PATIENCE_EXCEEDED
    assert 'the planner is gone' in result.message


@pytest.mark.parametrize('seed', range(5))
def test_a_path_of_many_points_becomes_few_segments_that_keep_near_to_it(seed):
    rng = np.random.default_rng(seed)
    corners = np.cumsum(rng.uniform(-2.0, 2.0, (6, 2)), axis=0)
    dense = np.vstack([np.linspace(a, b, 40) for a, b in pairwise(corners)])
    dense += rng.uniform(-0.005, 0.005, dense.shape)
    few = turning_points(dense)
    assert len(few) <= 8
    assert np.max(distances_to_polyline(dense, few)) <= 0.02
    assert np.array_equal(few[[0, -1]], dense[[0, -1]])
    # A second time nothing is left out any more.
    assert np.array_equal(turning_points(few), few)


def test_turning_points_of_few_points_and_of_a_circle():
    here = Pose2D(1.0, 2.0, 0.3)
    assert turning_points(np.array([[1.0, 2.0]])).tolist() == [[1.0, 2.0]]
    assert Plan.through(turning_points(np.array([[1.0, 2.0]])), 0.3).poses == (here,)
    angles = np.linspace(0.0, 2.0 * math.pi, 400)
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    few = turning_points(circle)
    assert 12 <= len(few) <= 40
    assert np.max(distances_to_polyline(circle, few)) <= 0.02


def test_turning_points_of_a_long_zigzag_keep_near_to_it():
    count = 3000
    zigzag = np.column_stack([0.2 * np.arange(count), np.linspace(1.0, 0.5, count)])
    zigzag[::2, 1] *= -1.0
    few = turning_points(zigzag)
    # Every corner is one: whichever part is halved, none may be left out.
    assert np.array_equal(few, zigzag)
