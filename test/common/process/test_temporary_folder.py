"""Temporary folders go with their process, or at the next start; nobody else's ever do."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from quad_common.process.temporary_folder import (
    ownerless_folders,
    remove_ownerless,
    temporary_folder,
)

ROOT = Path(__file__).resolve().parents[3]

OWNER = """
import time
from quad_common.process.temporary_folder import temporary_folder
with temporary_folder() as folder:
    (folder / 'node.log').write_text('words')
    print(folder, flush=True)
    time.sleep(60)
"""


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch) -> Path:
    """Have temporary folders made where no other process makes them."""
    monkeypatch.setenv('TMPDIR', str(tmp_path))
    monkeypatch.setattr(tempfile, 'tempdir', None)
    return tmp_path


def test_a_folder_goes_with_its_block(place):
    with temporary_folder() as folder:
        (folder / 'file').write_text('words')
        assert folder.parent == place
        assert ownerless_folders() == []
    assert list(place.iterdir()) == []


def test_a_living_process_keeps_its_folder_and_a_killed_one_loses_it():
    owner = subprocess.Popen(
        [sys.executable, '-c', OWNER], stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    folder = Path(owner.stdout.readline().strip())
    remove_ownerless()
    assert (folder / 'node.log').exists()
    owner.send_signal(signal.SIGKILL)
    owner.communicate(timeout=60)
    assert ownerless_folders() == [folder]
    with temporary_folder():
        assert not folder.exists()


def test_what_was_made_by_others_stays(place):
    for name, content in (('quadwalk_theirs', None), ('quadwalk_new', '')):
        (place / name).mkdir()
        if content is not None:
            # Just being made: it is not yet locked.
            (place / name / 'owner.pid').write_text(content)
    (place / 'quadwalk_link').symlink_to(place / 'quadwalk_theirs')
    (place / 'quadwalk_file').write_text('words')
    remove_ownerless()
    assert len(list(place.iterdir())) == 4


INTERRUPTED = """
import os, signal, tempfile
from quad_common.process.end_signals import EndSignals, Interrupted, Raises
from quad_common.process.temporary_folder import temporary_folder
EndSignals(Raises(), lambda number: 128 + number, 10.0).install()
tempfile.gettempdir()
unlink = os.unlink
def interrupted_unlink(*args, **kwargs):
    os.kill(os.getpid(), signal.SIGTERM)
    unlink(*args, **kwargs)
os.unlink = interrupted_unlink
try:
    with temporary_folder() as folder:
        (folder / 'node.log').write_text('words')
except Interrupted as signal_:
    print(signal_.number)
"""


def test_a_signal_while_a_folder_is_removed_leaves_nothing(place):
    ended = subprocess.run(
        [sys.executable, '-c', INTERRUPTED], capture_output=True, text=True, cwd=ROOT, timeout=90
    )
    assert (ended.stdout, ended.stderr) == (f'{int(signal.SIGTERM)}\n', '')
    assert list(place.iterdir()) == []
