"""
Pictures and videos from files, and pictures into files.

What a file holds is told by its first bytes, and its size is looked at before anything is
decoded: neither a playlist that names other files nor a picture of gigabytes goes farther.
"""

from __future__ import annotations

import io
import os
import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from quad_common.errors import (
    CameraFileUnusable,
    FileUnusable,
    NotAPicture,
    PictureNotWritten,
    PictureTooLarge,
)
from quad_common.files.bounded_file import check_target, read_bytes, read_head
from quad_common.files.whole_file import write_bytes
from quad_common.vision.camera import MOST_PIXELS
from quad_perception.picture.color_segmentation import Picture

_LARGEST_STILL = 2**28
"""Largest size of the file of a still picture [bytes]."""

_STILLS = ('PNG', 'JPEG', 'BMP', 'TIFF', 'WEBP', 'PPM', 'GIF', 'JPEG2000')
"""Formats of still pictures, as Pillow calls them; OpenCV decodes them all."""

_HEAD = 16
"""First bytes by which videos are told."""

_VIDEO = re.compile(
    rb"""
    .{4}(ftyp|moov|mdat|wide|free|skip)   # MP4, QuickTime
    | \x1a\x45\xdf\xa3                    # Matroska, WebM
    | RIFF.{4}AVI\x20
    | OggS
    | FLV
    | \x30\x26\xb2\x75                    # ASF, WMV
    | \x00\x00\x01[\xb3\xba]              # MPEG
    | \x47                                # MPEG transport stream
    """,
    re.DOTALL | re.VERBOSE,
)


def read_pictures(path: Path) -> Iterator[Picture]:
    """
    Yield a still picture, or those of a video.

    Parameters
    ----------
    path : Path
        The file.

    Yields
    ------
    ndarray of uint8, shape (height, width, 3)
        Red, green and blue.

    Raises
    ------
    CameraError
        If it cannot be read, is neither, or is too large.
    """
    try:
        head = read_head(path, 'picture', _HEAD)
        if _VIDEO.match(head):
            yield from _video(path)
            return
        content = read_bytes(path, 'picture', _LARGEST_STILL)
    except FileUnusable as error:
        raise error.of_kind(CameraFileUnusable) from error
    _check_still(path, content)
    try:
        still = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        still = None
    if still is None:
        raise NotAPicture(path)
    yield np.asarray(cv2.cvtColor(still, cv2.COLOR_BGR2RGB), np.uint8)


def write_picture(path: Path, rgb: Picture) -> None:
    """
    Write a picture.

    Parameters
    ----------
    path : Path
        The file; the end of its name says in which format.
    rgb : ndarray of uint8, shape (height, width, 3)
        Red, green and blue.

    Raises
    ------
    CameraError
        If it cannot be written.
    """
    try:
        check_target(path, 'picture')
    except FileUnusable as error:
        raise error.of_kind(CameraFileUnusable) from error
    try:
        is_made, content = cv2.imencode(path.suffix, cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR))
    except cv2.error as error:
        raise PictureNotWritten(path) from error
    if not is_made:
        raise PictureNotWritten(path)
    try:
        # Not by OpenCV, which dies of names that are not UTF-8.
        write_bytes(path, content.tobytes(), 'picture')
    except FileUnusable as error:
        raise error.of_kind(CameraFileUnusable) from error


def _check_still(path: Path, content: bytes) -> None:
    """Raise CameraError unless the file begins as a picture of a sensible size."""
    try:
        with warnings.catch_warnings():
            # Pillow warns of large images and of damage; both are dealt with below.
            warnings.simplefilter('ignore')
            with Image.open(io.BytesIO(content), formats=_STILLS) as image:
                size = image.size
    except Image.DecompressionBombError as error:
        raise PictureTooLarge(path, MOST_PIXELS) from error
    except Exception as error:
        # Whatever a damaged header makes a decoder meet.
        raise NotAPicture(path) from error
    if size[0] * size[1] > MOST_PIXELS:
        raise PictureTooLarge(path, MOST_PIXELS)


def _video(path: Path) -> Iterator[Picture]:
    # Damage is told in our own sentence, not by the decoder on stderr.
    os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')
    name = os.fspath(path.resolve())
    try:
        name.encode()
    except UnicodeEncodeError as error:
        # OpenCV dies of such names.
        raise CameraFileUnusable('video', path, 'cannot be read: its name is not UTF-8') from error
    # By the whole path: a relative one may look like the address of a stream.
    video = cv2.VideoCapture(name)
    has_pictures = False
    try:
        sides = [video.get(side) for side in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)]
        if sides[0] * sides[1] > MOST_PIXELS:
            raise PictureTooLarge(path, MOST_PIXELS)
        while True:
            is_there, frame = video.read()
            if not is_there:
                break
            has_pictures = True
            yield np.asarray(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB), np.uint8)
    except cv2.error as error:
        raise NotAPicture(path) from error
    finally:
        video.release()
    if not has_pictures:
        raise NotAPicture(path)
