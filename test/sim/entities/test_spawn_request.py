"""What a request for another robot means, and the codes of what is refused."""

import time

import pytest

from quad_common import errors
from quad_sim.entities.entity_codes import ResultCode, SpawnCode, code_of
from quad_sim.entities.spawn_request import SpawnRequest, names_like


def code(request, taken=()):
    with pytest.raises(errors.QuadError) as caught:
        _ = request.name_among(taken), request.kind
    assert str(caught.value)
    return code_of(caught.value)


@pytest.mark.parametrize(
    ('uri', 'kind'),
    [
        ('a1', 'a1'),
        ('  titan_viii ', 'titan_viii'),
        ('/somewhere/my robot.urdf', '/somewhere/my robot.urdf'),
        ('file:///somewhere/my%20robot.urdf', '/somewhere/my robot.urdf'),
        ('package://my_pkg/robots/my.yaml', 'package://my_pkg/robots/my.yaml'),
    ],
)
def test_a_uri_is_a_name_or_leads_to_a_file(uri, kind):
    assert SpawnRequest(uri).kind == kind


@pytest.mark.parametrize('uri', ['robot.sdf', 'http://x/robot.urdf', 'file://[', '/a/b', 'a://b'])
def test_a_format_that_is_not_read_is_refused(uri):
    assert code(SpawnRequest(uri, 'a')) == SpawnCode.UNSUPPORTED_FORMAT


def test_a_request_without_a_robot_is_refused():
    assert code(SpawnRequest(' ', 'a')) == SpawnCode.NO_RESOURCE
    given = SpawnRequest('', 'a', resource_string='<robot/>')
    assert code(given) == ResultCode.FEATURE_UNSUPPORTED


def test_a_name_is_kept_where_it_is_free():
    assert SpawnRequest('a1', 'left').name_among({'right'}) == 'left'
    assert SpawnRequest('a1', namespace='/left').name_among(()) == 'left'
    assert SpawnRequest('a1', 'left', 'left').name_among(()) == 'left'
    assert code(SpawnRequest('a1', 'left'), {'left'}) == SpawnCode.NAME_NOT_UNIQUE


@pytest.mark.parametrize('name', ['', '1st', 'a b', 'a/b', 'ä', 'a' * 62, 'a;b=c'])
def test_what_is_no_name_is_refused_or_replaced(name):
    assert code(SpawnRequest('a1', name)) == SpawnCode.NAME_INVALID
    made = SpawnRequest('a1', name, allow_renaming=True).name_among(())
    assert SpawnRequest('a1', made).name_among(()) == made


@pytest.mark.parametrize('namespace', ['a/b', '2nd', 'other'])
def test_a_namespace_that_is_not_the_name_is_refused(namespace):
    assert code(SpawnRequest('a1', 'left', namespace)) == SpawnCode.NAMESPACE_INVALID


def test_names_that_are_found_differ_from_all_others():
    taken = []
    for _ in range(5):
        taken.append(SpawnRequest('a1', allow_renaming=True).name_among(taken))
    assert taken == ['a1', 'a1_2', 'a1_3', 'a1_4', 'a1_5']
    wanted = SpawnRequest('a1', 'a' * 61, allow_renaming=True)
    assert len({'a' * 61, wanted.name_among({'a' * 61})}) == 2
    assert SpawnRequest('/x/2 legs.urdf', allow_renaming=True).name_among(()) == 'robot_2_legs'


def test_names_are_found_by_patterns():
    names = ['left', 'right', 'third']
    assert names_like('', names) == names
    assert names_like('^(left|third)$', names) == ['left', 'third']
    assert names_like('r', names) == ['right', 'third']
    assert names_like('^(a|b|c|d|e|third)$', names) == ['third']


@pytest.mark.parametrize(
    'pattern',
    [
        *('(a+)+$', 'a*a*a*a*a*b', '(', 'a' * 101, r'(a)\1', '[z-a]'),
        *('(a|)' * 4 + 'b', '(||||)a*b', 'a{99999999999}', '(?a)(?u)a'),
    ],
)
def test_a_pattern_that_is_none_or_takes_for_ever_is_refused(pattern):
    with pytest.raises(errors.NamePatternInvalid) as caught:
        names_like(pattern, ['a' * 61])
    assert code_of(caught.value) == ResultCode.OPERATION_FAILED


@pytest.mark.parametrize('pattern', ['a*a*a*b', '(a|)a*a*b', '(a|)(a|)(a|)b', f'({"a|" * 45})b'])
def test_patterns_that_are_taken_are_soon_searched_for(pattern):
    began = time.process_time()
    names_like(pattern, ['a' * 61] * 32)
    assert time.process_time() - began < 10.0


@pytest.mark.parametrize(
    ('error', 'wanted'),
    [
        (errors.RobotUnknown('x', ('a1',)), ResultCode.NOT_FOUND),
        (errors.RobotNotFound('x', ('a1',)), ResultCode.NOT_FOUND),
        (errors.PlaceTaken('a', 'b', 0.1, 1.0), SpawnCode.INVALID_POSE),
        (errors.ParameterError('start_pose', [0.0], 'elsewhere'), SpawnCode.INVALID_POSE),
        (errors.ResourcePathUnwritable('/a;b.urdf'), SpawnCode.RESOURCE_PARSE_ERROR),
        (errors.TooManyRobots(32), ResultCode.OPERATION_FAILED),
        (errors.NotAQuadruped('x.urdf', 'two legs'), SpawnCode.RESOURCE_PARSE_ERROR),
        (errors.RobotIsAlone(), ResultCode.FEATURE_UNSUPPORTED),
    ],
)
def test_every_fault_has_its_code(error, wanted):
    assert code_of(error) == wanted
