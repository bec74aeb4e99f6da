"""A file is whole, or stays what it was."""

from __future__ import annotations

import numpy as np
import pytest

from quad_cli.main import main
from quad_common.errors import FileUnusable, QuadError
from quad_common.files.whole_file import whole_file, write_bytes, write_text
from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_file import save_height_map
from quad_common.maps.map_file import load_map, save_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_perception.picture.picture_files import write_picture

ROOM = 1000
"""Bytes that a file may have."""


def noise(*shape):
    return np.random.default_rng(0).integers(0, 255, shape, dtype=np.uint8)


def grid_of(side):
    return OccupancyGrid(np.zeros((side, side), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))


WRITERS = {
    'words.txt': lambda path: write_text(path, 'w' * 5000),
    'bytes.bin': lambda path: write_bytes(path, bytes(5000)),
    'map.yaml': lambda path: save_map(grid_of(200), path),
    'heights.yaml': lambda path: save_height_map(
        HeightMap(noise(60, 60) / 50.0, 0.05, (0.0, 0.0)), path
    ),
    'picture.png': lambda path: write_picture(path, noise(60, 60, 3)),
}


@pytest.mark.parametrize('name', WRITERS)
def test_what_cannot_be_written_leaves_what_was_there(tmp_path, most_bytes, name):
    path = tmp_path / name
    for old in (path, path.with_suffix('.pgm'), path.with_suffix('.png')):
        old.write_text('old')
    with most_bytes(ROOM), pytest.raises(QuadError, match='cannot be written: File too large'):
        WRITERS[name](path)
    assert {file.read_text() for file in tmp_path.iterdir()} == {'old'}
    WRITERS[name](path)
    assert path.stat().st_size > 3


def test_a_map_whose_document_cannot_be_written_keeps_its_old_image(tmp_path, monkeypatch):
    save_map(grid_of(3), tmp_path / 'map.yaml')

    def refuse(*_):
        raise FileUnusable('map file', 'map.yaml', 'cannot be written: No space left on device')

    monkeypatch.setattr('quad_common.maps.map_file.write_text', refuse)
    with pytest.raises(QuadError, match='No space left'):
        save_map(grid_of(5), tmp_path / 'map.yaml')
    assert load_map(tmp_path / 'map.yaml').cells.shape == (3, 3)
    assert len(list(tmp_path.iterdir())) == 2


def test_a_picture_of_a_plan_is_whole_or_not_there(tmp_path, most_bytes, capsys, monkeypatch):
    # Where nothing is compiled yet it says so, if it has not begun within a while.
    monkeypatch.setattr('quad_cli.plan._LONG', 1000.0)
    wish = ['plan', '--start', '1.2,1.2,0', '--goal', '6.8,4.8,90deg', '--picture']
    with most_bytes(ROOM):
        assert main([*wish, str(tmp_path / 'plan.png')]) == 2
    error = capsys.readouterr().err
    assert error.startswith('error: picture ')
    assert error.count('\n') == 1
    assert list(tmp_path.iterdir()) == []


def test_an_interrupted_write_leaves_nothing(tmp_path):
    def interrupted() -> None:
        with whole_file(tmp_path / 'words.txt') as beside:
            beside.write_text('half')
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert list(tmp_path.iterdir()) == []


def test_links_and_permissions_stay(tmp_path):
    file, link = tmp_path / 'words.txt', tmp_path / 'link'
    file.write_text('old')
    file.chmod(0o640)
    link.symlink_to(file)
    write_text(link, 'new')
    assert link.is_symlink()
    assert file.read_text() == 'new'
    assert file.stat().st_mode & 0o777 == 0o640


def test_a_file_in_a_folder_that_may_not_be_written_is_written(tmp_path, monkeypatch):
    file = tmp_path / 'words.txt'
    file.write_text('old')
    may = lambda path, mode: path != tmp_path  # noqa: E731
    monkeypatch.setattr('quad_common.files.whole_file.os.access', may)
    write_text(file, 'new')
    assert file.read_text() == 'new'
    assert list(tmp_path.iterdir()) == [file]
