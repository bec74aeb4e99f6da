"""What was received is quoted on one line, and never at length."""

import math

import pytest

from quad_common.errors import (
    InvalidPlanner,
    JointNotFound,
    ParameterError,
    WrongFrame,
)
from quad_common.errors.quoting import LONGEST_SENTENCE, clipped, escaped, quoted, shown

HOSTILE = {
    'giant': 'x' * 10**7,
    'line ends': 'a\nb\r\x85c\u2028d',
    'control characters': '\x00\x1b[31m\x07\x7f',
    'lone surrogate': '\ud800',
    'right to left override': 'map\u202egoal',
    'giant and nasty': '\x00' * 10**7,
}


@pytest.mark.parametrize('text', HOSTILE.values(), ids=HOSTILE)
def test_a_quotation_is_printable_on_one_line_and_short(text):
    for sentence in (quoted(text), shown(text), clipped(text)):
        assert sentence.isprintable()
        assert len(sentence) <= LONGEST_SENTENCE
        assert sentence.encode('utf-8')
    assert len(quoted(text)) < 240


def test_ordinary_text_is_quoted_as_it_is():
    for text in ('map', 'odom', 'Zürich', '', "it's"):
        assert quoted(text) == f"'{text}'"
        assert escaped(text) == clipped(text) == text


def test_of_a_text_that_is_too_long_its_length_is_said():
    assert quoted('y' * 201) == f"'{'y' * 200}' ... (201 characters)"


def test_of_a_sentence_that_is_too_long_both_ends_are_kept():
    sentence = clipped('the beginning ' + 'x' * 10**6 + ' must be from 0 to 1')
    assert sentence.startswith('the beginning xxx')
    assert sentence.endswith('xxx must be from 0 to 1')
    assert len(sentence) == LONGEST_SENTENCE


@pytest.mark.parametrize(
    ('value', 'text'),
    [(10**5000, '16610 bits'), ([0.0] * 10**5, 'characters)'), (math.nan, 'nan'), ('a', "'a'")],
    ids=['integer', 'list', 'nan', 'text'],
)
def test_any_value_is_shown(value, text):
    assert text in shown(value)
    assert len(shown(value)) < 240


def test_a_value_that_cannot_write_itself_is_shown_by_its_type():
    class Mute:
        def __repr__(self):
            raise RuntimeError

    assert shown(Mute()) == 'a Mute that cannot be shown (RuntimeError)'


@pytest.mark.parametrize('text', HOSTILE.values(), ids=HOSTILE)
def test_errors_quote_what_they_are_given_briefly(text):
    for error in (
        WrongFrame('goal', text, 'map'),
        WrongFrame('goal', 'moon', text),
        JointNotFound(text, ['a', 'b']),
        JointNotFound('tail', [text] * 100),
        JointNotFound('tail', (str(number) for number in range(10**5))),
        InvalidPlanner(text, ['mesh']),
        ParameterError('gait', text, 'a name'),
    ):
        assert str(error).isprintable()
        # Forty names of sixty characters are the most, each up to ten once it is escaped.
        assert len(str(error)) < (3000 if text.isprintable() else 25000)


def test_of_many_names_some_are_listed_and_the_rest_is_counted():
    assert str(JointNotFound('tail', [f'joint_{n:03d}' for n in range(1000)])).endswith(
        'joint_039 and 960 more'
    )
