"""The distance field is exact on every cell: against SciPy's Dijkstra, and by its own laws."""

import math
from itertools import count

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from quad_common.errors import ParameterError
from quad_planner.search.cell_steps import DIAGONAL, STRAIGHT
from quad_planner.search.distance_field import NOT_REACHED, Beyond, distance_field


def graph_of(allowed):
    """Join each allowed cell to its neighbours, with no corner cut."""
    height, width = allowed.shape
    numbers = np.arange(height * width).reshape(allowed.shape)
    froms, tos, lengths = [], [], []
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        rows, left, right = slice(0, height - dy), max(-dx, 0), width - max(dx, 0)
        here, there = (rows, slice(left, right)), (slice(dy, None), slice(left + dx, right + dx))
        may = allowed[here] & allowed[there]
        if dy and dx:
            may &= allowed[rows, left + dx : right + dx] & allowed[dy:, left:right]
        froms.append(numbers[here][may])
        tos.append(numbers[there][may])
        lengths.append(np.full(may.sum(), float(DIAGONAL if dx and dy else STRAIGHT)))
    a, b, weights = (np.concatenate(parts) for parts in (froms, tos, lengths))
    size = height * width
    return coo_array(
        (np.tile(weights, 2), (np.concatenate((a, b)), np.concatenate((b, a)))), shape=(size, size)
    ).tocsr()


def exact(allowed, start):
    x, y = start
    lengths = dijkstra(graph_of(allowed), indices=y * allowed.shape[1] + x)
    whole = np.where(np.isfinite(lengths), lengths, NOT_REACHED).astype(np.int64)
    return whole.reshape(allowed.shape)


def some_cell(rng, allowed):
    cells = np.argwhere(allowed)
    y, x = cells[rng.integers(len(cells))]
    return int(x), int(y)


def octile(dx, dy):
    return STRAIGHT * max(dx, dy) + (DIAGONAL - STRAIGHT) * min(dx, dy)


@pytest.mark.parametrize('seed', range(40))
def test_it_is_exact_on_small_maps_of_scattered_cells(seed):
    rng = np.random.default_rng(seed)
    for _ in range(10):
        allowed = rng.random(rng.integers(1, 26, 2)) > rng.choice([0.05, 0.2, 0.35, 0.5])
        if not allowed.any():
            continue
        start = some_cell(rng, allowed)
        assert (distance_field(allowed, start) == exact(allowed, start)).all()


@pytest.mark.parametrize('seed', range(20))
def test_it_is_exact_among_boxes_farther_than_a_run_goes_at_once(seed):
    rng = np.random.default_rng(seed)
    allowed = np.ones(rng.integers(100, 200, 2), dtype=bool)
    for _ in range(rng.integers(0, 30)):
        x, y = rng.integers(0, allowed.shape[1]), rng.integers(0, allowed.shape[0])
        allowed[y : y + rng.integers(1, 40), x : x + rng.integers(1, 40)] = False
    start = some_cell(rng, allowed)
    assert (distance_field(allowed, start) == exact(allowed, start)).all()


def comb():
    allowed = np.ones((60, 121), dtype=bool)
    allowed[1:, 3::8] = False
    allowed[:-1, 7::8] = False
    return allowed


def spiral():
    allowed = np.zeros((41, 41), dtype=bool)
    low, high = 0, 40
    while low < high:
        allowed[low, low : high + 1] = True
        allowed[low : high + 1, high] = True
        allowed[high, low + 2 : high + 1] = True
        allowed[low + 2 : high + 1, low + 2] = True
        low, high = low + 2, high - 2
    return allowed


def checkerboard():
    """Cells that touch at corners only."""
    rows, columns = np.indices((12, 13))
    return (rows + columns) % 2 == 0


def pillars():
    """So even that most cells have many shortest paths."""
    allowed = np.ones((90, 90), dtype=bool)
    allowed[4::9, 4::9] = False
    return allowed


@pytest.mark.parametrize('make', [comb, spiral, checkerboard, pillars])
def test_it_is_exact_on_maps_with_structure(make):
    allowed = make()
    rng = np.random.default_rng(5)
    for _ in range(4):
        start = some_cell(rng, allowed)
        assert (distance_field(allowed, start) == exact(allowed, start)).all()


