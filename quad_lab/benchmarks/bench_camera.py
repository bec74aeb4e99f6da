"""
``quadwalk bench camera``: what the ceiling camera's pictures of random rooms say, and how fast.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_common.vision.camera import CameraModel
from quad_lab.benchmarks.bench_camera_walks import walk_bars
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_perception.picture.color_segmentation import Picture
from quad_perception.picture.marker_poses import MarkerPose
from quad_perception.picture.perception import Perceiver
from quad_sim.world.simulated_camera import Scene, SimulatedCamera

_ROOMS = 20
_SIZE = 8.0
"""Side of a room [m]."""
_BOUNDS = (0.0, 0.0, _SIZE, _SIZE)
_RESOLUTION = 0.05
"""[m]"""
_HEIGHT = 6.0
"""Of the camera [m]."""
_SEEN = 9.6
"""Side of the floor in the picture: tops of 1 m at the walls are in it [m]."""
_NOISE = 8.0
"""Standard deviation, of 255."""
_BRIGHTNESS = (0.7, 1.3)
_DISTORTION = -0.1
"""k1"""
_POSES = 4
"""Of the robot in each room, disturbed and not."""
_TIMES = 5
"""The best of so many is taken, for others share the machine."""


@dataclass
class _Figures:
    """What was measured of one kind of picture."""

    overlaps: list[float] = field(default_factory=list)
    missed: int = 0
    invented: int = 0
    robot: list[tuple[float, float]] = field(default_factory=list)
    """Distance and turn between what is said and what is so [m, rad]."""
    goal: list[tuple[float, float]] = field(default_factory=list)
    lost: int = 0
    """Robots and goals that are in sight and were not found."""
    times: list[float] = field(default_factory=list)
    """[s]"""


@dataclass
class _Kind:
    """One kind of picture: what takes it, what sees it, and what was measured."""

    camera: SimulatedCamera
    perceiver: Perceiver
    is_disturbed: bool
    figures: _Figures = field(default_factory=_Figures)

    def take(self, simulator: Scene, rng: np.random.Generator) -> Picture:
        """Take a picture."""
        picture = self.camera.take(simulator, rng)
        if not self.is_disturbed:
            return picture
        light = picture.astype(np.float32) * np.float32(rng.uniform(*_BRIGHTNESS))
        light += np.float32(_NOISE) * rng.standard_normal(light.shape, dtype=np.float32)
        disturbed: Picture = np.clip(np.rint(light), 0.0, 255.0).astype(np.uint8)
        return disturbed


def measure(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, Any]]:
    """
    See random rooms.

    Parameters
    ----------
    console : Console
        Where progress is said.
    quick : bool
        A third of the rooms.
    seed : int
        Of the first room.

    Returns
    -------
    bars : list of Criterion
        What was measured.
    details : dict
        The overlap of every room, and every walk.
    """
    robot = load_robot('titan_viii')
    rooms = 7 if quick else _ROOMS
    kinds = {}
    for kind, k1 in (('clean', 0.0), ('disturbed', _DISTORTION)):
        model = _camera_model(k1)
        perceiver = Perceiver.of_robot(model, robot, resolution=_RESOLUTION, bounds=_BOUNDS)
        kinds[kind] = _Kind(SimulatedCamera(model), perceiver, kind == 'disturbed')
    plain = math.inf
    for number in range(rooms):
        console.print(f'room {number + 1} of {rooms}')
        plain = min(plain, _see_room(seed + number, robot, list(kinds.values())))
    bars = []
    for kind, least in (('clean', 0.90), ('disturbed', 0.85)):
        found = kinds[kind].figures
        bars += [
            at_least(f'{kind}: overlap with the true map', _mean(found.overlaps), '', least),
            figure(f'{kind}: least overlap of a room', min(found.overlaps), ''),
            at_most(f'{kind}: obstacles missed', found.missed, '', 0.0),
            at_most(f'{kind}: obstacles invented', found.invented, '', 0.0),
            at_most(f'{kind}: robot, position, rms', _rms(found.robot, 0), 'm', 0.02),
            at_most(f'{kind}: robot, heading, rms', _degrees(_rms(found.robot, 1)), 'deg', 2.0),
            at_most(f'{kind}: goal, position, rms', _rms(found.goal, 0), 'm', 0.02),
            at_most(f'{kind}: goal, heading, rms', _degrees(_rms(found.goal, 1)), 'deg', 2.0),
            at_most(f'{kind}: robots and goals not found', found.lost, '', 0.0),
        ]
    times = [t for kind in kinds.values() for t in kind.figures.times]
    took = float(np.median(times))
    bars += [
        at_most('time for a picture of 640 x 640 pixels', 1e3 * took, 'ms', 20.0),
        figure('cv2.inRange on the same picture, once', 1e3 * plain, 'ms'),
        figure('time for a picture', took / plain, 'x inRange'),
    ]
    further_bars, walks = walk_bars(console, quick, seed)
    details = {f'{name}_overlaps': kind.figures.overlaps for name, kind in kinds.items()}
    return bars + further_bars, {**details, 'walks': walks}


def _see_room(
    seed: int,
    robot: Robot,
    kinds: list[_Kind],
) -> float:
    """See one room with every kind of camera; return the time of a plain ``cv2.inRange`` [s]."""
    # Imported late: it needs PyBullet.
    from quad_sim.engines.bullet_simulator import BulletSimulator
    from quad_sim.world.random_room import random_room
    from quad_sim.world.world import occupancy_of

    rng = np.random.default_rng(seed)
    room = random_room(seed)
    true_map = occupancy_of(room.world, _RESOLUTION, _BOUNDS).occupied()
    simulator = BulletSimulator(robot, room.world)
    simulator.put_goal_marker(room.goal)
    plain = math.inf
    try:
        for k in range(_POSES):
            pose = room.start if k == 0 else _free_pose(rng, room.world.obstacles, room.goal)
            simulator.reset(pose)
            for kind in kinds:
                found = kind.figures
                picture = kind.take(simulator, rng)
                seen = kind.perceiver.perceive(picture)
                _judge(found.robot, seen.robot, pose)
                found.lost += seen.robot is None
                if k > 0:
                    continue
                _judge(found.goal, seen.goal, room.goal)
                found.lost += seen.goal is None
                _judge_map(found, seen.map.occupied(), true_map)
                found.times.append(_best(lambda: kind.perceiver.perceive(picture)))  # noqa: B023
                plain = min(plain, _best(lambda: _plain_pass(picture)))  # noqa: B023
    finally:
        simulator.close()
    return plain


def _camera_model(k1: float) -> CameraModel:
    return CameraModel.looking_down(
        (_SIZE / 2.0, _SIZE / 2.0, _HEIGHT),
        0.0,
        2.0 * math.atan(_SEEN / 2.0 / _HEIGHT),
        distortion=(k1, 0.0, 0.0, 0.0, 0.0),
    )


def _free_pose(rng: np.random.Generator, obstacles: Any, goal: Pose2D) -> Pose2D:
    """Draw a pose of the robot at which nothing hides it, and it hides no obstacle."""
    while True:
        x, y = (float(v) for v in rng.uniform(0.6, _SIZE - 0.6, 2))
        pose = Pose2D(x, y, float(rng.uniform(-math.pi, math.pi)))
        # A top of 1 m hides the floor for up to a fifth of its distance from the middle.
        away = math.hypot(x - _SIZE / 2.0, y - _SIZE / 2.0)
        room = 0.5 + 0.25 * away
        others = [other.pose.distance_to(pose) - other.outer_radius for other in obstacles]
        if min(others, default=9.0) > room and goal.distance_to(pose) > 1.0:
            return pose


def _judge(errors: list[tuple[float, float]], found: MarkerPose | None, true: Pose2D) -> None:
    if found is not None:
        turn = abs(wrap_angle(found.pose.yaw - true.yaw))
        errors.append((found.pose.distance_to(true), turn))


def _judge_map(found: _Figures, occupied: NDArray[np.bool_], true_map: NDArray[np.bool_]) -> None:
    """Compare a map with the true one, cell by cell and obstacle by obstacle."""
    found.overlaps.append(float((occupied & true_map).sum() / (occupied | true_map).sum()))
    found.missed += _without(true_map, occupied)
    found.invented += _without(occupied, true_map)


def _without(ones: NDArray[np.bool_], others: NDArray[np.bool_]) -> int:
    """Count the connected parts of one mask that have nothing in common with another."""
    count, labels = cv2.connectedComponents(ones.astype(np.uint8))
    return sum(not others[labels == k].any() for k in range(1, count))


def _plain_pass(picture: Picture) -> None:
    cv2.inRange(picture, np.array([150.0, 0.0, 0.0]), np.array([255.0, 90.0, 90.0]))


def _best(work: Callable[[], Any]) -> float:
    """Return the shortest of some times [s]."""
    best = math.inf
    for _ in range(_TIMES):
        began = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - began)
    return best


def _mean(values: list[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _rms(errors: list[tuple[float, float]], column: int) -> float | None:
    if not errors:
        return None
    return math.sqrt(float(np.mean([error[column] ** 2 for error in errors])))


def _degrees(angle: float | None) -> float | None:
    return None if angle is None else math.degrees(angle)
