"""
Meshes are looked for where a description may mean them, within bounds.
"""

import json
import os
import tracemalloc
from types import SimpleNamespace

import pytest

from quad_common.description import mesh_files
from quad_common.description.bounded_call import Bounds
from quad_common.description.meshes import files_of, mesh_corners, mesh_path
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
        mesh_corners(mesh, description, files_of([], description))


def corners_of(path):
    description = path.parent / 'robot.urdf'
    mesh = SimpleNamespace(filename=path.name, scale=None)
    return mesh_corners(mesh, description, files_of([path.name], description))


def write_gltf(path, uri, count=3):
    """A triangle whose numbers are in another file; without one they are 0."""
    accessor = {'componentType': 5126, 'count': count, 'type': 'VEC3'}
    document = {
        'asset': {'version': '2.0'},
        'scenes': [{'nodes': [0]}],
        'scene': 0,
        'nodes': [{'mesh': 0}],
        'meshes': [{'primitives': [{'attributes': {'POSITION': 0}}]}],
        'accessors': [accessor],
    }
    if uri:
        document['buffers'] = [{'uri': uri, 'byteLength': 36}]
        document['bufferViews'] = [{'buffer': 0, 'byteLength': 36}]
        accessor['bufferView'] = 0
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize('name', ['bomb.zip', 'bomb.tar.gz', 'mesh.3mf', 'mesh', 'robot.xacro'])
def test_archives_and_what_is_no_mesh_by_its_name_are_not_opened(name, tmp_path):
    path = tmp_path / name
    path.write_text('v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n')
    with pytest.raises(DescriptionError, match=r'must end in one of \.obj, \.stl, .*\.gltf$'):
        corners_of(path)


def test_files_that_are_too_large_are_not_read_whole(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_files, 'LARGEST_MESH', 1000)
    path = tmp_path / 'large.obj'
    path.write_text('v 0 0 0\n' * 200)
    with pytest.raises(DescriptionError, match='more than 1000 bytes, which is the limit'):
        corners_of(path)


def test_meshes_with_too_many_corners_are_refused(tmp_path, monkeypatch):
    pytest.importorskip('trimesh')
    monkeypatch.setattr(mesh_files, '_MOST_CORNERS', 3)
    path = tmp_path / 'many.obj'
    path.write_text('v 0 0 0\nv 1 0 0\nv 0 1 1\nv 1 1 1\nf 1 2 3\nf 2 3 4\n')
    with pytest.raises(DescriptionError, match='has 4 corners; 3 are the most'):
        corners_of(path)


@pytest.mark.parametrize('name', ['none.obj', 'none.stl'])
def test_a_mesh_without_corners_is_said_to_have_none(name, tmp_path):
    pytest.importorskip('trimesh')
    path = tmp_path / name
    path.write_text('# nothing')
    with pytest.raises(DescriptionError, match=f'the mesh .*{name} has no corners$'):
        corners_of(path)


def test_colors_of_a_mesh_may_be_a_pipe_that_nobody_writes_to(tmp_path):
    pytest.importorskip('trimesh')
    os.mkfifo(tmp_path / 'pipe.mtl')
    path = tmp_path / 'painted.obj'
    path.write_text('mtllib pipe.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n')
    assert corners_of(path).tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 1]]


def test_a_mesh_of_gltf_may_be_of_several_files_but_not_of_pipes(tmp_path):
    np = pytest.importorskip('numpy')
    pytest.importorskip('trimesh')
    os.mkfifo(tmp_path / 'pipe.bin')
    with pytest.raises(DescriptionError, match='it is a pipe, not a file'):
        corners_of(write_gltf(tmp_path / 'waits.gltf', 'pipe.bin'))
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 1]], dtype=np.float32)
    (tmp_path / 'places.bin').write_bytes(places.tobytes())
    found = corners_of(write_gltf(tmp_path / 'reads.gltf', 'places.bin'))
    assert np.ptp(found, axis=0).tolist() == [1.0, 1.0, 1.0]


def test_a_few_bytes_that_stand_for_billions_of_corners_are_given_up(tmp_path, monkeypatch):
    pytest.importorskip('trimesh')
    bounds = Bounds(seconds=20, memory=2**32, patience=40.0)
    monkeypatch.setattr(mesh_files, '_BOUNDS', bounds)
    path = write_gltf(tmp_path / 'bomb.gltf', '', 3 * 10**9)
    with pytest.raises(DescriptionError, match=r'bomb\.gltf cannot be read: '):
        corners_of(path)


def test_a_file_is_read_once(tmp_path):
    pytest.importorskip('trimesh')
    path = tmp_path / 'body.obj'
    path.write_text('v 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n')
    files = files_of([path.name], tmp_path / 'robot.urdf')
    assert files.read(path) is files.read(path)
