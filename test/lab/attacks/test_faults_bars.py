"""What counts as failed: in walks whose nodes are killed, in a soak, in the matrix."""

from __future__ import annotations

import importlib
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip('rclpy')

from quad_lab.attacks import quick_faults
from quad_lab.attacks.bench_faults import PARTS
from quad_lab.attacks.bench_matrix import GOALS, METHODS, ROBOTS, Combination, Outcome, combinations
from quad_lab.attacks.bench_matrix import bars_of as matrix_bars
from quad_lab.attacks.stage.findings import Findings
from quad_lab.attacks.stage.reasons import reason_for_standing
from quad_lab.attacks.stage.report import Report
from quad_lab.attacks.stage.report import bars_of as message_bars
from quad_lab.attacks.stage.scenes import CAMERA, NODES, QUICK_SCENES, SCENES
from quad_lab.attacks.stage.violations import JOINTS_OUTSIDE, NOT_FINITE, OUTSIDE_LIMITS, UNREADABLE
from quad_lab.attacks.walks.kills import FULL as ALL_KILLS
from quad_lab.attacks.walks.kills import QUICK as QUICK_KILLS
from quad_lab.attacks.walks.kills import WAYS, KilledWalk
from quad_lab.attacks.walks.kills import bars_of as kill_bars
from quad_lab.attacks.walks.soak import bars_of as soak_bars
from quad_lab.attacks.walks.soak import growth_since
from quad_lab.tools.criterion import Criterion

OK, WARN, ERROR, STALE = b'\x00', b'\x01', b'\x02', b'\x03'

GOOD_WALK = KilledWalk(0, 'gait_node', 'SIGKILL', has_arrived=True)
GOOD_OUTCOME = Outcome(Combination('cuhk', 'trot', 'arc', 'mesh'), reached=GOALS, simulated=60.0)
GOOD_REPORT = Report(
    'sim_node', 'standing', messages=20, has_reached_goal=True, memory_growth={'sim_node': 0.01}
)


def failed(bars: list[Criterion]) -> list[str]:
    """List the bars that do not hold."""
    return [bar.name for bar in bars if bar.holds is False]


# ---- reasons ----


@pytest.mark.parametrize(
    ('activity', 'level'),
    [('waiting', WARN), ('blocked', ERROR), ('stopped', ERROR), ('lame', ERROR)],
)
def test_a_robot_that_waits_or_has_ended_says_why_in_a_sentence(activity, level):
    values = {'activity': activity}
    said = f'{activity}: no heartbeat of the planner'
    assert reason_for_standing(level, said, values) == 'no heartbeat of the planner'


@pytest.mark.parametrize(
    ('level', 'message', 'activity'),
    [
        (OK, 'standing: waiting for a plan', 'standing'),
        (OK, 'waiting: for better days', 'waiting'),
        (WARN, 'waiting: ', 'waiting'),
        (WARN, 'walking: 1.2 m to go; old localisation', 'walking'),
        (WARN, 'standing: ready; old localisation', 'standing'),
        (WARN, 'dancing: to music', 'dancing'),
        (WARN, '', ''),
        (b'', '', ''),
    ],
)
def test_other_words_are_no_reason_for_standing(level, message, activity):
    assert reason_for_standing(level, message, {'activity': activity}) == ''


def test_a_gait_that_knows_nothing_of_the_robot_says_so():
    assert reason_for_standing(WARN, "no odometry: waiting for it on 'odom'", {})
    assert reason_for_standing(STALE, 'stale clock: /clock stands still', {})


# ---- kills ----


def test_a_walk_that_goes_on_or_says_why_is_good():
    stood = replace(GOOD_WALK, has_stood=True, goals=2, reason='no odometry')
    assert GOOD_WALK.is_good
    assert stood.is_good
    assert failed(kill_bars([GOOD_WALK, stood], {}, 0)) == []


@pytest.mark.parametrize(
    ('change', 'bar'),
    [
        ({'has_arrived': False, 'problem': 'not seen'}, None),
        ({'has_fallen': True}, 'falls'),
        ({'contacts': 'lf_thigh and floor'}, 'walks with contacts'),
        ({'goals': 3}, 'goals given, at most'),
        ({'has_stood': True, 'goals': 2}, 'robots that stand and do not say why'),
        ({'without_effect': ['ready']}, 'goals at the beginning without effect'),
    ],
)
def test_one_bad_walk_fails(change, bar):
    bad = replace(GOOD_WALK, **change)
    assert not bad.is_good
    names = ['walks that end well'] + ([bar] if bar else [])
    assert failed(kill_bars([GOOD_WALK, bad], {}, 0)) == names


@pytest.mark.parametrize('kind', [NOT_FINITE, OUTSIDE_LIMITS, UNREADABLE])
def test_one_violation_in_the_walks_fails(kind):
    assert failed(kill_bars([GOOD_WALK], {kind: 1}, 0)) == [kind]


def test_a_traceback_in_the_walks_fails():
    assert failed(kill_bars([GOOD_WALK], {}, 1)) == ['tracebacks']


def test_no_walk_is_no_success():
    assert 'walks that end well' in failed(kill_bars([], {}, 0))


# ---- soak ----


def test_a_soak_fails_with_a_goal_missed_a_violation_or_a_traceback():
    assert failed(soak_bars(9, 0, {}, 0)) == []
    assert failed(soak_bars(8, 1, {}, 0)) == ['goals reached']
    assert failed(soak_bars(9, 0, {UNREADABLE: 1}, 0)) == [UNREADABLE]
    assert failed(soak_bars(9, 0, {}, 2)) == ['tracebacks']
    assert failed(soak_bars(0, 0, {}, 0)) == ['goals reached']


