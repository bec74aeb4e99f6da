"""
The cycles of a wave: its fronts go on by a stride, and where they arrive the robot turns.

A front is a robot in the middle of a stretch: its cell, its heading, and its cost so far, which
may be that of a cycle to come.
"""

from __future__ import annotations

import numpy as np

from quad_common.compiled import compiled_loop, compiled_part, inlined_part
from quad_planner.grid.bit_grid import first_bit
from quad_planner.search.cell_steps import DX, DY
from quad_planner.search.distance_field import word_length
from quad_planner.search.lattice_costs import HEADINGS, total_cost
from quad_planner.search.search_loop import DONE, FULL, PAUSED
from quad_planner.search.weighted_search import TWO_PARTS
from quad_planner.wave.wave_state import (
    ARRIVED,
    BEST,
    FRONTS,
    HEADING,
    LISTED,
    MOVES,
    PHASE,
    READ,
    TILES,
    TIME,
    TURN,
    WRITTEN,
    WaveCosts,
    WaveGround,
    WaveLists,
)
from quad_planner.wave.wave_tiles import WaveTiles, make_tile

_WALKING, _TURNING = 0, 1

_MOVES_AT_A_TIME = 100_000
"""Number of moves of fronts between two calls of `check`."""

_COLUMN = (1 << 29) - 1
_ONE = np.uint64(1)


@compiled_loop
def go_on(ground: WaveGround, costs: WaveCosts, tiles: WaveTiles, lists: WaveLists) -> int:
    """
    Go on with a wave for some cycles.

    Returns ``DONE``, ``PAUSED``, or ``FULL`` if the lists must grow.
    """
    state = ground.state
    moves = state[MOVES] + _MOVES_AT_A_TIME
    longest_turn = costs.times[-1]
    while state[MOVES] <= moves:
        now = state[TIME]
        if state[PHASE] == _WALKING:
            if now + 2 > len(lists.begins) or not _walk(ground, costs, tiles, lists):
                return FULL
            _settle(ground, tiles, lists)
            if state[BEST] <= (now + 1) * costs.cycle:
                return DONE
            state[PHASE], state[TURN] = _TURNING, 0
            state[READ] = lists.begins[max(now - costs.times[0], 0)]
        if not _turn(ground, costs, tiles, lists):
            return FULL
        now += 1
        if now * costs.cycle > costs.most:
            return DONE
        is_turning = lists.begins[now] > lists.begins[max(now - longest_turn, 0)]
        if state[FRONTS] == 0 and not is_turning:
            return DONE
        state[TIME], state[PHASE], state[READ], state[WRITTEN] = now, _WALKING, 0, 0
    return PAUSED


@compiled_part
def _walk(ground: WaveGround, costs: WaveCosts, tiles: WaveTiles, lists: WaveLists) -> bool:
    """Let all fronts go on until the end of the cycle; return whether there was room."""
    # Arrays one by one, for compiled code counts references to those of a tuple at each look.
    words, numbers, state = ground.words, ground.numbers, ground.state
    width, goal = ground.width, ground.goal
    steps, reached, closed, fresh = tiles.steps, tiles.reached, tiles.closed, tiles.fresh
    arrived, fronts, listed = tiles.arrived, lists.fronts, lists.words
    least_turns, scale, most, pause = costs.least_turns, costs.scale, costs.most, costs.pause
    limit = state[TIME] * costs.cycle
    weights, left, bottom = ground.weights, ground.left, ground.bottom
    is_weighted = len(weights) > 0
    goal_x, goal_y = goal % width, goal // width
    most_steps = costs.cycle // costs.straight + 2
    while state[READ] < state[FRONTS]:
        if state[LISTED] + most_steps > len(listed):
            return False
        place, cost = fronts[state[READ], 0], fronts[state[READ], 1]
        state[READ] += 1
        x, y, k = place >> 3 & _COLUMN, place >> 32, place & 7
        step = costs.diagonal if k & 1 else costs.straight
        goes_on = True
        tile = numbers[y >> 3, x >> 3]
        if tile == 0:
            # The start's.
            tile = _new_tile(ground, tiles, x, y)
        word, cell = 8 * tile + k, _cell(x, y)
        while True:
            if not steps[word] >> np.uint64(cell) & _ONE:
                goes_on = False
                break
            onward = step
            if is_weighted:
                row, column = y + bottom, x + left
                weight = weights[row, column] + weights[row + DY[k], column + DX[k]]
                onward = step * weight // TWO_PARTS
            if cost + onward > limit:
                break
            x, y, cost = x + DX[k], y + DY[k], cost + onward
            tile = numbers[y >> 3, x >> 3]
            if tile == 0:
                tile = _new_tile(ground, tiles, x, y)
            word, cell = 8 * tile + k, _cell(x, y)
            bit = _ONE << np.uint64(cell)
            if fresh[word] & bit:
                # Reached in this cycle: of two fronts the one behind ends in the next.
                continue
            if reached[word] & bit or (pause == 0 and closed[word] & bit):
                goes_on = False
                break
            reached[word] |= bit
            arrived[word << 6 | cell] = state[TIME]
            if y * width + x == goal:
                total = limit + costs.last_turns[k]
                if total <= most and total < state[BEST]:
                    state[BEST], state[HEADING], state[ARRIVED] = total, k, state[TIME]
                goes_on = False
                break
            if fresh[word] == 0:
                listed[state[LISTED]] = word
                state[LISTED] += 1
            fresh[word] |= bit
        if goes_on:
            ahead = word_length(words[y * width + x])
            total = total_cost(cost, ahead, goal_x - x, goal_y - y, k, scale, least_turns)
            if total <= most:
                fronts[state[WRITTEN], 0] = place_of(x, y, k)
                fronts[state[WRITTEN], 1] = cost
                state[WRITTEN] += 1
    state[MOVES] += state[FRONTS]
    state[FRONTS] = state[WRITTEN]
    return True


