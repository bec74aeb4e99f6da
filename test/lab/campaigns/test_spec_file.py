"""A campaign file says what it means, and each fault of one has its own sentence."""

import time

import pytest

from quad_common.errors import QuadError, TooManyWalks
from quad_lab.campaigns.campaign_spec import Span
from quad_lab.campaigns.spec_file import load_campaign, shipped_campaigns

GOOD = """
name: mine
seed: 7
walks: 3
fixed: {task: steer, gait.swing_height: 0.02, gait_node.turning: arc}
vary:
  robot: [titan_viii, cuhk]
  friction: {from: 0.4, to: 0.8, steps: 3}
"""

TUNE = """
walks: 1
fixed: {task: steer, robot: cuhk, gait: trot}
tune:
  numbers: {gait.swing_height: {from: 0.01, to: 0.03}}
  objective: {tilt_rms: 1}
"""


def load(tmp_path, text):
    path = tmp_path / 'campaign.yaml'
    path.write_text(text, encoding='utf-8')
    return load_campaign(path)


def test_a_campaign_is_read(tmp_path):
    spec = load(tmp_path, GOOD)
    assert (spec.name, spec.seed, spec.walks, spec.method) == ('mine', 7, 3, 'grid')
    assert spec.fixed == {'task': 'steer', 'gait.swing_height': 0.02, 'gait_node.turning': 'arc'}
    assert spec.vary == {'robot': ('titan_viii', 'cuhk'), 'friction': Span(0.4, 0.8, 3)}
    assert spec.tuning is None


def test_a_tuning_is_read(tmp_path):
    tuning = load(tmp_path, TUNE).tuning
    assert tuning.spans == {'gait.swing_height': Span(0.01, 0.03)}
    assert tuning.objective == {'tilt_rms': 1.0}


@pytest.mark.parametrize('name', shipped_campaigns())
def test_a_campaign_that_ships_is_valid(name):
    pytest.importorskip('pybullet')
    pytest.importorskip('mujoco')
    assert load_campaign(name).name == name


def test_there_are_campaigns_that_ship():
    assert {'reliability', 'rough_ground', 'tune_trot'} <= set(shipped_campaigns())


FAULTS = {
    'walks: many': "'walks' is 'many'",
    'walks: 0': 'from 1 to',
    'walk: 3': "the key 'walk' means nothing",
    'method: annealing': 'one of grid, random',
    'name: 7': 'a text of up to',
    'fixed: 3': 'a mapping of names to values',
    'fixed: {robto: cuhk}': "the key 'robto' means nothing",
    'fixed: {gait.swing: 0.02}': "valid keys of 'gait' are cycle_period",
    'fixed: {gait.swing_height: high}': "'gait.swing_height' is 'high'",
    'fixed: {gait_node.robot: cuhk}': "the key 'gait_node.robot' means nothing",
    'fixed: {planner_node.method: magic}': "'planner_node.method' is 'magic'",
    'fixed: {sim_node.seed: 3}': "the key 'sim_node.seed' means nothing",
    'fixed: {task: dance}': 'one of goal, steer',
    'fixed: {engine: kinematic}': 'one of bullet, mujoco',
    'fixed: {friction: -1.0}': 'from 0.01 to 10',
    'fixed: {shortest: 3.0}': 'below longest',
    'fixed: {robot: nobody}': 'nobody',
    'fixed: {gait: moonwalk}': 'moonwalk',
    'fixed: {map: atlantis}': "'map' is 'atlantis'",
    'fixed: {terrain: lava}': "'terrain' is 'lava'",
    'vary: {robot: cuhk}': 'a list of 1 to',
    'vary: {robot: []}': 'a list of 1 to',
    'vary: {robot: [cuhk, cuhk]}': 'in the list once',
    'vary: {robot: {from: a, to: b, steps: 3}}': 'a list: only numbers',
    'vary: {friction: {from: 0.4, to: 0.8}}': 'there in a grid',
    'vary: {friction: {from: 0.8, to: 0.4, steps: 3}}': 'below to',
    'vary: {friction: {from: 0.4, steps: 3}}': "'friction' is None",
    'vary: {friction: {from: 0.4, to: 0.8, steps: 3, by: 2}}': "the key 'vary.friction.by'",
    'vary: {friction: {from: 0.4, to: 0.8, steps: 3}}\nmethod: random': 'left out of a campaign',
    'vary: {robot: [cuhk]}\nfixed: {robot: cuhk}': 'in one of fixed, vary and tune only',
    'vary: {friction: {from: 0.4, to: 0.8, steps: 9999}}\nwalks: 1000': 'at most 1000000',
    'vary: {robot: [cuhk, nobody]}\nmethod: random': 'nobody',
    'vary: {robot: [cuhk, genibo], gait: [trot, moonwalk]}': 'moonwalk',
    'vary: {task: [steer, goal], map: [room, atlantis]}': "'map' is 'atlantis'",
    'vary: {terrain: [flat, lava]}': "'terrain' is 'lava'",
    'vary: {shortest: [0.5, 1.0, 3.0], longest: [4.0, 2.0]}': 'below longest, 2',
    'vary: {longest: {from: 0.2, to: 1.0}}\nmethod: random': 'below longest, 0.2',
    'tune: {objective: {tilt_rms: 1}}': "'tune.numbers' is {}",
    'tune: {numbers: {friction: {from: 0.4, to: 0.8}}}': "'tune.objective' is {}",
    'tune: {numbers: {friction: {from: 0.4, to: 0.8}}, objective: {grace: 1}}': "'tune.objective'",
    'tune: {numbers: {friction: 3}}': 'a range with from and to',
    'tune: {numbers: {friction: {from: 0.4, to: 0.8}}, objective: {tilt_rms: 0}}': 'from 1e-06',
}


