"""
``quadwalk camera``: what a ceiling camera's pictures show, and where the camera is.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from quad_cli.arguments import (
    count_argument,
    input_argument,
    output_argument,
    quantity_argument,
)
from quad_common.errors import (
    OutOfRange,
    PerceptionError,
    UnknownKey,
)
from quad_common.errors.quoting import quoted
from quad_common.maps.map_file import save_map
from quad_common.maps.occupancy_grid import FREE, OccupancyGrid
from quad_common.quantity import CELL_SIZE, COORDINATE
from quad_common.robot_files.robot_file import load_robot
from quad_common.vision.camera_file import load_camera, save_camera
from quad_perception.picture.annotated import annotated
from quad_perception.picture.camera_calibration import calibrate_pose
from quad_perception.picture.color_segmentation import ColorRange, Picture, load_ranges, segment
from quad_perception.picture.marker_poses import MarkerPose
from quad_perception.picture.mask_picture import draw_masks
from quad_perception.picture.perception import Perceiver, Perception
from quad_perception.picture.picture_files import read_pictures, write_picture
from quad_perception.picture.points_file import read_points
from quad_perception.picture.scene_model import SceneModel, default_ranges

EXAMPLES = """examples:
  quadwalk camera masks room.png --output masks.png
  quadwalk camera calibrate --camera lens.yaml --points points.txt --output camera.yaml
  quadwalk camera map room.png --camera camera.yaml --bounds 0,0,8,8 --output room.yaml
  quadwalk camera map walk.mp4 --camera camera.yaml --every 10 --drawn seen.png

A file of points has a line for each: x and y in the world [m], column and row in the picture,
as an image viewer shows them; lines that begin with # are comments.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    actions = parser.add_subparsers(dest='action', metavar='action', required=True)
    masks = actions.add_parser('masks', help='draw which pixels each range of colors catches')
    masks.add_argument('picture', type=input_argument, help='picture of the room, or a video')
    masks.add_argument(
        '--output', type=output_argument, default=Path('masks.png'), help='picture to write'
    )
    mapping = actions.add_parser('map', help='make a map from a picture, and find robot and goal')
    mapping.add_argument('picture', type=input_argument, help='picture of the room, or a video')
    mapping.add_argument('--camera', type=input_argument, required=True, help='camera file')
    mapping.add_argument(
        '--output', type=output_argument, default=None, help='Nav2 map file to write'
    )
    mapping.add_argument(
        '--drawn',
        type=output_argument,
        default=None,
        help='picture to write: the last one with what it shows',
    )
    mapping.add_argument('--robot', default='titan_viii', help='name or data file')
    mapping.add_argument(
        '--resolution',
        type=quantity_argument('resolution', CELL_SIZE),
        default=0.05,
        help='side of a cell of the map [m]',
    )
    mapping.add_argument(
        '--bounds', type=_bounds, default=None, help='x_min,y_min,x_max,y_max of the map [m]'
    )
    mapping.add_argument(
        '--every',
        type=count_argument,
        default=1,
        help='number of pictures of a video of which one is taken',
    )
    calibrating = actions.add_parser('calibrate', help='find where a camera is')
    calibrating.add_argument(
        '--camera',
        type=input_argument,
        required=True,
        help='file with the lens, or an old camera file',
    )
    calibrating.add_argument(
        '--points', type=input_argument, required=True, help='file with four points or more'
    )
    calibrating.add_argument(
        '--output', type=output_argument, default=None, help='camera file to write'
    )
    for action in (masks, mapping):
        action.add_argument(
            '--colors',
            type=input_argument,
            default=None,
            help='YAML file of color ranges',
        )
    for action in (masks, mapping, calibrating):
        action.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    actions = {'masks': _masks, 'map': _map, 'calibrate': _calibrate}
    return actions[arguments.action](arguments)


def _masks(arguments: argparse.Namespace) -> int:
    ranges = _ranges(arguments.colors)
    picture = next(read_pictures(arguments.picture))
    seen = segment(picture, ranges)
    drawn = draw_masks(picture, seen, ranges)
    write_picture(arguments.output, drawn)
    fractions = {name: float(np.mean(mask > 0)) for name, mask in seen.masks.items()}
    if arguments.json:
        print(json.dumps({'picture': str(arguments.output), 'fractions': fractions}))
        return 0
    for name, fraction in fractions.items():
        print(f'{name:16} {100.0 * fraction:7.3f} % of the picture')
    print(f'drawn in {arguments.output}')
    return 0


