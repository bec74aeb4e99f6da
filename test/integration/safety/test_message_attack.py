"""A short attack by messages: the nodes live, and walk to the next goal."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from quad_common.robot_files.robot_file import load_robot
from quad_lab.attacks.messages.message_attack import QUICK, MessageAttack
from quad_lab.attacks.stage.report import Report
from quad_lab.attacks.stage.scenes import NODES, start_nodes
from quad_lab.attacks.stage.stage import Stage
from quad_lab.attacks.stage.violations import NOT_FINITE, OUTSIDE_LIMITS, TOO_LONG, UNREADABLE

pytestmark = pytest.mark.ros


def test_nodes_bear_a_short_attack_and_refuse_nonsense(domain):
    with Stage(load_robot('titan_viii')) as stage:
        # In real time: nodes that share two processors with other tests fall behind at more.
        start_nodes(stage, 'kinematic', 1.0)
        reports = []
        for node in NODES:
            attack = MessageAttack(stage, Report(node, 'standing'), seed=7, effort=QUICK)
            attack.try_nonsense(4)
            attack.run(20)
            reports.append(attack.report)
        # Once, for it takes a while: after all of it.
        attack.walk_on()
        tracebacks, seen = stage.tracebacks(), stage.listener.examples
    for report in reports:
        assert report.messages == 20
        assert report.deaths == []
        assert report.slow == []
        assert report.accepted == []
    assert reports[-1].has_reached_goal, reports[-1].problem
    assert tracebacks == []
    for kind in (NOT_FINITE, OUTSIDE_LIMITS, TOO_LONG, UNREADABLE):
        assert seen.get(kind, []) == []
