"""
Where odometry's frame lies in the map: the transform map -> odom of REP-105.

Odometry has no leaps and drifts; a localiser corrects it by publishing where odometry's frame
is in the map, with leaps. Here transforms between frames are kept and composed, and corrections
are followed smoothly: each moves the robot's pose on the map by a fraction of what it would change.

The fraction is 1 - exp(-dt / T), with dt the time since the correction before and T a time
constant: a first-order low-pass filter of the robot's pose, not of the transform, whose
translation depends on how far the robot is from odometry's origin. The n-th correction counts at
least 1/n, so that the first ones are averaged. With noise of s [m] in each correction, what is
left is s * sqrt(f / (2 - f)).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from quad_common.errors import InvalidTransform, WrongFrame
from quad_common.frames.frame_tree import IDENTITY, FrameTransform, FrameTree
from quad_common.frames.leap_watch import LeapWatch
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D

_LEAP = 0.25
"""A correction that moves the robot farther is a relocalisation, taken whole [m]."""

_LEAP_TURN = math.radians(20.0)
"""Or one that turns it by more [rad]."""

_QUIET = 1.0
"""Leaps are reported at most so often [s]."""


class MapFrame:
    """
    Says where the robot is in the map, from odometry and the transforms that are published.

    Parameters
    ----------
    name : str
        The map's frame.
    time_constant : float
        Of the filter of corrections [s]; 0: each is taken whole.
    """

    def __init__(self, name: str = 'map', time_constant: float = 3.0) -> None:
        self._name = name
        self._time_constant = time_constant
        self._tree = FrameTree()
        self._tree.needed = (name,)
        self._odom_frame: str | None = None
        self._seen = 0
        self._is_static = False
        self._count = 0
        self._correction: Pose2D | None = None
        self._corrected_at = -math.inf
        self._time = self._leapt_at = -math.inf
        self._leaps = LeapWatch()
        self._remarks: list[str] = []

    @property
    def name(self) -> str:
        """The map's frame."""
        return self._name

    @property
    def odom_frame(self) -> str | None:
        """Odometry's frame; None before the first odometry."""
        return self._odom_frame

    @property
    def correction(self) -> Pose2D | None:
        """Odometry's frame in the map, as it is in force; None if it is not published."""
        return self._correction

    @property
    def is_in_map(self) -> bool:
        """Whether odometry itself is given in the map's frame."""
        return self._odom_frame == self._name

    @property
    def frames_on_map(self) -> tuple[str, ...]:
        """Frames that coincide with the map: its own, and odometry's while nothing corrects it."""
        is_other = self._odom_frame is None or (
            self._correction is not None and self._correction != IDENTITY
        )
        return (self._name,) if is_other else (self._name, str(self._odom_frame))

    @property
    def age(self) -> float:
        """Time of odometry since the last correction [s]; 0 without one, or for one for good."""
        if self._correction is None or self._is_static:
            return 0.0
        return max(0.0, self._time - self._corrected_at)

    @property
    def doubt(self) -> str:
        """That corrections do not end to leap, as a sentence; empty while they do not leap."""
        if not self._leaps.is_doubtful(self._time):
            return ''
        return (
            f"'{self._name}' -> '{self._odom_frame}' leaps again and again: "
            'do two publishers disagree?'
        )

    def rename(self, name: str) -> None:
        """Go on with another frame of the map."""
        if name != self._name:
            self._name = name
            self._need_ends()
            self._forget_correction()

    def add(self, transforms: Sequence[FrameTransform]) -> None:
        """
        Take transforms, of which those that do not lead from the map to odometry are left out.

        Raises
        ------
        InvalidTransform
            If one that may matter is not valid, or closes a cycle: those before it in the row are
            taken, and what was known of the frame stays.
        """
        for transform in transforms:
            parent, child = transform.parent.lstrip('/'), transform.child.lstrip('/')
            if child == parent or self._tree.holds_link(parent, child):
                # The robot's own links come at a high rate.
                continue
            named = FrameTransform(
                parent, child, transform.translation, transform.rotation, transform.is_static
            )
            is_relevant = self._may_matter(child)
            is_below = parent == self._odom_frame or self._tree.is_link(parent)
            # Links need not be planar.
            add = self._tree.add_link if is_below and not is_relevant else self._tree.add
            try:
                add(named, self._time)
            except InvalidTransform:
                # Else it may be a link of the robot that is not known as one yet.
                if is_relevant:
                    raise

    def locate(self, time: float, frame: str, odometry: Pose2D) -> Pose2D:
        """
        Take an odometry.

        Parameters
        ----------
        time : float
            Of the odometry [s].
        frame : str
            In which it is given.
        odometry : Pose2D
            base_link in that frame.

        Returns
        -------
        Pose2D
            base_link in the map; the odometry itself as long as the frames are not related.
        """
        if frame != self._odom_frame:
            self._odom_frame = frame
            self._need_ends()
            self._tree.forget_links()
            self._forget_correction()
        if time < self._corrected_at - 1.0:
            # The clock was set back.
            self._corrected_at = self._leapt_at = time
            self._leaps.forget()
        self._time = time
        self._take_published(time, odometry)
        return self._placed(odometry)

    def on_map(self, frame: str, pose: Pose2D) -> Pose2D | None:
        """
        Bring a pose into the map.

        Parameters
        ----------
        frame : str
            In which it is given: the map's, odometry's, or one that transforms relate to it.
        pose : Pose2D
            The pose in that frame.

        Returns
        -------
        Pose2D or None
            The pose in the map; None if nothing relates the frames.
        """
        if frame == self._name:
            return pose
        if frame == self._odom_frame:
            return self._placed(pose)
        found = self._tree.find(self._name, frame)
        return None if found is None else found.pose @ pose

    def pose_in(self, frame: str) -> Pose2D | None:
        """Return the pose of the map's frame in another one; None if nothing relates the two."""
        origin = self.on_map(frame, IDENTITY)
        return None if origin is None else origin.inverse()

    def plan_on_map(self, frame: str, plan: Plan) -> Plan:
        """
        Bring a plan into the map.

        Raises
        ------
        WrongFrame
            If nothing relates its frame to the map.
        """
        if frame == self._name:
            return plan
        poses = []
        for pose in plan.poses:
            placed = self.on_map(frame, pose)
            if placed is None:
                raise WrongFrame('plan', frame, self._name)
            poses.append(placed)
        return Plan(tuple(poses), plan.remark)

    def take_remarks(self) -> list[str]:
        """Return what is to be said of corrections since this was asked last."""
        remarks, self._remarks = self._remarks, []
        return remarks

    def _placed(self, pose: Pose2D) -> Pose2D:
        correction = self._correction
        # The very same numbers where the frames coincide.
        return pose if correction is None or correction == IDENTITY else correction @ pose

    def _forget_correction(self) -> None:
        self._correction = None
        self._is_static = False
        self._count = self._seen = 0
        self._corrected_at = -math.inf
        self._leaps.forget()

    def _need_ends(self) -> None:
        self._tree.needed = (self._name, *filter(None, [self._odom_frame]))

    def _may_matter(self, frame: str) -> bool:
        """Return whether a frame is map or odometry, or between them as far as is known."""
        ends = (self._odom_frame, self._name)
        return any(end is not None and self._tree.is_above(frame, end) for end in ends)

    def _take_published(self, time: float, odometry: Pose2D) -> None:
        """Follow what the transforms say, if a new one has come."""
        if self.is_in_map or self._odom_frame is None:
            return
        found = self._tree.find(self._name, self._odom_frame)
        if found is None or found.newest == self._seen:
            return
        self._seen = found.newest
        self._is_static = found.is_static
        if self._correction is None:
            self._begin(time, found.pose, odometry)
            return
        here = self._correction @ odometry
        error = here.inverse() @ (found.pose @ odometry)
        fraction = self._fraction(time, here, error)
        self._count += 1
        self._corrected_at = time
        if fraction >= 1.0:
            self._correction = found.pose
            return
        part = Pose2D(fraction * error.x, fraction * error.y, fraction * error.yaw)
        self._correction = here @ part @ odometry.inverse()

    def _fraction(self, time: float, here: Pose2D, error: Pose2D) -> float:
        """Say how much of a correction is taken at once."""
        distance = math.hypot(error.x, error.y)
        if distance > _LEAP or abs(error.yaw) > _LEAP_TURN:
            self._count = 0
            self._leaps.take(time)
            if time > self._leapt_at + _QUIET:
                self._leapt_at = time
                there = here @ error
                self._remarks.append(
                    f'localisation moved the robot by {distance:.2f} m and '
                    f'{math.degrees(error.yaw):.0f} degrees, to ({there.x:.2f}, {there.y:.2f}) m '
                    f'in the map'
                )
            return 1.0
        if self._is_static or self._time_constant <= 0.0:
            return 1.0
        elapsed = max(0.0, time - self._corrected_at)
        return max(1.0 / (self._count + 1), 1.0 - math.exp(-elapsed / self._time_constant))

    def _begin(self, time: float, published: Pose2D, odometry: Pose2D) -> None:
        self._correction = published
        self._corrected_at = time
        self._count = 1
        pose = self._placed(odometry)
        self._remarks.append(
            f"localised: '{self._name}' -> '{self._odom_frame}' is published; the robot is at "
            f'({pose.x:.2f}, {pose.y:.2f}) m in the map'
        )
