"""
How fast cycles are planned: vectorised, in a Python loop, and with others' inverse kinematics.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import CycleOptions, generate_cycle
from quad_lab.tools.criterion import Criterion, at_most, figure

Array = NDArray[np.float64]

_SAMPLE_PERIOD = 0.01


def speed_bars(quick: bool) -> list[Criterion]:
    """
    Time a cycle of 5 s at 100 Hz, twelve joints, positions and velocities.

    Parameters
    ----------
    quick : bool
        Time less often.

    Returns
    -------
    list of Criterion
        Milliseconds, and the ratios of two other methods to it, from this run.
    """
    robot = load_robot('titan_viii')
    crawl = load_gait('crawl', robot)
    motion = BodyMotion(forward=0.2)

    def plan() -> None:
        generate_cycle(robot, crawl, motion, options=CycleOptions(_SAMPLE_PERIOD))

    planned = _fastest(plan, 20 if quick else 100)
    cycle = generate_cycle(robot, crawl, motion, options=CycleOptions(_SAMPLE_PERIOD))
    feet = robot.foot_positions(cycle.joint_positions)

    def loop() -> None:
        """Do the same inverse kinematics, sample by sample and leg by leg."""
        for sample in range(len(cycle.times)):
            for k, leg in enumerate(robot.legs):
                angles = leg.inverse(feet[sample, k])
                leg.joint_velocities(angles, cycle.joint_velocities[sample, k])

    looped = _fastest(loop, 1 if quick else 3)
    bars = [
        at_most('cycle of 5 s at 100 Hz, 12 joints', 1e3 * planned, 'ms', 2.0),
        figure('a loop over its samples, inverse kinematics alone', looped / planned, 'x as long'),
    ]
    numeric = _numeric(robot, feet, 3 if quick else 20)
    bars.append(
        figure(
            "ikpy's numeric inverse kinematics, positions alone",
            None if numeric is None else numeric / planned,
            'x as long',
        )
    )
    return bars


def _fastest(work: Callable[[], None], times: int) -> float:
    """Return the least of several durations [s]: the others were disturbed."""
    work()
    durations = []
    for _ in range(times):
        began = time.perf_counter()
        work()
        durations.append(time.perf_counter() - began)
    return min(durations)


def _numeric(robot: Robot, feet: Array, samples: int) -> float | None:
    """Time ikpy for all samples of four legs, from a few; None if it is not installed."""
    try:
        from ikpy.chain import Chain
        from ikpy.link import OriginLink, URDFLink
    except ImportError:
        return None
    leg = robot.legs[0]
    links: list[Any] = [OriginLink()]
    pitch_axis, knee, foot = leg.chain(np.zeros(3))
    at: Array = np.zeros(3)
    for name, axis, end in (
        ('first', leg.first_axis, np.asarray(leg.hip)),
        ('pitch', leg.lateral_direction, pitch_axis),
        ('knee', leg.lateral_direction, knee),
    ):
        links.append(URDFLink(name, list(end - at), [0.0, 0.0, 0.0], list(axis)))
        at = end
    links.append(URDFLink('foot', list(foot - at), [0.0, 0.0, 0.0], joint_type='fixed'))
    chain = Chain(links, active_links_mask=[False, True, True, True, False])
    guess = np.concatenate([[0.0], robot.initial_joint_angles[0], [0.0]])
    chosen = np.linspace(0, len(feet) - 1, samples).astype(int)
    began = time.perf_counter()
    for sample in chosen:
        guess = chain.inverse_kinematics(feet[sample, 0], initial_position=guess)
    return (time.perf_counter() - began) / samples * 4 * len(feet)
