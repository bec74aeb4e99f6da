"""Law: whatever a file holds, it is read within bounds or refused in one sentence."""

import os
import time
from pathlib import Path

import pytest
import yaml

from quad_common.errors import FileUnusable, UnknownKey
from quad_common.files import yaml_document
from quad_common.files.bounded_file import (
    LARGEST_TEXT,
    check_folder_target,
    check_target,
    is_file,
    user_path,
)
from quad_common.files.whole_file import write_text
from quad_common.files.yaml_document import LARGEST_DEPTH, MOST_VALUES, check_keys, read_yaml

ROOT = Path(__file__).parents[3]


def read(tmp_path, text):
    path = tmp_path / 'a.yaml'
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_yaml(path, 'test file', 'keys')


def refusal(call, *arguments):
    with pytest.raises(FileUnusable) as caught:
        call(*arguments)
    assert '\n' not in str(caught.value)
    assert len(str(caught.value)) < 1000
    return str(caught.value)


def bomb(levels, width=9):
    """Aliases of aliases: width ** levels values in a few lines."""
    lines = ['a0: &a0 [1]']
    lines += [f'a{k}: &a{k} [{", ".join([f"*a{k - 1}"] * width)}]' for k in range(1, levels)]
    return '\n'.join(lines)


def test_plain_values_are_read_as_yaml_says(tmp_path):
    document = read(tmp_path, 'a: 1\nb: [0x10, 2.5, null, yes, x]\nc: {d: 2001-01-01}\n')
    assert document == {'a': 1, 'b': [16, 2.5, None, True, 'x'], 'c': {'d': '2001-01-01'}}


SHIPPED = sorted(
    path for folder in ('quad_common', 'config', 'maps') for path in (ROOT / folder).rglob('*.yaml')
)


@pytest.mark.parametrize('path', SHIPPED, ids=lambda path: path.name)
def test_libyaml_reads_what_is_shipped_as_python_does(path, monkeypatch):
    quick = read_yaml(path, 'test file', 'keys')
    monkeypatch.setattr(yaml_document, '_QUICK_LOADER', None)
    assert read_yaml(path, 'test file', 'keys') == quick


@pytest.mark.skipif(not yaml.__with_libyaml__, reason='PyYAML is built without libyaml')
def test_libyaml_parses_where_it_is_there(tmp_path, monkeypatch):
    monkeypatch.setattr(yaml_document, '_BoundedLoader', None)
    assert read(tmp_path, 'a: {b: [1, 2]}') == {'a': {'b': [1, 2]}}


def test_aliases_and_merges_are_read(tmp_path):
    document = read(tmp_path, 'a: &a {x: 1, y: 2}\nb: *a\nc: {<<: *a, y: 3}\n')
    assert document['b'] == {'x': 1, 'y': 2}
    assert document['c'] == {'x': 1, 'y': 3}


@pytest.mark.parametrize(
    ('text', 'told'),
    [
        ('', 'must hold keys'),
        ('- 1', 'must hold keys'),
        ('a: [1, 2', 'is not YAML'),
        ('a: 1\0', 'is not YAML: unacceptable character'),
        (b'a: \xff\xfe', 'is not UTF-8 from byte 3 on'),
        ('a: ' + '9' * 310, 'an integer of 310 digits'),
        ('a: ' + '9' * 5000, 'an integer of 5000 digits'),
        ('a: ' + '1:' * 200 + '1', 'an integer of 401 digits'),
        ('a: 18446744073709551616', 'integers have at most 64 bits'),
        ('a: ' + '[' * 3000, f'is nested deeper than {LARGEST_DEPTH}'),
        ('a: ' + '{b: ' * 3000, f'is nested deeper than {LARGEST_DEPTH}'),
        ('a: 1\nb: 2\na: 3\n', "the key 'a' is there twice (line 3, column 1)"),
        ('1: a', 'a key is not a text'),
        ('? [a]\n: b', 'a key is not a text'),
        ('a: &a [*a]', 'an alias stands in what it repeats'),
        ('a: *b', 'undefined alias'),
        (bomb(9), f'holds more than {MOST_VALUES} keys and values'),
        ('a: !!python/object:os.system x', 'is not YAML'),
        ('a: !!timestamp 2001-99-99', 'is not YAML'),
        ('a: !!int x', 'is not YAML'),
        ('a: !!int ""', 'is not YAML'),
        ('a: !!bool x', 'is not YAML'),
        ('a: !!float x', 'is not YAML'),
        ('a: 1\n---\nb: 2\n', 'is not YAML'),
        ('#' * (LARGEST_TEXT + 1), f'has more than {LARGEST_TEXT} bytes'),
        ('a: [' + '1,' * (MOST_VALUES + 1) + ']', f'holds more than {MOST_VALUES}'),
    ],
    ids=range(26),
)
def test_what_is_beyond_bounds_is_refused_at_once(tmp_path, text, told):
    began = time.process_time()
    sentence = refusal(read, tmp_path, text)
    assert time.process_time() - began < 2.0
    assert told in sentence
    assert sentence.startswith(f'test file {tmp_path / "a.yaml"} ')


def test_what_is_no_regular_file_is_refused_without_waiting(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'link').symlink_to(tmp_path / 'link')
    for name, told in (
        ('pipe', 'a pipe, not a file'),
        ('.', 'Is a directory'),
        ('/dev/zero', 'a device, not a file'),
        ('link', 'symbolic links'),
        ('none', 'No such file'),
        ('a\0b', 'null byte'),
        ('x' * 5000, 'File name too long'),
    ):
        assert told in refusal(read_yaml, tmp_path / name, 'test file', 'keys')
        assert not is_file(tmp_path / name)


def test_files_of_no_stated_length_are_read_to_the_limit_only():
    # Its size is 0 by its own account.
    assert '\n' not in refusal(read_yaml, Path('/proc/self/maps'), 'file', 'keys')


def test_the_home_of_nobody_is_refused():
    assert 'a user who does not exist' in refusal(user_path, '~no_such_user/a.yaml', 'map file')


def test_nothing_is_written_to_what_is_no_regular_file(tmp_path):
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'file').write_text('x')
    (tmp_path / 'link').symlink_to(tmp_path / 'nowhere' / 'file')
    for name, told in (
        ('pipe', 'a pipe, not a file'),
        ('.', 'a directory, not a file'),
        ('file/under', 'Not a directory'),
        ('link', 'No such file'),
        ('x' * 5000, 'File name too long'),
        ('a\0b', 'null byte'),
    ):
        assert told in refusal(write_text, tmp_path / name, 'text')
    check_target(tmp_path / 'new' / 'file')
    assert not (tmp_path / 'new').exists()
    write_text(tmp_path / 'file', 'ü')
    assert (tmp_path / 'file').read_text(encoding='utf-8') == 'ü'


def test_a_folder_for_results_is_one_or_can_be_made(tmp_path):
    (tmp_path / 'file').write_text('x')
    check_folder_target(tmp_path / 'a' / 'b')
    assert 'is not a folder' in refusal(check_folder_target, tmp_path / 'file')
    assert 'is not a folder' in refusal(check_folder_target, tmp_path / 'file' / 'b')


def test_a_key_that_means_nothing_is_named_beside_those_that_do():
    check_keys({'a': 1}, ('a', 'b'))
    with pytest.raises(UnknownKey) as caught:
        check_keys({'c': 1}, ('a', 'b'), 'part')
    assert (caught.value.key, caught.value.section, caught.value.known) == ('c', 'part', ('a', 'b'))
    assert "'part.c' means nothing; valid keys of 'part' are a, b" in str(caught.value)
