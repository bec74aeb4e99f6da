"""
Makes a film of a recording: the robot in its room, drawn by a physics engine.
"""

from __future__ import annotations

import errno
import io
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from nav_msgs.msg import OccupancyGrid as GridMessage
from nav_msgs.msg import Odometry
from numpy.typing import NDArray
from PIL import Image
from sensor_msgs.msg import JointState

from quad_common.errors import FilmTooLong, MissingOptionalDependency, NotSimulated
from quad_common.files.bounded_file import check_target
from quad_common.files.whole_file import whole_file
from quad_common.process.end_signals import shielded
from quad_common.robot.robot import Robot
from quad_common.ros.map_conversions import grid_from_message
from quad_common.ros.pose_conversions import pose_from_message
from quad_common.vision.camera import CameraModel
from quad_lab.recordings.recorded_messages import RecordedMessages
from quad_sim.engines.registry import engines_with, make_simulator
from quad_sim.engines.simulator import VisibleSimulator
from quad_sim.world.appearance import Appearance
from quad_sim.world.simulated_camera import SimulatedCamera
from quad_sim.world.world import World, world_from_map

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

_FIELD_OF_VIEW = math.radians(50.0)

_AWAY, _ABOVE = 9.0, 5.0
"""Distance and height of the camera above the robot, in heights of its hips."""

_SIDE = math.radians(-60.0)
"""Direction from the robot to the camera, on the map [rad]."""

_LOOK = Appearance(floor_color=(215, 215, 210), obstacle_color=(112, 122, 140), checker_size=0.5)
"""Colors of the room; squares on the floor show how fast the robot is."""

_SLOWLY = 1.0
"""Time in which the camera follows the robot [s]."""

_WALLS = 1.2
"""Height of walls, in heights of the hips: they hide nothing that stands behind."""

MOST_PICTURES = 100_000
"""Of a film: more than an hour of it."""

_MOST_BYTES = 2**33
"""Of the pictures of a GIF, all of which are in memory until it is written."""

_CUT_OFF = 'the encoder ended before the film did; is the disk full?'


@dataclass(frozen=True)
class FilmOptions:
    """What of a recording becomes a film, and how."""

    first: float = 0.0
    """Time from the beginning of the recording on [s]."""
    last: float = math.inf
    """Time up to which it goes [s]."""
    speed: float = 1.0
    """Recorded over shown time."""
    size: tuple[int, int] = (1280, 720)
    """Width and height [pixels]."""
    rate: float = 25.0
    """Pictures in a second of the film [Hz]."""


