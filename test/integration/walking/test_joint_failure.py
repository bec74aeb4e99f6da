"""A joint of the simulated robot fails while it walks: it stops, and says on topics which it is."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Twist, Vector3
from harness import ERROR, OK, PHYSICS, WARN, Bench
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import SetParameters

pytestmark = pytest.mark.ros


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what the gait makes of it."""
    return composed_bench


def set_parameters(bench: Bench, node: str, **values: str) -> None:
    """Do what ``ros2 param set`` does, for texts."""
    parameters = [
        Parameter(name=name, value=ParameterValue(type=4, string_value=value))
        for name, value in values.items()
    ]
    request = SetParameters.Request(parameters=parameters)
    results = bench.call(f'{node}/set_parameters', SetParameters, request).results
    assert all(result.successful for result in results), results


def test_a_joint_that_fails_in_mid_walk_is_named_and_the_robot_stands_still_until_repaired(
    bench: Bench,
) -> None:
    bench.start('sim_node', map_file='none', backend=PHYSICS, real_time_factor=4.0)
    bench.start('gait_node', cmd_vel_timeout=60.0)
    bench.wait_for_status('gait_node', 'standing', level=OK)
    bench.client('sim_node/set_parameters', SetParameters)
    bench.publisher(Twist, 'cmd_vel').publish(Twist(linear=Vector3(x=0.04)))
    bench.wait_for_walking()
    # One that gives way leaves a tenth of a second, which a busy machine may not have.
    set_parameters(bench, 'sim_node', failure='stuck')
    set_parameters(bench, 'sim_node', failing_joint='lh_hip_yaw_joint')
    bench.wait_for_status('sim_node', 'lh_hip_yaw_joint is stuck', level=WARN)
    status = bench.wait_for_status('gait_node', 'the robot stands on', level=ERROR)
    assert 'lame: lh_hip_yaw_joint of leg lh' in status.message
    # It is said when the last motion ends; the body then settles by a few millimetres.
    said = bench.elapsed
    bench.wait_until('the body has settled', lambda: bench.elapsed > said + 1.0)
    stopped = bench.pose
    bench.wait_until('five seconds go by', lambda: bench.elapsed > said + 6.0)
    assert bench.pose.distance_to(stopped) < 2e-3
    bench.call('reset')
    bench.call('stand')
    bench.wait_for_status('gait_node', 'standing', level=OK)
