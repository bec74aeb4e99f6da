"""Slip compensation asks for what was measured to be needed, and for nothing unmeasured."""

import re
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.following.slip_compensation import (
    NO_SLIP,
    Calibration,
    SlipCompensation,
    load_compensation,
    save_compensation,
    with_calibrations,
)

TROT, WAVE = load_gait('trot'), load_gait('wave')


def calibrated(gait, wanted, factor):
    asked = BodyMotion(factor[0] * wanted.forward, factor[1] * wanted.left, factor[2] * wanted.turn)
    return Calibration(gait.name, gait.cycle_period, wanted, asked)


FORWARD = calibrated(TROT, BodyMotion(0.1), (1.05, 1.0, 1.0))
ARC = calibrated(TROT, BodyMotion(0.08, 0.0, 0.2), (1.1, 1.0, 1.2))
TURN = calibrated(TROT, BodyMotion(turn=0.4), (1.0, 1.0, 1.15))
SLOW = calibrated(WAVE, BodyMotion(0.06), (1.02, 1.0, 1.0))
KNOWN = SlipCompensation((FORWARD, ARC, TURN, SLOW))


def parts(motion):
    return np.array([motion.forward, motion.left, motion.turn])


def random_motions(seed=1, count=50):
    rng = np.random.default_rng(seed)
    return [
        BodyMotion(*row) for row in rng.uniform((-0.1, -0.1, -0.5), (0.1, 0.1, 0.5), (count, 3))
    ]


def test_without_calibrations_one_asks_for_what_is_wanted():
    for motion in random_motions():
        assert NO_SLIP.compensated(TROT, motion) == motion


def test_alone_a_calibrated_motion_is_asked_for_as_measured():
    # But for the weight of nothing: 4 in 10000 of the excess.
    for calibration in KNOWN.calibrations:
        gait = TROT if calibration.gait == 'trot' else WAVE
        asked = SlipCompensation((calibration,)).compensated(gait, calibration.wanted)
        excess = parts(calibration.asked) - parts(calibration.wanted)
        assert parts(asked) - parts(calibration.wanted) == pytest.approx(excess, rel=5e-4)


def test_beside_others_a_calibrated_motion_is_asked_for_almost_as_measured():
    for calibration in KNOWN.calibrations:
        gait = TROT if calibration.gait == 'trot' else WAVE
        asked = KNOWN.compensated(gait, calibration.wanted)
        excess = parts(calibration.asked) - parts(calibration.wanted)
        got = parts(asked) - parts(calibration.wanted)
        assert np.abs(got - excess).max() < 0.01 * np.abs(excess).max()


def test_a_motion_unlike_any_known_one_is_hardly_changed():
    backward = BodyMotion(-0.1)
    known = SlipCompensation((FORWARD,))
    changed = parts(known.compensated(TROT, backward)) - parts(backward)
    assert np.abs(changed).max() < 0.1 * 0.005


def test_more_of_a_known_motion_needs_more_in_proportion():
    known = SlipCompensation((FORWARD,))
    for fraction in (0.9, 1.1):
        motion = FORWARD.wanted.scaled(fraction)
        asked = known.compensated(TROT, motion)
        assert asked.forward / motion.forward == pytest.approx(1.05, abs=0.005)


def test_no_movement_stays_no_movement():
    assert KNOWN.compensated(TROT, BodyMotion()) == BodyMotion()


def test_a_calibration_counts_for_its_gait_at_its_pace_only():
    for other in (WAVE, TROT.with_period(1.2 * TROT.cycle_period)):
        known = SlipCompensation((FORWARD,))
        assert known.compensated(other, FORWARD.wanted) == FORWARD.wanted
    almost = TROT.with_period(1.02 * TROT.cycle_period)
    assert SlipCompensation((FORWARD,)).compensated(almost, FORWARD.wanted).forward > 0.1


def test_between_two_known_motions_the_excess_is_between_theirs():
    small, large = (
        calibrated(TROT, BodyMotion(forward), (factor, 1.0, 1.0))
        for forward, factor in ((0.05, 1.02), (0.1, 1.1))
    )
    known = SlipCompensation((small, large))
    factors = [
        known.compensated(TROT, BodyMotion(forward)).forward / forward
        for forward in np.linspace(0.05, 0.1, 11)
    ]
    assert factors == sorted(factors)
    assert 1.0 < factors[0] < factors[-1] < 1.1


