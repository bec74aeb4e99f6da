"""Staircases, stepping stones, gaps and beams are as they are described."""

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_sim.world.terrain_spec import make_terrain, needs_footholds, specs_from_text

BOUNDS = (-1.0, -1.0, 5.0, 1.0)
START = Pose2D(0.0, 0.0, 0.0)
LEVEL_AT = ((0.0, 0.0), (4.2, 0.0))


def terrain_of(text, start=START, **numbers):
    return make_terrain(specs_from_text(text, **numbers), BOUNDS, start, LEVEL_AT)


def heights_along(terrain, y=0.0, step=0.01):
    x = np.arange(-0.9, 4.9, step) + 0.001
    return x, terrain.height_at(np.column_stack([x, np.full(len(x), y)]))


def test_stairs_rise_one_by_one_and_fall_again():
    terrain = terrain_of('stairs:height=0.04,size=0.3,count=4,length=0.5')
    x, z = heights_along(terrain)
    expected = np.zeros(len(x))
    for k in range(4):
        expected += 0.04 * ((x > 0.8 + 0.3 * k) & (x < 0.8 + 1.8 + 0.5 - 0.3 * k))
    assert z == pytest.approx(expected)
    assert z.max() == pytest.approx(0.16)


def test_stones_lie_a_gap_apart_over_a_pit_each_at_its_height():
    text = 'stones:height=0.02,size=0.2,gap=0.1,length=1.5,depth=0.4'
    terrain = terrain_of(text, seed=3)
    x, _ = heights_along(terrain)
    inside = (x > 0.8) & (x < 2.4)
    on_stone = np.zeros(len(x), dtype=bool)
    for y in np.linspace(-0.9, 0.9, 181):
        z = heights_along(terrain, y)[1]
        assert (z[x < 0.79] == 0.0).all()
        on_stone |= z > -0.03
        assert ((z[inside] > -0.0201) | (z[inside] < -0.1)).all()
    # The rows, whose stones are in different places, and between them the pit alone.
    edges = np.flatnonzero(np.diff(on_stone.astype(int)))
    widths = np.diff(x[edges])
    assert len(edges) == 2 * 5
    assert widths[1::2] == pytest.approx(0.2, abs=0.011)
    assert widths[0::2] == pytest.approx(0.1, abs=0.031)
    tops = {block.top for block in terrain.blocks}
    assert len(tops) == len(terrain.blocks)
    assert all(-0.02 <= top <= 0.0 for top in tops)
    same, other = terrain_of(text, seed=3), terrain_of(text, seed=4)
    assert same.blocks == terrain.blocks != other.blocks


def test_a_gap_is_as_wide_and_deep_as_it_is_to_be():
    terrain = terrain_of('gap:gap=0.2,depth=0.5')
    x, z = heights_along(terrain)
    assert z[(x > 0.83) & (x < 0.97)] == pytest.approx(-0.5)
    assert (z[(x < 0.79) | (x > 1.01)] == 0.0).all()


def test_a_beam_leads_over_its_pit():
    terrain = terrain_of('beam:width=0.7,length=1.5')
    assert not heights_along(terrain)[1].any()
    assert not heights_along(terrain, 0.34)[1].any()
    x, z = heights_along(terrain, 0.4)
    assert z[(x > 0.83) & (x < 2.27)] == pytest.approx(-0.3)


def test_a_pit_leaves_the_goal_on_level_ground():
    terrain = make_terrain(
        specs_from_text('stones:length=3,clear=0.5'), BOUNDS, START, ((0.0, 0.0), (2.0, 0.0))
    )
    angles = np.linspace(0.0, 2.0 * np.pi, 24)
    around = np.column_stack([2.0 + 0.47 * np.cos(angles), 0.47 * np.sin(angles)])
    assert (terrain.field.height_at(around) == 0.0).all()
    assert terrain.lowest == -0.3


def test_footholds_are_needed_where_there_is_a_pit():
    assert needs_footholds('noise+stones:gap=0.1')
    assert needs_footholds('gap')
    assert needs_footholds('beam')
    assert not needs_footholds('stairs+noise')
    assert not needs_footholds('flat')
