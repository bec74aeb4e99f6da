"""Every callback of every node is over the net: those that rclpy made for itself too."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

import rclpy
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter
from std_msgs.msg import String
from std_srvs.srv import Trigger

from quad_common.errors import MapError
from quad_common.ros.guarded_node import Guarded, GuardedNode
from quad_common.ros.ros_node import ERROR, OK, QuadNode
from quad_common.ros.run_node import make_executor

pytestmark = pytest.mark.ros

NODES = {
    'planner_node': ('quad_planner.planner_node', 'PlannerNode', {}),
    'gait_node': ('quad_gait.gait_node', 'GaitNode', {'ground': 'uneven', 'gait': 'crawl'}),
    'sim_node': ('quad_sim.sim_node', 'SimNode', {'backend': 'kinematic'}),
    'ceiling_camera_node': ('quad_perception.ceiling_camera_node', 'CeilingCameraNode', {}),
}


@pytest.fixture
def make(domain) -> Iterator:
    """Make nodes by name in a context of their own, and destroy them in the end."""
    context = rclpy.Context()
    rclpy.init(context=context)
    nodes = []

    def make_node(name: str) -> QuadNode:
        module, kind, parameters = NODES[name]
        given = {'use_sim_time': True, **parameters}
        overrides = [Parameter(key, value=value) for key, value in given.items()]
        node = getattr(importlib.import_module(module), kind)(
            context=context, parameter_overrides=overrides
        )
        nodes.append(node)
        return node

    yield make_node
    for node in nodes:
        node.destroy_node()
    context.try_shutdown()


def callbacks_of(node: QuadNode) -> dict[str, object]:
    """Return every callback that rclpy could call, and that of the node's clock."""
    # The node itself leaves that out: no executor calls it.
    subscriptions = super(GuardedNode, node).subscriptions
    found = {f'subscription {s.topic_name}': s.callback for s in subscriptions}
    found |= {f'service {s.srv_name}': s.callback for s in node.services}
    found |= {f'timer {index}': t.callback for index, t in enumerate(node.timers)}
    found |= {f'guard {index}': g.callback for index, g in enumerate(node.guards)}
    for kind in ('pre', 'on', 'post'):
        listed = getattr(node, f'_{kind}_set_parameters_callbacks')
        found |= {f'{kind}_set_parameters {i}': c for i, c in enumerate(listed)}
    return found


@pytest.mark.parametrize('name', NODES)
def test_every_callback_of_a_node_is_guarded(make, name):
    callbacks = callbacks_of(make(name))
    assert not [what for what, callback in callbacks.items() if not isinstance(callback, Guarded)]
    # rclpy's own are among them: simulated time, and the parameters' services.
    assert 'subscription /clock' in callbacks
    assert any('set_parameters' in what for what in callbacks)
    assert any('timer' in what for what in callbacks)


def test_whatever_a_callback_raises_the_node_goes_on_and_says_it(make):
    node = make('ceiling_camera_node')
    executor = make_executor(node.context)
    executor.add_node(node)
    heard, answers = [], []

    def fail(*_: object) -> None:
        raise OverflowError(34, 'Numerical result out of range')

    def refuse(*_: object) -> None:
        raise MapError('there is no such map')

    node.create_subscription(String, 'bad', fail, 10)
    node.create_subscription(String, 'good', heard.append, 10)
    node.create_service(Trigger, 'fails', fail)
    node.create_service(Trigger, 'refuses', refuse)
    timer = node.create_timer(0.01, fail)
    to_bad, to_good = (
        node.create_publisher(String, 'bad', 10),
        node.create_publisher(String, 'good', 10),
    )
    to_bad.publish(String())
    to_good.publish(String())
    clients = [node.create_client(Trigger, service) for service in ('fails', 'refuses')]
    for client in clients:
        assert client.wait_for_service(timeout_sec=10.0)
        answers.append(client.call_async(Trigger.Request()))
    node.call_soon(fail)

    def broken_drive(_: object) -> float:
        fail()
        return 0.0

    for _ in range(500):
        node.turn(executor, broken_drive)
        if heard and all(answer.done() for answer in answers):
            break
    timer.cancel()
    assert heard == [String()]
    failed, refused = (answer.result() for answer in answers)
    assert (failed.success, refused.success) == (False, False)
    assert "'fails' led to an unexpected OverflowError at test_guarded_nodes" in failed.message
    assert refused.message == 'there is no such map'
    level, message = node._status
    assert level == ERROR
    assert 'unexpected OverflowError' in message


