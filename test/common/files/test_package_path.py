"""
Packages are found by their manifests, whatever else may be called so.
"""

import os
import signal
from pathlib import Path

import pytest

from quad_common.files import package_path
from quad_common.files.package_path import package_candidates, package_name


@pytest.fixture
def no_waiting():
    """End a test that waits for a pipe: nobody ever writes to it."""

    def end(*_):
        raise AssertionError('it waits')

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(5)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def test_a_pipe_is_no_manifest(tmp_path, no_waiting):
    folder = tmp_path / 'my_robot' / 'urdf'
    folder.mkdir(parents=True)
    os.mkfifo(tmp_path / 'my_robot' / 'package.xml')
    assert package_name(tmp_path / 'my_robot') == ''
    candidates = package_candidates('package://zz/body.stl', folder)
    assert tmp_path / 'my_robot' / 'body.stl' not in candidates


def test_a_folder_is_no_manifest(tmp_path):
    (tmp_path / 'package.xml').mkdir()
    assert package_name(tmp_path) == ''


def test_manifests_are_read_up_to_a_bound(tmp_path):
    (tmp_path / 'package.xml').write_bytes(b' ' * 2**16 + b'<name>mine</name>')
    assert package_name(tmp_path) == tmp_path.name
    (tmp_path / 'package.xml').write_bytes(b' ' * 2**15 + b'<name>mine</name>')
    assert package_name(tmp_path) == 'mine'


@pytest.mark.parametrize(
    'name', ['a\0b', 'a' * 300, 'é' * 150, ''], ids=['null', 'long', 'long in bytes', 'empty']
)
def test_what_no_folder_can_be_called_is_no_name(name, tmp_path):
    (tmp_path / 'package.xml').write_text(f'<package><name>{name}</name></package>')
    assert package_name(tmp_path) == tmp_path.name


def test_manifests_are_read_once_for_all_meshes(tmp_path, monkeypatch):
    (tmp_path / 'package.xml').write_text('<package><name>mine</name></package>')
    opened = []

    def noted(path):
        opened.append(Path(path))
        return path.open('rb')

    monkeypatch.setattr(package_path, 'open_unblocked', noted)
    for k in range(20):
        candidates = package_candidates(f'package://mine/{k}.stl', tmp_path / 'urdf')
        assert tmp_path / f'{k}.stl' in candidates
    assert opened.count(tmp_path / 'package.xml') == 1


def test_manifests_that_change_are_read_again(tmp_path):
    for name in ('one', 'other'):
        (tmp_path / 'package.xml').write_text(f'<package><name>{name}</name></package>')
        assert package_name(tmp_path) == name
