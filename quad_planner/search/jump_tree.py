"""
What a jump point search has reached: nodes by their cells, and a heap of those that wait.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part

Records = NDArray[np.void]


_NODES_AT_FIRST = 2048


_HASH = np.uint64(0x9E3779B97F4A7C15)


_NODE = np.dtype(
    [
        ('length', np.int64),  # from the start
        ('x', np.int64),  # the cell, walls included
        ('y', np.int64),
        ('parent', np.int32),  # number of a node
        ('arrivals', np.uint8),  # directions by which a path of that length arrives, a bit each
        ('taken', np.uint8),  # directions in which the search went on, a bit each
    ],
    align=True,
)


_OPEN = np.dtype([('key', np.int64), ('node', np.int64)])


class Tree(NamedTuple):
    """
    What a search has reached: nodes, numbered as they were found; number 0 is the start.

    A search looks at few cells of a large map: the arrays grow with these, not with the map.
    """

    nodes: Records
    """Records of `_NODE`."""
    slots: NDArray[np.int32]
    """
    Slots by cells' hashes, 2^k: the number of a cell's node plus one, or 0; a cell's slot is where
    its hash points, or behind.
    """
    heap: Records
    """Records of `_OPEN`: nodes and the least length of a path through them, the least first."""
    counts: NDArray[np.int64]
    """Numbers of nodes and of entries of the heap, shape (2,)."""


def tree_of(start: tuple[int, int]) -> Tree:
    """Make a tree of the start alone."""
    tree = Tree(
        nodes=np.empty(_NODES_AT_FIRST, dtype=_NODE),
        slots=np.zeros(2 * _NODES_AT_FIRST, dtype=np.int32),
        heap=np.empty(_NODES_AT_FIRST, dtype=_OPEN),
        counts=np.ones(2, dtype=np.int64),
    )
    tree.nodes[0] = (0, *start, 0, 0, 0)
    tree.heap[0] = (0, 0)
    _fill_slots(tree.nodes, tree.slots, 1)
    return tree


def larger_tree(tree: Tree) -> Tree:
    """Return the same tree with twice the room."""
    size = len(tree.nodes)
    larger = Tree(
        nodes=np.empty(2 * size, dtype=_NODE),
        slots=np.zeros(4 * size, dtype=np.int32),
        heap=np.empty(2 * size, dtype=_OPEN),
        counts=tree.counts,
    )
    larger.nodes[:size] = tree.nodes
    larger.heap[:size] = tree.heap
    _fill_slots(larger.nodes, larger.slots, int(tree.counts[0]))
    return larger


@compiled_loop
def _fill_slots(nodes: Records, slots: NDArray[np.int32], count: int) -> None:
    for node in range(count):
        slots[slot_of(nodes, slots, nodes[node].x, nodes[node].y)] = node + 1


@compiled_part
def slot_of(nodes: Records, slots: NDArray[np.int32], x: int, y: int) -> int:
    """Return the slot that a cell has, or would have."""
    last = len(slots) - 1
    mixed = ((np.uint64(y) << np.uint64(32)) + np.uint64(x)) * _HASH
    slot = int(mixed >> np.uint64(32)) & last
    while slots[slot] != 0:
        node = slots[slot] - 1
        if nodes[node].x == x and nodes[node].y == y:
            break
        slot = (slot + 1) & last
    return slot


@compiled_part
def push_node(heap: Records, counts: NDArray[np.int64], key: int, node: int) -> None:
    """Put a node on the heap."""
    at = counts[1]
    counts[1] += 1
    while at > 0:
        parent = (at - 1) >> 1
        if heap[parent].key <= key:
            break
        heap[at] = heap[parent]
        at = parent
    heap[at].key = key
    heap[at].node = node


@compiled_part
def pop_node(heap: Records, counts: NDArray[np.int64]) -> None:
    """Take the first off the heap, whose content has been read."""
    counts[1] -= 1
    count = counts[1]
    last = heap[count]
    at = 0
    while True:
        child = 2 * at + 1
        if child >= count:
            break
        if child + 1 < count and heap[child + 1].key < heap[child].key:
            child += 1
        if heap[child].key >= last.key:
            break
        heap[at] = heap[child]
        at = child
    heap[at] = last
