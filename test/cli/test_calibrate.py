"""The calibrate command reads motions, measures them, and writes what to ask for."""

import json
import math

import numpy as np
import pytest

pytest.importorskip('rich')

from dataclasses import replace

from quad_cli.calibrate import _motion
from quad_cli.main import main
from quad_common.errors import ParameterError
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.slip_compensation import (
    Calibration,
    SlipCompensation,
    load_compensation,
    save_compensation,
)
from quad_lab.closed_loop.calibration import (
    DIRECTIONS,
    FRACTIONS,
    calibrate_motion,
    default_motions,
    measure_motion,
)
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_sim.engines.simulator import GRAVITY

TITAN, CUHK = load_robot('titan_viii'), load_robot('cuhk')
TROT = load_gait('trot', CUHK)
MOTIONS = {
    'forward': BodyMotion(0.03),
    'left': BodyMotion(left=0.01),
    'turn': BodyMotion(turn=-0.1),
    'arc': BodyMotion(0.02, -0.01, 0.05),
}
each_motion = pytest.mark.parametrize('motion', MOTIONS.values(), ids=MOTIONS)


def parts(motion):
    return (motion.forward, motion.left, motion.turn)


@pytest.mark.parametrize(
    ('text', 'motion'),
    [
        ('0.1,0,0', (0.1, 0.0, 0.0)),
        ('-0.1,0.02,-0.3', (-0.1, 0.02, -0.3)),
        ('0.126,0,18deg', (0.126, 0.0, math.pi / 10.0)),
        ('0,0,-90deg', (0.0, 0.0, -math.pi / 2.0)),
        (' 1e-1 , 0 , 1', (0.1, 0.0, 1.0)),
    ],
)
def test_a_motion_is_three_numbers_and_its_turn_may_be_in_degrees(text, motion):
    assert parts(_motion(text)) == pytest.approx(motion)


@pytest.mark.parametrize(
    'text', ['', '0.1', '0.1,0', '1,2,3,4', 'a,0,0', '0.1,0,', '0.1,0,deg', '5deg,0,0', '1;0;0']
)
def test_what_is_no_motion_is_refused(text):
    with pytest.raises(ParameterError, match='it must be three numbers: forward, left, turn'):
        _motion(text)


@pytest.mark.parametrize('text', ['0,0,0', '0,-0,0deg', 'nan,0,0', '0,inf,0', '0.1,0,infdeg'])
def test_a_motion_that_is_none_or_not_finite_is_refused(text):
    with pytest.raises(ParameterError, match='it must be finite, and not zero'):
        _motion(text)


@pytest.mark.parametrize('text', ['4e-7,0,0', '7e-4,-7e-4,0', '0,9.9e-4,0.09deg', '0,0,-1e-3'])
def test_a_motion_too_small_to_be_kept_is_refused(text):
    with pytest.raises(ParameterError, match=r'at least 1 mm far, or a turn of at least 0\.1 deg'):
        _motion(text)


@pytest.mark.parametrize('text', ['1e-3,0,0', '-8e-4,8e-4,0', '4e-7,0,0.1deg', '0,0,-0.1deg'])
def test_the_least_motions_are_written_as_they_can_be_read(tmp_path, monkeypatch, text):
    monkeypatch.setattr('quad_cli.calibrate.calibrate_motion', fake_calibration)
    path = tmp_path / 'slip.yaml'
    assert main([*COMMAND, f'--motion={text}', '--output', str(path), '--json']) == 0
    (calibration,) = load_compensation(path).calibrations
    assert parts(calibration.wanted) == pytest.approx(parts(_motion(text)), abs=1e-6)


