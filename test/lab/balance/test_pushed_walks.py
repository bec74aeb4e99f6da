"""Pushes on a way to a goal: where they come, how hard they are, and what counts as survived."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip('rclpy')

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_lab.balance.balance_case import push_unit
from quad_lab.balance.pushed_walks import PushedWalk, Pushes
from quad_lab.topic_walk.walk_record import WalkRecord

pytestmark = pytest.mark.ros

ROBOT = load_robot('cuhk')
GOAL = Pose2D(4.0, 0.0, 0.0)


class Walker:
    """Stands for an observer of a robot that walks straight on, and takes what is published."""

    def __init__(self, speed):
        self.speed, self.time, self.pose = speed, 0.0, None
        self.plan = Plan.through([[0.0, 0.0], [GOAL.x, GOAL.y]], 0.0)
        self.statuses, self.published = {}, []

    def publisher(self, kind, topic):
        assert topic == 'push'
        # The simulator finds it only after a while.
        found = lambda: int(self.time > 1.0)  # noqa: E731
        return SimpleNamespace(publish=self.take, get_subscription_count=found)

    def take(self, message):
        self.published.append((self.time, self.pose.x, message))
        self.statuses['sim_node'] = (b'', '', {'pushes': str(len(self.published))})

    def walk(self, pushes):
        while self.pose is None or self.pose.x < GOAL.x:
            self.time += 0.1
            self.pose = Pose2D(self.speed * self.time, 0.0, 0.0)
            pushes(self)
        return self.published


def published(speed, seed):
    return Walker(speed).walk(Pushes(ROBOT, 0.4, np.random.default_rng(seed)))


@pytest.mark.parametrize('seed', range(5))
def test_a_robot_is_pushed_once_in_each_third_of_the_way(seed):
    begin, third = 0.1 * GOAL.x, 0.25 * GOAL.x
    places = [x for _, x, _ in published(0.3, seed)]
    assert len(places) == 3
    for number, place in enumerate(places):
        assert begin + number * third <= place <= begin + (number + 1) * third + 0.04


def test_each_push_is_as_hard_as_it_is_to_be_and_along_the_body():
    for _, _, message in published(0.3, 0):
        force = message.wrench.force
        assert message.header.frame_id == 'base_link'
        impulse = 0.1 * math.hypot(force.x, force.y) / (ROBOT.mass * push_unit(ROBOT))
        assert (impulse, force.z) == (pytest.approx(0.4), 0.0)


def test_no_push_comes_upon_the_last_one():
    times = [time for time, _, _ in published(1.5, 1)]
    assert np.diff(times).min() >= 1.5


def walk_that_ends(pose, pushes=3, problem=''):
    record = WalkRecord(GOAL, has_arrived=not problem, problem=problem)
    record.note_pose(1.0, pose)
    return PushedWalk(
        'cuhk', 'room', 'crab', Pose2D(0.0, 0.0, 0.0), GOAL, pushes, (), record.result()
    )


def test_a_walk_ends_well_at_its_goal_after_all_of_its_pushes():
    assert walk_that_ends(GOAL).is_good
    assert not walk_that_ends(GOAL, pushes=2).is_good
    assert not walk_that_ends(replace(GOAL, x=GOAL.x - 0.06)).is_good
    assert not walk_that_ends(replace(GOAL, yaw=0.1)).is_good


def test_a_fall_that_the_gait_ends_by_itself_is_one():
    fallen = walk_that_ends(GOAL, problem='fallen: the body is tilted by 32 degrees')
    assert fallen.has_fallen
    assert not fallen.is_good
    assert not walk_that_ends(GOAL, problem='blocked: an obstacle').has_fallen
