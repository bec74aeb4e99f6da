"""What ``ros2 param`` meets: a node takes its own dump, and says what it refuses."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip('rclpy')

import yaml
from harness import Bench
from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter, parameter_dict_from_yaml_file, parameter_value_to_python

pytestmark = pytest.mark.ros

NODES = ['planner_node', 'gait_node', 'sim_node', 'ceiling_camera_node', 'viewer_node']


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what services answer."""
    return composed_bench


def values_of(bench: Bench, node: str) -> dict[str, Any]:
    """Return all parameters of a node, as ``ros2 param dump`` asks for them."""
    names = bench.call(f'{node}/list_parameters', ListParameters).result.names
    return {name: value_of(bench, node, name) for name in names}


def value_of(bench: Bench, node: str, name: str) -> Any:
    request = GetParameters.Request(names=[name])
    [value] = bench.call(f'{node}/get_parameters', GetParameters, request).values
    value = parameter_value_to_python(value)
    return list(value) if hasattr(value, 'tolist') else value


def set_parameters(bench: Bench, node: str, *parameters: Any) -> list[Any]:
    request = SetParameters.Request(parameters=list(parameters))
    return bench.call(f'{node}/set_parameters', SetParameters, request).results


def set_parameter(bench: Bench, node: str, name: str, value: Any) -> str:
    """Set a parameter; return why it was refused."""
    message = Parameter(name, value=value).to_parameter_msg()
    [result] = set_parameters(bench, node, message)
    assert result.successful == (result.reason == '')
    return result.reason


def nested(values: dict[str, Any]) -> dict[str, Any]:
    """Put parameters with points in their names into mappings, as ``ros2 param dump`` does."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *folders, last = name.split('.')
        folder = tree
        for part in folders:
            folder = folder.setdefault(part, {})
        folder[last] = value
    return tree


@pytest.mark.parametrize('node', NODES)
def test_a_node_loads_all_that_was_dumped_of_it(bench: Bench, node, tmp_path):
    if node == 'viewer_node':
        pytest.importorskip('viser')
    options = {'port': 0} if node == 'viewer_node' else {}
    bench.start(node, **options)
    before = values_of(bench, node)
    # rclpy's own are in the dump too.
    assert 'start_type_description_service' in before
    assert 'use_sim_time' in before
    file = tmp_path / 'dump.yaml'
    file.write_text(yaml.safe_dump({f'/{node}': {'ros__parameters': nested(before)}}))
    # As 'ros2 param load' reads and sends it.
    loaded = parameter_dict_from_yaml_file(str(file), target_nodes=[f'/{node}'])
    assert loaded.keys() == before.keys()
    results = set_parameters(bench, node, *loaded.values())
    refused = {
        name: result.reason
        for name, result in zip(loaded, results, strict=True)
        if not result.successful
    }
    assert refused == {}
    assert values_of(bench, node) == before


def test_whole_numbers_are_taken_for_floats_when_set_and_at_the_start(bench: Bench):
    bench.start('planner_node', use_sim_time=False, replan_distance=1)
    assert value_of(bench, 'planner_node', 'replan_distance') == 1.0
    assert set_parameter(bench, 'planner_node', 'safety_distance', 1) == ''
    distance = value_of(bench, 'planner_node', 'safety_distance')
    assert distance == 1.0
    assert isinstance(distance, float)


def test_what_cannot_change_is_refused_with_what_to_do(bench: Bench):
    bench.start('gait_node', use_sim_time=False)
    reason = set_parameter(bench, 'gait_node', 'robot', 'genibo')
    assert reason == (
        "'robot' is 'titan_viii', which is fixed while the node runs: restart it to change that"
    )
    assert value_of(bench, 'gait_node', 'robot') == 'titan_viii'
    request = DescribeParameters.Request(names=['robot', 'heading_tolerance'])
    fixed, dynamic = bench.call(
        'gait_node/describe_parameters', DescribeParameters, request
    ).descriptors
    assert (fixed.read_only, dynamic.read_only) == (True, False)
    assert dynamic.type == ParameterType.PARAMETER_DOUBLE

    assert set_parameter(bench, 'gait_node', 'heading_tolerance', 1) == ''
    assert value_of(bench, 'gait_node', 'heading_tolerance') == 1.0
    reason = set_parameter(bench, 'gait_node', 'heading_tolerance', 7.0)
    assert reason == ("'heading_tolerance' is 7.0; it must be a finite number from 0.005 to 1 rad")
    reason = set_parameter(bench, 'gait_node', 'heading_tolerance', 'wide')
    assert reason == (
        "'heading_tolerance' is 'wide'; it must be a finite number from 0.005 to 1 rad"
    )
    reason = set_parameter(bench, 'gait_node', 'nonsense', 1)
    assert reason.startswith("'nonsense' is no parameter of this node")

    # All or nothing: the one that is fixed holds the other back.
    both = [
        Parameter('heading_tolerance', value=0.5).to_parameter_msg(),
        Parameter('robot', value='genibo').to_parameter_msg(),
    ]
    request = SetParametersAtomically.Request(parameters=both)
    name = 'gait_node/set_parameters_atomically'
    assert not bench.call(name, SetParametersAtomically, request).result.successful
    assert value_of(bench, 'gait_node', 'heading_tolerance') == 1.0
