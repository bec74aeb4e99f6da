"""
What ``quadwalk bench robots`` measures.
"""

import ctypes
import importlib.util
import math
import re
from unittest import mock

import pytest

pytest.importorskip('yourdfpy')

from quad_common.errors import QuadError
from quad_common.importing.options import ImportOptions
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.named_robots.known_robots import KNOWN_ROBOTS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.cycle.motion_limits import MotionLimits
from quad_lab.closed_loop.controllers import largest_speed
from quad_lab.robots import bench_robots
from quad_lab.robots.broken_descriptions import BROKEN_DESCRIPTIONS, import_broken
from quad_lab.robots.import_check import check_description, check_import
from quad_lab.robots.imported_walks import walk_imported
from quad_lab.robots.numeric_kinematics import compare_kinematics
from quad_lab.robots.reversals import walk_there_and_back
from quad_lab.robots.serial_bars import crawl_forward, write_serial_robot
from quad_lab.robots.serial_robots import BUILDS, serial_urdf
from quad_sim.engines.registry import ENGINES, preferred

ENGINES_WITH_PHYSICS = [
    name for name, engine in ENGINES.items() if engine.has_world and engine.is_installed
]

needs_descriptions = pytest.mark.skipif(
    importlib.util.find_spec('pybullet_data') is None, reason='pybullet_data is not installed'
)


@pytest.mark.parametrize('fault', BROKEN_DESCRIPTIONS)
def test_every_fault_is_named(fault):
    result = import_broken(fault, BROKEN_DESCRIPTIONS[fault])
    assert result.is_named, result.said or 'it was accepted'


def test_a_good_description_is_not_refused():
    result = import_broken('none', lambda text: text)
    assert not result.is_named
    assert result.said == ''


@needs_descriptions
@pytest.mark.parametrize('name', ['a1', 'laikago', 'spirit40'])
def test_engines_agree_with_an_import(name):
    checks = check_import(name, KNOWN_ROBOTS[name], seed=1)
    assert [check.engine for check in checks] == ENGINES_WITH_PHYSICS
    for check in checks:
        assert check.foot < 1e-5
        assert check.mass < 1e-6
        assert check.center < 1e-3


@needs_descriptions
@pytest.mark.skipif('bullet' not in ENGINES_WITH_PHYSICS, reason='PyBullet is not installed')
def test_what_an_engine_prints_of_a_description_stays_off_the_output(capfd):
    check_import('mini_cheetah', KNOWN_ROBOTS['mini_cheetah'], seed=1)
    # C keeps what it prints until later.
    ctypes.CDLL(None).fflush(None)
    assert capfd.readouterr().out == ''


def test_closed_form_and_iteration_agree():
    assert compare_kinematics(load_robot('genibo'), seed=2).difference < 1e-6


@pytest.mark.sweep(kept=1)
@needs_descriptions
@pytest.mark.parametrize(
    ('robot', 'backend'),
    [('a1', ENGINES_WITH_PHYSICS[0]), ('spirit40', ENGINES_WITH_PHYSICS[-1])],
)
def test_imported_robots_walk_as_they_are_asked_to(robot, backend):
    walk = walk_imported(robot, 'trot', 'forward', backend, 0.6)
    assert walk.problem == ''
    assert not walk.has_fallen
    assert abs(walk.error) < 0.02
    assert walk.drift < 0.02
    assert walk.tilt_rms < 0.026


@needs_descriptions
@pytest.mark.parametrize('backend', ENGINES_WITH_PHYSICS)
def test_at_almost_its_most_an_imported_robot_stays_upright_on_a_curve(backend):
    walk = walk_imported('a1', 'trot', 'tight curve', backend, 0.95)
    assert (walk.problem, walk.has_fallen) == ('', False)
    assert abs(walk.error) < 0.03
    # With feet under the body it was tilted by 3.8 degrees, and fell in one engine.
    assert walk.tilt_rms < 0.015


@pytest.mark.parametrize('direction', ['turn', 'curve'])
def test_a_trot_that_is_turned_round_at_once_stays_upright(direction):
    walk = walk_there_and_back('cuhk', direction, ENGINES_WITH_PHYSICS[-1], 0.95)
    assert (walk.problem, walk.has_fallen) == ('', False)
    assert 0.0 < walk.largest_tilt < 0.2


