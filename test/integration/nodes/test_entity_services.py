"""Robots that come and go by the services that simulators have in common."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')
pytest.importorskip(
    'simulation_interfaces',
    reason='simulation_interfaces is not installed; make simulation builds it',
)

from geometry_msgs.msg import PoseStamped
from harness import SENSOR, Bench
from nav_msgs.msg import Odometry
from simulation_interfaces import srv as services
from simulation_interfaces.msg import Result, SimulationState, SimulatorFeatures
from test_parameter_services import set_parameter, value_of

from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_message
from quad_sim.entities.entity_codes import ALREADY_IN_TARGET_STATE, Feature, ResultCode, SpawnCode

pytestmark = pytest.mark.ros

OK = Result.RESULT_OK


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    return composed_bench


def ask(bench, service, /, **fields):
    kind = getattr(services, ''.join(part.capitalize() for part in service.split('_')))
    return bench.call(service, kind, kind.Request(**fields))


def at(x, y, yaw=0.0, frame='map'):
    pose = PoseStamped(pose=pose_message(Pose2D(x, y, yaw)))
    pose.header.frame_id = frame
    return pose


def spawn(bench, **fields):
    answer = ask(bench, 'spawn_entity', **fields)
    assert bool(answer.result.error_message) == (answer.result.result != OK)
    return answer.result.result, answer.entity_name


def names(bench):
    return list(ask(bench, 'get_entities').entities)


def test_robots_come_are_seen_and_go(bench):
    bench.start('sim_node', robots='none', map_file='none')
    features = ask(bench, 'get_simulator_features').features
    assert set(features.features) == set(Feature)
    assert 'urdf' in features.spawn_formats
    known = {each.uri for each in ask(bench, 'get_spawnables').spawnables}
    assert {'titan_viii', 'cuhk'} <= known
    assert names(bench) == []

    wanted = {'name': 'left', 'uri': 'titan_viii', 'initial_pose': at(1.0, 2.0, 0.5)}
    assert spawn(bench, **wanted) == (OK, 'left')
    heard = bench.hear(Odometry, 'left/odom', SENSOR)
    bench.wait_until('the robot is measured', lambda: heard)
    assert heard[0].header.frame_id == 'left/odom'
    state = ask(bench, 'get_entity_state', entity='left').state
    assert (state.pose.position.x, state.pose.position.y) == pytest.approx((1.0, 2.0), abs=1e-3)
    assert state.header.frame_id == 'map'

    # By its namespace, with a name that is found for it.
    assert spawn(bench, uri='cuhk', entity_namespace='/right') == (OK, 'right')
    wanted.update(allow_renaming=True, initial_pose=at(4.0, 2.0, frame='world'))
    assert spawn(bench, **wanted) == (OK, 'left_2')
    assert names(bench) == ['left', 'right', 'left_2']

    # The parameter follows, and goes on saying which there are.
    text = value_of(bench, 'sim_node', 'robots')
    assert text == 'left=titan_viii@1.0,2.0,0.5; right=cuhk@0.0,0.0,0.0; ' + text.split('; ')[2]
    assert set_parameter(bench, 'sim_node', 'robots', 'left=titan_viii; right=cuhk') == ''
    assert names(bench) == ['left', 'right']

    assert ask(bench, 'delete_entity', entity='left').result.result == OK
    assert names(bench) == ['right']
    bench.wait_until('its topics are gone', lambda: bench.node.count_publishers('left/odom') == 0)
    gone = ask(bench, 'delete_entity', entity='left').result
    assert (gone.result, "there is no robot 'left'" in gone.error_message) == (2, True)
    assert ask(bench, 'get_entity_state', entity='left').result.result == ResultCode.NOT_FOUND


def test_what_cannot_be_is_refused_with_its_code(bench, tmp_path):
    (tmp_path / 'broken.urdf').write_text('<robot')
    bench.start('sim_node', robots='left=titan_viii@1.2,1.2,0')
    for code, fields in (
        (SpawnCode.NAME_NOT_UNIQUE, {'name': 'left', 'uri': 'cuhk'}),
        (SpawnCode.NAME_INVALID, {'name': '1st', 'uri': 'cuhk'}),
        (SpawnCode.UNSUPPORTED_FORMAT, {'name': 'b', 'uri': 'robot.sdf'}),
        (SpawnCode.NO_RESOURCE, {'name': 'b'}),
        (SpawnCode.NAMESPACE_INVALID, {'name': 'b', 'uri': 'cuhk', 'entity_namespace': 'c'}),
        (SpawnCode.RESOURCE_PARSE_ERROR, {'name': 'b', 'uri': f'file://{tmp_path}/broken.urdf'}),
        (SpawnCode.INVALID_POSE, {'name': 'b', 'uri': 'cuhk', 'initial_pose': at(0.02, 0.02)}),
        (SpawnCode.INVALID_POSE, {'name': 'b', 'uri': 'cuhk', 'initial_pose': at(1.2, 1.3)}),
        (SpawnCode.INVALID_POSE, {'name': 'b', 'uri': 'cuhk', 'initial_pose': at(float('nan'), 1)}),
        (SpawnCode.INVALID_POSE, {'name': 'b', 'uri': 'cuhk', 'initial_pose': at(3, 3, 0, 'base')}),
        (ResultCode.NOT_FOUND, {'name': 'b', 'uri': 'no_such_robot'}),
        (ResultCode.FEATURE_UNSUPPORTED, {'name': 'b', 'resource_string': '<robot/>'}),
    ):
        assert spawn(bench, **fields) == (code, ''), fields
    # What the net under callbacks refuses is an answer that says so, too.
    far_too_many = ask(bench, 'get_spawnables', sources=['x'] * 1001).result
    assert far_too_many.result == ResultCode.OPERATION_FAILED
    assert '1000 are the most' in far_too_many.error_message
    assert names(bench) == ['left']


def test_a_robot_alone_is_seen_and_time_is_paused_and_played(bench):
    bench.start('sim_node')
    features = ask(bench, 'get_simulator_features').features.features
    assert SimulatorFeatures.SPAWNING not in features
    assert SimulatorFeatures.ENTITY_STATE_GETTING in features
    assert names(bench) == ['titan_viii']
    assert spawn(bench, name='b', uri='cuhk')[0] == ResultCode.FEATURE_UNSUPPORTED
    for state, repeated in (
        (SimulationState.STATE_PAUSED, False),
        (SimulationState.STATE_PAUSED, True),
        (SimulationState.STATE_PLAYING, False),
    ):
        wanted = SimulationState(state=state)
        answer = ask(bench, 'set_simulation_state', state=wanted).result.result
        # A request that seems lost is made again.
        assert answer in ((ALREADY_IN_TARGET_STATE,) if repeated else (OK, ALREADY_IN_TARGET_STATE))
        assert ask(bench, 'get_simulation_state').state.state == state
    stopped = SimulationState(state=SimulationState.STATE_STOPPED)
    assert ask(bench, 'set_simulation_state', state=stopped).result.result == 0