@pytest.mark.parametrize('text', FAULTS)
def test_a_fault_has_its_sentence(tmp_path, text):
    with pytest.raises(QuadError) as raised:
        load(tmp_path, text)
    sentence = str(raised.value)
    assert FAULTS[text] in sentence
    assert sentence.startswith('campaign file ')
    assert '\n' not in sentence


def test_where_there_is_no_such_campaign_those_that_ship_are_named():
    with pytest.raises(QuadError, match='reliability'):
        load_campaign('no_such_campaign')


STEPS = '{from: 0.1, to: 0.9, steps: 100}'


def values(count):
    return str([round(0.1 + 1e-4 * index, 6) for index in range(count)])


def varied(values):
    names = 'friction', 'position_noise', 'heading_noise', 'joint_noise'
    return '\n'.join(['vary:', *(f'  {name}: {given}' for name, given in zip(names, values))])


def test_too_large_a_grid_is_refused_without_listing_it(tmp_path):
    began = time.monotonic()
    with pytest.raises(QuadError, match='2000000 walks; at most 1000000 are') as raised:
        load(tmp_path, varied([STEPS, STEPS, STEPS, '[0.1, 0.2]']))
    assert time.monotonic() - began < 3.0
    problem = raised.value.problem
    assert isinstance(problem, TooManyWalks)
    assert (problem.combinations, problem.walks, problem.most) == (2 * 10**6, 1, 10**6)


@pytest.mark.parametrize('walks', [1, 10**6])
def test_a_campaign_at_random_has_the_walks_that_it_says_however_many_values(tmp_path, walks):
    text = varied([values(101), values(100), values(100)])
    began = time.monotonic()
    assert load(tmp_path, f'method: random\nwalks: {walks}\n{text}').walks == walks
    assert time.monotonic() - began < 3.0


def test_the_largest_grid_is_checked_soon(tmp_path):
    began = time.monotonic()
    assert len(load(tmp_path, varied([STEPS] * 3)).vary) == 3
    assert time.monotonic() - began < 3.0
    with pytest.raises(QuadError, match='1000000 combinations of what varies, 2 walks of each'):
        load(tmp_path, f'walks: 2\n{varied([STEPS] * 3)}')


def test_a_map_counts_for_nothing_where_there_is_no_walk_to_a_goal(tmp_path):
    assert load(tmp_path, 'fixed: {task: steer, map: atlantis}').walks == 1
