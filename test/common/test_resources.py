"""The files that ship with quadwalk are found, wherever it is installed."""

import sys
from pathlib import Path

import pytest

from quad_common import resources
from quad_common.maps.map_file import load_map
from quad_common.resources import sample_map, share_directory

ROOT = Path(__file__).parents[2]


@pytest.fixture
def no_ros(monkeypatch):
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)


def make_share(prefix):
    share = prefix / 'share' / 'quadwalk'
    (share / 'maps').mkdir(parents=True)
    return share


@pytest.mark.usefixtures('no_ros')
def test_from_a_source_tree_the_files_are_the_trees_own():
    assert share_directory() == ROOT
    for folder in ('maps', 'config', 'launch'):
        assert (share_directory() / folder).is_dir()


def test_a_colcon_installation_that_is_sourced_comes_first(monkeypatch, tmp_path):
    share = make_share(tmp_path / 'two')
    paths = (tmp_path / 'one', tmp_path / 'two', tmp_path / 'three')
    monkeypatch.setenv('AMENT_PREFIX_PATH', ':'.join(map(str, paths)))
    assert share_directory() == share


def test_a_ros_installation_without_quadwalk_does_not_matter(monkeypatch, tmp_path):
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(tmp_path))
    assert share_directory() == ROOT


@pytest.mark.usefixtures('no_ros')
def test_installed_by_pip_the_files_are_under_the_prefix(monkeypatch, tmp_path):
    module = tmp_path / 'lib' / 'quad_common' / 'resources.py'
    monkeypatch.setattr(resources, '__file__', str(module))
    monkeypatch.setattr(sys, 'prefix', str(tmp_path))
    share = make_share(tmp_path)
    assert share_directory() == share


@pytest.mark.usefixtures('no_ros')
def test_where_nothing_is_found_the_places_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr(resources, '__file__', str(tmp_path / 'lib' / 'x' / 'resources.py'))
    monkeypatch.setattr(sys, 'prefix', str(tmp_path / 'prefix'))
    with pytest.raises(FileNotFoundError, match=r'prefix/share/quadwalk; reinstall the package'):
        share_directory()


@pytest.mark.parametrize('name', sorted(p.stem for p in (ROOT / 'maps').glob('*.yaml')))
def test_every_sample_map_is_a_map_with_walls_and_room(name):
    grid = load_map(sample_map(name))
    assert grid.occupied().any()
    assert 0.5 < (grid.cells == 0).mean() < 1.0


def test_the_sample_map_is_the_room_unless_another_is_named():
    assert sample_map() == sample_map('room')
    assert sample_map('office').name == 'office.yaml'
