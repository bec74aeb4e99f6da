"""The queue answers every request, in order and in its owner's thread, and refuses too many."""

import queue
import threading

import pytest

from quad_common.errors import TooManyRequests
from quad_planner.session import request_queue
from quad_planner.session.request_queue import RequestQueue


@pytest.fixture
def owner():
    """A queue of what is to be called in the owner's thread."""
    return queue.SimpleQueue()


@pytest.fixture
def worker(owner):
    requests = RequestQueue(owner.put)
    yield requests
    requests.close()


def test_every_request_is_answered_in_its_turn(worker, owner):
    answers = []
    for number in range(5):
        worker.submit(
            lambda number=number: (number, threading.get_ident()),
            lambda result: answers.append((*result(), threading.get_ident())),
        )
    for _ in range(5):
        assert worker.is_busy
        owner.get(timeout=60.0)()
    assert [number for number, _, _ in answers] == list(range(5))
    worked_in, answered_in = ({answer[k] for answer in answers} for k in (1, 2))
    assert answered_in == {threading.get_ident()}
    assert not worked_in & answered_in
    assert not worker.is_busy


def test_what_the_work_raises_is_raised_in_the_owners_thread(worker, owner):
    def fail():
        raise ValueError('no')

    def done(result):
        with pytest.raises(ValueError, match='no'):
            result()
        answered.append(True)

    answered = []
    worker.submit(fail, done)
    owner.get(timeout=60.0)()
    assert answered


def test_too_many_requests_are_refused_and_those_that_wait_are_not(worker, owner, monkeypatch):
    monkeypatch.setattr(request_queue, '_MOST', 3)
    released, answers = threading.Event(), []
    for _ in range(3):
        worker.submit(lambda: released.wait(60.0), lambda result: answers.append(result()))
    with pytest.raises(TooManyRequests, match='3 requests for plans wait already'):
        worker.submit(lambda: True, lambda result: answers.append(result()))
    released.set()
    for _ in range(3):
        owner.get(timeout=60.0)()
    assert answers == [True] * 3
    worker.submit(lambda: True, lambda result: answers.append(result()))
    owner.get(timeout=60.0)()
    assert len(answers) == 4


def test_nothing_is_answered_after_its_end(worker, owner):
    answers = []
    worker.submit(lambda: True, lambda result: answers.append(result()))
    deliver = owner.get(timeout=60.0)
    worker.close()
    assert worker.is_superseded()
    deliver()
    assert answers == []
