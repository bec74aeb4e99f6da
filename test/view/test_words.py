"""The page says in plain words what the robot does, who is missing, and what follows from it."""

from __future__ import annotations

import numpy as np

from quad_common.status import Level
from quad_view.scene.robot_view import RobotView
from quad_view.scene.words import SILENT, Said, headline, lines

NOW = 100.0


def said(message: str, level: Level = Level.OK, at: float = NOW, **values: str) -> Said:
    return Said(level, message, values, at)


ALL = {
    'gait_node': said('standing: no plan to follow', activity='standing'),
    'planner_node': said("ready: waiting for a goal on 'goal_pose'"),
    'sim_node': said('running'),
}


def test_with_all_nodes_the_gait_speaks():
    assert headline(ALL, True, False, NOW) == (Level.OK, 'standing: no plan to follow')
    assert [line.level for line in lines(ALL, True, NOW)] == [Level.OK] * 3


def test_a_missing_node_is_named_with_what_follows_and_how_to_start_it():
    rest = {name: word for name, word in ALL.items() if name != 'planner_node'}
    level, sentence = headline(rest, True, False, NOW)
    assert level == Level.ERROR
    assert sentence == (
        'planner_node is missing: no path to a goal is planned; start it with: planner_node'
    )
    level, sentence = headline({}, True, False, NOW)
    assert sentence.startswith('gait_node is missing: the robot does not walk')


def test_a_node_that_has_fallen_silent_has_ended():
    silent = {**ALL, 'gait_node': said('walking', at=NOW - SILENT - 0.1)}
    level, sentence = headline(silent, True, False, NOW)
    assert level == Level.ERROR
    assert sentence.startswith('gait_node has ended, or hangs:')


def test_a_real_robot_needs_no_simulator():
    real = {name: word for name, word in ALL.items() if name != 'sim_node'}
    assert 'sim_node' not in {line.node for line in lines(real, True, NOW)}
    assert 'sim_node' in {line.node for line in lines(real, False, NOW)}


def test_a_refused_goal_is_what_a_standing_robot_is_about():
    refused = {**ALL, 'planner_node': said('the goal is in a wall', Level.ERROR)}
    assert headline(refused, True, False, NOW)[1] == 'the goal is in a wall'
    walking = {**refused, 'gait_node': said('walking: walking 0.2 m', activity='walking')}
    assert headline(walking, True, False, NOW)[1] == 'walking: walking 0.2 m'


def test_an_emergency_stop_and_a_missing_robot_come_first():
    assert headline(ALL, True, True, NOW)[1].startswith('emergency stop')
    assert headline(ALL, False, False, NOW)[1].startswith('no robot')


def test_only_what_changed_is_drawn_again():
    view = RobotView('')
    level = np.array([0.0, 0.0, 0.0, 1.0])
    view.note_joints({'knee': 0.1})
    view.note_pose(np.zeros(3), level, NOW)
    assert view.take_changes() >= {'joints', 'position', 'track'}
    view.note_joints({'knee': 0.1 + 1e-7})
    view.note_pose(np.full(3, 1e-7), level, NOW + 0.5)
    assert view.take_changes() == frozenset()
    assert view.has_robot(NOW + 1.0)
    view.note_joints({'knee': 0.2})
    assert view.take_changes() == {'joints'}
    assert not view.has_robot(NOW + 5.0)


def test_joints_are_plotted_once_they_are_known():
    view = RobotView('')
    view.plot(0.0, (0.0, 0.0, 0.0))
    assert 'joint angles [deg]' not in view.plots
    view.note_joints({'hip': 0.0, 'knee': np.pi / 2})
    view.plot(1.0, (0.0, 0.0, 0.0))
    assert view.plots['joint angles [deg]'].arrays()[2].tolist() == [90.0]


def test_a_part_that_cannot_be_shown_is_named_beside_the_nodes():
    view = RobotView('')
    view.note(said=ALL, lacking=("'trunk.xyz' is no file here", "'calf.xyz' is no file here"))
    *rest, line = view.lines(NOW)
    assert len(rest) == 3
    assert line.level == Level.WARN
    assert "'trunk.xyz' is no file here, and 1 more" in line.text
