"""Paces: cycles of stretches, turns and plans; files of them."""

import math

import pytest

from quad_common.errors import ParameterError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots
from quad_common.robot_files.walking_time import WalkingTimeModel, load_pace, paces_file, save_paces

CRAWL = WalkingTimeModel(cycle_period=5.0, stride=0.2, turn=math.radians(45.0))
TROT = WalkingTimeModel(cycle_period=0.5, stride=0.2, turn=math.radians(45.0), stopping=0.7)


@pytest.mark.parametrize(
    ('length', 'crawl', 'trot'),
    [(0.0, 0, 0), (0.01, 1, 1), (0.06, 1, 1), (0.07, 1, 2), (0.2, 1, 2), (0.6, 3, 4), (0.61, 4, 4)],
)
def test_a_stretch_takes_whole_cycles(length, crawl, trot):
    assert CRAWL.straight_cycles(length) == crawl
    assert TROT.straight_cycles(length) == trot


@pytest.mark.parametrize(
    ('degrees', 'cycles', 'at_the_goal'),
    [
        (0, 0, 0),
        (1.9, 0, 0),
        (11.9, 0, 1),
        (12.1, 1, 1),
        (45, 1, 1),
        (-46, 2, 2),
        (180, 4, 4),
        (350, 0, 1),
    ],
)
def test_a_turn_takes_whole_cycles(degrees, cycles, at_the_goal):
    assert CRAWL.turn_cycles(math.radians(degrees)) == cycles
    assert CRAWL.last_turn_cycles(math.radians(degrees)) == at_the_goal


def test_a_plan_takes_its_stretches_and_turns():
    plan = Plan.through([(0.0, 0.0), (1.0, 0.0), (1.0, 0.5)], math.pi)
    # A quarter turn, five strides, a quarter turn, three strides, a quarter turn.
    assert CRAWL.cycles(Pose2D(0.0, 0.0, -math.pi / 2.0), plan) == 2 + 5 + 2 + 3 + 2
    assert CRAWL.walking_time(Pose2D(0.0, 0.0, -math.pi / 2.0), plan) == 5.0 * 14


def test_a_bend_does_not_end_a_stretch():
    # Twice half a stride more than a whole number: together they are one more, not two.
    bent = Plan.through([(0.0, 0.0), (0.5, 0.0), (1.0, 0.05)], 0.1)
    broken = Plan.through([(0.0, 0.0), (0.5, 0.0), (0.9, 0.3)], 0.64)
    start = Pose2D(0.0, 0.0, 0.0)
    assert CRAWL.cycles(start, bent) == 6
    assert CRAWL.cycles(start, broken) == 3 + 1 + 3


def test_a_plan_of_one_pose_is_a_turn():
    assert CRAWL.cycles(Pose2D(0.0, 0.0, 0.0), Plan((Pose2D(0.0, 0.0, 1.0),))) == 2


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('stride', 0.0),
        ('turn', -1.0),
        ('cycle_period', math.nan),
        ('stopping', -0.1),
        ('bend', math.inf),
    ],
)
def test_a_number_that_is_not_valid_is_refused(name, value):
    numbers = {'cycle_period': 5.0, 'stride': 0.2, 'turn': 0.7, name: value}
    with pytest.raises(ParameterError, match=name):
        WalkingTimeModel(**numbers)


def test_a_file_of_paces_is_read_as_it_was_written(tmp_path):
    robot = tmp_path / 'mine.yaml'
    robot.write_text('name: mine\n')
    save_paces({'crawl': CRAWL, 'trot': TROT}, paces_file(robot), ['a comment'])
    read = load_pace(robot, 'trot')
    assert read.stride == TROT.stride
    assert read.turn == pytest.approx(TROT.turn, abs=1e-6)
    assert (tmp_path / 'mine.pace.yaml').read_text().startswith('# a comment\n')


def test_a_pace_that_is_not_known_is_said(tmp_path):
    robot = tmp_path / 'mine.yaml'
    robot.write_text('name: mine\n')
    with pytest.raises(ParameterError, match=f'quadwalk gait pace crawl --robot {robot}'):
        load_pace(robot, 'crawl')
    with pytest.raises(ParameterError, match='crawl, trot, walk, wave'):
        load_pace('titan_viii', 'gallop')
    (tmp_path / 'mine.pace.yaml').write_text('paces: {crawl: {stride: far}}')
    with pytest.raises(ParameterError, match=r'file of paces .*far'):
        load_pace(robot, 'crawl')


@pytest.mark.parametrize('robot', available_robots())
@pytest.mark.parametrize('gait', ['crawl', 'wave', 'trot', 'walk'])
def test_every_robot_has_its_paces(robot, gait):
    assert load_pace(robot, gait).stride > 0.0
