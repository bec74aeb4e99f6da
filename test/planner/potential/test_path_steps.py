"""Steps along a path are of one length, and lead to its end."""

import math

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_planner.potential.path_steps import steps_along
from quad_planner.potential.potential_field import PotentialField, RoundObstacle

FIELD = PotentialField(
    (3.0, 2.0),
    (RoundObstacle(1.5, 1.2, 0.3), RoundObstacle(-1.0, 2.0, 0.5)),
    goal_distance=4.0,
)


def lengths(path):
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


@pytest.mark.parametrize('length', [0.02, 0.3, 1.7, 50.0])
def test_a_path_is_cut_into_steps_of_one_length(length):
    path = FIELD.descend((0.0, 0.0))
    ends, headings = steps_along(path, length)
    assert ends[0] == pytest.approx(path[0])
    assert ends[-1] == pytest.approx(path[-1])
    assert lengths(ends)[:-1] == pytest.approx(length)
    assert 0.0 < lengths(ends)[-1] <= length * (1.0 + 1e-9)
    for k, heading in enumerate(headings):
        ray = np.array([math.cos(heading), math.sin(heading)])
        assert ends[k] + lengths(ends)[k] * ray == pytest.approx(ends[k + 1])


def test_ten_steps_of_a_centimetre_lead_ten_centimetres_far():
    # S1's own example (part IV.A).
    ends, headings = steps_along([[0.0, 0.0], [0.1, 0.0]], 0.01)
    assert ends[:, 0] == pytest.approx(np.linspace(0.0, 0.1, 11))
    assert headings == pytest.approx(np.zeros(10))
    ends, headings = steps_along([[1.0, 2.0]], 0.01)
    assert (ends.tolist(), headings.tolist()) == ([[1.0, 2.0]], [])
    with pytest.raises(ParameterError, match="'length'"):
        steps_along([[0.0, 0.0], [0.1, 0.0]], 0.0)
