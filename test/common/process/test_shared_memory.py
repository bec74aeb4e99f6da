"""What Fast DDS left in shared memory is removed when nobody holds it, and only then."""

from __future__ import annotations

import fcntl
import os
import time

import pytest

from quad_common.process import shared_memory


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """Have it look where no Fast DDS is."""
    monkeypatch.setattr(shared_memory, 'FOLDER', tmp_path)
    return tmp_path


def make(place, name: str, age: float = 60.0) -> None:
    """Make the files of a segment or of a port."""
    for part in (name, f'{name}_el', f'sem.{name}_mutex'):
        (place / part).write_text('')
        os.utime(place / part, (time.time() - age,) * 2)


def lock(place, name: str) -> int:
    handle = os.open(place / f'{name}_el', os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    return handle


def test_what_is_held_stays_and_what_nobody_holds_goes(place):
    for name in ('fastrtps_0123456789abcdef', 'fastrtps_port7411'):
        make(place, name)
    handle = lock(place, 'fastrtps_port7411')
    shared_memory.remove_ownerless()
    assert {path.name for path in place.iterdir()} == {
        'fastrtps_port7411', 'fastrtps_port7411_el', 'sem.fastrtps_port7411_mutex'
    }  # fmt: skip
    os.close(handle)
    shared_memory.remove_ownerless()
    assert list(place.iterdir()) == []


def test_what_is_just_being_made_and_what_is_of_others_stays(place):
    make(place, 'fastrtps_0123456789abcdef', age=0.0)
    (place / 'theirs_el').write_text('')
    shared_memory.remove_ownerless()
    assert len(list(place.iterdir())) == 4


def test_a_process_knows_what_is_its_own(place):
    for name in ('fastrtps_a', 'fastrtps_b'):
        make(place, name)
    assert shared_memory.files_of(os.getpid()) == []
    handle = lock(place, 'fastrtps_a')
    try:
        assert shared_memory.files_of(os.getpid()) == [place / 'fastrtps_a_el']
        shared_memory.release_own()
    finally:
        os.close(handle)
    assert sorted(path.name for path in place.iterdir()) == [
        'fastrtps_b', 'fastrtps_b_el', 'sem.fastrtps_b_mutex'
    ]  # fmt: skip