@pytest.mark.parametrize('kind', [SetParameters, SetParametersAtomically])
def test_a_parameter_of_no_type_or_no_name_is_refused_in_the_answer(make, kind):
    node = make('gait_node')
    wrong = ParameterMessage(name='gait', value=ParameterValue(type=99))
    # As the executor would.
    name = 'set_parameters' + ('_atomically' if kind is SetParametersAtomically else '')
    [service] = [service for service in node.services if service.srv_name.endswith(name)]
    answer = service.callback(kind.Request(parameters=[wrong]), kind.Response())
    [result] = answer.results if kind is SetParameters else [answer.result]
    assert not result.successful
    assert result.reason.endswith("cannot be used: the type of 'gait' is 99; known are 0 to 9")
    assert node.parameters.gait == 'crawl'
    # rclpy itself would keep it.
    nameless = ParameterMessage(name='', value=ParameterValue(type=1))
    answer = service.callback(kind.Request(parameters=[nameless]), kind.Response())
    [result] = answer.results if kind is SetParameters else [answer.result]
    assert result.reason.endswith('a parameter in it has no name')
    assert not node.has_parameter('')
    many = kind.Request(parameters=[wrong] * 1001)
    answer = service.callback(many, kind.Response())
    [result] = answer.results if kind is SetParameters else [answer.result]
    assert result.reason.endswith('its parameters are 1001; 1000 are the most')


def test_a_stream_of_different_refusals_does_not_fill_the_log(make):
    node = make('ceiling_camera_node')
    logged = []
    node.get_logger = lambda: SimpleNamespace(error=logged.append)
    for index in range(1000):
        node.report_error(MapError(f'map {index} is none'))
    assert len(logged) <= 200
    level, message = node._status
    assert (level, message) == (ERROR, 'map 999 is none')


def test_a_message_that_is_too_large_is_refused_and_one_that_is_not_is_taken(make):
    node = make('ceiling_camera_node')
    executor = make_executor(node.context)
    executor.add_node(node)
    heard = []
    node.create_subscription(String, 'texts', heard.append, 10, most_bytes=100)
    publisher = node.create_publisher(String, 'texts', 10)
    for length in (10_000_000, 10, 93, 20):
        publisher.publish(String(data='x' * length))
    for _ in range(500):
        node.turn(executor)
        if len(heard) == 2:
            break
    assert [len(message.data) for message in heard] == [10, 20]
    node.report(OK, 'as before')
    # Eight bytes that promise a text of four gigabytes.
    publisher.publish(b'\x00\x01\x00\x00\xff\xff\xff\xff')
    for _ in range(500):
        node.turn(executor)
        if node._status[0] == ERROR:
            break
    assert node._status[1].endswith('its bytes are no message of its type')


def test_a_message_of_too_many_bytes_is_named_with_both_numbers(make):
    node = make('ceiling_camera_node')
    executor = make_executor(node.context)
    executor.add_node(node)
    node.create_subscription(String, 'texts', print, 10, most_bytes=100)
    node.create_publisher(String, 'texts', 10).publish(String(data='x' * 93))
    for _ in range(500):
        node.turn(executor)
        if node._status[0] == ERROR:
            break
    level, message = node._status
    assert level == ERROR
    assert "the message on 'texts' cannot be used: it has 102 bytes; 100 are the most" in message
