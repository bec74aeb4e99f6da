"""
``quadwalk robot``: imports robots from their descriptions, lists them, checks and exports them.
"""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

from quad_cli.arguments import folder_argument, output_argument, quantity_argument
from quad_cli.motor_advice import motor_advice
from quad_common.errors import DescriptionUnusable, ParameterError, QuadError
from quad_common.errors.quoting import quoted
from quad_common.files.bounded_file import check_target, is_file, user_path
from quad_common.importing.options import DIRECTIONS, KNEES, ImportOptions
from quad_common.named_robots.description_cache import cached_names, is_installed
from quad_common.named_robots.known_robots import known_names
from quad_common.process.temporary_folder import temporary_folder
from quad_common.quantity import Quantity
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import JOINTS_PER_LEG, LEGS
from quad_common.robot.robot_figures import derived_figures
from quad_common.robot.urdf import published_urdf
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.robot_files.ros2_control import MOCK_PLUGIN, ExportOptions, export_robot

EXAMPLES = f"""examples:
  quadwalk robot import my_robot.urdf --effort 33.5 --speed 21
  quadwalk robot import my_robot.urdf.xacro --output robots/my_robot.yaml
  quadwalk robot list
  quadwalk robot check titan_viii
  quadwalk robot urdf titan_viii > titan_viii.urdf
  quadwalk robot export my_robot.yaml --output my_robot_bringup --plugin my_hardware/System

robots that ship: {', '.join(available_robots())}
"""

if TYPE_CHECKING:
    # Slow to import, and most actions need neither.
    from rich.table import Table

    from quad_common.importing.robot_import import ImportedRobot

_EFFORT = Quantity(1e-3, 1e5, 'N m')
_MASS = Quantity(0.01, 1e4, 'kg')
_SPEED = Quantity(0.01, 200.0, 'rad/s')