def test_a_file_gives_back_what_was_written(tmp_path):
    path = tmp_path / 'slip.yaml'
    save_compensation(KNOWN, path, 'Measured by a test.\nOn two lines.')
    text = path.read_text(encoding='utf-8')
    assert text.startswith('# Measured by a test.\n# On two lines.\n')
    again = load_compensation(path)
    assert len(again.calibrations) == len(KNOWN.calibrations)
    for read, written in zip(again.calibrations, KNOWN.calibrations):
        assert (read.gait, read.cycle_period) == (written.gait, written.cycle_period)
        assert parts(read.wanted) == pytest.approx(parts(written.wanted), abs=1e-6)
        assert parts(read.asked) == pytest.approx(parts(written.asked), abs=1e-6)
    for motion in random_motions(2):
        assert parts(again.compensated(TROT, motion)) == pytest.approx(
            parts(KNOWN.compensated(TROT, motion)), abs=1e-5
        )


def test_nothing_known_is_written_and_read_as_well(tmp_path):
    path = tmp_path / 'slip.yaml'
    save_compensation(NO_SLIP, path, 'Nothing yet.')
    assert load_compensation(path) == NO_SLIP


def test_a_file_that_is_not_there_holds_nothing(tmp_path):
    assert load_compensation(tmp_path / 'none.yaml') == NO_SLIP


GOOD = '{gait: trot, cycle_period: 0.5, wanted: [0.1, 0, 0], asked: [0.11, 0, 0]}'


def test_the_good_entry_is_good(tmp_path):
    path = tmp_path / 'slip.yaml'
    path.write_text(f'calibrations: [{GOOD}]', encoding='utf-8')
    assert load_compensation(path).calibrations[0].asked == BodyMotion(0.11)


@pytest.mark.parametrize(
    'content',
    [
        b'',
        b'- 1',
        b'calibrations',
        b'calibrations: 3',
        b'calibrations:',
        b'calibrations: [1]',
        b'calibrations: [[1, 2], {a: b',
        b'\xff\xfe\x00',
        f'calibrations: [{GOOD.replace("gait: trot, ", "")}]'.encode(),
        f'calibrations: [{GOOD.replace("0.5", "soon")}]'.encode(),
        f'calibrations: [{GOOD.replace("0.5", ".nan")}]'.encode(),
        f'calibrations: [{GOOD.replace("[0.1, 0, 0]", "[0.1, 0]")}]'.encode(),
        f'calibrations: [{GOOD.replace("[0.1, 0, 0]", "[.nan, 0, 0]")}]'.encode(),
        f'calibrations: [{GOOD.replace("[0.11, 0, 0]", "[.inf, 0, 0]")}]'.encode(),
        f'calibrations: [{GOOD.replace("[0.11, 0, 0]", "[0.3, 0, 0]")}]'.encode(),
        f'calibrations: [{GOOD.replace("[0.11, 0, 0]", "[-0.1, 0, 0]")}]'.encode(),
        f'calibrations: [{GOOD.replace("[0.11, 0, 0]", "[0, 0, 0]")}]'.encode(),
        b'calibrations: [{gait: a, cycle_period: 1, wanted: [0, 0, 0], asked: [0, 0, 0]}]',
    ],
)
def test_a_damaged_file_is_refused_in_one_sentence(tmp_path, content):
    path = tmp_path / 'slip.yaml'
    path.write_bytes(content)
    with pytest.raises(ParameterError) as caught:
        load_compensation(path)
    sentence = str(caught.value)
    assert '\n' not in sentence
    assert str(path) in sentence
    assert re.search('calibration file|written by quadwalk calibrate', sentence)


def test_a_new_calibration_takes_the_place_of_the_old_one_of_its_motion():
    newer = replace(FORWARD, asked=BodyMotion(0.12))
    known = with_calibrations(KNOWN, [newer])
    assert FORWARD not in known.calibrations
    assert known.calibrations.count(newer) == 1
    assert set(KNOWN.calibrations) - {FORWARD} <= set(known.calibrations)


def test_a_calibration_of_another_gait_or_motion_is_added():
    other = calibrated(WAVE, BodyMotion(0.1), (1.1, 1.0, 1.0))
    known = with_calibrations(KNOWN, iter([other]))
    assert known.calibrations == (*KNOWN.calibrations, other)
