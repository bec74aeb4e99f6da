"""A machine that pauses again and again makes no robot fall that feels for the ground."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
import pytest

from quad_common.errors import TrajectoryError
from quad_common.robot.robot_file import load_robot
from quad_common.rotations import tilt_from_quaternion
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_lab.closed_loop.terrain_walk import make_course

DEPTH = 5
"""Readings that wait for a gait that was not given the processor; older ones are lost."""

OFTEN = 0.02
"""Probability that a pause begins with a reading."""

TITAN = load_robot('titan_viii')


class PausedLoop(ClosedLoop):
    """A walk whose gait is not given the processor at random moments."""

    def pause(self, seed: int, longest: float):
        """Begin to pause, up to a time [s]."""
        self.rng = np.random.default_rng(seed)
        self.longest = longest
        self.until = 0.0
        self.waiting = deque(maxlen=DEPTH)
        self.tilt = 0.0

    def measure(self):
        seen = self._simulation.observe()
        self.tilt = max(self.tilt, tilt_from_quaternion(seen.orientation))
        self.waiting.append(seen)
        if self.time < self.until:
            return
        if self.rng.random() < OFTEN:
            self.until = self.time + self.rng.uniform(0.0, self.longest)
            return
        while self.waiting:
            state = self._state(self.waiting.popleft())
            trajectory = None if state is None else self.controller.update(state)
            if trajectory is not None:
                self._send(trajectory)

    def _send(self, trajectory):
        try:
            super()._send(trajectory)
        except TrajectoryError:
            # It was over before it came.
            return


# Each of them fell within this time while a foot was lifted whatever the others stood on.
@pytest.mark.parametrize(
    ('course', 'seed', 'longest', 'duration'), [('kerb', 2, 1.0, 20.0), ('bumps', 1, 0.3, 22.0)]
)
def test_a_robot_that_feels_for_the_ground_stays_upright(course, seed, longest, duration):
    ground = make_course(TITAN, course, 1)
    options = for_uneven_ground(SupervisorOptions(least_margin=-math.inf))
    controller = controller_for(TITAN, load_gait('crawl', TITAN), options)
    walk = PausedLoop(TITAN, controller, world=ground.world, start=ground.start)
    walk.pause(seed, longest)
    try:
        walk.run(1.0)
        controller.set_plan(ground.plan)
        walk.run(duration)
    finally:
        walk.close()
    assert walk.tilt < math.radians(6.0)
