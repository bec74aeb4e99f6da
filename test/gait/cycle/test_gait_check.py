"""A gait check finds nothing wrong with the gaits that ship, and says what is with others."""

from dataclasses import replace
from functools import cache

import pytest
import yaml

from quad_common.errors import ParameterError
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import Swing, available_gaits, load_gait
from quad_gait.cycle.gait_check import DIRECTIONS, check_gait
from quad_gait.cycle.gait_generator import generate_steady_cycle
from quad_gait.cycle.part_check import crossing_feet

ROBOTS = {name: load_robot(name) for name in ('titan_viii', 'pukyong', 'cuhk', 'genibo')}
TITAN, CUHK = ROBOTS['titan_viii'], ROBOTS['cuhk']
WAVE, CRAWL, TROT = (load_gait(name, TITAN) for name in ('wave', 'crawl', 'trot'))

each_gait = pytest.mark.parametrize('gait', available_gaits())
each_robot = pytest.mark.parametrize('robot', ROBOTS)
# The same ones in each test, which are checked once.
few = pytest.mark.sweep(kept=6)


@cache
def report_of(robot, gait):
    """Check a gait that ships; only once, and only where a test asks for it."""
    return check_gait(ROBOTS[robot], load_gait(gait, ROBOTS[robot]))


def parts(motion):
    return (motion.forward, motion.left, motion.turn)


def with_feet_of(robot, radius):
    """Return the robot with larger balls for feet, and nothing else changed."""
    foot = replace(robot.links['foot'], radius=radius)
    return replace(robot, links={**robot.links, 'foot': foot})


def check_each_direction_is_told_of(report):
    """Each direction either has its largest motion, or a problem that names it."""
    told = [motion.direction for motion in report.motions]
    wrong = [name for name in DIRECTIONS if name not in told]
    for name in wrong:
        assert any(problem.startswith(f'{name}: ') for problem in report.problems)
    assert told == [name for name in DIRECTIONS if name not in wrong]
    for problem in report.problems:
        assert '\n' not in problem


@few
@each_robot
@each_gait
def test_nothing_is_wrong_with_the_gaits_that_ship(robot, gait):
    assert report_of(robot, gait).problems == ()


@few
@each_robot
@each_gait
def test_each_of_the_six_directions_has_a_size_of_its_own_sign(robot, gait):
    report = report_of(robot, gait)
    assert [motion.direction for motion in report.motions] == list(DIRECTIONS)
    for motion in report.motions:
        for done, wanted in zip(parts(motion.largest), parts(DIRECTIONS[motion.direction])):
            assert done * wanted > 0.0 if wanted else done == 0.0


@few
@each_robot
@each_gait
def test_what_forbids_more_is_one_sentence(robot, gait):
    for motion in report_of(robot, gait).motions:
        assert motion.limit
        assert '\n' not in motion.limit


@few
@each_robot
@each_gait
def test_all_four_legs_swing_once_in_every_direction(robot, gait):
    for motion in report_of(robot, gait).motions:
        assert sorted(motion.order) == ['lf', 'lh', 'rf', 'rh']


@each_robot
@pytest.mark.parametrize('gait', [g for g in available_gaits() if load_gait(g).is_static])
def test_static_gaits_keep_their_margin_at_their_largest(robot, gait):
    assert all(motion.least_margin >= 0.0 for motion in report_of(robot, gait).motions)


@each_robot
def test_opposite_directions_are_as_large(robot):
    for gait in available_gaits():
        there = report_of(robot, gait).motions[::2]
        back = report_of(robot, gait).motions[1::2]
        for a, b in zip(there, back):
            opposite = [-part for part in parts(b.largest)]
            assert parts(a.largest) == pytest.approx(opposite, rel=0.1)


@each_robot
@pytest.mark.parametrize('together', ['lf, lh', 'lf, rf'])
def test_that_feet_of_one_side_or_end_cannot_be_balanced_on_is_said_once(robot, together, tmp_path):
    offsets = {leg: 0.02 if leg in together.split(', ') else 0.52 for leg in LEGS}
    document = {
        'cycle_period': 0.4, 'phase_offsets': offsets, 'duty_factor': 0.54, 'is_static': False,
        'swing_path': 'ellipse', 'swing_height': 0.025,
    }  # fmt: skip
    path = tmp_path / 'mine.yaml'
    path.write_text(yaml.safe_dump(document), encoding='utf-8')
    report = check_gait(ROBOTS[robot], load_gait(path, ROBOTS[robot]))
    assert report.motions == ()
    (sentence,) = report.problems
    assert 'mm beside the feet that stand' in sentence
    assert 'must be diagonal' in sentence


def test_a_margin_that_is_asked_for_is_kept_or_told():
    careful = check_gait(TITAN, WAVE, 0.03)
    assert careful.problems == ()
    assert all(motion.least_margin >= 0.03 - 1e-3 for motion in careful.motions)
    impossible = check_gait(TITAN, WAVE, 1.0)
    assert impossible.motions == ()
    check_each_direction_is_told_of(impossible)
    assert 'it must be at least 1000.0 mm' in impossible.problems[0]


