"""Compiled code is ready after warming up, and its parts work uncompiled too."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import NumbaError

from quad_common.compiled import compiled, compiled_loop, compiled_part

ROOT = Path(__file__).parents[3]

OPTIONS = (
    {'method': 'mesh'},
    {'method': 'shortest', 'any_angle': True},
    {'method': 'shortest', 'fewest_turns': True},
    {'method': 'quickest', 'any_angle': True},
    {'method': 'potential', 'potential': 'paper'},
    {'method': 'potential', 'potential': 'either'},
)

# Each planner in a child of its own, in which nothing is compiled yet; all is imported only once.
COUNT = """
import json
import os
import sys
import numba
import numpy as np
from quad_common.errors import PlannerError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.robot_files.walking_time import load_pace
from quad_common.planar_pose import Pose2D
from quad_planner.methods.planner import make_planner

def kinds():
    modules = [module for name, module in sys.modules.items() if name.startswith('quad_planner')]
    found = {id(f): f for module in modules for f in vars(module).values()}
    compiled = [f for f in found.values() if hasattr(f, 'signatures') and hasattr(f, 'py_func')]
    return {f'{f.__module__}.{f.__name__}': len(f.signatures) for f in compiled}

def count(options):
    planner = make_planner(
        mesh_size=0.6, clearance_radius=0.35, pace=load_pace('titan_viii', 'crawl'), **options
    )
    planner.warm_up()
    ready = kinds()
    rng = np.random.default_rng(0)
    plans = 0
    for _ in range(12):
        height, width = rng.integers(40, 130, 2)
        cells = np.zeros((height, width), dtype=np.int8)
        for y, x in rng.integers(0, min(height, width), (height * width // 700, 2)):
            cells[y : y + rng.integers(1, 12), x : x + rng.integers(1, 12)] = rng.choice([100, -1])
        for changed in (False, True):
            if changed:
                cells = cells.copy()
                cells[5:8] = 0
            grid = OccupancyGrid(cells, 0.1, Pose2D(0.0, 0.0, 0.3))
            planner.set_map(grid)
            for _ in range(4):
                ends = grid.map_to_world(rng.uniform(0.0, (width, height), (2, 2))).tolist()
                try:
                    planner.plan(*(Pose2D(x, y, rng.uniform(-3.0, 3.0)) for x, y in ends))
                    plans += 1
                except PlannerError:
                    pass
    return [plans, ready, kinds()]

for options in json.loads(sys.argv[1]):
    child = os.fork()
    if child == 0:
        print(json.dumps(count(options)), flush=True)
        os._exit(0)
    os.waitpid(child, 0)
"""


@pytest.mark.slow
def test_after_warming_up_nothing_is_left_to_compile():
    command = [sys.executable, '-c', COUNT, json.dumps(OPTIONS)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    lines = done.stdout.splitlines()
    assert len(lines) == len(OPTIONS), done.stderr
    for options, line in zip(OPTIONS, lines):
        plans, ready, then = json.loads(line)
        assert plans > 20, options
        assert then == ready, options
        assert max(then.values()) == 1, options


@compiled_part
def _half(number):
    return number // 2


@compiled
def _halves(numbers):
    for k in range(len(numbers)):
        numbers[k] = _half(numbers[k])


def test_python_may_call_a_part_of_compiled_code():
    numbers = np.arange(10)
    _halves(numbers)
    assert numbers.tolist() == [_half(k) for k in range(10)]


@compiled_loop
def _add_up(rows, total):
    for k in range(len(rows[0])):
        row = rows[0][k]
        for value in row:
            total[0] += value


def test_a_loop_holds_no_array_longer_than_its_call():
    rows, total = np.ones((5, 7)), np.zeros(1)
    # The first call compiles.
    _add_up((rows,), total)
    before = sys.getrefcount(rows), sys.getrefcount(total)
    for _ in range(100):
        _add_up((rows,), total)
    assert (sys.getrefcount(rows), sys.getrefcount(total)) == before
    assert total[0] == 101 * rows.sum()


@compiled_loop
def _make(count):
    return np.zeros(count)


def test_a_loop_that_makes_an_array_is_refused():
    # Without counts nobody would ever give its memory back.
    with pytest.raises(NumbaError):
        _make(3)
