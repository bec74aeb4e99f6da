"""
Which of the stances that an imported robot could take is taken.
"""

import numpy as np
import pytest

pytest.importorskip('yourdfpy')

from quad_common.importing.stance import _score

FEET = np.array([[0.2, 0.1, -0.3], [0.2, -0.1, -0.3], [-0.2, 0.1, -0.3], [-0.2, -0.1, -0.3]])
WIDER = FEET * [1.0, 1.2, 1.0]


def test_the_part_with_the_least_room_counts_first():
    assert _score(np.array([0.5, 0.5, 0.5]), FEET) > _score(np.array([0.4, 1.0, 1.0]), FEET)


def test_parts_get_room_beside_covers_that_overlap_in_all_stances():
    assert _score(np.array([-0.3, 0.9]), FEET) > _score(np.array([-0.3, 0.2]), FEET)
    assert _score(np.array([-0.1, 0.5]), FEET) == _score(np.array([-0.3, 0.5]), FEET)


def test_wider_stances_are_better_up_to_what_is_enough():
    rooms = np.array([1.0, 1.0])
    assert _score(rooms, WIDER) > _score(rooms, FEET)
    assert _score(rooms, WIDER * [1.0, 2.0, 1.0]) == _score(rooms, WIDER * [1.0, 3.0, 1.0])
