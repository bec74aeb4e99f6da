"""A parameter takes what its table says, and nothing else."""

import math
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml

from quad_cli.parameters import TABLES
from quad_common.errors import ParameterError
from quad_common.parameters import (
    checked_parameters,
    parameter,
    parameters_of,
    valid_range,
    yaml_from_parameters,
)

CONFIG = Path(__file__).parents[2] / 'config'


@dataclass(frozen=True)
class Sample:
    flag: bool = parameter(True, 'A flag.')
    count: int = parameter(3, 'A count.', lower=1, upper=10)
    speed: float = parameter(0.5, 'A speed.', 'm/s', lower=0.0)
    depth: float = parameter(-1.0, 'A depth.', 'm', upper=0.0)
    free: float = parameter(2.5, 'Anything.')
    name: str = parameter('lf', 'Any text.')
    mode: str = parameter('walk', 'A mode.', choices=('walk', 'stand'))
    pose: list[float] = parameter([1.0, 2.0, 3.0], 'A pose.', 'm')  # noqa: RUF009
    bounds: list[float] = parameter([], 'Bounds, if any.', 'm', length=4)  # noqa: RUF009


def checked(**values):
    return checked_parameters(Sample, values)


def refusal(**values):
    with pytest.raises(ParameterError) as caught:
        checked(**values)
    return str(caught.value)


def test_without_values_every_parameter_has_its_default():
    assert checked() == Sample()


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('flag', False),
        ('count', 1),
        ('count', 10),
        ('speed', 0.0),
        ('speed', 1e300),
        ('depth', 0.0),
        ('depth', -1e300),
        ('free', -7.25),
        ('name', ''),
        ('mode', 'stand'),
        ('pose', [-1.0, 0.0, 1e3]),
        ('bounds', []),
        ('bounds', [0.0, 0.0, 8.0, 6.0]),
    ],
)
def test_a_valid_value_is_taken_as_it_is_and_the_rest_stays(name, value):
    result = checked(**{name: value})
    assert getattr(result, name) == value
    assert type(getattr(result, name)) is type(getattr(Sample(), name))
    others = {field: getattr(result, field) for field in vars(result) if field != name}
    assert others == {field: v for field, v in vars(Sample()).items() if field != name}


def test_a_whole_number_is_a_valid_float_but_a_float_is_no_whole_number():
    assert checked(speed=2).speed == 2.0
    assert isinstance(checked(speed=2).speed, float)
    assert "'count' is 2.0; it must be a whole number from 1 to 10" in refusal(count=2.0)


def test_a_list_may_be_any_sequence_of_numbers():
    for given in ((1, 2, 3), [1, 2.0, 3], range(1, 4)):
        pose = checked(pose=given).pose
        assert pose == [1.0, 2.0, 3.0]
        assert all(isinstance(number, float) for number in pose)


