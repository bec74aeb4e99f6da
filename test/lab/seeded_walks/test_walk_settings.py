"""A case says what it means, completed by the defaults of walks and nodes."""

import math

import pytest

from quad_common.errors import ParameterError
from quad_lab.seeded_walks.walk_settings import checked_case, walk_of


def test_a_case_is_completed():
    walk = walk_of(
        checked_case({
            'robot': 'cuhk', 'gait': 'trot', 'gait.swing_height': 0.01,
            'gait_node.turning': 'arc', 'planner_node.method': 'shortest', 'payload': 1,
        })
    )  # fmt: skip
    assert (walk.settings.robot, walk.settings.payload) == ('cuhk', 1.0)
    assert walk.gait_numbers == {'swing_height': 0.01}
    assert (walk.gait_node.robot, walk.gait_node.gait, walk.gait_node.turning) == (
        'cuhk', 'trot', 'arc'
    )  # fmt: skip
    assert (walk.planner_node.robot, walk.planner_node.method) == ('cuhk', 'shortest')


@pytest.mark.parametrize(
    ('case', 'ground'),
    [
        ({}, 'flat'),
        ({'terrain': 'bumps'}, 'uneven'),
        ({'terrain': 'bumps', 'gait_node.ground': 'flat'}, 'flat'),
    ],
)
def test_the_gait_knows_of_uneven_ground_unless_told_otherwise(case, ground):
    assert walk_of(checked_case(case)).gait_node.ground == ground


def test_values_become_of_one_type_and_order():
    case = checked_case({'friction': 1, 'engine': 'bullet'})
    assert list(case.items()) == [('engine', 'bullet'), ('friction', 1.0)]
    assert isinstance(case['friction'], float)


@pytest.mark.parametrize(
    'case',
    [
        {'friction': math.nan},
        {'gait.swing_height': 0.0},
        {'gait.wings': 2.0},
        {'gait_node.gait': 'trot'},
        {'sim_node.seed': 1},
        {'colour': 'red'},
    ],
)
def test_what_means_nothing_is_refused(case):
    with pytest.raises(ParameterError):
        checked_case(case)
