"""
Walks whose trajectories are kept as hashes: a change of the layout changes none of them by a bit.

``python test/lab/closed_loop/fixed_walks.py`` writes the hashes again. That is right only after a
change that is meant to change how the robot walks, with the benchmarks run in full.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import json
import math
import platform
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from importlib import metadata
from pathlib import Path

import numpy as np

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.supervisor import Supervisor
from quad_gait.uneven.uneven_options import UnevenOptions
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import controller_for
from quad_lab.closed_loop.terrain_walk import make_course
from quad_sim.engines.simulator import JointFailure

RECORD = Path(__file__).with_name('fixed_walks.json')

TURNINGS = {'crawl': 'in_place', 'wave': 'crab', 'trot': 'arc', 'walk': 'in_place'}
"""Gaits, and how each turns along a plan; the crab gait's legs move as the crawl's."""


@dataclass(frozen=True)
class Trace:
    """What is kept of a walk."""

    digest: str
    """SHA-256 of all trajectories, bit for bit."""
    trajectories: int
    """Number of trajectories."""
    travel: float
    """Sum of all changes of joint positions from point to point [rad]."""
    end: tuple[float, float, float]
    """Pose at the end: x, y [m], yaw [rad]."""


class TracedWalk(ClosedLoop):
    """A walk that keeps the trajectories that its robot is given."""

    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.hash = hashlib.sha256()
        self.count = 0
        self.travel = 0.0

    def _send(self, trajectory):
        for part in (trajectory.stamp, trajectory.times, trajectory.positions):
            self.hash.update(np.ascontiguousarray(part, dtype=np.float64).tobytes())
        self.hash.update(np.ascontiguousarray(trajectory.velocities, dtype=np.float64).tobytes())
        self.count += 1
        self.travel += float(np.abs(np.diff(trajectory.positions, axis=0)).sum())
        super()._send(trajectory)

    def trace(self) -> Trace:
        """Return what is kept of the walk."""
        pose = self.record.poses[-1]
        return Trace(self.hash.hexdigest(), self.count, self.travel, (pose.x, pose.y, pose.yaw))


def make_controller(robot, gait, turning='in_place', uneven=None) -> Supervisor:
    """Make a controller as gait_node does."""
    options = SupervisorOptions(
        least_margin=0.005,
        twist_timeout=math.inf,
        follower=FollowerOptions(turning=turning),
        uneven=uneven,
    )
    return controller_for(robot, gait, options)


def steered(robot_name: str, gait_name: str, direction: BodyMotion) -> Trace:
    """Walk as steered, without physics."""
    robot = load_robot(robot_name)
    controller = make_controller(robot, load_gait(gait_name, robot))
    walk = TracedWalk(robot, controller, 'kinematic')
    try:
        walk.run(0.1)
        gear = controller.gait_pair.of_twist(direction.rate(1.0))
        asked = direction.scaled(0.6 * gear.largest_scale(direction))
        controller.set_twist(asked.rate(gear.period))
        walk.run(0.5 + 4.0 * gear.period)
        controller.stop()
        walk.run(2.0 * gear.period)
        return walk.trace()
    finally:
        walk.close()


def planned(robot_name: str, gait_name: str, turning: str, backend: str = 'kinematic') -> Trace:
    """Walk along a plan with two turns."""
    robot = load_robot(robot_name)
    size = robot.relative_size
    poses = tuple(
        Pose2D(size * x, size * y, yaw)
        for x, y, yaw in ((0.0, 0.0, 0.0), (0.4, 0.0, 0.0), (0.7, 0.25, 0.5), (0.7, 0.6, 2.0))
    )
    controller = make_controller(robot, load_gait(gait_name, robot), turning)
    walk = TracedWalk(robot, controller, backend)
    try:
        walk.run(0.1)
        controller.set_plan(Plan(poses))
        walk.run(240.0, until=lambda: controller.activity.is_terminal)
        walk.run(0.5)
        return walk.trace()
    finally:
        walk.close()


def uneven(robot_name: str, course_name: str) -> Trace:
    """Walk for a while over uneven ground, in physics."""
    robot = load_robot(robot_name)
    course = make_course(robot, course_name, 0)
    controller = make_controller(robot, load_gait('crawl', robot), uneven=UnevenOptions())
    controller.set_height_map(course.height_map)
    walk = TracedWalk(robot, controller, 'bullet', course.world, course.start)
    try:
        walk.run(1.0)
        controller.set_plan(course.plan)
        walk.run(30.0)
        return walk.trace()
    finally:
        walk.close()


def failing(robot_name: str, gait_name: str, joint: int, kind: str, on_ground: str = '') -> Trace:
    """Walk ahead in physics until a joint fails, and come to a standstill."""
    robot = load_robot(robot_name)
    course = make_course(robot, on_ground, 0) if on_ground else None
    ground = UnevenOptions() if on_ground else None
    controller = make_controller(robot, load_gait(gait_name, robot), uneven=ground)
    world = None if course is None else course.world
    start = Pose2D(0.0, 0.0, 0.0) if course is None else course.start
    if course is not None:
        controller.set_height_map(course.height_map)
    walk = TracedWalk(robot, controller, 'bullet', world, start)
    try:
        walk.run(1.0)
        controller.set_plan(Plan((start, start @ Pose2D(3.0 * robot.relative_size, 0.0, 0.0))))
        period = controller.gait.cycle_period
        walk.run(2.3 * period)
        walk.simulation.plan_failure(JointFailure(robot.joint_names[joint], kind))
        walk.run(2.0 * period + 4.0)
        controller.stand()
        walk.run(4.0)
        return walk.trace()
    finally:
        walk.close()


def _walks() -> dict[str, Callable[[], Trace]]:
    walks: dict[str, Callable[[], Trace]] = {}
    directions = {
        'straight': BodyMotion(forward=1.0),
        'turn': BodyMotion(turn=-1.0),
        'arc': BodyMotion(forward=0.2, turn=0.5),
    }
    for robot in available_robots():
        for gait, turning in TURNINGS.items():
            for name, direction in directions.items():
                walks[f'{robot} {gait} {name}'] = partial(steered, robot, gait, direction)
            walks[f'{robot} {gait} plan {turning}'] = partial(planned, robot, gait, turning)
    walks['titan_viii crawl plan in physics'] = partial(
        planned, 'titan_viii', 'crawl', 'in_place', 'bullet'
    )
    walks['cuhk trot plan in physics'] = partial(planned, 'cuhk', 'trot', 'arc', 'bullet')
    for robot, course in (('titan_viii', 'bumps'), ('genibo', 'kerb'), ('titan_viii', 'boxes')):
        walks[f'{robot} on {course}'] = partial(uneven, robot, course)
    for robot, gait, joint, kind, ground in (
        ('titan_viii', 'crawl', 4, 'free', ''),
        ('titan_viii', 'crawl', 10, 'stuck', ''),
        ('genibo', 'trot', 1, 'free', ''),
        ('titan_viii', 'crawl', 5, 'free', 'bumps'),
    ):
        walks[f'{robot} {gait} joint {joint} {kind} {ground}'.strip()] = partial(
            failing, robot, gait, joint, kind, ground
        )
    return walks


WALKS = _walks()
"""Each walk by its name."""


def machine() -> str:
    """Name what decides on the last bit: processor, linear algebra, C library and packages."""
    try:
        lines = Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines()
    except OSError:
        lines = []
    keys = ('model name', 'cpu family', 'model', 'stepping', 'flags')
    facts = {line.partition(':')[0].strip(): line for line in reversed(lines)}
    processor = hashlib.sha256('\n'.join(facts.get(key, '') for key in keys).encode())
    packages = (f'{name} {metadata.version(name)}' for name in ('numpy', 'scipy', 'pybullet'))
    python = f'Python {platform.python_version()}'
    parts = [processor.hexdigest()[:16], *_blas_kernels(), *platform.libc_ver(), python, *packages]
    return ', '.join(parts)


def _blas_kernels() -> list[str]:
    """Name the processors for which OpenBLAS computes: ``OPENBLAS_CORETYPE`` may choose another."""
    try:
        mapped = Path('/proc/self/maps').read_text(encoding='utf-8').split()
    except OSError:
        return []
    found = set()
    for path in {part for part in mapped if 'openblas' in part}:
        library = ctypes.CDLL(path)
        for name in ('scipy_openblas_get_corename64_', 'scipy_openblas_get_corename'):
            with contextlib.suppress(AttributeError):
                tell = getattr(library, name)
                tell.restype = ctypes.c_char_p
                found.add(tell().decode())
    return sorted(found)


def main() -> None:
    """Write the hashes; with ``--add`` this machine's beside those of others."""
    traces = {name: asdict(walk()) for name, walk in WALKS.items()}
    digests = {name: trace.pop('digest') for name, trace in traces.items()}
    machines = {}
    if '--add' in sys.argv[1:]:
        kept = json.loads(RECORD.read_text(encoding='utf-8'))
        machines, traces = kept['machines'], kept['walks']
    machines[machine()] = digests
    text = json.dumps({'machines': machines, 'walks': traces}, indent=1)
    RECORD.write_text(text + '\n', encoding='utf-8')


if __name__ == '__main__':
    main()
