"""A robot that was stopped: whatever it waited for, its goal is given up."""

import numpy as np
import pytest

from quad_common.frames.map_frame import MapFrame
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import session_from_parameters
from quad_planner.session.given_goal import GoalEnd

GOAL, OTHER = Pose2D(3.0, 1.0, 0.0), Pose2D(3.0, 3.0, 1.0)
FREE, CLOSED = np.zeros((80, 80), np.int8), np.zeros((80, 80), np.int8)
CLOSED[:, 40] = 100


class Later:
    """Requests that are worked on when a test says so; a newer one ends an older one."""

    is_busy = False

    def __init__(self):
        self._request = None

    def is_superseded(self):
        return False

    def submit(self, work, done):
        self._request = work, done

    def work(self):
        request, self._request = self._request, None
        if request is not None:
            work, done = request
            done(work)


class Walk:
    """A robot in an empty room of 4 m by 4 m, on its way to the goal."""

    def __init__(self):
        self.plans, self.said, self.requests = [], [], Later()
        parameters = PlannerParameters(robot='titan_viii', method='mesh')
        robot = load_robot('titan_viii')
        self.session = session_from_parameters(
            parameters, robot, MapFrame('map'), self.requests, self
        )
        self.take_map(FREE)
        self.session.take_pose(0.1, Pose2D(1.0, 1.0, 0.0))
        self.given = self.give(GOAL)

    def publish_plan(self, plan):
        self.plans.append(plan)
        return len(self.plans)

    def show_map(self, prepared):
        """Show nothing."""

    def say(self, sentence):
        self.said.append(sentence)

    warn = say

    def update_status(self):
        """Report nothing."""

    def give(self, goal):
        given = self.session.give_goal('map', goal)
        self.requests.work()
        return given

    def take_map(self, cells):
        self.session.take_grid(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)), 'map')
        self.requests.work()

    def stop(self, stamp=None):
        """Say, as gait_node does, that the robot was stopped; the last plan, or none, came."""
        stamp = len(self.plans) if stamp is None else stamp
        self.session.take_followed(stamp, '', None)
        self.requests.work()


def on_its_way(walk):
    """It follows its plan."""


def without_a_path(walk):
    """The map leaves no path: the plan was taken back, the goal is kept."""
    walk.take_map(CLOSED)
    assert walk.plans[-1] is None


def waiting_for_another_robot(walk):
    """It stands until another robot has passed."""
    walk.session.hold('waiting for b to pass')
    assert walk.plans[-1] is None


def giving_way(walk):
    """It goes aside, for another robot to pass."""
    walk.session.detour(Pose2D(1.0, 2.5, 0.0), 'giving way to b')
    walk.requests.work()
    assert walk.session.is_detour


def given_way(walk):
    """It has gone aside, and waits there."""
    giving_way(walk)
    walk.session.take_pose(1.0, Pose2D(1.0, 2.5, 0.0))
    walk.session.take_followed(len(walk.plans), 'map', None)
    assert walk.session.goal is not None


def while_the_same_goal_is_searched(walk):
    """The goal was given again, and its path is searched."""
    walk.given = walk.session.give_goal('map', GOAL)


def close_to_its_goal(walk):
    """It would arrive in a moment."""
    walk.session.take_pose(1.0, Pose2D(2.95, 1.0, 0.0))


SITUATIONS = (
    on_its_way,
    without_a_path,
    waiting_for_another_robot,
    giving_way,
    given_way,
    while_the_same_goal_is_searched,
    close_to_its_goal,
)


@pytest.mark.parametrize('situation', SITUATIONS)
def test_it_goes_nowhere_whatever_happens_afterwards(situation):
    walk = Walk()
    situation(walk)
    walk.stop()
    assert walk.said[-1] == 'the robot was stopped: its goal is given up'
    assert walk.given.end is GoalEnd.ENDED
    assert walk.session.goal is walk.session.plan is None
    count = len(walk.plans)
    walk.take_map(CLOSED)
    walk.take_map(FREE)
    walk.session.resume()
    walk.session.take_pose(5.0, Pose2D(2.0, 2.0, 0.0))
    walk.requests.work()
    assert [plan for plan in walk.plans[count:] if plan is not None] == []


@pytest.mark.parametrize('situation', SITUATIONS)
def test_the_same_goal_may_be_given_again(situation):
    walk = Walk()
    situation(walk)
    walk.stop()
    # A robot that was stopped follows no plan to that goal until one was taken back.
    assert walk.plans[-1] is None
    walk.take_map(FREE)
    walk.give(GOAL)
    assert walk.plans[-1].poses[-1] == GOAL


def test_a_plan_that_crossed_the_stop_is_taken_back():
    walk = Walk()
    walk.take_map(CLOSED)
    last_seen = len(walk.plans)
    walk.take_map(FREE)
    assert walk.plans[-1] is not None
    walk.stop(last_seen)
    assert walk.plans[-1] is None
    assert walk.session.goal is None


def test_a_stop_before_a_goal_was_planned_to_does_not_end_it():
    walk = Walk()
    last_seen = len(walk.plans)
    walk.give(OTHER)
    walk.stop(last_seen)
    assert walk.session.goal == OTHER
    assert walk.plans[-1].poses[-1] == OTHER


def test_a_stop_that_is_told_again_to_a_planner_that_begins_says_nothing():
    walk = Walk()
    walk.stop(123_456)
    assert walk.session.goal == GOAL
    assert walk.said == []


def test_a_robot_that_is_stopped_twice_is_told_of_once():
    walk = Walk()
    walk.stop()
    walk.stop()
    assert len(walk.said) == 1
    assert len(walk.plans) == 2
