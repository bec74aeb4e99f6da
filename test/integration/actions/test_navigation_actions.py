"""Nav2's actions, as a client uses them that does what nav2_simple_commander does."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('nav2_msgs.action', reason='nav2_msgs is not installed; make nav2 builds it')

from action_msgs.msg import GoalStatus
from harness import EVERY_SAMPLE, START, Bench
from nav_msgs.msg import Odometry

from quad_common.planar_pose import Pose2D
from quad_lab.topic_walk.navigation_client import NavigationClient

pytestmark = pytest.mark.ros

GOAL, NEXT, FAR = Pose2D(1.6, 1.2, 0.0), Pose2D(1.9, 1.2, 0.0), Pose2D(2.3, 1.2, 0.0)
"""Straight ahead of the start, so that the robot need not turn."""

IN_A_WALL = Pose2D(0.02, 0.02, 0.0)
SUCCEEDED, CANCELED, ABORTED = (
    GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED
)  # fmt: skip


@pytest.fixture
def client(bench: Bench):
    bench.start_robot()
    return NavigationClient(bench.node, lambda: bench._executor.spin_once(timeout_sec=0.1))


def test_goals_are_reached_canceled_preempted_and_refused(bench: Bench, client):
    # Preempted by a goal of another action, which goes through two poses.
    assert client.go_to_pose(FAR)
    older = client.result_future()
    bench.wait_for_walking(0.02)
    assert client.go_through_poses([GOAL, NEXT])
    client.wait_until(older.done)
    assert (older.result().status, older.result().result.error_code) == (ABORTED, 0)
    assert 'preempted' in older.result().result.error_msg
    client.wait_until(client.is_complete)
    assert client.status == SUCCEEDED
    assert bench.is_near(NEXT)
    assert {f.number_of_poses_remaining for f in client.feedback} >= {1, 2}

    # Canceled: it ends when the robot stands.
    assert client.go_to_pose(FAR)
    bench.wait_for_walking(0.02)
    assert client.cancel()
    client.wait_until(client.is_complete)
    assert client.status == CANCELED
    assert bench.activity == 'standing'
    assert bench.plan is None

    # Given again, and reached, with feedback on the way.
    start = bench.pose
    assert client.go_to_pose(FAR)
    client.wait_until(client.is_complete)
    assert (client.status, client.result.error_code) == (SUCCEEDED, 0)
    assert bench.is_near(FAR)
    distances = [f.distance_remaining for f in client.feedback if f.distance_remaining > 0.0]
    assert distances[0] == pytest.approx(start.distance_to(FAR), abs=0.1)
    assert distances[-1] < distances[0]
    first = client.feedback[0]
    assert first.current_pose.header.frame_id == 'map'
    assert first.current_pose.pose.position.x == pytest.approx(start.x, abs=0.1)
    assert any(f.estimated_time_remaining.sec > 0 for f in client.feedback)

    # Refused, with the planner's code.
    assert client.go_to_pose(IN_A_WALL)
    client.wait_until(client.is_complete)
    assert (client.status, client.result.error_code) == (ABORTED, 206)
    assert 'the goal' in client.result.error_msg
    assert not client.go_through_poses([])


def test_paths_are_computed_and_followed_without_the_topics(bench, client):
    found = client.get_path([GOAL])
    assert client.status == SUCCEEDED
    assert found.path.header.frame_id == 'map'
    assert len(bench.plans) == 0
    through = client.get_path([GOAL, NEXT], start=START)
    corners = [(p.pose.position.x, p.pose.position.y) for p in through.path.poses]
    assert any(abs(x - GOAL.x) + abs(y - GOAL.y) < 1e-6 for x, y in corners)
    assert client.get_path([IN_A_WALL]).error_code == 206
    assert client.get_path([GOAL, IN_A_WALL]).error_code == 306
    assert client.get_path([GOAL], planner_id='no_such').error_code == 201
    assert client.get_path([]).error_code == 309

    assert client.follow_path(through.path)
    client.wait_until(client.is_complete)
    assert client.status == SUCCEEDED
    assert bench.is_near(NEXT)
    assert client.feedback[0].distance_to_goal == pytest.approx(START.distance_to(NEXT), abs=0.2)
    assert max(f.speed for f in client.feedback) > 0.0
    assert client.follow_path(found.path, controller_id='no_such')
    client.wait_until(client.is_complete)
    assert client.result.error_code == 101


def test_a_path_ends_where_odometry_falls_silent(bench: Bench):
    relayed = bench.node.create_publisher(Odometry, 'relayed', EVERY_SAMPLE)
    is_told = True

    def relay(message: Odometry) -> None:
        if is_told:
            relayed.publish(message)

    bench.node.create_subscription(Odometry, 'odom', relay, EVERY_SAMPLE)
    bench.start_robot({'odom_topic': 'relayed'})
    client = NavigationClient(bench.node, lambda: bench._executor.spin_once(timeout_sec=0.1))
    path = client.get_path([FAR]).path
    assert client.follow_path(path)
    bench.wait_for_walking(0.02)
    # The clock goes on, and nobody tells any more where the robot is.
    is_told = False
    client.wait_until(client.is_complete)
    assert (client.status, client.result.error_code) == (ABORTED, 104)
