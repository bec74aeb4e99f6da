"""
Followed through the code, a measurement enters each file that decides at most twice.

Whoever reads how a trajectory comes about opens a file, follows what it does, and comes back to
it once at the most: to be asked, and to be told what came of it. An entry is a call from another
file of quadwalk. What a signal or a service wishes for is not a measurement; what becomes of a
trajectory that the last gate refuses is another decision.
"""

import pytest
from file_entries import counted
from walk_scenes import SCENES, Traced

CASES = [(scene, 'crawl') for scene in SCENES]
# A trot goes on in motion; it needs even ground.
CASES += [(scene, 'trot') for scene in SCENES if SCENES[scene].uneven is None]


@pytest.mark.sweep(kept=8)
@pytest.mark.parametrize(('scene', 'gait'), CASES, ids=lambda case: getattr(case, '__name__', case))
def test_a_decision_enters_each_file_at_most_twice(scene, gait):
    walk, seen, found = Traced(SCENES[scene], gait), set(), {}
    walk.supervisor.update = counted(walk.supervisor.update, seen, found)
    walk.run(0.5)
    scene(walk)
    assert not found
    assert 'quad_gait/behaviours/guidance.py' in seen
