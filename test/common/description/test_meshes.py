"""
Meshes are looked for where a description may mean them, within bounds.
"""

import tracemalloc
from types import SimpleNamespace

import pytest

from quad_common.description.meshes import mesh_corners, mesh_path
from quad_common.errors import DescriptionError, MeshNotFound


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


@pytest.mark.parametrize(('number', 'scale'), [('nan', 1.0), ('1e300', 1.0), ('2', 1e4)])
def test_meshes_with_corners_that_are_no_places_are_refused(number, scale, tmp_path):
    pytest.importorskip('trimesh')
    description = tmp_path / 'robot.urdf'
    (tmp_path / 'body.obj').write_text(f'v 0 0 0\nv 1 0 0\nv 0 1 {number}\nf 1 2 3\n')
    mesh = SimpleNamespace(filename='body.obj', scale=scale)
    with pytest.raises(DescriptionError, match='has a corner that is no place'):
        mesh_corners(mesh, description)