@pytest.mark.parametrize(
    ('name', 'value', 'valid'),
    [
        ('bounds', 5.0, '4 finite numbers, or none'),
        ('bounds', math.nan, '4 finite numbers, or none'),
        ('bounds', None, '4 finite numbers, or none'),
        ('bounds', '', '4 finite numbers, or none'),
        ('flag', 1, 'true or false'),
        ('flag', 'true', 'true or false'),
        ('flag', None, 'true or false'),
        ('count', True, 'a whole number from 1 to 10'),
        ('count', 0, 'a whole number from 1 to 10'),
        ('count', 11, 'a whole number from 1 to 10'),
        ('count', '3', 'a whole number from 1 to 10'),
        ('speed', False, 'a finite number of at least 0 m/s'),
        ('speed', -1e-9, 'a finite number of at least 0 m/s'),
        ('speed', math.nan, 'a finite number of at least 0 m/s'),
        ('speed', math.inf, 'a finite number of at least 0 m/s'),
        ('speed', '1', 'a finite number of at least 0 m/s'),
        ('depth', 0.1, 'a finite number of at most 0 m'),
        ('free', math.nan, 'a finite number'),
        ('free', -math.inf, 'a finite number'),
        ('free', None, 'a finite number'),
        ('name', 3, 'a text'),
        ('mode', 'fly', 'one of walk, stand'),
        ('mode', 1, 'one of walk, stand'),
        ('pose', [1.0, 2.0], '3 finite numbers'),
        ('pose', [1.0, 2.0, 3.0, 4.0], '3 finite numbers'),
        ('pose', [], '3 finite numbers'),
        ('pose', 1.0, '3 finite numbers'),
        ('pose', [1.0, 2.0, math.nan], '3 finite numbers'),
        ('pose', [1.0, 2.0, 'x'], '3 finite numbers'),
        ('pose', [1.0, 2.0, None], '3 finite numbers'),
        ('pose', [1.0, 2.0, True], '3 finite numbers'),
        ('pose', '123', '3 finite numbers'),
        ('bounds', [0.0, 0.0], '4 finite numbers, or none'),
    ],
)
def test_a_value_that_is_not_valid_is_told_with_what_would_be(name, value, valid):
    sentence = refusal(**{name: value})
    assert sentence.startswith(f"'{name}' is ")
    assert sentence.endswith(f'; it must be {valid}')


def test_a_parameter_that_does_not_exist_is_refused_with_those_that_do():
    assert refusal(velocity=1.0).endswith(
        'it must be left out; '
        'parameters are flag, count, speed, depth, free, name, mode, pose, bounds'
    )


def test_defaults_that_are_lists_are_not_shared():
    Sample().pose[0] = 9.0
    assert Sample().pose == checked().pose == [1.0, 2.0, 3.0]


def test_the_range_is_said_in_a_few_words():
    told = {entry.name: valid_range(entry) for entry in parameters_of(Sample)}
    assert told == {
        'flag': '',
        'count': '1 to 10',
        'speed': 'at least 0',
        'depth': 'at most 0',
        'free': '',
        'name': '',
        'mode': 'walk, stand',
        'pose': '3 numbers',
        'bounds': '4 numbers, or none',
    }


def defaults(table):
    return {entry.name: entry.default for entry in parameters_of(table)}


@pytest.mark.parametrize(('node', 'table'), [*TABLES.items(), ('sample_node', Sample)])
def test_the_parameter_file_holds_the_defaults(node, table):
    text = yaml_from_parameters(node, parameters_of(table))
    values = yaml.safe_load(text)[f'/**/{node}']['ros__parameters']
    assert values == defaults(table)
    assert {name: type(v) for name, v in values.items()} == {
        name: type(v) for name, v in defaults(table).items()
    }
    assert checked_parameters(table, values) == table()


@pytest.mark.parametrize(('node', 'table'), TABLES.items())
def test_the_parameter_file_describes_every_parameter(node, table):
    text = yaml_from_parameters(node, parameters_of(table))
    for entry in parameters_of(table):
        assert f'    # {entry.description}' in text
        assert entry.description.endswith('.')


@pytest.mark.parametrize('table', TABLES.values(), ids=TABLES)
def test_every_default_is_valid(table):
    assert checked_parameters(table, defaults(table)) == checked_parameters(table, {}) == table()


@pytest.mark.parametrize(('node', 'table'), TABLES.items())
def test_the_file_in_config_is_the_one_that_is_generated(node, table):
    in_config = (CONFIG / f'{node}.yaml').read_text(encoding='utf-8')
    generated = yaml_from_parameters(node, parameters_of(table))
    assert in_config == generated, f'write it with: quadwalk parameters {node}'


def test_awkward_values_survive_the_file():
    @dataclass(frozen=True)
    class Awkward:
        tiny: float = parameter(1e-05, 'Small.')
        huge: float = parameter(1e20, 'Large.')
        text: str = parameter("it's", 'With an apostrophe.')
        empty: str = parameter('', 'Empty.')

    text = yaml_from_parameters('node', parameters_of(Awkward))
    assert yaml.safe_load(text)['/**/node']['ros__parameters'] == defaults(Awkward)