@pytest.fixture(scope='module', params=BUILDS)
def serial_robot(request, tmp_path_factory):
    return write_serial_robot(request.param, tmp_path_factory.mktemp('robots'))


@pytest.mark.sweep(kept=1)
def test_engines_agree_with_legs_of_any_axes(serial_robot):
    description = serial_robot.with_suffix('.urdf')
    checks = check_description(serial_robot.stem, description, ImportOptions(), seed=1)
    assert [check.engine for check in checks] == ENGINES_WITH_PHYSICS
    for check in checks:
        assert check.foot < 1e-5
        assert check.mass < 1e-6
        assert check.center < 1e-3


@pytest.mark.sweep(kept=1)
def test_legs_of_any_axes_are_kept_in_the_data_file(serial_robot):
    robot = load_robot(serial_robot)
    assert robot.leg_type == 'serial'
    angles = robot.joint_angles(robot.neutral_feet)
    assert abs(angles - robot.initial_joint_angles).max() < 1e-6
    assert 0.3 < robot.largest_stride / robot.hip_height < 1.5
    assert 0.0 < robot.step_height < robot.hip_height


def test_ranges_of_nearly_whole_turns_are_narrowed_and_said(tmp_path):
    wide = 'lower="-3.1" upper="3.1" effort'
    text = re.sub(r'lower="[^"]*" upper="[^"]*" effort', wide, serial_urdf('turned_knee'))
    description = tmp_path / 'wide.urdf'
    description.write_text(text, encoding='utf-8')
    imported = import_robot(description)
    assert any('FL_calf_joint is used from' in said for said in imported.notes.assumed)
    robot = load_robot(write_robot(imported, tmp_path / 'wide.yaml')[0])
    for leg, lower, upper in zip(robot.legs, robot.lower, robot.upper):
        low, high = leg.window()
        assert abs(low - lower).max() < 0.15
        assert abs(high - upper).max() < 0.15
        assert (upper - lower).max() < 2.0 * math.pi - 0.1


def test_legs_of_any_axes_crawl(tmp_path):
    robot = write_serial_robot('pitch_roll_pitch', tmp_path)
    with preferred(ENGINES_WITH_PHYSICS[-1]):
        assert abs(crawl_forward(robot, 22.0)) < 0.02


def test_limits_that_allow_nothing_are_said():
    with mock.patch.object(MotionLimits, 'largest_scale', return_value=0.0):
        walk = walk_imported('genibo', 'crawl', 'turn', ENGINES_WITH_PHYSICS[0], 0.6)
    assert walk.problem == 'the limits allow none'
    assert math.isnan(walk.error)


@pytest.mark.parametrize(('quick', 'parts'), [(True, [0.6]), (False, [0.6, 0.95])])
def test_robots_that_are_given_walk_alone(quick, parts):
    with mock.patch.object(bench_robots, '_walks', return_value=[]) as walks:
        _, details = bench_robots.measure(mock.Mock(), quick, 0, robots=('genibo', 'cuhk'))
    assert [call.args[1:3] for call in walks.call_args_list] == [
        (('genibo', 'cuhk'), fraction) for fraction in parts
    ]
    assert set(details) == {'walks', 'fast'} if len(parts) > 1 else {'walks'}


def test_a_robot_that_is_none_is_said_before_anything_walks():
    with (
        mock.patch.object(bench_robots, '_walks', side_effect=AssertionError),
        pytest.raises(QuadError, match='nobody'),
    ):
        bench_robots.measure(mock.Mock(), True, 0, robots=('genibo', 'nobody'))


def test_a_turn_on_the_spot_is_asked_for_as_far_as_the_gait_goes_that_turns():
    robot = load_robot('titan_viii')
    crawl = load_gait('crawl', robot)
    turn = BodyMotion(turn=1.0)
    most = largest_speed(robot, crawl, turn)
    turning = MotionLimits(robot, turning_gait_for(crawl, robot))
    assert most.scale * most.period == pytest.approx(turning.largest_scale(turn))
    assert most.scale * most.period > 1.01 * MotionLimits(robot, crawl).largest_scale(turn)
