"""Random starts and goals of walks are drawn, or it is said that there are none."""

import math
from pathlib import Path

import numpy as np
import pytest

from quad_common.errors import ParameterError, PlannerError
from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks import bench_walk
from quad_lab.benchmarks.bench_walk import SHORTEST, draw_pairs
from quad_lab.tools.benchmark_maps import benchmark_maps

ROBOT = load_robot('titan_viii')


@pytest.mark.parametrize('longest', [0.0, 0.3, SHORTEST, -1.0, math.nan])
def test_a_longest_plan_below_the_shortest_is_refused(longest: float):
    with pytest.raises(ParameterError, match=r'it must be more than 0.5 m'):
        draw_pairs(ROBOT, benchmark_maps(), 1, longest, 0)


def test_without_a_map_nothing_is_drawn():
    with pytest.raises(ParameterError, match='one map at least'):
        draw_pairs(ROBOT, [], 1, math.inf, 0)


def test_a_map_without_room_ends_the_drawing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(bench_walk, '_MOST_DRAWS', 50)
    (tmp_path / 'full.pgm').write_bytes(b'P5 40 40 255\n' + bytes(1600))
    (tmp_path / 'full.yaml').write_text(
        'image: full.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n'
        'occupied_thresh: 0.65\nfree_thresh: 0.2\n'
    )
    with pytest.raises(PlannerError, match=r'of 50 random pairs of poses on full.yaml none has'):
        draw_pairs(ROBOT, [tmp_path / 'full.yaml'], 1, math.inf, 0)


def test_pairs_are_the_same_for_the_same_seed():
    drawn = [draw_pairs(ROBOT, benchmark_maps()[:1], 2, math.inf, 3) for _ in range(2)]
    assert drawn[0] == drawn[1]
    starts = np.array([(start.x, start.y) for _, start, _ in drawn[0]])
    assert len(np.unique(starts, axis=0)) == 2