def make_film(
    path: Path,
    messages: RecordedMessages,
    robot: Robot,
    backend: str,
    options: FilmOptions,
    progress: Callable[[float], None] = lambda done: None,
) -> int:
    """
    Make a film.

    Parameters
    ----------
    path : Path
        ``*.mp4`` or ``*.gif``.
    messages : RecordedMessages
        The recording.
    robot : Robot
        The robot that was recorded.
    backend : str
        Engine that draws.
    options : FilmOptions
        What becomes of it.
    progress : callable
        Called with the part that is done, up to 1.

    Returns
    -------
    int
        Number of pictures.

    Raises
    ------
    FilmTooLong
        If it would have too many pictures.
    NotSimulated
        If the engine draws no pictures.
    MissingOptionalDependency
        If nothing here encodes MP4.
    """
    check_target(path, 'film')
    is_gif = path.suffix.lower() == '.gif'
    begin = min(messages.start + options.first, messages.end)
    end = min(messages.end, messages.start + options.last)
    count = 1 + int((end - begin) * options.rate / options.speed)
    most = min(MOST_PICTURES, _MOST_BYTES // math.prod(options.size)) if is_gif else MOST_PICTURES
    if count > most:
        raise FilmTooLong(end - begin, count, most)
    scene = _FilmedRobot(messages, robot, backend)

    def pictures() -> Iterator[Picture]:
        for number in range(count):
            time = begin + number * options.speed / options.rate
            yield scene.picture(time, options.speed / options.rate, options.size)
            progress((number + 1) / count)

    try:
        with whole_file(path, 'film') as beside:
            write = _write_gif if is_gif else _write_mp4
            write(beside, pictures(), options)
    finally:
        scene.close()
    return count


class _FilmedRobot:
    """A robot in a world that is looked at, and put where it was recorded."""

    def __init__(self, messages: RecordedMessages, robot: Robot, backend: str) -> None:
        self._robot = robot
        self._pose: tuple[Array, Array] | None = None
        self._angles = robot.initial_joint_angles.reshape(-1).copy()
        self._target: Array | None = None
        self._world = World(np.empty((0, 4, 2)))
        messages.all_of('map', self._on_map, GridMessage)
        messages.newest_of('odom', self._on_odometry, Odometry)
        messages.newest_of('joint_states', self._on_joints, JointState)
        self._messages = messages
        messages.go_on_to(messages.start)
        # A map is latched: it comes with the first messages.
        messages.go_on_to(min(messages.start + 1.0, messages.end))
        simulator = make_simulator(backend, robot, self._world, appearance=_LOOK)
        if not isinstance(simulator, VisibleSimulator):
            raise NotSimulated('a film', engines_with('has_pictures'))
        simulator.prepare_pictures()
        self._simulator = simulator
        self._rng = np.random.default_rng(0)
        messages.rewind()

    def picture(self, time: float, step: float, size: tuple[int, int]) -> Picture:
        """Draw the robot as it was at a time, some time [s] after the last picture."""
        if time < self._messages.time:
            self._messages.rewind()
        self._messages.go_on_to(time)
        if self._pose is not None:
            self._simulator.place(*self._pose, self._angles)
        position = np.zeros(3) if self._pose is None else self._pose[0]
        if self._target is None:
            self._target = position
        self._target = self._target + min(1.0, step / _SLOWLY) * (position - self._target)
        height = self._robot.hip_height
        away = height * np.array(
            [_AWAY * math.cos(_SIDE), _AWAY * math.sin(_SIDE), _ABOVE], dtype=float
        )
        target = np.array([self._target[0], self._target[1], 0.5 * height])
        model = CameraModel.looking_at(target + away, target, _FIELD_OF_VIEW, size)
        return SimulatedCamera(model).take(self._simulator, self._rng)

    def close(self) -> None:
        """Give back what the engine holds."""
        self._simulator.close()

    def _on_map(self, message: GridMessage) -> None:
        height = _WALLS * self._robot.hip_height
        self._world = world_from_map(grid_from_message(message), obstacle_height=height)

    def _on_odometry(self, message: Odometry) -> None:
        pose_from_message(message.pose.pose, 'odometry')
        p, q = message.pose.pose.position, message.pose.pose.orientation
        turn = np.array([q.x, q.y, q.z, q.w])
        self._pose = np.array([p.x, p.y, p.z]), turn / np.linalg.norm(turn)

    def _on_joints(self, message: JointState) -> None:
        measured = dict(zip(message.name, message.position))
        for index, name in enumerate(self._robot.joint_names):
            if math.isfinite(angle := measured.get(name, math.nan)):
                self._angles[index] = angle


def _write_mp4(path: Path, pictures: Iterable[Picture], options: FilmOptions) -> None:
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise MissingOptionalDependency('imageio-ffmpeg', "pip install 'quadwalk[film]'") from error
    encoder: Any = imageio_ffmpeg.write_frames(
        str(path), options.size, fps=options.rate, macro_block_size=2, quality=7,
        ffmpeg_log_level='error',
    )  # fmt: skip
    with shielded():
        encoder.send(None)
    try:
        for picture in pictures:
            encoder.send(np.ascontiguousarray(picture))
    except OSError as error:
        # Its words are the encoder's whole log.
        raise OSError(errno.EIO, _CUT_OFF) from error
    finally:
        with shielded():
            encoder.close()
    try:
        # An encoder that could not write ends, and says nothing.
        imageio_ffmpeg.count_frames_and_secs(str(path))
    except RuntimeError as error:
        raise OSError(errno.EIO, _CUT_OFF) from error


def _write_gif(path: Path, pictures: Iterable[Picture], options: FilmOptions) -> None:
    images = [
        Image.fromarray(picture).quantize(96, dither=Image.Dither.NONE) for picture in pictures
    ]
    # Into memory: written by itself, Pillow leaves a part where the disk is full, and no word.
    content = io.BytesIO()
    images[0].save(
        content, 'GIF', save_all=True, append_images=images[1:],
        duration=round(1e3 / options.rate), loop=0,
    )  # fmt: skip
    path.write_bytes(content.getvalue())
