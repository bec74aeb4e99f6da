"""
Kinds of arguments that several commands take.
"""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

from quad_common.errors import QuadError
from quad_common.errors.quoting import clipped, quoted
from quad_common.files.bounded_file import (
    check_folder_target,
    check_target,
    is_file,
    user_path,
)
from quad_common.parameters import parameters_of
from quad_common.planar_pose import Pose2D
from quad_common.quantity import ANGLE, COORDINATE, Quantity, number_from
from quad_common.resources import sample_map, share_directory

LARGEST_SEED = 2**31 - 1
"""Largest seed of random numbers."""

PICTURES = ('.png', '.pdf', '.svg', '.jpg')
"""Endings of the names of drawings."""


class CommandParser(argparse.ArgumentParser):
    """A parser whose errors are short and on one line, whatever was given."""

    def error(self, message: str) -> NoReturn:
        """Print usage and what is wrong, and end with code 2."""
        super().error(clipped(message))

    def print_help(self, file: Any = None) -> None:
        """Print the help; raise OSError where it cannot be written, which argparse ignores."""
        print(self.format_help(), end='', file=file, flush=True)

    def check_values(self, arguments: list[str]) -> None:
        """Refuse ``--start=--``: up to Python 3.12 argparse makes an empty list of it."""
        for text in arguments:
            option, _, value = text.partition('=')
            if value == '--' and option.startswith('-'):
                self.error(f"argument {option}: '--' is no value")


class PrintVersion(argparse.Action):
    """Prints which version of quadwalk is installed, and ends."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        """Print it; what finds it takes a while to import, and is seldom asked."""
        from importlib import metadata

        try:
            version = metadata.version('quadwalk')
        except metadata.PackageNotFoundError:
            version = '(a source tree that is not installed)'
        print(f'quadwalk {version}', flush=True)
        parser.exit()


def pose_argument(text: str) -> Pose2D:
    """
    Read ``x,y,yaw`` in metres and radians; ``90deg`` gives the yaw in degrees.

    Raises
    ------
    argparse.ArgumentTypeError
        If the text is no such pose.
    """
    try:
        x, y, yaw = text.split(',')
        angle = math.radians(float(yaw[:-3])) if yaw.endswith('deg') else float(yaw)
        pose = Pose2D(float(x), float(y), angle)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f'{quoted(text)} is not x,y,yaw, for example 1.5,2,0'
        ) from None
    if not pose.is_finite():
        raise argparse.ArgumentTypeError(f'{quoted(text)} holds a number that is not finite')
    with _as_argument_error():
        COORDINATE.check('x', pose.x)
        COORDINATE.check('y', pose.y)
    with _as_argument_error('; in degrees it is written as 90deg'):
        ANGLE.check('yaw', pose.yaw)
    return pose


def quantity_argument(name: str, quantity: Quantity) -> Callable[[str], float]:
    """Make a reader of numbers within a range; `name` is for its errors."""

    def read(text: str) -> float:
        with _as_argument_error():
            return quantity.check(name, text)

    return read


def add_parameter(
    parser: argparse.ArgumentParser, table: type, name: str, description: str
) -> None:
    """
    Declare an argument for a node's parameter, with its default and its range.

    Parameters
    ----------
    parser : ArgumentParser
        Of the command.
    table : type
        Parameters of the node.
    name : str
        Name of the parameter; the argument has hyphens in place of its underscores.
    description : str
        Help text.
    """
    parser.add_argument(
        f'--{name.replace("_", "-")}',
        type=parameter_argument(table, name),
        default=getattr(table(), name),
        help=description,
    )


def parameter_argument(table: type, name: str) -> Callable[[str], float]:
    """Make a reader of a node's parameter, with the range that the node's table gives it."""
    parameter = next(item for item in parameters_of(table) if item.name == name)

    def read(text: str) -> float:
        number = number_from(text)
        is_whole = isinstance(parameter.default, int) and number.is_integer()
        with _as_argument_error():
            value = parameter.check(int(number) if is_whole else number)
        assert isinstance(value, (int, float))
        return value

    return read


def seed_argument(text: str) -> int:
    """Read the seed of random numbers; raise argparse.ArgumentTypeError."""
    return _whole(text, 0, LARGEST_SEED)


def count_argument(text: str) -> int:
    """Read a number of things, at least one; raise argparse.ArgumentTypeError."""
    return _whole(text, 1, 10**9)


def map_argument(text: str) -> Path:
    """
    Read a map: a file, or the name of a sample map.

    Raises
    ------
    argparse.ArgumentTypeError
        If there is neither.
    """
    with _as_argument_error():
        path = user_path(text, 'map file')
    if is_file(path):
        return path
    if is_file(sample_map(text)):
        return sample_map(text)
    samples = ', '.join(sorted(path.stem for path in (share_directory() / 'maps').glob('*.yaml')))
    raise argparse.ArgumentTypeError(
        f'there is no map file {quoted(text)}; give a Nav2 map YAML, or a sample map: {samples}'
    )


def input_argument(text: str) -> Path:
    """Read the path of a file, of which its reader will say more; raise ArgumentTypeError."""
    return _path(text)


def output_argument(text: str) -> Path:
    """Read the path of a file that can be written; raise argparse.ArgumentTypeError."""
    path = _path(text)
    with _as_argument_error():
        check_target(path)
    return path


def drawing_argument(text: str) -> Path:
    """Read the path of a drawing that can be written; raise argparse.ArgumentTypeError."""
    path = output_argument(text)
    if path.suffix.lower() not in PICTURES:
        endings = ', '.join(PICTURES)
        raise argparse.ArgumentTypeError(f'{quoted(text)} must end in one of {endings}')
    return path


def folder_argument(text: str) -> Path:
    """Read the path of a folder that is there or can be made; raise ArgumentTypeError."""
    path = _path(text)
    with _as_argument_error():
        check_folder_target(path)
    return path


def namespace_argument(text: str) -> str:
    """Read a namespace of ROS, slashes at its ends left out; raise ArgumentTypeError."""
    namespace = text.strip('/')
    if namespace and not re.fullmatch(r'[A-Za-z_]\w*(/[A-Za-z_]\w*)*', namespace, re.ASCII):
        raise argparse.ArgumentTypeError(
            f'{quoted(text)} is no namespace, which has letters, digits and underscores'
        )
    return namespace


def _path(text: str) -> Path:
    if not text:
        raise argparse.ArgumentTypeError('a path is needed, not an empty text')
    with _as_argument_error():
        return user_path(text)


def _whole(text: str, lower: int, upper: int) -> int:
    number = number_from(text)
    if not (number.is_integer() and lower <= number <= upper):
        raise argparse.ArgumentTypeError(
            f'{quoted(text)} is not a whole number from {lower} to {upper}'
        )
    return int(number)


@contextmanager
def _as_argument_error(advice: str = '') -> Iterator[None]:
    """Turn our own errors into those that argparse reports beside the option's name."""
    try:
        yield
    except QuadError as error:
        raise argparse.ArgumentTypeError(f'{error}{advice}') from error


def with_negative_values(arguments: list[str]) -> list[str]:
    """
    Join options with values that begin with a minus sign: ``--start -1,2,0``.

    By itself argparse takes such a value for another option, unless it is a plain number.
    """
    joined: list[str] = []
    for text in arguments:
        is_value = re.match(r'-[\d.][^=]*,', text) is not None
        if is_value and joined and re.fullmatch(r'--[\w-]+', joined[-1]):
            joined[-1] += f'={text}'
        else:
            joined.append(text)
    return joined