@compiled_part
def _settle(ground: WaveGround, tiles: WaveTiles, lists: WaveLists) -> None:
    """List what was reached in this cycle, where it is of use to turn."""
    state, closed, fresh = ground.state, tiles.closed, tiles.fresh
    listed, listed_bits, begins = lists.words, lists.bits, lists.begins
    now = state[TIME]
    kept = begins[now]
    for at in range(begins[now], state[LISTED]):
        word = listed[at]
        bits = fresh[word] & ~closed[word]
        closed[word] |= bits
        fresh[word] = 0
        if bits:
            listed[kept], listed_bits[kept] = word, bits
            kept += 1
    state[LISTED] = begins[now + 1] = kept


@compiled_part
def _turn(ground: WaveGround, costs: WaveCosts, tiles: WaveTiles, lists: WaveLists) -> bool:
    """Begin stretches where turns are over in this cycle; return whether there was room."""
    words, width, numbers, state = ground.words, ground.width, ground.numbers, ground.state
    steps, closed, corners = tiles.steps, tiles.closed, tiles.corners
    fronts, listed, listed_bits, begins = lists.fronts, lists.words, lists.bits, lists.begins
    times, turns = costs.times, costs.turns
    least_turns, scale, most = costs.least_turns, costs.scale, costs.most
    goal_x, goal_y = ground.goal % width, ground.goal // width
    now = state[TIME]
    begun = now * costs.cycle + costs.pause
    while state[TURN] < len(times):
        then = now - times[state[TURN]]
        end = begins[then + 1] if then >= 0 else 0
        while state[READ] < end:
            if state[FRONTS] + HEADINGS * 64 > len(fronts):
                return False
            word, found = listed[state[READ]], listed_bits[state[READ]]
            state[READ] += 1
            to = turns[state[TURN], word & 7]
            for j in range(HEADINGS):
                turned = word & ~7 | j
                bits = found & ~closed[turned]
                if not to >> j & 1 or not bits:
                    continue
                closed[turned] |= bits
                bits &= steps[turned]
                step = costs.diagonal if j & 1 else costs.straight
                while bits:
                    cell = first_bit(bits)
                    bits &= bits - _ONE
                    x = corners[word >> 3 << 1] + (cell & 7)
                    y = corners[word >> 3 << 1 | 1] + (cell >> 3)
                    ahead_x, ahead_y = x + DX[j], y + DY[j]
                    tile = numbers[ahead_y >> 3, ahead_x >> 3]
                    ahead = np.uint64(_cell(ahead_x, ahead_y))
                    if tile and closed[8 * tile + j] >> ahead & _ONE:
                        # Whoever was there is ahead.
                        continue
                    left = word_length(words[ahead_y * width + ahead_x])
                    dx, dy = goal_x - ahead_x, goal_y - ahead_y
                    total = total_cost(begun + step, left, dx, dy, j, scale, least_turns)
                    if total <= most:
                        fronts[state[FRONTS], 0], fronts[state[FRONTS], 1] = (
                            place_of(x, y, j),
                            begun,
                        )
                        state[FRONTS] += 1
        state[TURN] += 1
        if state[TURN] < len(times):
            state[READ] = begins[max(now - times[state[TURN]], 0)]
    return True


@compiled_part
def _new_tile(ground: WaveGround, tiles: WaveTiles, x: int, y: int) -> int:
    """Make the tile of a cell; return its number."""
    tile = int(ground.state[TILES])
    ground.state[TILES] += 1
    ground.numbers[y >> 3, x >> 3] = tile
    make_tile(ground.words, ground.width, ground.goal, tiles, tile, x, y)
    return tile


@inlined_part
def _cell(x: int, y: int) -> int:
    """Return the bit of a cell in its tile."""
    return (y & 7) << 3 | (x & 7)


@inlined_part
def place_of(x: int, y: int, heading: int) -> int:
    """Return a front's place in one number."""
    return y << 32 | x << 3 | heading
