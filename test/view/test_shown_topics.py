"""The page is there whatever robots come and go, and whatever they publish."""

from __future__ import annotations

import pytest

pytest.importorskip('nav_msgs')
pytest.importorskip('viser')

import rclpy
from geometry_msgs.msg import Point32, Polygon, PolygonStamped
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from quad_common.errors import InvalidMessage
from quad_common.status import Level
from quad_lab.topic_walk.node_processes import isolated_domain
from quad_view.parameters import ViewerParameters
from quad_view.robot_topics import RobotTopics, SampledTopics
from quad_view.scene.commands import Request
from quad_view.scene.robot_model import model_from_urdf
from quad_view.scene.robot_view import RobotView
from quad_view.scene.robots import MOST_ROBOTS
from quad_view.scene.words import Said
from quad_view.viewer_node import ViewerNode


@pytest.fixture(scope='module')
def viewer():
    with isolated_domain():
        rclpy.init()
        node = ViewerNode(parameter_overrides=[Parameter('port', value=0)])
        yield node
        node.destroy_node()
        rclpy.try_shutdown()


@pytest.fixture
def robots(viewer):
    yield viewer._robots
    viewer._robots.match((), 1e6)
    viewer._robots.match((), 2e6)


def entities(node):
    return [len(list(kind)) for kind in (node.subscriptions, node.publishers, node.clients)]


def names_of(robots):
    return [robot.view.name for robot in robots]


def test_a_robot_that_has_gone_leaves_the_page_and_nothing_behind(viewer, robots):
    robots.match(['one'], 0.0)
    before = entities(viewer), entities(viewer._inputs)
    robots.match(['one', 'two'], 0.0)
    two = robots.get('two')
    two.commands.carry_out(Request('two', 'stand'))
    viewer._page.draw(0.0)
    robots.match(['one'], 59.0)
    assert names_of(robots) == ['one', 'two']
    robots.match(['one'], 61.0)
    assert names_of(robots) == ['one']
    assert (entities(viewer), entities(viewer._inputs)) == before
    viewer._page.draw(61.0)
    robots.match(['two'], 62.0)
    assert names_of(robots) == ['one', 'two']


def test_the_last_robot_may_go(viewer, robots):
    robots.match(['one'], 0.0)
    robots.match([], 61.0)
    assert len(robots) == 0
    viewer._page.draw(61.0)
    robots.match(['two'], 62.0)
    viewer._page.draw(62.0)
    assert viewer._page._robot_looked_at() is robots.get('two').view


def test_robots_under_ever_new_names_take_no_more_and_no_more_room(robots):
    for number in range(3 * MOST_ROBOTS):
        robots.match([f'robot{number}', 'one'], float(number))
    assert len(robots) == MOST_ROBOTS
    assert {'one', f'robot{number}'} <= set(names_of(robots))


class Wanted:
    """Notes how topics are subscribed to."""

    def __init__(self) -> None:
        self.made = {}

    def create_subscription(self, kind, topic, callback, qos, **options):
        self.made[topic] = kind, options


def holds_many(kind) -> bool:
    """Return whether a message holds a sequence of other messages, slow to take apart."""
    fields = kind.get_fields_and_field_types().values()
    return any(text.startswith('sequence<') and '/' in text for text in fields)


def test_messages_that_hold_many_others_are_bounded_before_they_are_taken_apart():
    named = Wanted()
    RobotTopics(named, Wanted(), RobotView(''), ViewerParameters())
    slow = {topic for topic, (kind, _) in named.made.items() if holds_many(kind)}
    assert {'plan', 'plan_markers', 'footholds', 'diagnostics', 'obstacles/present'} <= slow
    unbounded = {topic for topic in slow if 'most_bytes' not in named.made[topic][1]}
    # Its sequence is of a few fields.
    assert unbounded <= {'height_map'}


class Taken:
    """A subscription on which one message waits."""

    msg_type = PolygonStamped

    def __init__(self, data) -> None:
        self.handle = self
        self._data = [(data, {})]

    def __enter__(self):
        return self

    def __exit__(self, *_) -> None:
        pass

    def take_message(self, kind, raw):
        assert raw
        return self._data.pop() if self._data else None


class Inputs:
    """A node on which one message waits for each subscription."""

    def __init__(self, data) -> None:
        self._data = data

    def create_subscription(self, kind, name, callback, qos, **options):
        return Taken(self._data)


@pytest.mark.parametrize('data', [bytes(1_000_001), b'none at all'])
def test_what_is_looked_at_is_refused_if_it_is_too_long_or_no_message(data):
    sampled = SampledTopics(Inputs(data), '/')
    sampled.create_subscription(PolygonStamped, 'support_polygon', pytest.fail, 10)
    (problem,) = sampled.look()
    assert isinstance(problem, InvalidMessage)


def test_what_is_looked_at_is_handed_on():
    message = PolygonStamped(polygon=Polygon(points=[Point32(x=2.0)]))
    got = []
    sampled = SampledTopics(Inputs(serialize_message(message)), '/')
    sampled.create_subscription(PolygonStamped, 'support_polygon', got.append, 10)
    assert sampled.look() == []
    assert got == [message]


def test_a_robot_of_too_many_parts_is_refused():
    visual = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
    with pytest.raises(InvalidMessage, match='2001 visible parts'):
        model_from_urdf(f'<robot name="r"><link name="b">{visual * 2001}</link></robot>')


def test_words_of_ever_new_nodes_do_not_hide_our_own():
    view = RobotView('')
    view.note_said({'gait_node': Said(Level.OK, 'standing', {}, 0.0)})
    for number in range(300):
        view.note_said({f'node{number}': Said(Level.OK, 'words', {}, float(number))})
    assert len(view.said) < 60
    assert {'gait_node', 'node299'} <= view.said.keys()
    assert 'node0' not in view.said
