"""A clock follows ``/clock`` whenever it is asked for; no executor calls its node each time."""

import time

import pytest

pytest.importorskip('rclpy')

import rclpy
from builtin_interfaces.msg import Time
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from quad_common.ros.guarded_node import GuardedNode
from quad_common.ros.run_node import make_executor
from quad_lab.topic_walk.node_processes import isolated_domain

pytestmark = pytest.mark.ros

_PATIENCE = 30.0


class Listener(GuardedNode):
    """Has a clock, and notes what is reported."""

    def __init__(self, **kwargs):
        super().__init__('listener', **kwargs)
        self.reports = []

    def report_error(self, error):
        self.reports.append(str(error))

    def report_unexpected(self, sentence, kind, stack):
        self.reports.append(sentence)

    @property
    def seconds(self):
        return self.get_clock().now().nanoseconds * 1e-9


class Stage:
    """A node in simulated time, and who makes that."""

    def __init__(self):
        quality = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        simulated = [Parameter('use_sim_time', value=True)]
        self.listener = Listener(parameter_overrides=simulated)
        self.maker = rclpy.create_node('maker')
        self.clock = self.maker.create_publisher(Clock, '/clock', quality)
        self.executor = make_executor()
        self.executor.add_node(self.listener)
        self.wait(lambda: self.clock.get_subscription_count() == 1)

    def wait(self, holds):
        end = time.monotonic() + _PATIENCE
        while not holds():
            assert time.monotonic() < end
            self.listener.turn(self.executor)

    def tell(self, sec, nanosec=0):
        self.clock.publish(Clock(clock=Time(sec=sec, nanosec=nanosec)))


@pytest.fixture
def stage():
    with isolated_domain():
        rclpy.init()
        stage = Stage()
        yield stage
        stage.executor.shutdown()
        stage.listener.destroy_node()
        stage.maker.destroy_node()
        rclpy.try_shutdown()


def test_the_clock_is_as_far_on_as_the_topic_has_told(stage):
    assert stage.listener.seconds == 0.0
    for told in (3, 12, 5):
        stage.tell(told, 250_000_000)
        stage.wait(lambda told=told: stage.listener.seconds == told + 0.25)


def test_no_executor_calls_the_node_for_each_time(stage):
    topics = [subscription.topic_name for subscription in stage.listener.subscriptions]
    assert '/clock' not in topics
    stage.tell(7)
    stage.wait(lambda: stage.listener.seconds == 7.0)
    before = stage.listener.callbacks
    for told in range(8, 40):
        stage.tell(told)
    stage.listener.turn(stage.executor)
    # The turn itself is one.
    assert stage.listener.callbacks <= before + 2
    stage.wait(lambda: stage.listener.seconds == 39.0)


def test_a_time_that_is_none_is_refused_and_the_last_one_stays(stage):
    stage.tell(7)
    stage.wait(lambda: stage.listener.seconds == 7.0)
    stage.tell(-1)
    stage.wait(lambda: stage.listener.seconds == 7.0 and stage.listener.reports)
    assert 'the clock cannot be used: it is -1 s' in stage.listener.reports[0]
    stage.tell(8)
    stage.wait(lambda: stage.listener.seconds == 8.0)


def test_a_node_that_leaves_simulated_time_has_its_own_and_may_come_back(stage):
    stage.tell(7)
    stage.wait(lambda: stage.listener.seconds == 7.0)
    stage.listener.set_parameters([Parameter('use_sim_time', value=False)])
    assert stage.listener.seconds == pytest.approx(time.time(), abs=60.0)
    stage.wait(lambda: stage.clock.get_subscription_count() == 0)
    stage.listener.set_parameters([Parameter('use_sim_time', value=True)])
    stage.wait(lambda: stage.clock.get_subscription_count() == 1)
    stage.tell(9)
    stage.wait(lambda: stage.listener.seconds == 9.0)
