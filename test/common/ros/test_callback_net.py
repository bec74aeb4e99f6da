"""Nothing but the end of Python itself passes the net under callbacks."""

import pytest

from quad_common.errors import MapError, QuadError
from quad_common.ros.callback_net import CallbackNet


class Listener:
    def __init__(self, is_broken=False):
        self.errors = []
        self.unexpected = []
        self.is_broken = is_broken

    def report_error(self, error):
        if self.is_broken:
            raise OSError('the topic is gone')
        self.errors.append(str(error))

    def report_unexpected(self, sentence, kind, stack):
        if self.is_broken:
            raise OSError('the topic is gone')
        self.unexpected.append((sentence, kind, stack))


def raising(error):
    def callback():
        raise error

    return callback


def test_what_a_callback_returns_comes_through():
    listener = Listener()
    assert CallbackNet(listener).call('a message', lambda: 7, lambda sentence: 0) == 7
    assert not listener.errors
    assert not listener.unexpected


def test_what_is_refused_on_purpose_is_reported_as_it_is():
    listener = Listener()
    answer = CallbackNet(listener).call('a message', raising(MapError('no map')), str.upper)
    assert answer == 'NO MAP'
    assert listener.errors == ['no map']


@pytest.mark.parametrize(
    'error', [ValueError('x'), OverflowError(34, 'range'), MemoryError(), RecursionError('deep')]
)
def test_whatever_else_is_raised_becomes_a_sentence_with_its_kind_and_place(error):
    listener = Listener()
    sentence = CallbackNet(listener).call("a message on 'odom'", raising(error), str)
    assert sentence.startswith(f"a message on 'odom' led to an unexpected {type(error).__name__}")
    assert 'test_callback_net.py:' in sentence
    assert '(callback)' in sentence
    assert listener.unexpected[0][:2] == (sentence, type(error).__name__)


def test_the_stack_comes_once_a_kind_and_the_sentence_each_time():
    listener = Listener()
    net = CallbackNet(listener)
    for error in (ValueError('a'), ValueError('b'), TypeError('c'), ValueError('d')):
        net.call('a message', raising(error), str)
    stacks = [stack is not None for _, _, stack in listener.unexpected]
    assert stacks == [True, False, True, False]
    assert listener.unexpected[0][2].startswith('Traceback (most recent call last)')


@pytest.mark.parametrize('error', [KeyboardInterrupt(), SystemExit(3)])
def test_the_end_of_python_passes(error):
    listener = Listener()
    with pytest.raises(type(error)):
        CallbackNet(listener).call('a message', raising(error), str)
    assert not listener.unexpected


@pytest.mark.parametrize('error', [MapError('no map'), ValueError('x')])
def test_who_cannot_be_told_ends_nothing_and_the_console_hears_of_it_once(error, capsys):
    net = CallbackNet(Listener(is_broken=True))
    for _ in range(3):
        assert net.call('a message', raising(error), lambda sentence: 'failed') == 'failed'
    assert capsys.readouterr().err.count("OSError: 'the topic is gone'") == 1


def test_a_hostile_text_goes_into_neither_sentence_nor_stack_as_a_whole():
    listener = Listener()
    sentence = CallbackNet(listener).call('a message', raising(ValueError('x' * 10**7)), str)
    assert len(sentence) < 600
    assert len(listener.unexpected[0][2]) < 2000


def test_an_error_that_cannot_write_itself_ends_nothing():
    class Mute(Exception):
        def __str__(self):
            raise RuntimeError

    class MuteRefusal(QuadError):
        def __str__(self):
            raise RuntimeError

    listener = Listener()
    for error in (Mute(), MuteRefusal()):
        sentence = CallbackNet(listener).call('a message', raising(error), str)
        assert type(error).__name__ in sentence
