"""A gait is data: what ships is sound, and what is not is told."""

import copy
import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import yaml

import quad_gait.cycle.gait
from quad_common.errors import ParameterError
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.gait import available_gaits, load_gait, resting

GAITS = Path(quad_gait.__file__).parent / 'gaits'
CRAWL, TROT, WAVE = (
    yaml.safe_load((GAITS / f'{name}.yaml').read_text(encoding='utf-8'))
    for name in ('crawl', 'trot', 'wave')
)
STATIC = [name for name in available_gaits() if load_gait(name).is_static]

each_gait = pytest.mark.parametrize('name', available_gaits())
each_static_gait = pytest.mark.parametrize('name', STATIC)
each_robot = pytest.mark.parametrize('robot', available_robots())

# S0's numbers of the legs, beside its formulas only.
NUMBER = {'lf': 1, 'rf': 2, 'lh': 3, 'rh': 4}


def written(tmp_path, document):
    path = tmp_path / 'mine.yaml'
    path.write_text(yaml.safe_dump(document), encoding='utf-8')
    return path


def refusal(gait):
    with pytest.raises(ParameterError) as caught:
        load_gait(gait)
    assert '\n' not in str(caught.value)
    return str(caught.value)


def test_six_gaits_ship():
    assert available_gaits() == ('crab', 'crawl', 'trot', 'turn', 'walk', 'wave')
    assert set(available_gaits()) == {path.stem for path in GAITS.glob('*.yaml')}


@each_gait
def test_every_foot_swings_once_in_a_cycle(name):
    gait = load_gait(name)
    assert gait.name == name
    assert sorted(swing.leg for swing in gait.swings) == sorted(LEGS)
    for swing in gait.swings:
        assert 0.0 <= swing.liftoff < swing.touchdown <= gait.cycle_period


@each_gait
def test_swings_are_in_the_order_of_liftoff(name):
    liftoffs = [swing.liftoff for swing in load_gait(name).swings]
    assert liftoffs == sorted(liftoffs)


def test_all_but_the_trot_and_the_walk_are_static():
    assert set(available_gaits()) - set(STATIC) == {'trot', 'walk'}


@each_static_gait
def test_in_a_static_gait_one_foot_at_most_is_in_the_air(name):
    swings = load_gait(name).swings
    for swing, following in itertools.pairwise(swings):
        assert swing.touchdown < following.liftoff


@each_gait
def test_the_duty_factor_is_the_share_of_the_cycle_on_the_ground(name):
    gait = load_gait(name)
    for swing in gait.swings:
        beta = 1.0 - (swing.touchdown - swing.liftoff) / gait.cycle_period
        assert gait.duty_factor(swing.leg) == pytest.approx(beta)
        # S4: a static gait with sway needs more than three quarters.
        assert beta > 0.75 or not gait.is_static


def test_in_the_trot_diagonal_pairs_swing_half_a_cycle_apart():
    gait = load_gait('trot')
    for leg, diagonal in (('lf', 'rh'), ('rf', 'lh')):
        assert gait.swing(leg).liftoff == gait.swing(diagonal).liftoff
        assert gait.swing(leg).touchdown == gait.swing(diagonal).touchdown
    assert gait.swing('rf').liftoff - gait.swing('lf').liftoff == pytest.approx(
        gait.cycle_period / 2.0
    )
    # S2 sec. III.B: swing to support 1:1, less a moment with all feet down.
    assert gait.duty_factor('lf') == pytest.approx(0.5, abs=0.05)
    assert (gait.swing_path, gait.support_depth) == ('ellipse', 0.25)


def test_in_the_walk_hind_before_front_on_each_side_and_two_feet_that_stand_are_diagonal():
    gait = load_gait('walk')
    # From touchdown to touchdown: a lateral sequence (Hildebrand).
    landed = [leg for _, leg in sorted((swing.touchdown, swing.leg) for swing in gait.swings)]
    assert landed == ['rf', 'lh', 'lf', 'rh']
    assert 0.6 <= gait.duty_factor('lf') <= 0.8
    assert len({round(gait.duty_factor(leg), 9) for leg in LEGS}) == 1
    fewest = 4
    for time in np.linspace(0.0, gait.cycle_period, 1001):
        lifted = {s.leg for s in gait.swings if s.liftoff < time < s.touchdown}
        fewest = min(fewest, 4 - len(lifted))
        assert len(lifted) < 2 or lifted in ({'rf', 'lh'}, {'lf', 'rh'})
    assert fewest == 2
    # The second half is the first one with left and right exchanged.
    half = gait.cycle_period / 2.0
    for leg, other in (('rf', 'lf'), ('lh', 'rh')):
        assert gait.swing(other).liftoff == pytest.approx(gait.swing(leg).liftoff + half)


