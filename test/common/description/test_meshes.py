"""
Meshes are looked for where a description may mean them, within bounds.
"""

import tracemalloc

import pytest

from quad_common.description.meshes import mesh_path
from quad_common.errors import MeshNotFound


def test_meshes_of_copied_descriptions_are_found_by_their_ends(tmp_path):
    mesh = tmp_path / 'meshes' / 'go' / 'body.stl'
    mesh.parent.mkdir(parents=True)
    mesh.write_text('solid')
    description = tmp_path / 'urdf' / 'robot.urdf'
    for name in ('/srv/somebody/meshes/go/body.stl', f'package://{"a/" * 3000}meshes/go/body.stl'):
        assert mesh_path(name, description) == mesh


def test_names_of_thousands_of_parts_take_no_more_memory_than_others(tmp_path):
    name = f'package://x/{"a/" * 3000}body.stl'
    tracemalloc.start()
    with pytest.raises(MeshNotFound):
        mesh_path(name, tmp_path / 'robot.urdf')
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # All its ends would take 3000 times the name's 6 kB, for each of four folders.
    assert peak < 5e6
