"""What the gait says to its planner when it is stopped."""

from types import SimpleNamespace

import pytest

pytest.importorskip('nav_msgs')

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from std_msgs.msg import Header
from told_supervisor import ToldSupervisor, measurement

from quad_common.plan import Plan
from quad_common.planar_pose import STILL, Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.gait_topics import GaitTopics
from quad_gait.parameters import GaitParameters

PLAN = Plan.through([[0.0, 0.0], [2.0, 0.0]], 0.0)


class Told:
    """A gait, and what it publishes on plan/followed: (stamp, frame, whether a plan)."""

    def __init__(self):
        robot = load_robot('titan_viii')
        gait = load_gait('crawl', robot)
        turning = turning_gait_for(gait, robot)
        self.supervisor = ToldSupervisor(robot, gait, turning, SupervisorOptions())
        self.supervisor.update(measurement(robot, 1.0))
        self._published = []
        self._topics = GaitTopics(self, self.supervisor, GaitParameters())

    def create_publisher(self, kind, topic, qos):
        is_followed = topic == 'plan/followed'
        return SimpleNamespace(
            publish=self._published.append if is_followed else lambda message: None,
            get_subscription_count=lambda: 0,
        )

    def receive(self, stamp, plan):
        poses = [] if plan is None else [PoseStamped()]
        self.supervisor.set_plan(plan)
        path = Path(header=Header(stamp=Time(sec=stamp), frame_id='map'), poses=poses)
        is_followed = plan is not None and self.supervisor.wanted_plan is plan
        self._topics.take_plan(path, is_followed)

    def tell(self):
        self._topics.publish_followed()

    @property
    def published(self):
        told = [(p.header.stamp.sec, p.header.frame_id, bool(p.poses)) for p in self._published]
        self._published.clear()
        return told


def wish(name, *args):
    """Return what wishes for something of a supervisor; pytest shows its name."""

    def make(supervisor):
        getattr(supervisor, name)(*args)

    make.__name__ = name
    return make


STOPS = (
    wish('stop'),
    wish('stand'),
    wish('sit'),
    wish('freeze'),
    wish('set_twist', Twist2D(0.1, 0.0, 0.0)),
    wish('set_twist', STILL),
)


@pytest.mark.parametrize('stop', STOPS)
def test_a_robot_that_follows_a_plan_is_said_to_be_stopped(stop):
    told = Told()
    told.receive(5, PLAN)
    assert told.published == [(5, 'map', True)]
    stop(told.supervisor)
    told.tell()
    assert told.published == [(5, '', False)]
    # The planner takes it back.
    told.receive(6, None)
    assert told.published == []


@pytest.mark.parametrize('stop', STOPS)
def test_a_robot_whose_plan_was_taken_back_is_said_to_be_stopped_too(stop):
    told = Told()
    told.receive(5, PLAN)
    told.receive(6, None)
    assert told.published == [(5, 'map', True), (5, 'map', False)]
    stop(told.supervisor)
    told.tell()
    assert told.published == [(6, '', False)]


def test_steering_says_so_once():
    told = Told()
    for _ in range(5):
        told.supervisor.set_twist(Twist2D(0.1, 0.0, 0.0))
        told.tell()
    assert told.published == [(0, '', False)]


def test_a_plan_that_is_refused_is_said_to_be_stopped():
    told = Told()
    told.supervisor.freeze()
    told.tell()
    assert told.published == [(0, '', False)]
    told.receive(5, PLAN)
    assert told.published == [(5, '', False)]


def test_a_robot_that_was_stopped_follows_the_next_plan_to_the_same_goal_once_one_was_taken_back():
    told = Told()
    told.receive(5, PLAN)
    told.supervisor.stop()
    told.receive(6, PLAN)
    assert told.published == [(5, 'map', True), (6, '', False)]
    told.receive(7, None)
    told.receive(8, PLAN)
    assert told.published == [(8, 'map', True)]