def _map(arguments: argparse.Namespace) -> int:
    """Make a map; return 1 if no picture of a video could be used."""
    robot = load_robot(arguments.robot)
    perceiver = Perceiver(
        load_camera(arguments.camera),
        SceneModel.of_robot(robot, _ranges(arguments.colors)),
        resolution=arguments.resolution,
        bounds=arguments.bounds,
    )
    grid: OccupancyGrid | None = None
    drawn: Picture | None = None
    entries: list[dict[str, Any]] = []
    for number, picture in enumerate(read_pictures(arguments.picture)):
        if number % arguments.every:
            continue
        entry: dict[str, Any] = {'picture': number}
        try:
            seen = perceiver.perceive(picture, grid)
        except PerceptionError as problem:
            entries.append({**entry, 'problem': str(problem)})
            continue
        grid = seen.map
        if arguments.drawn is not None:
            drawn = annotated(picture, perceiver, seen)
        entries.append({**entry, **_described(seen)})
    if arguments.output is not None and grid is not None:
        save_map(grid, arguments.output)
    if arguments.drawn is not None and drawn is not None:
        write_picture(arguments.drawn, drawn)
    if arguments.json:
        # A still picture is one object, a video has one for each picture.
        print(json.dumps(entries[0] if len(entries) == 1 else {'pictures': entries}))
    else:
        for entry in entries:
            _print_entry(entry)
        if arguments.output is not None and grid is not None:
            print(f'map written to {arguments.output}')
        if drawn is not None:
            print(f'drawn in {arguments.drawn}')
    return 0 if grid is not None else 1


def _described(seen: Perception) -> dict[str, Any]:
    """Say in numbers what a picture shows."""
    cells = seen.map.cells
    return {
        'obstacles': len(seen.footprints),
        'occupied': float(np.mean(seen.map.occupied())),
        'free': float(np.mean(cells == FREE)),
        'unknown': float(np.mean(seen.map.unknown())),
        'robot': _pose(seen.robot),
        'robot_problem': None if seen.robot_problem is None else str(seen.robot_problem),
        'goal': _pose(seen.goal),
        'goal_problem': None if seen.goal_problem is None else str(seen.goal_problem),
    }


def _pose(found: MarkerPose | None) -> dict[str, Any] | None:
    if found is None:
        return None
    pose = found.pose
    return {'pose': [pose.x, pose.y, pose.yaw], 'covariance': found.covariance.tolist()}


def _print_entry(entry: dict[str, Any]) -> None:
    print(f'picture {entry["picture"]}:')
    if 'problem' in entry:
        print(f'  {entry["problem"]}')
        return
    print(
        f'  {entry["obstacles"]} obstacles; {100.0 * entry["occupied"]:.1f} % of the map is '
        f'occupied, {100.0 * entry["free"]:.1f} % free, {100.0 * entry["unknown"]:.1f} % unknown'
    )
    for name in ('robot', 'goal'):
        found = entry[name]
        if found is None:
            print(f'  {entry[f"{name}_problem"]}')
            continue
        x, y, yaw = found['pose']
        deviations = np.sqrt(np.diag(found['covariance']))
        print(
            f'  {name} at ({x:.3f}, {y:.3f}) m +- {1e3 * max(deviations[:2]):.0f} mm, heading '
            f'{math.degrees(yaw):.1f} deg +- {math.degrees(deviations[2]):.1f} deg'
        )


def _calibrate(arguments: argparse.Namespace) -> int:
    lens = load_camera(arguments.camera, needs_pose=False)
    points, pixels = read_points(arguments.points)
    # An image viewer counts whole pixels: what is meant is their middle.
    found = calibrate_pose(lens, points, pixels + 0.5)
    if arguments.output is not None:
        save_camera(found.camera, arguments.output)
    x, y, z = (float(value) for value in found.camera.position)
    tilt = math.degrees(math.acos(min(1.0, max(-1.0, -float(found.camera.rotation[2, 2])))))
    if arguments.json:
        figures = {
            'position': [x, y, z],
            'position_deviation': found.position_deviation.tolist(),
            'rotation': found.camera.rotation.tolist(),
            'tilt_deg': tilt,
            'reprojection_error': found.reprojection_error,
            'errors': found.errors.tolist(),
        }
        print(json.dumps(figures))
        return 0
    worst = int(np.argmax(found.errors))
    print(f'camera at ({x:.3f}, {y:.3f}, {z:.3f}) m, {tilt:.2f} deg from straight down')
    print(
        f'reprojection error {found.reprojection_error:.2f} pixels; the worst is point '
        f'{worst + 1} with {found.errors[worst]:.2f}'
    )
    deviations = ', '.join(f'{1e3 * value:.0f}' for value in found.position_deviation)
    print(f'standard deviation of the position: {deviations} mm')
    if arguments.output is not None:
        print(f'camera written to {arguments.output}')
    return 0


def _ranges(path: Path | None) -> tuple[ColorRange, ...]:
    """Return the usual ranges, with those of a file in their places."""
    ranges = {color.name: color for color in default_ranges()}
    if path is not None:
        given = {color.name: color for color in load_ranges(path)}
        for name in given:
            if name not in ranges:
                raise UnknownKey('', name, ranges, f'color file {path}: ')
        ranges |= given
    return tuple(ranges.values())


def _bounds(text: str) -> tuple[float, float, float, float]:
    try:
        x_min, y_min, x_max, y_max = (COORDINATE.check('bounds', part) for part in text.split(','))
    except (OutOfRange, ValueError):
        raise argparse.ArgumentTypeError(
            f'{quoted(text)} is not x_min,y_min,x_max,y_max within '
            f'{COORDINATE.upper:g} m, for example 0,0,8,8'
        ) from None
    return x_min, y_min, x_max, y_max
