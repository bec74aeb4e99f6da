"""A gait is data: what ships is sound, and what is not is told."""

import copy
import itertools
import math
from pathlib import Path

import pytest
import yaml

import quad_gait.gait
from quad_common.errors import ParameterError
from quad_common.robot import LEGS
from quad_gait.gait import available_gaits, load_gait

GAITS = Path(quad_gait.gait.__file__).parent / 'gaits'
CRAWL = yaml.safe_load((GAITS / 'crawl.yaml').read_text(encoding='utf-8'))

each_gait = pytest.mark.parametrize('name', available_gaits())

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


def test_crawl_and_turn_ship():
    assert {'crawl', 'turn'} <= set(available_gaits())
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


@each_gait
def test_one_foot_at_most_is_in_the_air(name):
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
        assert beta > 0.75


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
def test_nothing_moves_before_the_motion_starts(name):
    gait = load_gait(name)
    starts = [gait.sway_start, gait.swings[0].liftoff, gait.body_progress[0][0]]
    assert gait.motion_start == min(starts) > 0.0


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


@pytest.mark.parametrize('key', [key for key in CRAWL if key != 'name'])
def test_a_gait_without_one_of_its_keys_is_not_complete(tmp_path, key):
    document = copy.deepcopy(CRAWL)
    del document[key]
    sentence = refusal(written(tmp_path, document))
    assert 'a complete gait file' in sentence
    assert key in sentence


def test_a_key_that_means_nothing_is_named(tmp_path):
    sentence = refusal(written(tmp_path, {**CRAWL, 'cycle_periodd': 4.0}))
    assert "['cycle_periodd']" in sentence
    assert 'complete' not in sentence


OVERLAP = {'lh': [1.1, 1.65], 'lf': [1.66, 2.55], 'rh': [3.1, 3.65], 'rf': [4.0, 4.55]}


@pytest.mark.parametrize(
    ('key', 'value', 'told'),
    [
        ('cycle_period', 0.0, "'cycle_period' is 0.0; it must be a positive number of seconds"),
        ('cycle_period', math.nan, "'cycle_period' is nan"),
        ('cycle_period', math.inf, "'cycle_period' is inf"),
        ('cycle_period', 'long', 'a complete gait file'),
        ('swings', {'lf': [1.0, 2.0]}, 'one swing for each of lf, rf, lh, rh'),
        ('swings', {**CRAWL['swings'], 'tail': [1, 2]}, 'one swing for each of lf, rf, lh, rh'),
        ('swings', {**CRAWL['swings'], 'lf': [2.5, 2.0]}, "'swings.lf' is [2.5, 2.0]"),
        ('swings', {**CRAWL['swings'], 'lf': [4.8, 5.1]}, 'both within 0 and 5.0 s'),
        ('swings', {**CRAWL['swings'], 'lf': [-0.1, 0.5]}, "'swings.lf' is [-0.1, 0.5]"),
        ('swings', {**CRAWL['swings'], 'lf': [math.nan, 2.5]}, "'swings.lf' is [nan, 2.5]"),
        ('swings', {**CRAWL['swings'], 'lf': 2.0}, 'a complete gait file'),
        ('swings', {**CRAWL['swings'], 'lf': ['a', 'b']}, 'a complete gait file'),
        ('swings', OVERLAP, 'at least 0.05 s apart'),
        ('swings', None, 'a complete gait file'),
        ('body_progress', [[0.6, 0.0]], 'at least two rising times in 0 to 5.0 s'),
        ('body_progress', [[0.6, 0.0], [0.6, 1.0]], 'at least two rising times'),
        ('body_progress', [[0.6, 0.0], [5.1, 1.0]], 'at least two rising times'),
        ('body_progress', [[-0.1, 0.0], [5.0, 1.0]], 'at least two rising times'),
        ('body_progress', [[0.6, 0.0], [5.0, 0.9]], 'shares that rise from 0 to 1'),
        ('body_progress', [[0.6, 0.1], [5.0, 1.0]], 'shares that rise from 0 to 1'),
        ('body_progress', [[0.6, 0.0], [2, 0.6], [3, 0.5], [5, 1.0]], 'shares that rise'),
        ('swing_height', 0.0, "'swing_height' is 0.0; it must be positive"),
        ('swing_height', math.nan, "'swing_height' is nan"),
        ('sway_weight', -0.1, "'sway_weight' is -0.1; it must be from 0"),
        ('sway_weight', 1.1, "'sway_weight' is 1.1; it must be from 0"),
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
