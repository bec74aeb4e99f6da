"""
Sizes of shapes are numbers that a robot's parts can have, and flat meshes get a thin box.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from quad_common.description.poses import moved
from quad_common.description.shape_sizes import size_problem, thin_box


def geometry(kind, **sizes):
    shapes = dict.fromkeys(('box', 'sphere', 'cylinder', 'mesh'))
    return SimpleNamespace(**{**shapes, kind: SimpleNamespace(**sizes)})


@pytest.mark.parametrize(
    ('shape', 'said'),
    [
        (geometry('box', size=[0.1, 0.2]), 'has a box size of 2 numbers (0.1 0.2); it must be 3'),
        (geometry('box', size=[1, 1, 1, 1]), 'has a box size of 4 numbers (1 1 1 1); it must be 3'),
        (
            geometry('box', size=[0.1, np.nan, 0.1]),
            'has a box size of 0.1 nan 0.1; it must be from 0 to 1000',
        ),
        (
            geometry('sphere', radius=1e30),
            'has a sphere radius of 1e+30; it must be from 0 to 1000',
        ),
        (
            geometry('cylinder', radius=0.1, length=-1.0),
            'has a cylinder length of -1; it must be from 0 to 1000',
        ),
        (
            geometry('cylinder', radius=np.inf, length=1.0),
            'has a cylinder radius of inf; it must be from 0 to 1000',
        ),
        (
            geometry('mesh', scale=[1.0, 1.0]),
            'has a mesh scale of 2 numbers (1 1); it must be 3',
        ),
        (
            geometry('mesh', scale=np.nan),
            'has a mesh scale of nan; it must be from -1000 to 1000',
        ),
    ],
)
def test_what_no_shape_can_have_is_said(shape, said):
    assert size_problem(shape) == said


@pytest.mark.parametrize(
    'shape',
    [
        None,
        geometry('box', size=[0.1, 0.2, 0.3]),
        geometry('box', size=[0.1]),
        geometry('sphere', radius=0.0),
        geometry('mesh', scale=None),
        geometry('mesh', scale=[1.0, -1.0, 1.0]),
    ],
)
def test_dummies_cubes_and_mirrored_meshes_are_shapes(shape):
    assert size_problem(shape) == ''


@pytest.mark.parametrize('seed', range(5))
def test_the_box_of_a_flat_mesh_holds_it_closely(seed):
    rng = np.random.default_rng(seed)
    sides = rng.uniform(0.01, 0.3, 2)
    corners = np.array([[x, y, 0.0] for x in (0.0, sides[0]) for y in (0.0, sides[1])])
    corners = Rotation.random(random_state=seed).apply(corners) + rng.uniform(-1.0, 1.0, 3)
    pose, size = thin_box(corners)
    assert np.sort(size[:2]) == pytest.approx(np.sort(sides), abs=1e-6)
    assert 0.0 < size[2] < 0.002
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3))
    places = moved(np.linalg.inv(pose), corners)
    assert np.abs(places) == pytest.approx(np.tile(size / 2.0 * [1, 1, 0], (4, 1)), abs=1e-6)


def test_a_mesh_with_a_volume_gets_no_box():
    assert thin_box(np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 1e-4]])) is None


@pytest.mark.parametrize('corners', [[[0, 0, 0]], [[0, 0, 0], [1, 2, 3], [2, 4, 6]]])
def test_lines_and_points_have_no_width(corners):
    _, size = thin_box(np.array(corners, dtype=float))
    assert size[1] == 0.0