_PLUGIN = re.compile(r'[A-Za-z]\w*/\w+(::\w+)*|\w+(::\w+)+')
"""Names of pluginlib: ``package/Class``, or a class with its namespace."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    actions = parser.add_subparsers(dest='action', metavar='action', required=True)
    importing = actions.add_parser(
        'import', help='write a data file from a URDF, xacro or MJCF file, and draw what was found'
    )
    _add_import_arguments(importing)
    listing = actions.add_parser('list', help='list the robots that can be asked for by name')
    checking = actions.add_parser('check', help='check a robot, and say what follows from its data')
    printing = actions.add_parser('urdf', help="print a robot's URDF")
    exporting = actions.add_parser(
        'export', help='write what ros2_control needs: URDF, controllers, limits and a launch file'
    )
    for action in (checking, printing, exporting):
        action.add_argument('robot', help='name of a robot, path of a data file or a description')
    exporting.add_argument(
        '--output', type=folder_argument, help='folder to write to; NAME_bringup here if left out'
    )
    exporting.add_argument(
        '--plugin',
        type=plugin_argument,
        default=MOCK_PLUGIN,
        help='hardware plugin; %(default)s, which has no hardware, if left out',
    )
    for action in (importing, listing, checking, printing, exporting):
        action.add_argument('--json', action='store_true', help='print one JSON object only')


def _add_import_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument('file', help='URDF, xacro or MJCF file')
    parser.add_argument('--name', default='', help="name of the robot; the file's if left out")
    for name, quantity in (('effort', _EFFORT), ('speed', _SPEED)):
        parser.add_argument(
            f'--{name}',
            nargs='+',
            default=[],
            type=quantity_argument(name, quantity),
            metavar='VALUE',
            help=f'largest {name} of the joints, one or three from the body outward; '
            f"the description's if left out [{quantity.unit}]",
        )
    parser.add_argument(
        '--mass',
        type=quantity_argument('mass', _MASS),
        default=0.0,
        help='mass of the whole robot, for descriptions that state none [kg]',
    )
    parser.add_argument(
        '--forward', choices=DIRECTIONS, default='', help="forward, along the root link's axes"
    )
    parser.add_argument(
        '--argument',
        action='append',
        default=[],
        type=_named_value,
        metavar='NAME=VALUE',
        help="of a xacro file's arguments; may be repeated",
    )
    parser.add_argument('--knees', choices=KNEES, default='', help='where the knees point')
    parser.add_argument(
        '--output', type=output_argument, help='data file to write; NAME.yaml here if left out'
    )
    parser.add_argument('--no-picture', action='store_true', help='write no picture')


def _named_value(text: str) -> tuple[str, str]:
    name, equals, value = text.partition('=')
    if not name or not equals:
        raise argparse.ArgumentTypeError(f'{quoted(text)} is not NAME=VALUE')
    return name, value


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    if arguments.action == 'import':
        return _import(arguments)
    if arguments.action == 'list':
        return _list(arguments.json)
    robot = load_robot(arguments.robot)
    if arguments.action == 'urdf':
        print(
            json.dumps({'urdf': published_urdf(robot)}) if arguments.json else published_urdf(robot)
        )
        return 0
    if arguments.action == 'export':
        return _export(robot, arguments)
    return _check(robot, arguments.json)


def plugin_argument(text: str) -> str:
    """Read the name of a plugin; raise argparse.ArgumentTypeError."""
    if not _PLUGIN.fullmatch(text):
        raise argparse.ArgumentTypeError(
            f'{quoted(text)} is no plugin, which is package/Class, for example {MOCK_PLUGIN}'
        )
    return text


def _export(robot: Robot, arguments: argparse.Namespace) -> int:
    path = user_path(arguments.robot)
    # Nodes are started in folders of their own: a path means the same to all of them.
    source = str(path.resolve()) if is_file(path) else arguments.robot
    options = ExportOptions(robot=source, plugin=arguments.plugin)
    folder = Path(arguments.output or f'{robot.name}_bringup')
    written = [str(path) for path in export_robot(robot, folder, options)]
    if arguments.json:
        print(json.dumps({'name': robot.name, 'plugin': arguments.plugin, 'written': written}))
        return 0
    print(f'written: {", ".join(written)}')
    print(f'next: ros2 launch {folder / "bringup.launch.py"}')
    return 0


def _list(as_json: bool) -> int:
    names = {
        'shipped': available_robots(),
        'installed': known_names(),
        'robot_descriptions': cached_names(),
    }
    if as_json:
        print(json.dumps(names))
        return 0
    print(f'ship with quadwalk: {", ".join(names["shipped"])}')
    print(f'from descriptions that are installed: {", ".join(names["installed"]) or "none"}')
    if is_installed():
        cached = ', '.join(names['robot_descriptions']) or 'none yet'
        print(f'in the cache of robot_descriptions: {cached}')
    return 0


def _check(robot: Robot, as_json: bool) -> int:
    figures = derived_figures(robot)
    overlapping = [str(pair) for pair in robot.own_parts.ignored]
    advice = motor_advice(robot)
    if as_json:
        said = {'parts_not_watched': overlapping, **advice.figures()}
        print(json.dumps({**figures, **said}))
        return 0
    print(f'{robot.name}: {len(robot.sources)} numbers, each with its source')
    for name, value in figures.items():
        print(f'  {name.replace("_", " "):28} {value}')
    if overlapping:
        print(
            f'  nearer than {1e3 * robot.own_parts.least:.1f} mm in the initial posture, and so '
            f'not kept apart: {", ".join(overlapping)}'
        )
    for sentence in advice.sentences():
        print(f'  {sentence}')
    return 0


def _import(arguments: argparse.Namespace) -> int:
    # Packages that read descriptions are slow to import, and may not be there.
    from rich.console import Console
    from rich.markup import escape

    from quad_common.importing.robot_import import import_robot

    for name in ('effort', 'speed'):
        if len(getattr(arguments, name)) not in (0, 1, JOINTS_PER_LEG):
            raise ParameterError(name, getattr(arguments, name), 'one number, or three')
    options = ImportOptions(
        name=arguments.name,
        effort=tuple(arguments.effort),
        speed=tuple(arguments.speed),
        mass=arguments.mass,
        forward=arguments.forward,
        knees=arguments.knees,
        arguments=tuple(arguments.argument),
    )
    imported = import_robot(user_path(arguments.file), options)
    path = Path(arguments.output or f'{imported.name}.yaml')
    data_file, urdf = _written(imported, path, arguments.file)
    robot = load_robot(data_file)
    written = [data_file, urdf]
    if not arguments.no_picture:
        from quad_cli.output.robot_picture import draw_robot

        written.append(draw_robot(robot, data_file.with_suffix('.png')))
    figures = derived_figures(robot)
    advice = motor_advice(robot)
    if arguments.json:
        said = {'found': imported.notes.found, 'assumed': imported.notes.assumed}
        files = {'written': [str(file) for file in written]}
        print(json.dumps({'name': robot.name, **said, **advice.figures(), **files, **figures}))
        return 0
    console = Console()
    console.print(_legs_table(robot))
    for heading, sentences in (
        ('found', imported.notes.found),
        ('assumed', imported.notes.assumed),
    ):
        for sentence in sentences:
            console.print(f'{heading}: {escape(sentence)}', highlight=False)
    console.print(
        f'{escape(robot.name)}: {robot.mass:.2f} kg, hips {figures["hip_height_mm"]:.0f} mm above '
        f'the feet, strides of up to {figures["largest_stride_mm"]:.0f} mm',
        highlight=False,
    )
    print(f'written: {", ".join(str(file) for file in written)}')
    for sentence in advice.sentences():
        print(sentence)
    print(f'next: quadwalk demo --robot {data_file}')
    return 0


def _written(imported: ImportedRobot, path: Path, source: str) -> tuple[Path, Path]:
    """Write data file and URDF of what a source was read into, if a robot follows from it."""
    from quad_common.importing.robot_document import urdf_path, write_robot

    for target in (path, urdf_path(path, imported.tree.path)):
        check_target(target, 'robot data file')
    # What cannot be walked with is not written, least of all over what can.
    with temporary_folder() as folder:
        draft = folder / path.name
        try:
            load_robot(write_robot(imported, draft)[0])
        except QuadError as error:
            # Nobody will find the draft.
            problem = str(error).partition(f'{draft}: ')[2] or str(error)
            reason = f'no robot follows from it: {problem}'
            raise DescriptionUnusable(source, reason) from error
    return write_robot(imported, path)


def _legs_table(robot: Robot) -> Table:
    """Tabulate which joints were taken for which legs, and what they can do."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=f'{robot.name}: {robot.leg_type.replace("_", ", ")}')
    for column in ('leg', 'joints, from the body outward', 'range [deg]', 'N m', 'rad/s', 'foot'):
        table.add_column(column)
    degrees = 57.29577951308232
    for k, leg in enumerate(LEGS):
        names = robot.joint_names[JOINTS_PER_LEG * k : JOINTS_PER_LEG * (k + 1)]
        ranges = [
            f'{degrees * low:.0f}..{degrees * high:.0f}'
            for low, high in zip(robot.lower[k], robot.upper[k])
        ]
        table.add_row(
            leg,
            escape('\n'.join(names)),
            '\n'.join(ranges),
            '\n'.join(f'{value:g}' for value in robot.effort[k]),
            '\n'.join(f'{value:g}' for value in robot.velocity[k]),
            escape(robot.part_names.feet[k]),
        )
    return table