def test_growth_counts_from_the_end_of_the_warm_up():
    memory = [
        (0.0, {'a': 50.0}),
        (600.0, {'a': 100.0}),
        (900.0, {'a': 120.0}),
        (999.0, {'a': 101.0}),
    ]
    assert growth_since(memory, 600.0) == {'a': pytest.approx(0.01)}
    assert growth_since(memory, 0.0) == {'a': pytest.approx(1.02)}
    assert growth_since(memory, 990.0) == {}


# ---- matrix ----


def test_a_combination_that_reaches_its_goals_is_good():
    assert GOOD_OUTCOME.is_good
    assert failed(matrix_bars([GOOD_OUTCOME])) == []


@pytest.mark.parametrize(
    ('change', 'bar'),
    [
        ({'reached': GOALS - 1}, 'goals reached'),
        ({'contacts': 'lf_thigh and base_link'}, 'combinations with contacts'),
        ({'has_fallen': True}, 'falls'),
        ({'alarms': ['lame: lf_hip does not follow']}, 'combinations with false alarms'),
        ({'violations': {JOINTS_OUTSIDE: 1}}, JOINTS_OUTSIDE),
        ({'violations': {UNREADABLE: 1}}, UNREADABLE),
    ],
)
def test_one_bad_combination_fails(change, bar):
    bad = replace(GOOD_OUTCOME, **change)
    assert not bad.is_good
    assert failed(matrix_bars([GOOD_OUTCOME, bad])) == [bar]


def test_no_combination_is_no_success():
    assert failed(matrix_bars([])) == ['goals reached']


def test_only_limits_the_quantities_that_it_names():
    every = combinations()
    assert len(every) == len(set(every)) == 192
    some = combinations(['pukyong', 'trot', 'wave'])
    assert {c.robot for c in some} == {'pukyong'}
    assert {c.gait for c in some} == {'trot', 'wave'}
    assert {c.method for c in some} == set(METHODS)
    assert {c.robot for c in combinations(['arc'])} == set(ROBOTS)


# ---- messages ----


def test_one_bad_report_fails():
    assert failed(message_bars([GOOD_REPORT], {}, [])) == []
    for change, bar in (
        ({'deaths': ['sim_node ended']}, 'node deaths'),
        ({'slow': ['sim_node: 3 s']}, 'reactions slower than 2 s'),
        ({'memory_growth': {'sim_node': 0.06}}, 'largest growth of memory'),
        ({'nonsense': 2, 'accepted': ['x = nan']}, 'nonsense accepted'),
        ({'falls': 1}, 'falls under attack'),
        ({'has_reached_goal': False}, 'good goals reached after'),
    ):
        assert failed(message_bars([replace(GOOD_REPORT, **change)], {}, [])) == [bar]
    assert failed(message_bars([GOOD_REPORT], {UNREADABLE: 1}, [])) == [UNREADABLE]


def test_every_node_is_attacked_while_the_robot_stands_and_while_it_walks():
    attacked = {
        (node, state) for scene in SCENES for node in scene.targets for state in scene.states
    }
    assert attacked == {(n, s) for n in (*NODES, CAMERA) for s in ('standing', 'walking')}
    assert {node for scene in QUICK_SCENES for node in scene.targets} == {*NODES, CAMERA}
    assert {node for scene in SCENES if scene.has_nonsense for node in scene.targets} == {
        *NODES,
        CAMERA,
    }


def test_every_part_can_be_found():
    for function in PARTS.values():
        module, _, name = function.rpartition('.')
        assert callable(getattr(importlib.import_module(module), name))


def test_a_quick_attack_leaves_no_part_out(monkeypatch):
    ran = []
    monkeypatch.setattr(quick_faults, '_attack_shared_nodes', lambda parts, *_: ran.extend(parts))
    monkeypatch.setattr(quick_faults, '_attack_camera', lambda *_: ran.append('messages'))
    monkeypatch.setattr(quick_faults, '_attack_alone', lambda part, *_: ran.append(part))
    for task in quick_faults._tasks(list(PARTS)):
        task(0, 80)
    assert sorted(ran) == sorted([*PARTS, 'messages'])


@pytest.mark.parametrize('plan', [ALL_KILLS, QUICK_KILLS])
def test_every_node_is_killed_and_stopped_as_often(plan):
    rng = np.random.default_rng(0)
    ways = [way for _, way in plan.drawn_ways(rng)]
    assert len(ways) == plan.walks
    assert ways.count(WAYS[0]) == ways.count(WAYS[1])
    assert set(replace(plan, walks=6).drawn_ways(rng)) == {(n, way) for n in NODES for way in WAYS}


def test_what_was_seen_before_belongs_to_another_attack():
    before = Findings({UNREADABLE: 2}, {UNREADABLE: ['a', 'b']}, ['sim_node: ValueError'])
    after = Findings(
        {UNREADABLE: 3, NOT_FINITE: 1},
        {UNREADABLE: ['a', 'b', 'c'], NOT_FINITE: ['d']},
        ['gait_node: KeyError', 'sim_node: ValueError', 'sim_node: ValueError'],
    )
    seen = after.since(before)
    assert seen.counts == {UNREADABLE: 1, NOT_FINITE: 1}
    assert seen.examples == {UNREADABLE: ['c'], NOT_FINITE: ['d']}
    assert sorted(seen.tracebacks) == ['gait_node: KeyError', 'sim_node: ValueError']
    assert after.since(after) == Findings()
    both = before.since(Findings())
    both.add(seen)
    assert both.counts == after.counts
    assert both.examples == after.examples
