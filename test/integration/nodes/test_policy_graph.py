"""Whatever running nodes publish, hear and offer is allowed by the SROS2 policy."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

pytest.importorskip('rclpy')

from harness import Bench

pytestmark = pytest.mark.ros

POLICY = Path(__file__).resolve().parents[3] / 'config' / 'sros2_policy.xml'
NODES = ('planner_node', 'gait_node', 'sim_node', 'ceiling_camera_node', 'viewer_node')


def allowed(owner: str, right: str) -> set[str]:
    root = ElementTree.fromstring(POLICY.read_text(encoding='utf-8'))
    [profile] = root.findall(f"./enclaves/enclave/profiles/profile[@node='{owner}']")
    return {
        name.text or '' for listed in profile if listed.get(right) == 'ALLOW' for name in listed
    }


def test_the_policy_allows_all_that_running_nodes_do(composed_bench: Bench):
    bench = composed_bench
    # A process takes its time, in which nothing is to be simulated yet.
    bench.start('viewer_node')
    bench.wait_for_status('viewer_node', '')
    bench.start('sim_node')
    bench.start('planner_node')
    bench.start('gait_node')
    bench.start('ceiling_camera_node')
    graph = {
        'publish': bench.node.get_publisher_names_and_types_by_node,
        'subscribe': bench.node.get_subscriber_names_and_types_by_node,
        'reply': bench.node.get_service_names_and_types_by_node,
    }

    def is_complete(node: str) -> bool:
        # A node's own services come after those that rclpy makes, and diagnostics before them.
        names = {name for name, *_ in bench.node.get_node_names_and_namespaces()}
        return (
            node in names
            and len(graph['reply'](node, '/')) >= 7
            and all(found(node, '/') for found in graph.values())
        )

    for node in NODES:
        bench.wait_until(f'{node} is there', lambda node=node: is_complete(node))
        bench.wait_for_status(node, '')
        for right, names in graph.items():
            # Whoever may execute an action has the topics and services that it is made of.
            found = {
                name for name, _ in names(node, '/')
                if name.partition('/_action/')[0] not in allowed(node, 'execute')
            }  # fmt: skip
            assert found
            assert found <= allowed(node, right), (node, right)
