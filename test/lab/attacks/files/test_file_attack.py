"""Law: no file and no argument ends in a traceback, in a hang, or as nonsense that is believed."""

import dataclasses
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

import quad_lab.attacks.files.file_cases as cases
from quad_cli.main import main
from quad_common.errors import (
    CameraValueOutOfRange,
    MapValueOutOfRange,
    OutOfRange,
    QuadError,
    RobotValueOutOfRange,
)
from quad_lab.attacks.files.argument_cases import (
    COMMANDS,
    CommandLine,
    run_in_process,
    without_work,
)
from quad_lab.attacks.files.file_attack import attack_files
from quad_lab.attacks.files.file_cases import ARGUMENTS, HANG, NAMES, NONSENSE, TRACEBACK, run_case
from quad_lab.attacks.files.file_kinds import KINDS
from quad_lab.attacks.files.file_worker import Worker
from quad_lab.attacks.files.hostile import NUMBERS, OTHERS, changed_document

ROOT = Path(__file__).resolve().parents[4]

DOCUMENTS = [kind for kind in KINDS if kind.is_document]
each_document = pytest.mark.parametrize('kind', DOCUMENTS, ids=lambda kind: kind.name)
each_kind = pytest.mark.parametrize('kind', KINDS, ids=lambda kind: kind.name)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refusal(kind, path):
    with pytest.raises(QuadError) as caught:
        kind.read(path)
    sentence = str(caught.value)
    assert '\n' not in sentence
    assert len(sentence) < 2000
    assert str(path.parent) in sentence
    return caught.value


@pytest.mark.parametrize('name', NAMES)
def test_a_sample_of_the_attack_finds_nothing(folder, name):
    for index in range(6):
        assert run_case(7, name, index, cases.emptied(folder)) is None


@each_kind
@pytest.mark.parametrize('number', [0, 1])
def test_the_examples_are_valid(folder, kind, number):
    kind.read(kind.write(folder, number))


@each_document
def test_what_is_no_document_is_refused_in_a_sentence_with_its_name(folder, kind):
    path = kind.write(folder, 0)
    for content in (
        b'a: ' + b'9' * 310,
        b'a: ' + b'[' * 3000,
        b'a: 2001-99-99',
        b'a: 1\0',
        b'\xff\xfe\x00',
        f'a: {next(text for text in OTHERS if text.startswith("[&a"))}'.encode(),
        b'- 1',
        b'',
    ):
        path.write_bytes(content)
        refusal(kind, path)
    path.unlink()
    path.mkdir()
    refusal(kind, path)


@each_document
def test_a_number_outside_its_range_is_refused_with_the_facts(folder, kind):
    # The first place of the example with a range, and a number just above it.
    path = kind.write(folder, 0)
    document = yaml.safe_load(path.read_text())
    key, range_ = next(
        (key, kind.range_of(key)) for key in places(document) if kind.range_of(key) is not None
    )
    node = document
    for name in key[:-1]:
        node = node[name]
    node[key[-1]] = range_.upper * 1.1 if isinstance(node[key[-1]], float) else 10**9
    path.write_text(yaml.safe_dump(document))
    error = refusal(kind, path)
    assert isinstance(error, OutOfRange)
    assert error.value == node[key[-1]]
    assert (error.lower, error.upper, error.unit) == (range_.lower, range_.upper, range_.unit)
    assert error.name
    kinds = {'map': MapValueOutOfRange, 'height map': MapValueOutOfRange}
    kinds |= {'robot': RobotValueOutOfRange, 'camera': CameraValueOutOfRange}
    kinds |= {'colors': CameraValueOutOfRange}
    assert isinstance(error, kinds.get(kind.name, OutOfRange))


def places(node, key=()):
    if isinstance(node, (dict, list)):
        for name, child in node.items() if isinstance(node, dict) else enumerate(node):
            yield from places(child, (*key, name))
    else:
        yield key


@each_document
def test_a_key_that_means_nothing_is_refused(folder, kind):
    path = kind.write(folder, 0)
    if kind.may_have(('moon',)):
        return
    path.write_text(path.read_text() + '\nmoon: {value: 1, source: x}\n')
    assert "'moon' means nothing; valid keys are " in str(refusal(kind, path))


