"""
A reader of the viewer's page that draws nothing: it counts what comes.

It speaks the protocol of viser's own page, so that the viewer sends it what it sends a browser.
"""

from __future__ import annotations

import re
import threading
import time
from collections import Counter
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any

from quad_common.errors import MissingOptionalDependency

_HEAD = 16
"""Length of the head of a window of messages: two lengths of eight bytes."""

_POSES = ('SetPositionMessage', 'SetOrientationMessage')

_ROBOT = re.compile(r'^/robots/(\d+)/')

FIRST_WORD: dict[str, Any] = {
    'type': 'ViewerCameraMessage',
    'wxyz': (1.0, 0.0, 0.0, 0.0),
    'position': (0.0, -5.0, 5.0),
    'fov': 1.0,
    'near': 0.1,
    'far': 100.0,
    'image_height': 800,
    'image_width': 1280,
    'look_at': (0.0, 0.0, 0.0),
    'up_direction': (0.0, 0.0, 1.0),
}
"""What a page says first, and from when on the viewer counts it as a reader."""


@dataclass
class ReadUpdates:
    """What has come."""

    windows: int = 0
    """Number of windows of messages."""
    size: int = 0
    """Number of bytes."""
    poses: Counter[int] = field(default_factory=Counter)
    """Number of windows that have moved each robot, by its number on the page."""
    began: float = 0.0
    """Time from which on it is counted [s], of the monotonic clock."""


class PageReader:
    """
    Reads the page in a thread of its own for as long as the block runs.

    Parameters
    ----------
    address : str
        Address of the page.
    """

    def __init__(self, address: str) -> None:
        try:
            import msgspec
            import viser
            import zstandard
            from websockets.sync.client import connect
            from websockets.typing import Subprotocol
        except ImportError as error:
            raise MissingOptionalDependency('viser', "pip install 'quadwalk[view]'") from error
        self._decode = msgspec.msgpack.decode
        self._inflate = zstandard.ZstdDecompressor().decompress
        self._updates = ReadUpdates(began=time.monotonic())
        self._socket = connect(
            address.replace('http://', 'ws://'),
            subprotocols=[Subprotocol(f'viser-v{viser.__version__}')],
            max_size=None,
            compression=None,
        )
        self._socket.send(msgspec.msgpack.encode(FIRST_WORD))
        self._thread = threading.Thread(target=self._read, name='page', daemon=True)
        self._thread.start()

    def __enter__(self) -> PageReader:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._socket.close()
        self._thread.join()

    def count(self, duration: float) -> tuple[ReadUpdates, float]:
        """Count what comes from now on, for so long [s]; return it, and how long it was [s]."""
        before = self._updates = ReadUpdates(began=time.monotonic())
        time.sleep(duration)
        self._updates = ReadUpdates(began=time.monotonic())
        return before, self._updates.began - before.began

    def _read(self) -> None:
        for window in self._socket:
            assert isinstance(window, bytes)
            self._take(window)

    def _take(self, window: bytes) -> None:
        """Count one window of messages."""
        updates = self._updates
        length = int.from_bytes(window[8:_HEAD], 'little')
        decoded = self._decode(self._inflate(window[_HEAD : _HEAD + length]))
        moved = set()
        for message in decoded['messages']:
            if message.get('type') in _POSES:
                found = _ROBOT.match(message['name'])
                if found is not None:
                    moved.add(int(found[1]))
        updates.windows += 1
        updates.size += len(window)
        updates.poses.update(moved)
