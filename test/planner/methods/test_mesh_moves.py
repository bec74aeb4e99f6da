"""Moves over a mesh stay in allowed cells, all along."""

import exact_segments
import numpy as np
import pytest

from quad_planner.grid.bit_grid import BitMask
from quad_planner.methods.mesh_moves import MOVES, mesh_moves, segment_allowed


def segments_allowed(allowed, starts, step):
    forbidden = BitMask.of(~allowed)
    return np.array(
        [segment_allowed(forbidden.words, forbidden.width, *start, *step) for start in starts]
    )


def test_a_segment_is_allowed_if_and_only_if_all_its_points_are():
    rng = np.random.default_rng(10)
    for _ in range(60):
        allowed = rng.random((30, 30)) < 0.9
        step = rng.uniform(-8.0, 8.0, 2)
        starts = rng.uniform(8.0, 22.0, (50, 2))
        t = np.linspace(0.0, 1.0, 4001)[:, None]
        index = np.floor(starts[:, None] + t * step).astype(int)
        fraction = allowed[index[..., 1], index[..., 0]].mean(axis=1)
        told = segments_allowed(allowed, starts, step)
        assert (fraction[told] == 1.0).all()
        # What is refused may touch a forbidden cell between two samples.
        assert (~told[fraction < 1.0]).all()
        assert (fraction[~told] == 1.0).mean() < 0.2 if (~told).any() else True


def test_a_segment_may_run_along_the_edge_of_the_allowed_zone():
    allowed = np.zeros((3, 3), dtype=bool)
    allowed[:, 1] = True
    starts = np.array([[1.0, 0.0], [1.5, 0.0], [2.0, 0.0], [0.99, 0.0], [2.01, 0.0]])
    told = segments_allowed(allowed, starts, np.array([0.0, 3.0]))
    assert told.tolist() == [True, True, True, False, False]


def test_a_diagonal_may_pass_the_corner_of_a_forbidden_cell():
    allowed = np.eye(3, dtype=bool)
    diagonal = np.array([3.0, 3.0])
    assert segments_allowed(allowed, np.array([[0.0, 0.0]]), diagonal).all()
    assert not segments_allowed(allowed, np.array([[0.1, 0.0]]), diagonal - 0.1).any()


@pytest.mark.parametrize('seed', range(6))
def test_candidates_and_moves_are_those_of_a_slow_look_at_each(seed):
    rng = np.random.default_rng(seed)
    for spacing in (2.5, 4.2854571, 12.5631):
        allowed = rng.random(tuple(rng.integers(13, 40, 2))) >= rng.choice([0.0, 0.02, 0.1, 0.3])
        columns, rows = (int(n / spacing + 1e-9) + 1 for n in allowed.shape[::-1])
        candidates, exits = mesh_moves(BitMask.of(~allowed), spacing, (0, rows), columns)
        places = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1) * spacing
        assert (candidates == exact_segments.points_allowed(allowed, places)).all()
        for k, (dc, dr) in enumerate(MOVES):
            for row, column in np.argwhere(candidates):
                to = row + dr, column + dc
                inside = 0 <= to[0] < rows and 0 <= to[1] < columns
                # Looked at from the same end as the mesh does, for rounding.
                at, step = ((row, column), (dc, dr)) if k < 4 else (to, (-dc, -dr))
                start = np.array([[at[1] * spacing, at[0] * spacing]])
                free = (
                    inside
                    and candidates[to]
                    and exact_segments.segments_allowed(allowed, start, np.array(step) * spacing)[0]
                )
                assert bool(exits[row, column] >> k & 1) == bool(free)
