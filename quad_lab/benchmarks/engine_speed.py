"""
Part of ``quadwalk bench engines``: how fast each engine is, alone, in the loop and over topics.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.maps.map_file import load_map
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.gait_measures import PlanWalk, plan_walk
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_planner.planner_setup import planner_for
from quad_sim.engines.registry import make_simulator, preferred

Bars = tuple[list[Criterion], dict[str, Any]]

BACKENDS = ('bullet', 'mujoco')
"""The first is what the second is compared with."""

_STEPS, _ROUNDS = 50, 120
"""Steps that are timed together, and how often; the engines take turns."""

_START, _GOAL = Pose2D(1.2, 1.2, 0.0), Pose2D(6.8, 4.8, math.pi / 2.0)
"""Ends of the walk through the room whose speed is measured, as in ``quadwalk demo``."""

_SHORT_GOAL = Pose2D(1.5, 2.0, 1.0)
"""End of a short walk from the same start."""


def step_times(console: Console, quick: bool, seed: int) -> Bars:
    """
    Time a step and an observation of a standing robot, the engines in turn.

    What counts is the processor's time of this thread: on a machine that does other work the
    elapsed time says little, and both engines work in the thread that calls them.
    """
    bars, details = [], {}
    for name in available_robots():
        robot = load_robot(name)
        posture, still = robot.initial_joint_angles.reshape(-1), np.zeros(12)
        simulators = [make_simulator(backend, robot, None) for backend in BACKENDS]
        times = np.full((2, 2, 10 if quick else _ROUNDS), math.inf)
        for simulator in simulators:
            for _ in range(_STEPS):
                simulator.step(posture, still)
        for turn, (index, simulator) in product(range(times.shape[2]), enumerate(simulators)):
            began = time.thread_time()
            for _ in range(_STEPS):
                simulator.step(posture, still)
            stepped = time.thread_time()
            for _ in range(_STEPS):
                simulator.observe()
            times[index, :, turn] = stepped - began, time.thread_time() - stepped
        for simulator in simulators:
            simulator.close()
        # The least of many: the others were disturbed.
        steps, observations = (times.min(axis=2) * 1e6 / _STEPS).T
        details[name] = {'step': steps.tolist(), 'observation': observations.tolist()}
        bars += [
            at_least(f'{name}: a step, PyBullet over MuJoCo', steps[0] / steps[1], 'times', 4.0),
            figure(f'{name}: a step in MuJoCo', steps[1], 'us'),
            at_least(
                f'{name}: an observation, PyBullet over MuJoCo',
                observations[0] / observations[1],
                'times',
                2.0,
            ),
        ]
    return bars, details


def loop_speed(console: Console, quick: bool, seed: int) -> Bars:
    """Time a walk through the room without topics, and see whether it repeats."""
    bars, details = [], {}
    for backend, least in zip(BACKENDS, (25.0, 40.0)):
        with preferred(backend):
            factor, first = timed_walk(4.0 if quick else 120.0)
            _, second = timed_walk(4.0 if quick else 120.0)
        same = np.array_equal(first.record.positions, second.record.positions)
        details[backend] = {'factor': factor, 'repeats': bool(same)}
        bars += [
            at_least(f'{backend}: a walk without topics', factor, 'x real time', least),
            at_least(f'{backend}: the same walk repeats bit for bit', same, '', 1),
        ]
    return bars, details


def timed_walk(timeout: float) -> tuple[float, PlanWalk]:
    """
    Walk through the room without topics.

    Parameters
    ----------
    timeout : float
        Simulated time that is walked at most [s].

    Returns
    -------
    tuple of float and PlanWalk
        Simulated over elapsed time, and the walk.
    """
    robot = load_robot('titan_viii')
    planner = planner_for(robot, 'mesh')
    planner.set_map(load_map(sample_map('room')))
    # The walk begins at the origin.
    plan = planner.plan(_START, _GOAL)
    plan = Plan(tuple(_START.inverse() @ pose for pose in plan.poses))
    began = time.perf_counter()
    walk = plan_walk(robot, load_gait('crawl', robot), plan, 'in_place', timeout)
    return walk.record.times[-1] / (time.perf_counter() - began), walk


def topic_speed(console: Console, quick: bool, seed: int) -> Bars:
    """Time the same walk over topics."""
    # Only this part needs ROS.
    from quad_lab.topic_walk.walk import WalkOptions, walk

    goal = _SHORT_GOAL if quick else _GOAL
    bars, details = [], {}
    for backend, least in zip(BACKENDS, (13.0, 20.0)):
        options = WalkOptions(
            map_file=sample_map('room'), start=_START, goal=goal, backend=backend, seed=seed
        )
        result = walk(options).result()
        details[backend] = result.as_dict()
        bars += [
            at_least(f'{backend}: walks over topics that arrived', result.arrived, 'of 1', 1),
            at_least(f'{backend}: over topics', result.real_time_factor, 'x real time', least),
            at_most(f'{backend}: late trajectories', result.late_trajectories, '', 0),
        ]
        short = replace(options, goal=_SHORT_GOAL, composed=True)
        twice = [_without_the_clock(walk(short).result().as_dict()) for _ in range(2)]
        same = twice[0] == twice[1]
        bars.append(at_least(f'{backend}: a composed walk repeats bit for bit', same, '', 1))
    return bars, details


def _without_the_clock(result: dict[str, object]) -> dict[str, object]:
    """Leave out what depends on how fast the machine is."""
    return {k: v for k, v in result.items() if k not in ('wall_time', 'real_time_factor')}
