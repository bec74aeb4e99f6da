"""What is known of all cells and classes in advance is what each kernel says."""

import numpy as np
import pytest

from quad_lab.benchmarks.planning.footprint_maps import free_classes
from quad_planner.grid.bit_grid import BitMask
from quad_planner.outline import class_layers as module
from quad_planner.outline.class_layers import class_layers
from quad_planner.outline.heading_kernels import CLASSES, kernels_of

# Longer behind than ahead, and not the same to both sides.
OUTLINE = np.array([[0.3, 0.1], [-0.45, 0.15], [-0.45, -0.2], [0.3, -0.15]])


@pytest.mark.parametrize(('width', 'resolution'), [(64, 0.05), (75, 0.03), (130, 0.1)])
def test_a_class_does_not_fit_where_its_kernel_holds_an_obstacle(width, resolution):
    rng = np.random.default_rng(width)
    blocked = rng.random((50, width)) < 0.005
    blocked[:, [0, -1]] |= rng.random((50, 2)) < 0.1
    kernels = kernels_of(OUTLINE, 0.05, resolution)
    mask = BitMask.of(blocked)
    # Beyond the width a mask may hold anything.
    if width % 64:
        mask.words[:, -1] |= np.uint64(2**64 - 2 ** (width % 64))
    layers = class_layers(mask.words, width, kernels)
    free = free_classes(blocked, np.zeros_like(blocked), kernels)
    assert 0.02 < free.mean() < 0.98
    for k in range(CLASSES):
        assert np.array_equal(BitMask(layers[k], width).unpacked(), free[k] == 0)


def test_large_maps_and_kernels_are_left_to_the_search(monkeypatch):
    kernels = kernels_of(OUTLINE, 0.05, 0.05)
    words = np.zeros((10, 1), dtype=np.uint64)
    assert class_layers(words, 60, kernels) is not None
    assert class_layers(words, 60, kernels_of(OUTLINE, 0.05, 0.008)) is None
    monkeypatch.setattr(module, '_LARGEST', 599)
    assert class_layers(words, 60, kernels) is None
