"""Free cells as bits: what goes in comes out."""

import numpy as np
import pytest

from quad_planner.grid.bit_grid import BitGrid, BitMask, first_bit, is_set, last_bit, packed_cells
from quad_planner.grid.dilation import dilated


@pytest.mark.parametrize('place', range(64))
def test_the_first_and_last_bit_of_a_word_are_found(place):
    rng = np.random.default_rng(place)
    bit = np.uint64(1 << place)
    noise = int(rng.integers(0, 2**63))
    above = np.uint64(noise & ~((2 << place) - 1))
    below = np.uint64(noise & ((1 << place) - 1))
    assert first_bit(bit) == last_bit(bit) == place
    assert first_bit(bit | above) == place
    assert last_bit(bit | below) == place


@pytest.mark.parametrize(('height', 'width'), [(1, 1), (3, 62), (5, 63), (64, 64), (70, 130)])
def test_rows_and_columns_hold_the_mask_within_a_wall(height, width):
    free = np.random.default_rng(width).random((height, width)) < 0.5
    grid = BitGrid.of(free)
    assert (grid.width, grid.height) == (width, height)
    assert len(grid.rows) == height + 2
    assert len(grid.columns) == width + 2
    walled = np.pad(free, 1)
    for y in range(height + 2):
        for x in range(width + 2):
            assert is_set(grid.rows, y, x) == is_set(grid.columns, x, y) == walled[y, x]


@pytest.mark.parametrize(('height', 'width'), [(1, 1), (3, 63), (5, 64), (7, 65), (70, 130)])
def test_a_packed_mask_gives_back_any_part_of_it(height, width):
    rng = np.random.default_rng(width)
    mask = rng.random((height, width)) < 0.5
    bits = BitMask.of(mask)
    assert (bits.width, bits.height) == (width, height)
    assert (bits.unpacked() == mask).all()
    assert (bits.places() == np.argwhere(mask)).all()
    for row, column in np.ndindex(mask.shape):
        assert bits[row, column] == mask[row, column]
    for _ in range(60):
        left, right = np.sort(rng.integers(0, width + 1, 2))
        bottom, top = np.sort(rng.integers(0, height + 1, 2))
        part = bits.window(left, bottom, right, top)
        assert part.shape == (top - bottom, right - left)
        assert (part == mask[bottom:top, left:right]).all()


@pytest.mark.parametrize(('least', 'most'), [(0, 64), (-128, 64), (-1, 127), (5, 5), (0, -1)])
def test_cells_outside_of_a_range_are_packed(least, most):
    rng = np.random.default_rng(1)
    for width in (1, 8, 63, 64, 65, 200):
        cells = rng.integers(-1, 101, (3, width)).astype(np.int8)
        bits = BitMask(packed_cells(cells, least, most), width)
        assert (bits.unpacked() == ((cells < least) | (cells > most))).all()


def test_what_is_beyond_the_width_of_a_packed_mask_is_not_seen():
    bits = BitMask(np.full((3, 2), 2**64 - 1, dtype=np.uint64), 70)
    assert bits.unpacked().shape == (3, 70)
    assert len(bits.places()) == 3 * 70
    assert not BitGrid.outside(bits).rows.any()
    nothing = BitMask(np.uint64([[0, 2**64 - 2**6]]), 70)
    assert BitGrid.outside(nothing).rows[1].tolist() == [2**64 - 2, 2**7 - 1]


@pytest.mark.parametrize('seed', range(20))
def test_what_is_near_a_set_cell_is_set_too(seed):
    rng = np.random.default_rng(seed)
    height, width = rng.integers(1, 90, 2)
    mask = rng.random((height, width)) < (0.01 if seed % 2 else 0.0)
    # Blocks have many rows that are alike.
    for _ in range(rng.integers(0, 5)):
        y, x = rng.integers(0, height), rng.integers(0, width)
        mask[y : y + rng.integers(1, 30), x : x + rng.integers(1, 30)] = True
    reaches = np.sort(rng.integers(0, 40, rng.integers(1, 12)))[::-1].copy()
    expected = np.zeros_like(mask)
    for y, x in np.argwhere(mask):
        for off, reach in enumerate(reaches):
            for row in (y - off, y + off):
                if 0 <= row < height:
                    expected[row, max(x - reach, 0) : x + reach + 1] = True
    near = BitMask(dilated(BitMask.of(mask).words, reaches), width).unpacked()
    assert (near == expected).all()
