"""After warming up nothing of the footing is left to compile."""

import json
import subprocess
import sys
from pathlib import Path

# In a child, in which nothing is compiled yet.
COUNT = """
import json
import sys
import numpy as np
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.footing import nearest_footholds, stances
from quad_planner.methods.footed_planner import FootingOptions
from quad_planner.footing.footing import FootedRobot
from quad_planner.methods.planner import make_planner
from quad_planner.planner_setup import outline_for

def kinds():
    found = [f for m in (nearest_footholds, stances) for f in vars(m).values()]
    return {f.__name__: len(f.signatures) for f in found if hasattr(f, 'signatures')}

robot = load_robot('titan_viii')
footed = FootedRobot.of(robot)
options = FootingOptions(footed, outline_for(robot))
make_planner('mesh', footing=options, mesh_size=0.6, clearance_radius=0.35).warm_up()
ready, loaded = kinds(), [name for name in ('cv2', 'scipy.ndimage') if name in sys.modules]
rng = np.random.default_rng(0)
heights = HeightMap(0.15 * rng.random((60, 60)) * (rng.random((60, 60)) < 0.2), 0.04, (0.0, 0.0))
grid = OccupancyGrid(np.zeros((48, 48), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
before = footed.on(heights)
unfit = int(before.layers(grid).any())
changed = heights.heights.copy()
changed[3, 3] += 0.1
footed.on(heights.with_heights(changed), before).layers(grid)
print(json.dumps([unfit, loaded, ready, kinds()]))
"""


def test_after_warming_up_no_loop_over_footholds_is_left_to_compile():
    done = subprocess.run(
        [sys.executable, '-c', COUNT],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[3],
    )
    unfit, loaded, ready, then = json.loads(done.stdout)
    assert unfit == 1
    # They take long to load, and without a height map nothing needs them.
    assert loaded == []
    assert then == ready
    assert set(then.values()) == {1}
    assert len(then) == 4