@pytest.mark.parametrize('name', ['trot', 'walk'])
def test_diagonal_pairs_take_over_from_each_other_twice_in_a_cycle(name):
    gait = load_gait(name)
    period = gait.cycle_period
    assert gait.support_edges == pytest.approx((0.0, period / 2.0, period))


def test_the_longest_swing_is_what_the_duty_factor_leaves():
    gait = load_gait('walk')
    assert gait.longest_swing == pytest.approx(0.36 * gait.cycle_period)


def test_in_the_wave_a_front_foot_follows_the_hind_foot_of_its_side():
    # S4: order 4-2-3-1 of its fig. 4, all feet down in between, and a period of 4 s.
    gait = load_gait('wave')
    assert [swing.leg for swing in gait.swings] == ['rh', 'rf', 'lh', 'lf']
    assert (gait.cycle_period, gait.footholds) == (4.0, 'mid_stance')
    assert all(gait.duty_factor(leg) > 0.75 for leg in LEGS)


def test_the_crab_walks_in_the_order_of_the_crawl():
    assert load_gait('crab').swings == load_gait('crawl').swings


def test_a_gait_whose_body_rests_between_cycles_says_when_it_moves():
    steady = {name for name in available_gaits() if load_gait(name).is_steady}
    assert steady == {'trot', 'walk', 'wave'}


@each_gait
def test_mirroring_exchanges_left_and_right_and_twice_is_the_identity(name):
    gait = load_gait(name)
    mirrored = gait.mirrored()
    assert mirrored.mirrored() == gait
    for swing, other in zip(gait.swings, mirrored.swings):
        assert {swing.leg[0], other.leg[0]} == {'l', 'r'}
        assert swing.leg[1] == other.leg[1]
        assert (swing.liftoff, swing.touchdown) == (other.liftoff, other.touchdown)
        assert gait.duty_factor(swing.leg) == mirrored.duty_factor(other.leg)


def test_the_crawl_swings_in_the_papers_order():
    gait = load_gait('crawl')
    assert [NUMBER[swing.leg] for swing in gait.swings] == [3, 1, 4, 2]
    assert [NUMBER[swing.leg] for swing in gait.mirrored().swings] == [4, 2, 3, 1]
    assert gait.cycle_period == 5.0


def test_the_turn_swings_in_the_papers_order_to_either_side():
    gait = load_gait('turn')
    assert [NUMBER[swing.leg] for swing in gait.swings] == [4, 2, 1, 3]
    assert [NUMBER[swing.leg] for swing in gait.mirrored().swings] == [3, 1, 2, 4]
    assert gait.cycle_period == 5.0


@each_gait
def test_a_gait_at_another_period_is_the_same_in_proportion(name):
    gait = load_gait(name)
    slow = gait.with_period(3.0 * gait.cycle_period)
    assert slow.cycle_period == pytest.approx(3.0 * gait.cycle_period)
    assert slow.motion_start == pytest.approx(3.0 * gait.motion_start)
    for swing, other in zip(gait.swings, slow.swings):
        assert (other.leg, other.liftoff, other.touchdown) == (
            swing.leg,
            pytest.approx(3.0 * swing.liftoff),
            pytest.approx(3.0 * swing.touchdown),
        )
        assert slow.duty_factor(swing.leg) == pytest.approx(gait.duty_factor(swing.leg))
    for knot, other in zip(gait.body_progress or (), slow.body_progress or ()):
        assert other == (pytest.approx(3.0 * knot[0]), knot[1])
    assert slow.swing_height == gait.swing_height


