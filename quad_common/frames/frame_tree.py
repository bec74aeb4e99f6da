"""
Transforms between frames, as tf has them, in the plane: kept, and composed along their tree.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from quad_common.errors import InvalidTransform
from quad_common.errors.quoting import quoted
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

_PATIENCE = 5.0
"""Time for which a transform that does not come any more holds against one that contradicts it:
a single one the wrong way round undoes nothing, and a tree with another root takes over [s]."""

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
    pose: Pose2D | None
    """Pose of the frame in its parent; None of a link, of which it is not wanted."""
    is_static: bool
    """Whether it does not move."""
    number: int
    """Count of transforms when it came."""
    contradicted_at: float | None = None
    """Time when the first one came that contradicts it, if one has since it came [s]."""


@dataclass(frozen=True)
class Chain:
    """Transforms composed from one frame to another."""

    pose: Pose2D
    """Pose of the last frame in the first one."""
    is_static: bool = True
    """Whether all of them hold for good."""
    newest: int = 0
    """Number of the transform among them that came last."""

    def then(self, edge: _Edge, pose: Pose2D) -> Chain:
        """Add the transform of the first frame to its parent, in which it has a pose."""
        pose = pose if self.pose == IDENTITY else pose @ self.pose
        newest = max(self.newest, edge.number)
        return Chain(pose, self.is_static and edge.is_static, newest)


class FrameTree:
    """
    The transforms that were received: each frame has one parent, and there are no cycles.

    At most `MOST_FRAMES` are known; for one more, the one that came longest ago is forgotten.
    """

    def __init__(self) -> None:
        self.needed: tuple[str, ...] = ()
        """Names of frames that are not forgotten for others, nor are their parents."""
        self._edges: dict[str, _Edge] = {}
        # Names of those that are not static, in the order in which they came last.
        self._moving: dict[str, None] = {}
        self._count = 0

    def add(self, transform: FrameTransform, time: float = 0.0) -> None:
        """
        Take a transform in place of the one of the same frame before.

        Parameters
        ----------
        transform : FrameTransform
            The transform.
        time : float
            When it came, by any clock [s].

        Raises
        ------
        InvalidTransform
            If it is no transform in the plane, or would close a cycle; the one before stays. What
            closes a cycle is taken once it has contradicted for 5 s one that is not static and has
            not come again meanwhile: that is forgotten.
        """
        self._put(transform, transform.planar(), time)

    def add_link(self, transform: FrameTransform, time: float = 0.0) -> None:
        """
        Take where a frame hangs, not its pose: it need not be in the plane, and nothing finds it.

        Parameters and errors are those of :meth:`add`.
        """
        self._put(transform, None, time)

    def holds_link(self, parent: str, child: str) -> bool:
        """Return whether a frame was added as this link, and nothing has contradicted it since."""
        edge = self._edges.get(child)
        is_known = edge is not None and edge.pose is None and edge.parent == parent
        return edge is not None and is_known and edge.contradicted_at is None

    def is_link(self, frame: str) -> bool:
        """Return whether a frame was added as a link."""
        edge = self._edges.get(frame)
        return edge is not None and edge.pose is None

    def forget_links(self) -> None:
        """Forget all frames that were added as links."""
        for frame in [*filter(self.is_link, self._edges)]:
            self._forget(frame)

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
        return frame in self._upwards(other)

    def _put(self, transform: FrameTransform, pose: Pose2D | None, time: float) -> None:
        parent, child = transform.parent, transform.child
        if max(len(parent), len(child)) > _LONGEST_NAME:
            raise InvalidTransform(
                parent, child, f'its names have more than {_LONGEST_NAME} characters'
            )
        known = self._edges.get(child)
        if known is None or known.parent != parent:
            self._break_cycle(parent, child, time)
        if known is None:
            self._make_room(parent, child)
        self._forget(child)
        self._count += 1
        self._edges[child] = _Edge(parent, pose, transform.is_static, self._count)
        if not transform.is_static:
            self._moving[child] = None

    def _break_cycle(self, parent: str, child: str, time: float) -> None:
        """Refuse a transform that closes a cycle, or forget what it has contradicted for long."""
        above = self._upwards(parent)
        if child not in above:
            return
        between = above[: above.index(child)]
        moving = [frame for frame in between if not self._edges[frame].is_static]
        oldest = min(moving, key=lambda frame: self._edges[frame].number, default=None)
        if oldest is not None:
            edge = self._edges[oldest]
            if edge.contradicted_at is None:
                self._edges[oldest] = replace(edge, contradicted_at=time)
            elif abs(time - edge.contradicted_at) > _PATIENCE:
                # Also if the clock was set back.
                self._forget(oldest)
                return
        raise InvalidTransform(
            parent,
            child,
            f'{quoted(parent)} lies below {quoted(child)} already; '
            'is one of them published the wrong way round?',
        )

    def _make_room(self, parent: str, child: str) -> None:
        """Forget a frame if there are too many: a moving one first, which is published again."""
        if len(self._edges) < MOST_FRAMES:
            return
        kept = {frame for end in (*self.needed, parent) for frame in self._upwards(end)}
        for frames in (self._moving, self._edges):
            for frame in frames:
                if frame not in kept:
                    self._forget(frame)
                    return
        raise InvalidTransform(parent, child, f'{MOST_FRAMES} frames are known already')

    def _forget(self, frame: str) -> None:
        self._edges.pop(frame, None)
        self._moving.pop(frame, None)

    def _upwards(self, frame: str) -> list[str]:
        """Return a frame, its parent, and so on to the root."""
        frames = [frame]
        while (edge := self._edges.get(frame)) is not None:
            frame = edge.parent
            frames.append(frame)
        return frames

    def _chains(self, frame: str) -> dict[str, Chain]:
        """Return a frame's pose in itself, its parent, and so on to the root, nearest first."""
        chain = Chain(IDENTITY)
        chains = {frame: chain}
        while (edge := self._edges.get(frame)) is not None and edge.pose is not None:
            chain = chain.then(edge, edge.pose)
            frame = edge.parent
            chains[frame] = chain
        return chains