def test_by_default_six_directions_at_two_speeds_within_the_limits_are_measured():
    limits = MotionLimits(CUHK, TROT)
    motions = default_motions(CUHK, TROT)
    assert len(motions) == len(DIRECTIONS) * len(FRACTIONS)
    for k, motion in enumerate(motions):
        direction, fraction = DIRECTIONS[k // len(FRACTIONS)], FRACTIONS[k % len(FRACTIONS)]
        for done, wanted in zip(parts(motion), parts(direction)):
            assert done * wanted > 0.0 if wanted else done == 0.0
        assert 1.0 / limits.largest_scale(motion) == pytest.approx(fraction, rel=0.01)


@each_motion
def test_without_physics_a_gait_does_what_is_asked_of_it(motion):
    measured = measure_motion(TITAN, load_gait('trot', TITAN), motion, 4, 'kinematic')
    assert parts(measured.mean) == pytest.approx(parts(motion), rel=1e-3, abs=1e-4)
    assert measured.spread < 1e-9
    assert not measured.has_fallen


@each_motion
def test_without_physics_even_small_feet_go_as_far_to_about_a_percent(motion):
    measured = measure_motion(CUHK, TROT, motion, 4, 'kinematic')
    assert parts(measured.mean) == pytest.approx(parts(motion), rel=0.012, abs=1e-4)
    assert measured.spread < 1e-9


@pytest.mark.parametrize('gait', ['wave', 'crawl'])
def test_without_physics_static_gaits_are_measured_alike(gait):
    motion = MOTIONS['arc']
    measured = measure_motion(TITAN, load_gait(gait, TITAN), motion, 2, 'kinematic')
    assert parts(measured.mean) == pytest.approx(parts(motion), rel=2e-3, abs=1e-4)


def test_a_backend_that_is_none_is_refused():
    with pytest.raises(ParameterError, match=r"'backend' is 'paper'; .* bullet, mujoco, kinematic"):
        measure_motion(CUHK, TROT, MOTIONS['forward'], 2, 'paper')


def test_a_compensated_motion_is_nearer_to_what_is_wanted():
    pytest.importorskip('pybullet')
    wanted = BodyMotion(0.05)
    calibration, before, after = calibrate_motion(CUHK, TROT, wanted, rounds=2, cycles=4)
    assert (calibration.gait, calibration.cycle_period) == ('trot', TROT.cycle_period)
    assert calibration.wanted == wanted
    errors = [math.dist(parts(m.mean)[:2], parts(wanted)[:2]) for m in (before, after)]
    assert errors[1] <= errors[0]
    assert errors[1] < 0.02 * wanted.forward
    assert calibration.asked.forward == pytest.approx(wanted.forward, rel=0.1)


COMMAND = ['calibrate', '--robot', 'cuhk', '--gait', 'trot']


def test_the_command_writes_a_file_and_prints_one_object(tmp_path, capsys):
    pytest.importorskip('pybullet')
    path = tmp_path / 'new' / 'folder' / 'slip.yaml'
    arguments = ['--motion', '0.05,0,9deg', '--output', str(path), '--json']
    assert main([*COMMAND, *arguments]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told['file'] == str(path)
    (row,) = told['motions']
    wanted = [0.05, 0.0, math.radians(9.0)]
    assert row['wanted'] == pytest.approx(wanted)
    assert row['with'] == pytest.approx(wanted, rel=0.02, abs=1e-3)
    assert 0.0 <= row['fraction_off'] < 0.02
    (calibration,) = load_compensation(path).calibrations
    assert (calibration.gait, calibration.cycle_period) == ('trot', TROT.cycle_period)
    assert parts(calibration.wanted) == pytest.approx(wanted, abs=1e-6)
    assert parts(calibration.asked) == pytest.approx(row['asked'], abs=1e-6)
    assert path.read_text(encoding='utf-8').startswith('# Slip compensation of cuhk')


def fake_calibration(robot, gait, wanted):
    """Stand in for the measurement: the gait does 90 % of what is asked of it, then all."""
    measured = measure_motion(robot, gait, wanted, 1, 'kinematic')
    before, after = (replace(measured, mean=wanted.scaled(fraction)) for fraction in (0.9, 1.0))
    return Calibration(gait.name, gait.cycle_period, wanted, wanted.scaled(1.1)), before, after


def test_for_people_the_command_prints_a_table_and_where_it_is_written(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr('quad_cli.calibrate.calibrate_motion', fake_calibration)
    monkeypatch.setenv('COLUMNS', '300')
    path = tmp_path / 'slip.yaml'
    motions = ['--motion', '0.05,0,9deg', '--motion', '0,0.02,0']
    assert main([*COMMAND, *motions, '--output', str(path)]) == 0
    told = capsys.readouterr().out
    assert '50.0, 0.0, 9.00: 45.0, 0.0, 8.10 without, 50.0, 0.0, 9.00 with' in told
    assert f'written to {path}' in told
    assert len(load_compensation(path).calibrations) == 2


def test_what_was_calibrated_before_is_kept(tmp_path, monkeypatch):
    monkeypatch.setattr('quad_cli.calibrate.calibrate_motion', fake_calibration)
    path = tmp_path / 'slip.yaml'
    old = Calibration('wave', 4.0, BodyMotion(0.1), BodyMotion(0.11))
    save_compensation(SlipCompensation((old,)), path, 'Old.')
    for _ in range(2):
        assert main([*COMMAND, '--motion', '0.05,0,0', '--output', str(path), '--json']) == 0
    assert [c.gait for c in load_compensation(path).calibrations] == ['wave', 'trot']


def test_a_motion_that_cannot_be_compensated_ends_with_code_1(tmp_path, capsys, monkeypatch):
    def far_off(robot, gait, wanted):
        calibration, before, after = fake_calibration(robot, gait, wanted)
        return calibration, before, replace(after, mean=wanted.scaled(0.97))

    monkeypatch.setattr('quad_cli.calibrate.calibrate_motion', far_off)
    arguments = ['--motion', '0.05,0,0', '--output', str(tmp_path / 'slip.yaml'), '--json']
    assert main([*COMMAND, *arguments]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told['motions'][0]['fraction_off'] == pytest.approx(0.03)


@pytest.mark.parametrize(
    ('arguments', 'told'),
    [
        (['--motion', 'a,b,c'], "'motion' is 'a,b,c'; it must be three numbers"),
        (['--motion', '0.05,0,0', '--motion', '0,0,0'], 'it must be finite, and not zero'),
        (['--motion', '0.05,0,0', '--gait', 'gallop'], "'gait' is 'gallop'; it must be one of"),
        (['--motion', '0.05,0,0', '--robot', 'spot'], "there is no robot 'spot'; available: "),
    ],
)
def test_what_cannot_be_calibrated_ends_with_code_2_and_no_file(tmp_path, capsys, arguments, told):
    path = tmp_path / 'slip.yaml'
    assert main([*COMMAND, *arguments, '--output', str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('error: ')
    assert told in err
    assert err.count('\n') == 1
    assert not path.exists()


def test_a_motion_beyond_the_limits_leaves_a_file_that_can_be_read(tmp_path):
    pytest.importorskip('pybullet')
    path = tmp_path / 'slip.yaml'
    main([*COMMAND, '--motion', '9,0,0', '--output', str(path), '--json'])
    load_compensation(path)


class OverturnedLoop(ClosedLoop):
    """A walk in which the robot is pushed over after its first cycle."""

    def next_cycle_end(self):
        end = super().next_cycle_end()
        self.simulation.push(np.array([0.0, 3.0 * GRAVITY * self.robot.mass, 0.0]))
        return end


@pytest.mark.parametrize(('engine', 'module'), [('bullet', 'pybullet'), ('mujoco', 'mujoco')])
def test_a_robot_that_falls_is_measured_as_fallen(monkeypatch, engine, module):
    pytest.importorskip(module)
    monkeypatch.setattr('quad_lab.closed_loop.calibration.ClosedLoop', OverturnedLoop)
    measured = measure_motion(CUHK, TROT, BodyMotion(0.1), 4, engine)
    assert measured.has_fallen
    assert math.isnan(measured.mean.forward)