@each_robot
@each_gait
def test_a_fitted_gait_has_what_the_robot_says_of_it(name, robot):
    robot = load_robot(robot)
    settings, plain, fitted = robot.gaits[name], load_gait(name), load_gait(name, robot)
    assert fitted == plain.fitted(robot)
    assert fitted.cycle_period == pytest.approx(settings.cycle_period or plain.cycle_period)
    # What a robot does not say is in proportion to TITAN-VIII's height of 243 mm.
    in_proportion = plain.swing_height * robot.hip_height / 0.243
    assert fitted.swing_height == pytest.approx(settings.swing_height or in_proportion)
    assert fitted.swings == plain.with_period(fitted.cycle_period).swings


def test_fitted_to_titan_viii_the_crawl_is_as_in_its_file():
    assert load_gait('crawl', load_robot('titan_viii')) == load_gait('crawl')


def test_a_gait_of_which_the_robot_says_nothing_is_fitted_by_its_height_alone(tmp_path):
    robot = load_robot('genibo')
    gait = load_gait(written(tmp_path, {**CRAWL, 'name': 'mine'}), robot)
    assert gait.cycle_period == CRAWL['cycle_period']
    assert gait.swing_height == pytest.approx(
        CRAWL['swing_height'] * robot.hip_height / 0.243, rel=1e-9
    )


@each_robot
@each_gait
def test_only_on_two_feet_a_body_is_a_pendulum_of_its_own_height(name, robot):
    robot = load_robot(robot)
    gait = load_gait(name, robot)
    if gait.is_static:
        assert gait.pendulum_rate == 0.0
    else:
        height = 9.80665 / gait.pendulum_rate**2
        assert 0.5 * robot.hip_height < height < 1.7 * robot.hip_height


@pytest.mark.parametrize('name', [name for name in available_gaits() if load_gait(name).is_steady])
def test_a_steady_gait_moves_from_the_very_start(name):
    assert load_gait(name).motion_start == 0.0


@pytest.mark.parametrize(
    'name', [name for name in available_gaits() if not load_gait(name).is_steady]
)
def test_nothing_moves_before_the_motion_starts(name):
    gait = load_gait(name)
    starts = [gait.sway_start, gait.swings[0].liftoff, gait.body_progress[0][0]]
    assert gait.motion_start == min(starts) > 0.0


@each_static_gait
def test_a_static_gait_that_rests_has_the_same_swings(name):
    gait = load_gait(name)
    rested = resting(gait)
    assert not rested.is_steady
    assert (rested.swings, rested.cycle_period) == (gait.swings, gait.cycle_period)
    assert rested.swing_height == gait.swing_height
    assert (rested is gait) == (not gait.is_steady)
    assert resting(rested) is rested


def test_a_gait_may_be_given_as_a_path(tmp_path):
    document = copy.deepcopy(CRAWL)
    document['swing_height'] = 0.03
    del document['name']
    gait = load_gait(written(tmp_path, document))
    assert (gait.name, gait.swing_height) == ('mine', 0.03)
    assert gait.swings == load_gait('crawl').swings
    assert load_gait(str(tmp_path / 'mine.yaml')) == gait


def test_an_unknown_gait_is_answered_with_those_that_there_are():
    sentence = refusal('gallop')
    assert sentence.startswith("'gait' is 'gallop'; it must be one of ")
    assert all(name in sentence for name in available_gaits())


def test_swings_may_be_given_as_phase_offsets_and_a_duty_factor(tmp_path):
    offsets = {leg: up / 5.0 for leg, (up, _) in CRAWL['swings'].items()}
    document = {**CRAWL, 'phase_offsets': offsets, 'duty_factor': 1.0 - 0.55 / 5.0}
    del document['swings']
    gait, crawl = load_gait(written(tmp_path, document)), load_gait('crawl')
    for swing, other in zip(gait.swings, crawl.swings):
        assert swing.leg == other.leg
        assert (swing.liftoff, swing.touchdown) == pytest.approx((other.liftoff, other.touchdown))


@pytest.mark.parametrize(
    ('weight', 'pair'), [(0.3, (0.3, 0.3)), (0, (0.0, 0.0)), ([0.1, 0.5], (0.1, 0.5))]
)
def test_a_sway_weight_may_be_one_number_or_one_forward_and_one_to_the_left(tmp_path, weight, pair):
    gait = load_gait(written(tmp_path, {**CRAWL, 'sway_weight': weight}))
    assert gait.sway_weight == pair
    assert gait.sways == any(pair)