@pytest.mark.parametrize('kind', [k for k in KINDS if k.image], ids=lambda kind: kind.name)
def test_an_image_that_is_none_is_refused_without_waiting(folder, kind):
    path = kind.write(folder, 0)
    image = folder / kind.image
    content = image.read_bytes()
    for make in (os.mkfifo, os.mkdir, lambda at: at.write_bytes(content[: len(content) // 2])):
        image.unlink() if image.is_file() else None
        make(image)
        assert str(image) in str(refusal(kind, path))
        shutil.rmtree(image) if image.is_dir() else image.unlink()


def test_a_small_file_with_a_picture_of_gigabytes_is_refused(folder):
    # The head alone: what would follow is not looked at.
    kind = next(kind for kind in KINDS if kind.name == 'map')
    path = kind.write(folder, 0)
    (folder / 'map.pgm').write_bytes(b'P5\n60000 60000\n255\n' + bytes(1000))
    refusal(kind, path)
    (folder / 'map.pgm').write_bytes(b'P5\n12000 12000\n255\n' + bytes(1000))
    assert 'has 12000 x 12000 pixels' in str(refusal(kind, path))


def test_a_reader_that_lets_exceptions_out_is_found(folder, monkeypatch):
    def read(path):
        raise KeyError(path)

    replace_reader(monkeypatch, read)
    assert {run_case(0, 'pace', k, cases.emptied(folder)).what for k in range(5)} == {TRACEBACK}


def test_a_reader_that_believes_everything_is_found(folder, monkeypatch):
    replace_reader(monkeypatch, lambda path: None)
    found = [run_case(0, 'pace', k, cases.emptied(folder)) for k in range(60)]
    assert {fault.what for fault in found if fault} == {NONSENSE}
    assert sum(fault is not None for fault in found) > 6


def test_what_is_read_as_infinite_is_found(folder, monkeypatch):
    replace_reader(monkeypatch, lambda path: {'a': [np.array([np.inf])]})
    found = [run_case(0, 'pace', k, cases.emptied(folder)) for k in range(5)]
    assert all(fault.what == NONSENSE for fault in found)


def replace_reader(monkeypatch, read):
    kinds = [dataclasses.replace(k, read=read) if k.name == 'pace' else k for k in KINDS]
    monkeypatch.setattr(cases, 'KINDS', tuple(kinds))


def test_a_case_is_drawn_from_its_seed_and_number_alone():
    document = {'a': 1.0, 'b': {'c': [1, 2, 3]}}
    drawn = [changed_document(np.random.default_rng((3, k)), document) for k in range(40)]
    again = [changed_document(np.random.default_rng((3, k)), document) for k in reversed(range(40))]
    assert drawn == again[::-1]
    assert document == {'a': 1.0, 'b': {'c': [1, 2, 3]}}
    assert len({content for content, _ in drawn}) > 20


def test_a_case_that_takes_too_long_is_ended_and_the_next_one_is_tried():
    with Worker(0) as worker:
        assert worker.run('points', 0, 0.0).what == HANG
        assert worker.run('points', 0, 30.0) is None


def test_an_attack_counts_its_cases():
    told = []
    result = attack_files(0, 2, lambda *done: told.append(done), kinds=('points', 'colors'))
    assert (result.cases, result.faults, result.kept()) == (4, [], [])
    assert told == [('points', 1, 2), ('points', 2, 2), ('colors', 1, 2), ('colors', 2, 2)]


@pytest.mark.sweep(kept=8)
@pytest.mark.parametrize('words', COMMANDS, ids=' '.join)
def test_the_command_lines_that_are_changed_reach_their_work(folder, words, capsys):
    cases.write_all(folder)
    with without_work():
        assert run_in_process(CommandLine(words, must_fail=False)) == ''


@pytest.mark.sweep(kept=9)
@pytest.mark.parametrize(
    'words',
    [
        ('plan', '--start', '1e300,0,0', '--goal', '1,1,0'),
        ('plan', '--start', '1,1,0', '--goal', '1,1,inf'),
        ('plan', '--start', '1,1,0', '--goal', '2,2,0', '--safety-distance', '1e300'),
        ('plan', '--start', '1,1,0', '--goal', '2,2,0', '--step-height', 'nan'),
        ('plan', '--start', '1,1,0', '--goal', '2,2,0', '--picture', 'plan.xyz'),
        ('plan', '--start', '1,1,0', '--goal', '2,2,0', '--map', '~no_such_user/map.yaml'),
        ('plan', '--start', '1,1,0', '--goal', '2,2,0', '--map', 'x' * 5000),
        ('demo', '--seed', '9' * 5000),
        ('demo', '--terrain', 'bumps:seed=' + '9' * 5000),
        ('demo', '--terrain', 'bumps+' * 500 + 'bumps'),
        ('demo', '--goal', '1000,0,0'),
        ('demo', '--robot', 'pipe'),
        ('demo', '--output', 'bad.yaml'),
        ('demo', '--real-time-factor', '-1'),
        ('bench', 'walk', '--seed', '-1'),
        ('calibrate', '--motion', '1e300,0,0'),
        ('calibrate', '--output', 'pipe'),
        ('gait', 'check', 'crawl', '--least-margin', 'inf'),
        ('gait', 'pace', '--output', ''),
        ('camera', 'masks', 'pipe'),
        ('camera', 'masks', '/dev/zero'),
        ('camera', 'masks', 'room.png', '--output', 'folder'),
        ('camera', 'map', 'room.png', '--camera', 'camera.yaml', '--resolution', '1e-300'),
        ('camera', 'map', 'room.png', '--camera', 'camera.yaml', '--bounds', '0,0,1e300,1'),
        ('camera', 'map', 'room.png', '--camera', 'camera.yaml', '--every', '9' * 5000),
        ('camera', 'calibrate', '--camera', 'camera.yaml', '--points', 'pipe'),
        ('reproduce', 'S3', '--output', 'room.png/x'),
    ],
    ids=lambda words: ' '.join(words)[:60],
)
def test_wrong_arguments_end_in_one_sentence_with_code_2(folder, capsys, words):
    cases.write_all(folder)
    try:
        code = main(list(words))
    except SystemExit as end:
        code = end.code
    last = capsys.readouterr().err.strip().splitlines()[-1]
    assert code == 2
    assert 'error: ' in last
    assert len(last) < 1000


def test_the_hostile_values_stay_hostile():
    # Kept apart: a number is compared with the range of its place, anything else is not.
    assert not set(NUMBERS) & set(OTHERS)
    assert ARGUMENTS in NAMES


def test_a_disk_that_is_full_is_told_in_a_sentence(monkeypatch, capsys):
    def run(arguments):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr('quad_cli.parameters.run', run)
    assert main(['parameters', 'gait_node']) == 2
    assert capsys.readouterr().err == 'error: [Errno 28] No space left on device\n'


def test_a_closed_output_is_no_reason_to_fail(monkeypatch):
    monkeypatch.setattr('sys.stdout', None)
    assert main(['parameters', 'gait_node']) == 0


KILLED = """
import time
from quad_lab.attacks.files.file_worker import Worker
if __name__ == '__main__':
    with Worker(0) as worker:
        worker.run('robot', 0, 60.0)
        print(worker.folder, flush=True)
        time.sleep(60)
"""


@pytest.mark.slow
def test_an_attack_that_is_killed_leaves_nothing_once_the_next_begins(tmp_path, monkeypatch):
    monkeypatch.setenv('TMPDIR', str(tmp_path))
    monkeypatch.setattr(tempfile, 'tempdir', None)
    script = tmp_path / 'attack.py'
    script.write_text(KILLED)
    attack = subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, 'PYTHONPATH': str(ROOT)},
    )
    folder = Path(attack.stdout.readline().strip())
    workers = [
        int(pid)
        for thread in Path(f'/proc/{attack.pid}/task').iterdir()
        for pid in (thread / 'children').read_text().split()
    ]
    attack.kill()
    attack.communicate(timeout=60)
    assert folder.exists()
    with Worker(0) as worker:
        assert not folder.parent.exists()
        assert worker.folder.exists()
    assert [path.name for path in tmp_path.iterdir()] == ['attack.py']
    assert workers
    assert ended_within(workers, 10.0)


def ended_within(pids: list[int], timeout: float) -> bool:
    """Return whether all these processes have ended before the timeout [s]."""
    end = time.monotonic() + timeout
    while any(Path(f'/proc/{pid}').exists() for pid in pids):
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True
