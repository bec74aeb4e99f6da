"""
The kinds of files that quadwalk reads, each with a valid example, its reader and its ranges.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PIL import Image

from quad_common import quantity
from quad_common.files.bounded_file import read_text
from quad_common.files.yaml_document import read_yaml
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.maps import height_map_file, map_file
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.quantity import Quantity
from quad_common.robot.robot_figures import derived_figures
from quad_common.robot.urdf import urdf_from_robot
from quad_common.robot_files import robot_numbers, walking_time
from quad_common.robot_files.robot_file import ROBOTS_FOLDER, load_robot
from quad_common.vision import camera
from quad_common.vision.camera_file import load_camera, save_camera
from quad_gait.cycle import gait_document
from quad_gait.cycle.gait import load_gait
from quad_gait.following import slip_compensation
from quad_lab.attacks.files.hostile import Key
from quad_perception.picture import color_segmentation
from quad_perception.picture.picture_files import read_pictures
from quad_perception.picture.points_file import read_points

_GAITS = Path(gait_document.__file__).parents[1] / 'gaits'
_ROBOT = load_robot('titan_viii')

Reader = Callable[[Path], object]


@dataclass(frozen=True)
class FileKind:
    """One kind of file."""

    name: str
    """Name of the kind."""
    write: Callable[[Path, int], Path]
    """Function that writes valid files into a folder and returns the one to attack; which
    example is written depends on the number."""
    read: Reader
    """Function that reads the file and makes of it what commands and nodes make of it."""
    ranges: Mapping[str, Quantity] | None = None
    """Stated ranges by dotted names with stars; None if it is no YAML document."""
    free: tuple[str, ...] = ()
    """Places where a key may have any name, by dotted names with stars."""
    image: str = ''
    """Name of the image beside it; empty if there is none."""

    @property
    def is_document(self) -> bool:
        """Whether it is a YAML document."""
        return self.ranges is not None

    def range_of(self, key: Key) -> Quantity | None:
        """Return the stated range of a place in the document; None if it has none."""
        name = '.'.join(map(str, key))
        for pattern, range_ in (self.ranges or {}).items():
            if fnmatch.fnmatchcase(name, pattern):
                return range_
        return None

    def may_have(self, key: Key) -> bool:
        """Return whether a document may have a key of any name at a place."""
        name = '.'.join(map(str, key))
        return any(
            fnmatch.fnmatchcase(name, pattern) and name.count('.') == pattern.count('.')
            for pattern in self.free
        )


def _copied(path: Path, folder: Path, name: str) -> Path:
    target = folder / name
    target.write_text(read_text(path), encoding='utf-8')
    return target


def _write_robot(folder: Path, index: int) -> Path:
    robots = sorted(ROBOTS_FOLDER.glob('*.yaml'))
    return _copied(robots[index % len(robots)], folder, 'robot.yaml')


def _write_imported(folder: Path, index: int) -> Path:
    """Write the data file of a robot whose legs are each given for themselves, and its URDF."""
    description = folder / 'description.urdf'
    description.write_text(urdf_from_robot(load_robot('genibo')), encoding='utf-8')
    data_file, _ = write_robot(import_robot(description), folder / 'imported.yaml')
    return data_file


def _write_gait(folder: Path, index: int) -> Path:
    gaits = sorted(_GAITS.glob('*.yaml'))
    return _copied(gaits[index % len(gaits)], folder, 'gait.yaml')


def _write_map(folder: Path, index: int) -> Path:
    cells = np.zeros((12, 15), np.int8)
    cells[2:5, 3:7] = 100
    grid = OccupancyGrid(cells, 0.05, Pose2D(0.5, -0.5, 0.1))
    map_file.save_map(grid, folder / 'map.yaml')
    if index % 2:
        # As a PNG in color and with an alpha channel.
        with Image.open(folder / 'map.pgm') as image:
            image.convert('RGBA').save(folder / 'map.pgm', 'PNG')
    return folder / 'map.yaml'


def _write_height_map(folder: Path, index: int) -> Path:
    heights = np.linspace(-0.1, 0.2, 80).astype(np.float64).reshape(8, 10)
    height_map_file.save_height_map(HeightMap(heights, 0.1, (0.0, 0.5)), folder / 'hills.yaml')
    return folder / 'hills.yaml'


def _write_camera(folder: Path, index: int) -> Path:
    model = camera.CameraModel.looking_down((2.0, 2.0, 3.0), 0.1, 1.2, (320, 240))
    save_camera(model, folder / 'camera.yaml')
    return folder / 'camera.yaml'


def _write_pace(folder: Path, index: int) -> Path:
    return _copied(ROBOTS_FOLDER / 'pace' / 'titan_viii.yaml', folder, 'walking_time.yaml')


def _write_calibration(folder: Path, index: int) -> Path:
    return _copied(ROBOTS_FOLDER / 'calibration' / 'cuhk.yaml', folder, 'calibration.yaml')


def _write_colors(folder: Path, index: int) -> Path:
    path = folder / 'colors.yaml'
    path.write_text('obstacle: {lower: [340, 0.4, 0.1], upper: [20, 1, 1]}\n', encoding='utf-8')
    return path


def _write_points(folder: Path, index: int) -> Path:
    path = folder / 'points.txt'
    path.write_text('# x y column row\n0 0 1 1\n1 0 90 2\n0 1 3 80\n1 1 90 88\n', encoding='utf-8')
    return path


def _write_picture(folder: Path, index: int) -> Path:
    name = ('room.png', 'room.jpg', 'room.bmp', 'room.gif', 'room.tif', 'room.webp')[index % 6]
    shades = np.linspace(0, 255, 48 * 64 * 3).reshape(48, 64, 3).astype(np.uint8)
    Image.fromarray(shades).save(folder / name)
    return folder / name


def _write_video(folder: Path, index: int) -> Path:
    path = folder / 'walk.avi'
    video = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*'MJPG'), 10.0, (64, 48))
    for shade in (0, 90, 200):
        video.write(np.full((48, 64, 3), shade, np.uint8))
    video.release()
    return path


def _write_map_image(folder: Path, index: int) -> Path:
    _write_map(folder, index)
    return folder / 'map.pgm'


def _write_height_image(folder: Path, index: int) -> Path:
    return _write_height_map(folder, index).with_suffix('.png')


def _read_robot(path: Path) -> object:
    robot = load_robot(path)
    urdf_from_robot(robot)
    derived_figures(robot)
    return robot


def _read_pictures(path: Path) -> object:
    return sum(picture.size for picture in read_pictures(path))


_MAP_RANGES = {
    **map_file.QUANTITIES,
    'origin.2': quantity.ANGLE,
    'origin.*': quantity.COORDINATE,
}
_HEIGHT_RANGES = {**height_map_file.QUANTITIES, 'origin.*': quantity.COORDINATE}
_COLOR_RANGES = {
    f'*.{place}': range_ for place, range_ in enumerate(color_segmentation.QUANTITIES.values())
}
_GAIT_RANGES = {
    **{
        key: range_
        for key, range_ in gait_document.QUANTITIES.items()
        if key not in ('swings', 'phase_offsets', 'body_progress')
    },
    'sway_weight.*': gait_document.QUANTITIES['sway_weight'],
    'phase_offsets.*': gait_document.QUANTITIES['phase_offsets'],
    'swings.*.*': gait_document.QUANTITIES['swings'],
    'body_progress.*.0': gait_document.QUANTITIES['body_progress'],
    'body_progress.*.1': Quantity(0.0, 1.0),
}
_CAMERA_RANGES = {
    'image_*': camera.QUANTITIES['side'],
    'camera_matrix.data.0': camera.QUANTITIES['focal_length'],
    'camera_matrix.data.4': camera.QUANTITIES['focal_length'],
    'camera_matrix.data.[25]': camera.QUANTITIES['principal_point'],
    'distortion_coefficients.data.*': camera.QUANTITIES['distortion'],
    'position.*': camera.QUANTITIES['position'],
    'orientation.*': Quantity(-1.02, 1.02),
}
_CALIBRATION_RANGES = {
    'calibrations.*.cycle_period': quantity.CYCLE_PERIOD,
    **{
        f'calibrations.*.*.{place}': range_
        for place, range_ in enumerate(slip_compensation.QUANTITIES.values())
    },
}

KINDS = (
    FileKind(
        'robot',
        _write_robot,
        _read_robot,
        {f'{name}.value': range_ for name, range_ in robot_numbers.QUANTITIES.items()},
        free=('gaits.*', 'stated.*', 'stated.*.*'),
    ),
    FileKind(
        'imported robot',
        _write_imported,
        _read_robot,
        {
            f'{name}.value{element}': range_
            for name, range_ in robot_numbers.QUANTITIES.items()
            for element in ('', '.*')
        },
        free=('gaits.*',),
    ),
    FileKind('gait', _write_gait, lambda path: load_gait(path, _ROBOT), _GAIT_RANGES),
    FileKind('map', _write_map, map_file.load_map, _MAP_RANGES, image='map.pgm'),
    FileKind(
        'height map',
        _write_height_map,
        height_map_file.load_height_map,
        _HEIGHT_RANGES,
        image='hills.png',
    ),
    FileKind('camera', _write_camera, load_camera, _CAMERA_RANGES),
    FileKind(
        'pace',
        _write_pace,
        walking_time.load_paces,
        {f'paces.*.{key}': range_ for key, range_ in walking_time.QUANTITIES.items()},
        free=('paces.*',),
    ),
    FileKind(
        'calibration', _write_calibration, slip_compensation.load_compensation, _CALIBRATION_RANGES
    ),
    FileKind('colors', _write_colors, color_segmentation.load_ranges, _COLOR_RANGES, ('*',)),
    FileKind('points', _write_points, read_points),
    FileKind('picture', _write_picture, _read_pictures),
    FileKind('video', _write_video, _read_pictures),
    FileKind(
        'map image', _write_map_image, lambda path: map_file.load_map(path.with_suffix('.yaml'))
    ),
    FileKind(
        'height image',
        _write_height_image,
        lambda path: height_map_file.load_height_map(path.with_suffix('.yaml')),
    ),
)
"""Every kind of file that is attacked."""


def document_of(path: Path) -> dict[str, Any]:
    """Read the valid example."""
    return read_yaml(path, 'example', 'keys')
