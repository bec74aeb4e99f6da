"""Height maps are spoiled as they are said to be, and robots told of nothing else."""

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.ground.wrong_maps import FAULTS, faulty_knowledge, shifted, with_holes
from quad_lab.closed_loop.ground_walk import GroundWalk, make_scene

TITAN = load_robot('titan_viii')


def hills():
    level = HeightMap.level((-1.0, -2.0, 3.0, 2.0), 0.02)
    x, y = np.moveaxis(level.centers, -1, 0)
    return level.with_heights(0.03 * np.sin(4.0 * x) + 0.02 * np.cos(5.0 * y))


def test_a_shifted_map_shows_all_ground_aside_and_higher_or_lower_by_the_same():
    truth, places = hills(), np.random.default_rng(1).uniform(0.0, 1.5, (50, 2))
    seen = set()
    for seed in range(100):
        wrong = shifted(truth, 0.02, np.random.default_rng(seed))
        dx, dy = np.subtract(wrong.origin, truth.origin)
        up = wrong.height_at(places + (dx, dy)) - truth.height_at(places)
        assert np.abs([dx, dy]) == pytest.approx(0.02)
        assert np.ptp(up) < 1e-12
        assert abs(up[0]) == pytest.approx(0.02)
        seen.add((dx > 0.0, dy > 0.0, up[0] > 0.0))
    assert len(seen) == 8


def test_a_fifth_of_a_map_with_holes_is_unknown_and_the_rest_as_it_was():
    truth = hills()
    wrong = with_holes(truth, 0.12, np.random.default_rng(3))
    unknown = np.isnan(wrong.heights)
    assert unknown.mean() == pytest.approx(0.2, abs=0.05)
    assert np.array_equal(wrong.heights[~unknown], truth.heights[~unknown])


@pytest.mark.parametrize('fault', FAULTS)
def test_a_robot_is_told_what_is_wrong_and_where_it_believes_to_be(fault):
    scene = make_scene(TITAN, 'bumps', 2)
    knowledge = faulty_knowledge(TITAN, scene, fault)
    again = faulty_knowledge(TITAN, scene, fault)
    assert (knowledge.height_map is None) == (fault == 'none')
    if knowledge.height_map is not None:
        assert np.array_equal(
            knowledge.height_map.heights, again.height_map.heights, equal_nan=True
        )
    assert knowledge.localisation.drift == 0.03


def test_a_walk_goes_by_what_the_robot_believes():
    scene = make_scene(TITAN, 'bumps', 2)
    walk = GroundWalk(TITAN, scene, knowledge=faulty_knowledge(TITAN, scene, 'none'))
    try:
        walk.run(7.0)
        seen = walk.loop.simulation.observe()
        turned = abs(wrap_angle(seen.pose.yaw - scene.start.yaw))
        off = abs(wrap_angle(walk.loop.locate(seen)[0].yaw - seen.pose.yaw))
        assert turned > 0.3
        assert 0.005 * turned < off < 0.1 * turned
    finally:
        walk.close()
