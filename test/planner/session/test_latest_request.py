"""The worker answers the latest request, in its owner's thread, and gives up the others."""

import queue
import threading

import pytest

from quad_planner.session.latest_request import LatestRequest


@pytest.fixture
def owner():
    """A queue of what is to be called in the owner's thread."""
    return queue.SimpleQueue()


@pytest.fixture
def worker(owner):
    requests = LatestRequest(owner.put)
    yield requests
    requests.close()


def test_a_request_is_answered_in_the_owners_thread(worker, owner):
    answers = []
    worker.submit(
        threading.get_ident, lambda result: answers.append((result(), threading.get_ident()))
    )
    assert worker.is_busy
    owner.get(timeout=60.0)()
    (worked_in, answered_in) = answers[0]
    assert worked_in != answered_in == threading.get_ident()
    assert not worker.is_busy


def test_what_the_work_raises_is_raised_in_the_owners_thread(worker, owner):
    caught = []

    def fail():
        raise ValueError('no')

    def done(result):
        with pytest.raises(ValueError, match='no') as info:
            result()
        caught.append(info.value)

    worker.submit(fail, done)
    owner.get(timeout=60.0)()
    assert len(caught) == 1


def test_a_newer_request_ends_what_runs_and_is_the_only_one_answered(worker, owner):
    began = threading.Event()
    answers = []

    def search():
        began.set()
        while not worker.is_superseded():
            pass
        return 'given up'

    worker.submit(search, lambda result: answers.append(result()))
    assert began.wait(60.0)
    worker.submit(lambda: 'skipped', lambda result: answers.append(result()))
    worker.submit(lambda: 'latest', lambda result: answers.append(result()))
    for _ in range(3):
        owner.get(timeout=60.0)()
    assert answers == ['latest']


def test_outside_its_work_nothing_is_superseded(worker, owner):
    worker.submit(lambda: None, lambda result: result())
    worker.submit(lambda: None, lambda result: result())
    assert not worker.is_superseded()


def test_work_may_ask_any_worker_and_what_is_old_before_it_begins_is_not_done(worker, owner):
    other, done = LatestRequest(owner.put), []
    began = threading.Event()

    def search():
        began.set()
        # A planner asks the worker that it was made with, whoever works with it.
        while not other.is_superseded():
            pass
        done.append('given up')

    worker.submit(search, lambda result: result())
    assert began.wait(60.0)
    worker.submit(lambda: done.append('old'), lambda result: result())
    worker.submit(lambda: done.append('latest'), lambda result: result())
    for _ in range(3):
        owner.get(timeout=60.0)()
    assert done == ['given up', 'latest']
    other.close()


def test_closing_ends_what_runs():
    answers = queue.SimpleQueue()
    requests = LatestRequest(answers.put)
    began, ended = threading.Event(), threading.Event()

    def search():
        began.set()
        while not requests.is_superseded():
            pass
        ended.set()

    requests.submit(search, lambda result: result())
    assert began.wait(60.0)
    requests.close()
    assert ended.wait(10.0)
    assert not requests.is_busy or answers.get(timeout=60.0)() is None