@pytest.mark.parametrize(
    ('key', 'default'),
    [
        ('body_progress', None),
        ('footholds', 'mid_stance'),
        ('swing_path', 'smooth'),
        ('support_depth', 0.0),
        ('sway_start', 0.0),
        ('sway_weight', (0.0, 0.0)),
        ('is_static', True),
    ],
)
def test_what_a_gait_file_leaves_out_has_a_default(tmp_path, key, default):
    document = {**CRAWL, 'sway_start': 0.0}
    document.pop(key, None)
    assert getattr(load_gait(written(tmp_path, document)), key) == default


@pytest.mark.parametrize('key', ['cycle_period', 'swing_height'])
def test_a_gait_without_one_of_its_keys_is_not_complete(tmp_path, key):
    document = copy.deepcopy(CRAWL)
    del document[key]
    sentence = refusal(written(tmp_path, document))
    assert 'a complete gait file' in sentence
    assert key in sentence


def test_a_key_that_means_nothing_is_named(tmp_path):
    sentence = refusal(written(tmp_path, {**CRAWL, 'cycle_periodd': 4.0}))
    assert "the key 'cycle_periodd' means nothing; valid keys are cycle_period, " in sentence
    assert 'complete' not in sentence


def test_a_gait_without_swings_is_told_how_to_give_them(tmp_path):
    both = {**TROT, 'swings': CRAWL['swings']}
    neither = {key: value for key, value in CRAWL.items() if key != 'swings'}
    for document in (both, neither):
        sentence = refusal(written(tmp_path, document))
        assert 'given its swings as times (swings), or by phase_offsets and duty' in sentence


def test_phase_offsets_without_a_duty_factor_are_not_complete(tmp_path):
    document = {key: value for key, value in TROT.items() if key != 'duty_factor'}
    assert 'duty_factor' in refusal(written(tmp_path, document))


def test_a_duty_factor_beside_swings_is_refused(tmp_path):
    sentence = refusal(written(tmp_path, {**CRAWL, 'duty_factor': 0.8}))
    assert "'gait' is ['duty_factor', 'swings']; it must be given its swings as" in sentence


def test_a_gait_file_does_not_set_what_comes_from_the_robot(tmp_path):
    sentence = refusal(written(tmp_path, {**TROT, 'pendulum_rate': 5.0}))
    assert "the key 'pendulum_rate' means nothing" in sentence


def test_a_gait_on_two_feet_has_to_say_so(tmp_path):
    sentence = refusal(written(tmp_path, {**TROT, 'is_static': True}))
    assert 'both in the air' in sentence
    assert 'is_static: false' in sentence
    assert not load_gait(written(tmp_path, TROT)).is_static


OVERLAP = {'lh': [1.1, 1.65], 'lf': [1.66, 2.55], 'rh': [3.1, 3.65], 'rf': [4.0, 4.55]}


