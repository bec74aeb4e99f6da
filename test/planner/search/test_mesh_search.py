"""Shortest paths over a mesh are those of Dijkstra's algorithm on the whole graph."""

import numpy as np
import pytest

from quad_lab.benchmarks.planning.plain_searches import path_over_whole_mesh
from quad_lab.benchmarks.planning.small_requests import DIAGONAL, STRAIGHT, random_meshes
from quad_planner.search.mesh_search import Ends, Legs, Mesh, mesh_path


@pytest.mark.parametrize('seed', range(10))
def test_the_path_is_that_of_a_search_of_the_whole_mesh(seed):
    for mesh, ends in random_meshes(seed, 12):
        assert mesh_path(mesh, ends) == path_over_whole_mesh(mesh, ends)


def test_without_a_segment_to_the_mesh_there_is_no_path():
    mesh = Mesh(np.zeros((3, 3), dtype=np.uint8), STRAIGHT, DIAGONAL)
    none = Legs(*np.empty((3, 0), dtype=np.int64))
    one = Legs(np.array([4]), np.array([STRAIGHT]), np.array([0]))
    assert mesh_path(mesh, Ends(none, one, -1, -1, (0, 0))) is None
    assert mesh_path(mesh, Ends(one, none, 7, 0, (0, 0))) == []
    assert mesh_path(mesh, Ends(one, one, -1, -1, (0, 0))) == [4]
