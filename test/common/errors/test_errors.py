"""Errors carry facts, and make one sentence of them."""

import ast
import importlib
import inspect
import pickle
from pathlib import Path

import pytest

from quad_common.errors import QuadError
from quad_common.errors.descriptions import DescriptionError
from quad_common.errors.perception import PictureFileError
from quad_common.errors.robots import RobotFileError
from quad_common.planar_pose import Pose2D

ROOT = Path(__file__).parents[3]
SOURCES = sorted(path for package in ROOT.glob('quad_*') for path in package.rglob('*.py'))

SAMPLES = {
    'str': 'front',
    'float': 0.25,
    'int': 3,
    'bool': True,
    'object': ['given'],
    'Path': Path('a.yaml'),
    'Pose2D': Pose2D(1.0, 2.0, 0.5),
    'Index': 2,
    'QuadError': QuadError('it is wrong'),
    'str | PathLike[str]': Path('a.yaml'),
    'Iterable[str]': ('one', 'two'),
    'Sequence[str]': ('one', 'two'),
    'Sequence[float]': (0.1, 0.2, 0.3, 0.4),
    'Sequence[Sequence[float]]': [(0.1, 0.2), (0.3, 0.4)],
    'list[object]': [2, 3],
    'tuple[str, ...]': ('one', 'two'),
    'tuple[int, ...]': (2, 3),
    'tuple[int, int]': (4, 5),
    'tuple[float, ...]': (0.1, 0.2),
    'tuple[float, float]': (0.1, 0.2),
    'tuple[float, float] | None': (0.1, 0.2),
    'tuple[float, float, float, float]': (0.1, 0.2, 0.3, 0.4),
}
"""A fact of each type that errors take."""


def defined_errors():
    """Every class of errors in the tree, found by the modules that know the base."""
    for path in SOURCES:
        if path.name != '__main__.py' and 'quad_common.errors' in path.read_text(encoding='utf-8'):
            name = '.'.join(path.relative_to(ROOT).with_suffix('').parts)
            importlib.import_module(name.removesuffix('.__init__'))
    found, waiting = set(), [QuadError]
    while waiting:
        kind = waiting.pop()
        if kind.__module__.startswith('quad_'):
            found.add(kind)
            waiting += kind.__subclasses__()
    return sorted(found, key=lambda kind: (kind.__module__, kind.__name__))


ERRORS = defined_errors()
WITH_A_FACT = (DescriptionError, PictureFileError, RobotFileError)
"""Categories with a fact that all their errors have."""
CATEGORIES = [kind for kind in ERRORS if kind.__init__ is Exception.__init__ or kind in WITH_A_FACT]
FAULTS = [kind for kind in ERRORS if kind not in CATEGORIES]


def made(kind):
    """Make an error from facts; return both."""
    parameters = inspect.signature(kind).parameters.values()
    facts = {each.name: SAMPLES[each.annotation] for each in parameters}
    return kind(**facts), facts


def test_there_are_errors_of_both_kinds():
    assert len(CATEGORIES) > 8
    assert len(FAULTS) > 100


@pytest.mark.parametrize('kind', FAULTS)
def test_an_error_has_its_facts_as_attributes(kind):
    error, facts = made(kind)
    assert {name for name in facts if not hasattr(error, name)} == set()


@pytest.mark.parametrize('kind', FAULTS)
def test_an_error_makes_one_sentence(kind):
    text = str(made(kind)[0])
    # What a node says last is quoted below the sentence.
    sentence = text.removesuffix('\nfront')
    assert sentence
    assert sentence == ' '.join(sentence.split())
    assert not sentence.endswith('.')


@pytest.mark.parametrize('kind', FAULTS)
def test_an_error_comes_out_of_a_worker_process_as_it_went_in(kind):
    error, _ = made(kind)
    same = pickle.loads(pickle.dumps(error))
    assert type(same) is kind
    assert str(same) == str(error)
    assert same.__dict__.keys() == error.__dict__.keys()


def test_no_error_is_made_of_prose():
    """A category says of what kind an error is: one that takes a sentence has no facts."""
    names = {kind.__name__ for kind in CATEGORIES}
    prose = [
        f'{path.relative_to(ROOT)}:{node.lineno}'
        for path in SOURCES
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8')))
        if isinstance(node, ast.Call)
        and getattr(node.func, 'id', getattr(node.func, 'attr', '')) in names
    ]
    assert prose == []