@pytest.mark.parametrize(
    ('key', 'value', 'told'),
    [
        (
            'cycle_period',
            0.0,
            "'cycle_period' is 0.0; it must be a finite number from 0.05 to 120 s",
        ),
        ('cycle_period', math.nan, "'cycle_period' is nan"),
        ('cycle_period', math.inf, "'cycle_period' is inf"),
        ('cycle_period', 'long', "'cycle_period' is 'long'; it must be a finite number from 0.05"),
        ('swings', {'lf': [1.0, 2.0]}, 'one swing for each of lf, rf, lh, rh'),
        ('swings', {**CRAWL['swings'], 'tail': [1, 2]}, 'one swing for each of lf, rf, lh, rh'),
        ('swings', {**CRAWL['swings'], 'lf': [2.5, 2.0]}, "'swings.lf' is [2.5, 2.0]"),
        ('swings', {**CRAWL['swings'], 'lf': [4.8, 5.1]}, 'both within 0 and 5.0 s'),
        ('swings', {**CRAWL['swings'], 'lf': [-0.1, 0.5]}, "'swings.lf.liftoff' is -0.1"),
        ('swings', {**CRAWL['swings'], 'lf': [math.nan, 2.5]}, "'swings.lf.liftoff' is nan"),
        (
            'swings',
            {**CRAWL['swings'], 'lf': 2.0},
            "'swings.lf' is 2.0; it must be [liftoff, touchdown]",
        ),
        ('swings', {**CRAWL['swings'], 'lf': ['a', 'b']}, "'swings.lf.liftoff' is 'a'"),
        ('swings', OVERLAP, 'at least 0.05 s apart'),
        ('swings', None, 'a complete gait file'),
        ('body_progress', [[0.6, 0.0]], 'at least two rising times in 0 to 5.0 s'),
        ('body_progress', [[0.6, 0.0], [0.6, 1.0]], 'at least two rising times'),
        ('body_progress', [[0.6, 0.0], [5.1, 1.0]], 'at least two rising times'),
        ('body_progress', [[-0.1, 0.0], [5.0, 1.0]], "'body_progress[0].time' is -0.1"),
        ('body_progress', [[0.6, 0.0], [5.0, 0.9]], 'fractions that rise from 0 to 1'),
        ('body_progress', [[0.6, 0.1], [5.0, 1.0]], 'fractions that rise from 0 to 1'),
        ('body_progress', [[0.6, 0.0], [2, 0.6], [3, 0.5], [5, 1.0]], 'fractions that rise'),
        (
            'body_progress',
            [[0.6, 0.0], [2.0, math.nan], [5.0, 1.0]],
            "'body_progress[1].fraction' is nan",
        ),
        (
            'body_progress',
            [[0.6, 0.0], [math.nan, 0.5], [5.0, 1.0]],
            "'body_progress[1].time' is nan",
        ),
        ('body_progress', False, 'a list of up to 100 pairs, each [time, fraction]'),
        ('body_progress', [], 'at least two rising times'),
        (
            'swing_height',
            0.0,
            "'swing_height' is 0.0; it must be a finite number from 0.0001 to 5 m",
        ),
        ('swing_height', math.nan, "'swing_height' is nan"),
        ('swing_height', math.inf, "'swing_height' is inf"),
        ('sway_weight', -0.1, "'sway_weight' is -0.1; it must be a finite number from 0 to 1"),
        (
            'sway_weight',
            [0.2, 1.1],
            "'sway_weight.left' is 1.1; it must be a finite number from 0 to 1",
        ),
        ('sway_weight', [0.2], 'it must be [forward, left]'),
        ('sway_weight', [0.2, 0.2, 0.2], 'it must be [forward, left]'),
        ('sway_weight', math.nan, "'sway_weight' is nan"),
        ('sway_start', -0.1, "'sway_start' is -0.1; it must be a finite number from 0 to 120 s"),
        ('sway_start', 2.0, "'sway_start' is 2.0; it must be from 0 s to the first liftoff"),
        ('footholds', 'anywhere', 'one of initial_posture, mid_stance'),
        ('swing_path', 'square', 'one of smooth, ellipse'),
        ('support_depth', 1.0, "'support_depth' is 1.0; it must be from 0 to below 1"),
        ('support_depth', -0.1, "'support_depth' is -0.1"),
        ('support_depth', math.nan, "'support_depth' is nan"),
        ('is_static', 'yes', "'is_static' is 'yes'; it must be true or false"),
        ('is_static', 1, "'is_static' is 1; it must be true or false"),
        ('sway_start', 1.09, 'at least 0.05 s apart, from sway_start to the end'),
    ],
)
def test_a_bad_gait_is_refused_in_one_sentence_with_what_is_valid(tmp_path, key, value, told):
    assert told in refusal(written(tmp_path, {**CRAWL, key: value}))


@pytest.mark.parametrize('content', [b'', b'- 1', b'a: [1, 2\nb: 3\n', b'\xff\xfe', b'crawl'])
def test_what_is_no_mapping_is_refused_in_one_sentence(tmp_path, content):
    path = tmp_path / 'gait.yaml'
    path.write_bytes(content)
    assert f"'gait' is '{path}'; it must be a complete gait file" in refusal(path)


def test_without_sway_the_swings_may_follow_each_other_at_once(tmp_path):
    swings = {leg: [float(k + 1), float(k + 2)] for k, leg in enumerate(('lh', 'lf', 'rh', 'rf'))}
    path = written(tmp_path, {**CRAWL, 'swings': swings, 'sway_weight': 0.0})
    assert load_gait(path).motion_start == 0.6
