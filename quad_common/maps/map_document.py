"""
What the YAML files of maps have in common: keys, numbers, images, and sentences about them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from quad_common.errors import (
    FileUnusable,
    MapEntryInvalid,
    MapFileUnusable,
    MapValueOutOfRange,
    MissingKey,
    ParameterError,
    QuadError,
)
from quad_common.files.bounded_file import user_path
from quad_common.files.yaml_document import check_keys, in_file, read_yaml
from quad_common.quantity import Quantity


def read_document(
    path: str | Path, keys: Collection[str], what: str = 'map file'
) -> tuple[Path, dict[str, Any]]:
    """
    Read a YAML file that holds keys.

    Parameters
    ----------
    path : str or Path
        The file; ``~`` is the home directory.
    keys : collection of str
        The keys that it may have.
    what : str
        What it is, for the error's sentence.

    Returns
    -------
    path : Path
        The file.
    document : dict of str to object
        Its keys and values.

    Raises
    ------
    MapError
        If it cannot be read, is not YAML, holds no keys, or one that means nothing.
    """
    try:
        path = user_path(path, what)
        document = read_yaml(path, what, 'keys such as image, resolution and origin')
    except FileUnusable as error:
        raise error.of_kind(MapFileUnusable) from error
    try:
        check_keys(document, keys)
    except QuadError as error:
        raise in_map_file(error, what, Path(path)) from error
    return path, document


def in_map_file(error: QuadError, what: str, path: Path) -> QuadError:
    """Return an error about an entry as a MapError about the file that it stands in."""
    return in_file(error, what, path, MapEntryInvalid, MapValueOutOfRange)


def value_of(document: Mapping[str, Any], key: str) -> Any:
    """Return the value of a key; raise MissingKey if there is none."""
    if key not in document:
        raise MissingKey(key)
    return document[key]


def number_of(document: Mapping[str, Any], key: str, quantity: Quantity) -> float:
    """Return the number of a key; raise if it is missing or outside its range."""
    return quantity.check(key, value_of(document, key))


def image_of(document: Mapping[str, Any]) -> str:
    """Return the name of the image; raise ParameterError if there is none."""
    image = document.get('image')
    if not isinstance(image, str) or not image:
        raise ParameterError('image', image, 'the name of an image file')
    return image