def test_two_feet_in_the_air_in_a_static_gait_are_refused_when_it_is_loaded(tmp_path):
    path = tmp_path / 'hasty.yaml'
    path.write_text(
        'cycle_period: 4.0\nswing_height: 0.05\n'
        'swings: {rh: [0.1, 1.0], rf: [0.5, 1.5], lh: [2.0, 2.5], lf: [3.0, 3.5]}\n',
        encoding='utf-8',
    )
    with pytest.raises(ParameterError, match='rh and rf are both in the air'):
        load_gait(path, TITAN)


def test_two_feet_in_the_air_in_a_static_gait_leave_it_without_margin():
    swings = (Swing('rh', 0.1, 1.0), Swing('rf', 0.5, 1.5), Swing('lh', 2, 2.5), Swing('lf', 3, 4))
    report = check_gait(TITAN, replace(WAVE, swings=swings, sway_weight=(0.0, 0.0)))
    assert report.motions == ()
    check_each_direction_is_told_of(report)
    # Both right feet are up: the center of mass is outside by half the stance's width.
    assert report.problems[0].startswith('stepping on the spot the least stability margin is -30')
    assert 'the body must sway more, or the swings come in another order' in report.problems[0]
    assert all('stability margin' in problem for problem in report.problems)


def test_a_trot_that_claims_to_be_static_has_problems_except_on_the_spot():
    assert check_gait(TITAN, TROT).problems == ()
    report = check_gait(TITAN, replace(TROT, is_static=True))
    check_each_direction_is_told_of(report)
    assert [motion.direction for motion in report.motions] == ['turn left', 'turn right']
    assert all('stability margin' in problem for problem in report.problems)


def test_without_sway_the_margin_is_missing_on_the_spot():
    # A symmetric robot's center of mass lies on the edge of every triangle.
    for gait in (CRAWL, WAVE):
        assert check_gait(TITAN, gait, 0.01).problems == ()
        report = check_gait(TITAN, replace(gait, sway_weight=(0.0, 0.0)), 0.01)
        assert report.motions == ()
        check_each_direction_is_told_of(report)
        first = report.problems[0]
        assert first.startswith('stepping on the spot the least stability margin is ')
        assert 'it must be at least 10.0 mm: the body must sway more' in first
        assert len(report.problems) == 1 + len(DIRECTIONS)


def test_the_margin_of_a_dynamic_gait_does_not_matter():
    assert check_gait(TITAN, TROT, 1.0) == check_gait(TITAN, TROT)


def test_feet_that_are_lifted_beyond_reach_are_told_on_the_spot_and_everywhere():
    for gait, told in ((WAVE, '_joint would go to'), (TROT, 'the leg reaches')):
        report = check_gait(TITAN, replace(gait, swing_height=0.5))
        assert report.motions == ()
        check_each_direction_is_told_of(report)
        assert report.problems[0].startswith('stepping on the spot: ')
        assert all(told in problem for problem in report.problems)


def test_a_gait_too_fast_for_the_joints_is_told():
    report = check_gait(TITAN, WAVE.with_period(0.2))
    assert report.motions == ()
    check_each_direction_is_told_of(report)
    assert all('rad/s' in problem for problem in report.problems)


def test_feet_too_large_for_the_stance_are_in_each_others_way():
    wave = load_gait('wave', CUHK)
    # These touch their own legs when they are lifted, but not one another.
    report = check_gait(with_feet_of(CUHK, 0.05), wave)
    check_each_direction_is_told_of(report)
    assert report.problems
    assert all('touch' in problem for problem in report.problems)
    # The feet stand 115 mm apart, and now need 120 mm.
    report = check_gait(with_feet_of(CUHK, 0.06), wave)
    assert report.motions == ()
    check_each_direction_is_told_of(report)
    assert all('feet lf and rf cross: 115 mm' in problem for problem in report.problems)


def test_the_largest_motions_of_a_good_gait_keep_the_feet_apart():
    for name in ('genibo', 'cuhk'):
        robot = ROBOTS[name]
        for gait in ('wave', 'trot'):
            loaded = load_gait(gait, robot)
            for motion in report_of(name, gait).motions:
                swings = tuple(
                    replace(swing, leg=leg) for swing, leg in zip(loaded.swings, motion.order)
                )
                cycle = generate_steady_cycle(robot, replace(loaded, swings=swings), motion.largest)
                assert crossing_feet(robot, cycle) == ''
                assert cycle.least_margin == pytest.approx(motion.least_margin)


def test_feet_that_cross_at_the_largest_motion_are_told_with_its_size(monkeypatch):
    monkeypatch.setattr('quad_gait.cycle.gait_check.crossing_feet', lambda *_: 'lf and rf cross')
    report = check_gait(TITAN, CRAWL)
    assert len(report.motions) == len(DIRECTIONS)
    assert len(report.problems) == len(DIRECTIONS)
    assert report.problems[0] == 'forward at 226 mm a cycle: lf and rf cross'
    assert report.problems[4].startswith('turn left at ')
    assert report.problems[4].endswith(' degrees a cycle: lf and rf cross')