@pytest.mark.parametrize('shape', [(1, 1), (1, 300), (300, 1), (2, 2), (150, 170)])
def test_on_an_empty_map_it_is_the_octile_distance(shape):
    start = (shape[1] // 3, shape[0] // 2)
    lengths = distance_field(np.ones(shape, dtype=bool), start)
    expected = [
        [octile(abs(x - start[0]), abs(y - start[1])) for x in range(shape[1])]
        for y in range(shape[0])
    ]
    assert lengths.tolist() == expected


def test_what_is_walled_off_is_not_reached():
    allowed = np.ones((9, 11), dtype=bool)
    allowed[:, 5] = False
    lengths = distance_field(allowed, (2, 4))
    assert (lengths[:, 5:] == NOT_REACHED).all()
    assert (lengths[:, :5] >= 0).all()


def test_no_corner_is_cut():
    allowed = np.array([[True, False], [True, True]])
    lengths = distance_field(allowed, (0, 0))
    assert lengths.tolist() == [[0, NOT_REACHED], [STRAIGHT, 2 * STRAIGHT]]
    allowed = np.array([[True, False], [False, True]])
    assert distance_field(allowed, (0, 0)).tolist() == [[0, NOT_REACHED]] + [[NOT_REACHED] * 2]


def test_there_and_back_is_as_far():
    rng = np.random.default_rng(2)
    allowed = rng.random((40, 50)) > 0.25
    for _ in range(20):
        a, b = some_cell(rng, allowed), some_cell(rng, allowed)
        there, back = distance_field(allowed, a)[b[::-1]], distance_field(allowed, b)[a[::-1]]
        assert there == back


def test_turned_and_mirrored_maps_have_turned_and_mirrored_fields():
    rng = np.random.default_rng(3)
    allowed = rng.random((33, 47)) > 0.2
    x, y = some_cell(rng, allowed)
    field = distance_field(allowed, (x, y))
    assert (distance_field(allowed.T, (y, x)) == field.T).all()
    assert (distance_field(allowed[::-1], (x, 32 - y)) == field[::-1]).all()
    assert (distance_field(allowed[:, ::-1], (46 - x, y)) == field[:, ::-1]).all()


def test_a_way_longer_than_32_bits_is_counted_right():
    # A meander as wide as one cell.
    allowed = np.ones((1401, 1401), dtype=bool)
    allowed[1::4, 1:] = False
    allowed[3::4, :-1] = False
    lengths = distance_field(allowed, (1400, 0))
    assert lengths.max() > 2**31
    # Along each row, and two cells up at its end; no corner is cut there.
    assert lengths[1400, 0] == (1400 * 701 + 2 * 700) * STRAIGHT


def test_from_where_nobody_may_be_nothing_is_reached():
    allowed = np.ones((4, 5), dtype=bool)
    allowed[1, 2] = False
    assert (distance_field(allowed, (2, 1)) == NOT_REACHED).all()


@pytest.mark.parametrize('start', [(-1, 0), (5, 0), (0, 4), (0, -1)])
def test_a_start_that_is_no_cell_of_the_map_is_refused(start):
    with pytest.raises(ParameterError, match='a cell of a map of 5 x 4 cells'):
        distance_field(np.ones((4, 5), dtype=bool), start)


def test_the_search_can_be_ended_from_outside():
    class EnoughError(Exception):
        pass

    calls = count()

    def check():
        if next(calls) == 3:
            raise EnoughError

    allowed = np.random.default_rng(0).random((600, 600)) > 0.2
    allowed[0, 0] = True
    with pytest.raises(EnoughError):
        distance_field(allowed, (0, 0), check)
    assert next(calls) == 4


def test_the_length_is_that_of_a_plane_within_the_octile_ratio():
    lengths = distance_field(np.ones((80, 80), dtype=bool), (0, 0)) / STRAIGHT
    rows, columns = np.indices(lengths.shape)
    straight = np.hypot(rows, columns)
    # At 22.5 degrees eight directions are longest: 1 / cos(22.5 degrees).
    assert (lengths >= straight - 1e-5 * straight).all()
    assert (lengths <= straight / math.cos(math.pi / 8) + 1e-5).all()


@pytest.mark.parametrize('seed', range(6))
def test_cells_on_short_enough_paths_have_their_lengths(seed):
    rng = np.random.default_rng(seed)
    allowed = rng.random((90, 120)) > 0.25
    allowed[[5, 80], [100, 10]] = True
    all_lengths = distance_field(allowed, (100, 5))
    others = distance_field(allowed, (10, 80))
    if all_lengths[80, 10] == NOT_REACHED:
        return
    longest = int(1.05 * all_lengths[80, 10])
    lengths = distance_field(allowed, (100, 5), beyond=Beyond(10, 80, longest))
    is_near = (all_lengths != NOT_REACHED) & (all_lengths + others <= longest)
    assert is_near.sum() > 50
    assert np.array_equal(lengths[is_near], all_lengths[is_near])
    assert ((lengths == NOT_REACHED) | (lengths >= all_lengths)).all()
    # And some are left out.
    assert (lengths == NOT_REACHED).sum() > (all_lengths == NOT_REACHED).sum()
