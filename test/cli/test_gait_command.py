"""The gait command lists the gaits that ship, and says whether one suits a robot."""

import json
from pathlib import Path

import pytest

pytest.importorskip('rich')

import quad_gait
from quad_cli.main import main
from quad_gait.cycle.gait import available_gaits, load_gait
from quad_gait.cycle.gait_check import DIRECTIONS

GAITS = Path(quad_gait.__file__).parent / 'gaits'


@pytest.fixture(autouse=True)
def wide(monkeypatch):
    """Tables for people are not wrapped."""
    monkeypatch.setenv('COLUMNS', '300')


@pytest.fixture
def restless(tmp_path):
    """Write a wave gait whose body does not sway."""
    path = tmp_path / 'restless.yaml'
    text = (GAITS / 'wave.yaml').read_text(encoding='utf-8')
    assert 'sway_weight: [0.5, 0.25]' in text
    text = text.replace('sway_weight: [0.5, 0.25]', 'sway_weight: 0.0')
    path.write_text(text.replace('name: wave', 'name: restless'), encoding='utf-8')
    return path


def test_list_names_all_gaits_that_ship(capsys):
    assert main(['gait', 'list']) == 0
    told = capsys.readouterr().out
    for name in available_gaits():
        (row,) = [line for line in told.splitlines() if f' {name} ' in line]
        gait = load_gait(name)
        assert ('static' if gait.is_static else 'dynamic') in row
        assert f'{gait.cycle_period:g} s' in row
        assert ' '.join(swing.leg for swing in gait.swings) in row


def test_list_as_json_is_one_object(capsys):
    assert main(['gait', 'list', '--json']) == 0
    assert json.loads(capsys.readouterr().out) == {'gaits': list(available_gaits())}


@pytest.mark.parametrize(('gait', 'robot'), [('wave', 'genibo'), ('trot', 'cuhk')])
def test_check_of_a_good_gait_ends_with_code_0_and_tells_every_direction(capsys, gait, robot):
    assert main(['gait', 'check', gait, '--robot', robot]) == 0
    out, err = capsys.readouterr()
    assert err == ''
    assert out.startswith(f'{gait} on {robot}, a cycle of ')
    assert 'wrong: ' not in out
    for direction in DIRECTIONS:
        assert f'{direction}, what forbids more: ' in out


def test_check_takes_titan_viii_if_no_robot_is_named(capsys):
    assert main(['gait', 'check', 'crawl']) == 0
    told = capsys.readouterr().out
    assert told.startswith('crawl on titan_viii, a cycle of 5 s:')
    assert '226 mm' in told
    assert '0.045 m/s' in told


def test_check_as_json_is_one_object_with_what_the_gait_can_do(capsys):
    assert main(['gait', 'check', 'crawl', '--robot', 'titan_viii', '--json']) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told['robot'], told['gait'], told['problems']) == ('titan_viii', 'crawl', [])
    assert [motion['direction'] for motion in told['motions']] == list(DIRECTIONS)
    forward = told['motions'][0]
    assert forward['largest'] == pytest.approx({'forward': 0.226, 'left': 0, 'turn': 0}, abs=5e-4)
    assert forward['order'] == ['lh', 'lf', 'rh', 'rf']
    assert forward['least_margin'] > 0.03
    assert forward['limit']


def test_check_of_a_bad_gait_file_ends_with_code_1_and_prints_the_problems(capsys, restless):
    assert main(['gait', 'check', str(restless), '--least-margin', '0.01']) == 1
    out, err = capsys.readouterr()
    assert err == ''
    wrong = [line for line in out.splitlines() if line.startswith('wrong: ')]
    assert wrong[0].startswith('wrong: stepping on the spot the least stability margin is ')
    assert 'it must be at least 10.0 mm: the body must sway more' in wrong[0]
    for direction in DIRECTIONS:
        assert any(line.startswith(f'wrong: {direction}: ') for line in wrong)


def test_check_of_a_bad_gait_file_as_json_is_one_object_too(capsys, restless):
    assert main(['gait', 'check', str(restless), '--least-margin', '0.01', '--json']) == 1
    told = json.loads(capsys.readouterr().out)
    assert (told['gait'], told['motions']) == ('restless', [])
    assert len(told['problems']) == 1 + len(DIRECTIONS)


def test_a_larger_least_margin_is_harder_to_keep(capsys):
    assert main(['gait', 'check', 'wave', '--least-margin', '0.03']) == 0
    assert main(['gait', 'check', 'wave', '--least-margin', '1']) == 1
    assert 'it must be at least 1000.0 mm' in capsys.readouterr().out


@pytest.mark.parametrize(
    ('arguments', 'told'),
    [
        (
            ['gallop'],
            'it must be one of crab, crawl, trot, turn, walk, wave, or the path',
        ),
        (['/nowhere.yaml'], "'gait' is '/nowhere.yaml'; it must be one of"),
        (['wave', '--robot', 'spot'], "there is no robot 'spot'; available: "),
    ],
)
@pytest.mark.parametrize('as_json', [[], ['--json']])
def test_a_gait_or_robot_that_is_not_there_ends_with_code_2(capsys, arguments, told, as_json):
    assert main(['gait', 'check', *arguments, *as_json]) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('error: ')
    assert told in err
    assert err.count('\n') == 1


@pytest.mark.parametrize(
    ('content', 'told'),
    [
        ('', 'a complete gait file'),
        ('[1, 2', 'a complete gait file'),
        ('cycle_period: 1.0', 'given its swings as times (swings), or by phase_offsets'),
        ('cycle_period: soon', "'cycle_period' is 'soon'"),
        (
            'cycle_period: 4.0\nswing_height: 0.05\n'
            'swings: {rh: [0.1, 1.0], rf: [0.5, 1.5], lh: [2.0, 2.5], lf: [3.0, 3.5]}',
            'rh and rf are both in the air',
        ),
    ],
)
def test_a_file_that_is_no_gait_ends_with_code_2_and_one_sentence(capsys, tmp_path, content, told):
    path = tmp_path / 'broken.yaml'
    path.write_text(content, encoding='utf-8')
    assert main(['gait', 'check', str(path)]) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('error: ')
    assert told in err
    assert err.count('\n') == 1


@pytest.mark.parametrize(
    'arguments',
    [[], ['dance'], ['check'], ['check', 'wave', '--least-margin', 'much'], ['list', 'wave']],
)
def test_arguments_that_are_not_understood_end_with_code_2(capsys, arguments):
    with pytest.raises(SystemExit) as caught:
        main(['gait', *arguments])
    assert caught.value.code == 2
    assert 'usage: quadwalk ' in capsys.readouterr().err


def test_a_least_margin_that_is_not_finite_is_refused():
    try:
        code = main(['gait', 'check', 'wave', '--least-margin', 'nan'])
    except SystemExit as exit:
        code = exit.code
    assert code == 2
