"""An action serves one goal at a time, and whoever gave one always gets an answer."""

from __future__ import annotations

import time

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('nav2_msgs.action', reason='nav2_msgs is not installed; make nav2 builds it')

import rclpy
from action_msgs.msg import GoalStatus
from nav2_msgs.action import FollowPath
from rclpy.action import ActionClient

from quad_common.errors import NoMap
from quad_common.ros.goal_actions import GoalAction, GoalPort
from quad_common.ros.guarded_node import GuardedNode
from quad_common.ros.run_node import make_executor
from quad_common.task_result import FollowCode, TaskOutcome, TaskResult
from quad_lab.topic_walk.node_processes import isolated_domain

pytestmark = pytest.mark.ros

_PATIENCE = 30.0


class Server(GuardedNode):
    """Serves an action; what it does with goals is the test's."""

    def __init__(self, **kwargs):
        super().__init__('server', **kwargs)
        self.reports = []
        self.begun = []
        self.refusal = self.failure = None
        port = GoalPort(self._check, self._begin, self._cancel)
        self.action = GoalAction(self, FollowPath, 'follow_path', port)

    def _check(self, request):
        if self.refusal is not None:
            raise self.refusal

    def _begin(self, request):
        self.begun.append(request.controller_id)
        if self.failure is not None:
            raise self.failure

    def _cancel(self):
        self.action.finish(TaskResult(TaskOutcome.CANCELED))

    def report_error(self, error):
        self.reports.append(error)

    def report_unexpected(self, sentence, kind, stack):
        self.reports.append(kind)


class Stage:
    """A server and a client, in one process."""

    def __init__(self, context):
        self.server = Server(context=context)
        self.node = rclpy.create_node('client', context=context)
        self.executor = make_executor(context)
        self.executor.add_node(self.server)
        self.executor.add_node(self.node)
        self.client = ActionClient(self.node, FollowPath, 'follow_path')
        self.until(self.client.server_is_ready)

    def until(self, condition):
        deadline = time.monotonic() + _PATIENCE
        while not condition():
            self.executor.spin_once(timeout_sec=0.1)
            assert time.monotonic() < deadline

    def give(self, name):
        future = self.client.send_goal_async(FollowPath.Goal(controller_id=name))
        self.until(future.done)
        return future.result()

    def result(self, handle):
        future = handle.get_result_async()
        self.until(future.done)
        return future.result()

    def close(self):
        self.executor.shutdown()
        self.server.destroy_node()
        self.node.destroy_node()


@pytest.fixture
def stage(monkeypatch, tmp_path):
    monkeypatch.delenv('ROS_DOMAIN_ID', raising=False)
    monkeypatch.setenv('ROS_LOG_DIR', str(tmp_path))
    with isolated_domain():
        context = rclpy.Context()
        rclpy.init(context=context)
        one = Stage(context)
        yield one
        one.close()
        context.try_shutdown()


def test_every_goal_gets_an_answer(stage):
    server = stage.server
    # One goal ends as its task has; one that ended stays as it is.
    first = stage.give('first')
    server.action.finish(TaskResult(TaskOutcome.ABORTED, FollowCode.NO_PROGRESS, 'stuck'))
    server.action.finish(TaskResult(TaskOutcome.SUCCEEDED))
    answer = stage.result(first)
    assert (answer.status, answer.result.error_code) == (GoalStatus.STATUS_ABORTED, 105)
    assert answer.result.error_msg == 'stuck'
    assert not server.action.is_active

    # A newer one preempts it; the older cannot be canceled any more.
    older = stage.give('older')
    newer = stage.give('newer')
    assert 'preempted' in stage.result(older).result.error_msg
    asked = older.cancel_goal_async()
    stage.until(asked.done)
    assert not asked.result().goals_canceling
    assert server.action.is_active
    asked = newer.cancel_goal_async()
    stage.until(asked.done)
    assert stage.result(newer).status == GoalStatus.STATUS_CANCELED

    # Whatever goes wrong where it begins, its giver does not wait for ever.
    server.failure = RuntimeError('a defect')
    assert stage.result(stage.give('failing')).status == GoalStatus.STATUS_ABORTED
    assert server.reports == ['RuntimeError']
    server.failure = None

    # One that is refused is no goal.
    server.refusal = NoMap()
    assert not stage.give('refused').accepted
    assert server.reports[-1] is server.refusal
    assert server.begun == ['first', 'older', 'newer', 'failing']
