"""
All that is shown of one robot, and what of it has changed since it was last drawn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.rotations import angles_from_quaternion, yaw_from_quaternion
from quad_common.status import Level
from quad_view.scene.course import Track, distance_from_plan
from quad_view.scene.floor import FloorPicture, Surface
from quad_view.scene.robot_model import RobotModel
from quad_view.scene.series import Series
from quad_view.scene.words import Line, Said, headline, lines, newest_said

Array = NDArray[np.float64]

_NOTHING = np.zeros((0, 2))

_STILL = 1e-5
"""Joints and poses that changed by less are not drawn again [rad, m]."""

_FRESH = 1.0
"""A robot whose state is older does not report any more [s]."""


class RobotView:
    """
    What is known of a robot.

    Each field is set by :meth:`note`, which marks it as changed for :meth:`take_changes`.

    Parameters
    ----------
    name : str
        Namespace of the robot; empty for none.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        """Namespace."""
        self.model: RobotModel | None = None
        """Links and joints."""
        self.lacking: tuple[str, ...] = ()
        """Meshes of the model that cannot be shown, and why."""
        self.joints: dict[str, float] = {}
        """Joint positions by name [rad or m]."""
        self.position = np.zeros(3)
        """Position of the root link on the map, shape (3,) [m]."""
        self.orientation = np.array([0.0, 0.0, 0.0, 1.0])
        """Its orientation on the map, a quaternion xyzw."""
        self.pose: Pose2D | None = None
        """Pose on the map; None before it is known."""
        self.floor: FloorPicture | None = None
        """Map."""
        self.boundary: tuple[Array, ...] = ()
        """Safety boundary: closed lines, each of shape (n, 2) [m]."""
        self.plan: Array = _NOTHING
        """Turning points, shape (n, 2) [m]."""
        self.goal: Pose2D | None = None
        """Goal that was last given, by whomever."""
        self.track: Array = _NOTHING
        """Walked track, shape (n, 2) [m]."""
        self.footholds: Array = np.zeros((0, 3))
        """Next footholds, shape (n, 3) [m]."""
        self.support: Array = _NOTHING
        """Corners of the support polygon on the map, shape (n, 2) [m]."""
        self.margin = math.nan
        """Stability margin [m]."""
        self.surface: Surface | None = None
        """Ground, from a height map."""
        self.picture: NDArray[np.uint8] | None = None
        """Picture of the camera, shape (height, width, 3)."""
        self.obstacles: dict[tuple[str, int], tuple[str, Pose2D, tuple[float, float, float]]] = {}
        """Kind, pose and size [m] of obstacles in the simulation, by name."""
        self.options: dict[str, str] = {}
        """Parameters of the nodes that can be chosen, by name."""
        self.is_stopped = False
        """Whether the emergency stop is on."""
        self.said: dict[str, Said] = {}
        """What each node said last."""
        self.answer = ''
        """Answer to the last request, as a sentence."""
        self.plots = {
            'stability margin [m]': Series(['margin']),
            'tilt [deg]': Series(['roll', 'pitch']),
            'speed [m/s], turning [rad/s]': Series(['forward', 'left', 'turning']),
            'distance from the path [m]': Series(['distance']),
        }
        """Plots by title; that of the joints is added with the first of them."""
        self._track = Track()
        self._changed: set[str] = set()
        self._moved_at = -math.inf

    def note(self, **values: Any) -> None:
        """Take values of fields, and mark these as changed."""
        for field, value in values.items():
            assert hasattr(self, field), field
            setattr(self, field, value)
        self._changed |= values.keys()

    def take_changes(self) -> frozenset[str]:
        """Return the fields that changed since the last call."""
        changed, self._changed = frozenset(self._changed), set()
        return changed

    def has_robot(self, now: float) -> bool:
        """Return whether the robot's state came in lately; time by the wall clock [s]."""
        return now - self._moved_at < _FRESH

    def note_said(self, said: Mapping[str, Said]) -> None:
        """Take what nodes have said, by their names; of many the newest, besides our own."""
        self.note(said=newest_said({**self.said, **said}))

    def note_joints(self, joints: Mapping[str, float]) -> None:
        """Take joint positions; those that have hardly moved are not drawn again."""
        old = self.joints
        if old.keys() != joints.keys() or any(
            abs(value - old[name]) > _STILL for name, value in joints.items()
        ):
            self.note(joints=dict(joints))

    def note_pose(self, position: Array, orientation: Array, now: float) -> None:
        """Take the pose of the root link on the map, received at a time of the wall clock [s]."""
        self._moved_at = now
        if self.pose is not None and (
            np.abs(position - self.position).max() < _STILL
            and np.abs(orientation - self.orientation).max() < _STILL
        ):
            return
        pose = Pose2D(float(position[0]), float(position[1]), yaw_from_quaternion(orientation))
        self.note(position=position, orientation=orientation, pose=pose)
        if self._track.add(pose.x, pose.y):
            self.note(track=self._track.points())

    def rewind(self) -> None:
        """Forget what is not so at the beginning; links, map and ground stay."""
        self._track, self._moved_at = Track(), -math.inf
        for series in self.plots.values():
            series.clear()
        self.note(
            plan=_NOTHING, goal=None, track=_NOTHING, footholds=np.zeros((0, 3)), support=_NOTHING,
            margin=math.nan, obstacles={}, is_stopped=False, said={}, answer='', boundary=(),
        )  # fmt: skip

    def note_plan(self, plan: Plan | None) -> None:
        """Take the plan on the map; None where it is taken back."""
        self.note(plan=_NOTHING if plan is None else plan.corners)

    def plot(self, time: float, velocity: tuple[float, float, float]) -> None:
        """
        Note what is plotted.

        Parameters
        ----------
        time : float
            Time of the measurement [s].
        velocity : tuple of float
            Forward and left [m/s], and turning [rad/s].
        """
        roll, pitch, _ = angles_from_quaternion(self.orientation)
        rows: dict[str, tuple[float, ...]] = {
            'stability margin [m]': (self.margin,),
            'tilt [deg]': (math.degrees(roll), math.degrees(pitch)),
            'speed [m/s], turning [rad/s]': velocity,
            'distance from the path [m]': (distance_from_plan(self.pose, self.plan),),
        }
        if self.joints:
            title = 'joint angles [deg]'
            if title not in self.plots or set(self.plots[title].names) != self.joints.keys():
                self.plots[title] = Series(list(self.joints))
            rows[title] = tuple(math.degrees(self.joints[n]) for n in self.plots[title].names)
        for title, values in rows.items():
            self.plots[title].add(time, values)

    def lines(self, now: float) -> tuple[Line, ...]:
        """Say of each node what it does, or what follows from its absence; time as above [s]."""
        rows = lines(self.said, self.has_robot(now), now)
        if not self.lacking:
            return rows
        more = f', and {len(self.lacking) - 1} more' if len(self.lacking) > 1 else ''
        text = f'a part of the robot is not shown: {self.lacking[0]}{more}'
        return (*rows, Line(Level.WARN, 'viewer_node', text))

    def headline(self, now: float) -> tuple[int, str]:
        """Say in one sentence what the robot does, with its level; time as above [s]."""
        return headline(self.said, self.has_robot(now), self.is_stopped, now)
