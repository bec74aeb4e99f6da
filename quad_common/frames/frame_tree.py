"""
Transforms between frames, as tf has them, in the plane: kept, and composed along their tree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from quad_common.errors import InvalidTransform
from quad_common.planar_pose import Pose2D
from quad_common.rotations import tilt_from_quaternion, yaw_from_quaternion

_FARTHEST = 1e6
"""No frame is farther from its parent [m]."""

_LARGEST_TILT = 0.2
"""A frame tilted more against the ground's plane is no frame of the plane [rad]."""

_LONGEST_NAME = 200
"""Largest length of a frame's name, in characters."""

MOST_FRAMES = 1000
"""Most frames that are remembered: those of 32 robots with their legs, and some more."""

IDENTITY = Pose2D(0.0, 0.0, 0.0)
"""Transform between two frames that coincide."""


@dataclass(frozen=True)
class FrameTransform:
    """Pose of a frame in its parent, as somebody publishes it."""

    parent: str
    """Name of the parent frame."""
    child: str
    """Name of the frame."""
    translation: tuple[float, float, float]
    """Origin of the frame in its parent [m]."""
    rotation: tuple[float, float, float, float]
    """Orientation in its parent, quaternion xyzw."""
    is_static: bool = False
    """Whether it holds for good, as what comes on ``tf_static``."""

    def planar(self) -> Pose2D:
        """
        Return the pose in the plane; the height does not count.

        Raises
        ------
        InvalidTransform
            If a number is not finite, too large, or the turn is not about the vertical.
        """
        numbers = (*self.translation, *self.rotation)
        if not all(map(math.isfinite, numbers)):
            raise InvalidTransform(self.parent, self.child, 'its numbers are not finite')
        if max(map(abs, self.translation)) > _FARTHEST:
            x, y, z = self.translation
            raise InvalidTransform(
                self.parent,
                self.child,
                f'its translation is ({x:.4g}, {y:.4g}, {z:.4g}) m; {_FARTHEST:g} m are the most',
            )
        length = math.hypot(*self.rotation)
        if not 0.9 < length < 1.1:
            raise InvalidTransform(
                self.parent, self.child, f'its quaternion has length {length:.4g}; it must be 1'
            )
        unit = [part / length for part in self.rotation]
        tilt = tilt_from_quaternion(unit)
        if tilt > _LARGEST_TILT:
            raise InvalidTransform(
                self.parent,
                self.child,
                f'it is tilted by {math.degrees(tilt):.1f} degrees; '
                f'{math.degrees(_LARGEST_TILT):.1f} are the most for a frame of the plane',
            )
        return Pose2D(self.translation[0], self.translation[1], yaw_from_quaternion(unit))


@dataclass(frozen=True)
class _Edge:
    """The transform of a frame that was received last."""

    parent: str
    """Name of the frame in which it is given."""
    pose: Pose2D
    """Pose of the frame in its parent."""
    is_static: bool
    """Whether it does not move."""
    number: int
    """Count of transforms when it came."""


@dataclass(frozen=True)
class Chain:
    """Transforms composed from one frame to another."""

    pose: Pose2D
    """Pose of the last frame in the first one."""
    is_static: bool = True
    """Whether all of them hold for good."""
    newest: int = 0
    """Number of the transform among them that came last."""

    def then(self, edge: _Edge) -> Chain:
        """Add the transform of the first frame to its parent."""
        pose = edge.pose if self.pose == IDENTITY else edge.pose @ self.pose
        newest = max(self.newest, edge.number)
        return Chain(pose, self.is_static and edge.is_static, newest)


class FrameTree:
    """The transforms that were received: each frame has one parent."""

    def __init__(self) -> None:
        self._edges: dict[str, _Edge] = {}
        self._count = 0

    def add(self, transform: FrameTransform) -> None:
        """
        Take a transform in place of the one of the same frame before.

        Raises
        ------
        InvalidTransform
            If it is no transform in the plane; the one before stays.
        """
        parent, child = transform.parent, transform.child
        if max(len(parent), len(child)) > _LONGEST_NAME:
            raise InvalidTransform(
                parent, child, f'its names have more than {_LONGEST_NAME} characters'
            )
        pose = transform.planar()
        if child not in self._edges and len(self._edges) >= MOST_FRAMES:
            raise InvalidTransform(parent, child, f'{MOST_FRAMES} frames are known already')
        self._count += 1
        self._edges[child] = _Edge(parent, pose, transform.is_static, self._count)

    def find(self, target: str, source: str) -> Chain | None:
        """
        Compose the transforms between two frames.

        Parameters
        ----------
        target, source : str
            Names of frames.

        Returns
        -------
        Chain or None
            Pose of the source in the target; None if no transforms connect them.
        """
        from_source, from_target = self._chains(source), self._chains(target)
        for frame, chain in from_source.items():
            back = from_target.get(frame)
            if back is not None:
                pose = chain.pose if back.pose == IDENTITY else back.pose.inverse() @ chain.pose
                is_static = chain.is_static and back.is_static
                return Chain(pose, is_static, max(chain.newest, back.newest))
        return None

    def is_above(self, frame: str, other: str) -> bool:
        """Return whether a frame is another one, its parent, or the parent of that."""
        return frame in self._chains(other)

    def _chains(self, frame: str) -> dict[str, Chain]:
        """Return a frame's pose in itself, its parent, and so on to the root, nearest first."""
        chain = Chain(IDENTITY)
        chains = {frame: chain}
        while (edge := self._edges.get(frame)) is not None and edge.parent not in chains:
            chain = chain.then(edge)
            frame = edge.parent
            chains[frame] = chain
        return chains
