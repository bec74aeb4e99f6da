"""
What the YAML files of maps have in common: keys, numbers, and sentences about them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from quad_common.errors import MapError


class InvalidEntry(Exception):
    """What is wrong with a map file, still without the file's name."""


def read_document(path: Path, what: str = 'map file') -> Mapping[str, Any]:
    """
    Read a YAML file that holds keys.

    Parameters
    ----------
    path : Path
        The file.
    what : str
        What it is, for the error's sentence.

    Returns
    -------
    mapping of str to object
        Its keys and values.

    Raises
    ------
    MapError
        If it cannot be read, is not YAML, or holds no keys.
    """
    try:
        document = yaml.safe_load(path.read_text(encoding='utf-8'))
    except OSError as error:
        raise MapError(f'{what} {path} cannot be read: {error.strerror}') from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise MapError(f'{what} {path} is not YAML: {" ".join(str(error).split())}') from error
    if not isinstance(document, dict):
        raise MapError(f'{what} {path} must hold keys such as image, resolution and origin')
    return document


def value_of(document: Mapping[str, Any], key: str) -> Any:
    """Return the value of a key; InvalidEntry if it is missing."""
    if key not in document:
        raise InvalidEntry(f"the key '{key}' is missing")
    return document[key]


def finite(value: Any, what: str) -> float:
    """Return a value as a number; InvalidEntry if it is not one, or not finite."""
    # Text is tried too: YAML 1.1 reads 5e-2 as text, and yaml-cpp reads it as a number.
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InvalidEntry(f'{what} is {value!r}; it must be a finite number')
    return number


def number_of(document: Mapping[str, Any], key: str) -> float:
    """Return the number of a key; InvalidEntry if there is none."""
    return finite(value_of(document, key), f"'{key}'")


def numbers_of(document: Mapping[str, Any], key: str, names: tuple[str, ...]) -> list[float]:
    """Return the numbers of a key, one for each name; InvalidEntry if they are not there."""
    value = value_of(document, key)
    if not isinstance(value, list) or len(value) != len(names):
        raise InvalidEntry(f"'{key}' is {value!r}; it must be [{', '.join(names)}]")
    return [finite(number, f"{name} of '{key}'") for name, number in zip(names, value, strict=True)]


def image_of(document: Mapping[str, Any]) -> str:
    """Return the name of the image; InvalidEntry if there is none."""
    image = document.get('image')
    if not isinstance(image, str) or not image:
        raise InvalidEntry(f"'image' is {image!r}; it must be the name of an image file")
    return image
