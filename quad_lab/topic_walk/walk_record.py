"""
What happened in a walk, and the figures that are read from it.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distances_to_polyline, wrap_angle

Array = NDArray[np.float64]

_LATE = 1.0
"""Time by which odometry that is older than the one before may be late [s]."""


@dataclass
class WalkRecord:
    """What an observer of the topics has noted down."""

    goal: Pose2D
    times: list[float] = field(default_factory=list)
    """Of the poses, simulated [s]."""
    poses: list[Pose2D] = field(default_factory=list)
    """True poses of base_link."""
    plan_counts: list[int] = field(default_factory=list)
    """Number of plans that there were at each pose: the last of them was in force."""
    plans: list[Plan] = field(default_factory=list)
    """Every plan, the one in force last."""
    footholds: list[Array] = field(default_factory=list)
    """Planned footholds of each cycle, shape (4, 3) [m]."""
    height_map: HeightMap | None = None
    """Height map of the ground; None if none was published."""
    least_margin: float = math.inf
    """Least stability margin received [m]."""
    cycles: int = 0
    contacts: str = ''
    """Contacts of anything but feet with the ground, as the simulator reports them."""
    has_fallen: bool = False
    late_trajectories: int = 0
    """Trajectories that reached the simulator after their first movement was due."""
    has_arrived: bool = False
    """The gait node said so."""
    problem: str = ''
    """Why it ended, if not on arrival."""
    wall_time: float = 0.0
    """From the goal to the end, on the wall clock [s]."""
    seconds_in_physics: float = 0.0
    """Part of the wall time that the simulator spent in its physics [s]."""
    seconds_publishing: float = 0.0
    """Part of the wall time that the simulator spent observing and publishing [s]."""

    def note_pose(self, time: float, pose: Pose2D, plan_count: int | None = None) -> None:
        """
        Take down where the robot is.

        Parameters
        ----------
        time : float
            Simulated [s].
        pose : Pose2D
            Of base_link.
        plan_count : int, optional
            Number of plans that there were; that of now if not given.
        """
        self.times.append(time)
        self.poses.append(pose)
        self.plan_counts.append(len(self.plans) if plan_count is None else plan_count)

    def result(self) -> WalkResult:
        """Work the figures out."""
        duration = _duration(self.times)
        last = self.poses[-1] if self.poses else None
        track = np.array([(pose.x, pose.y) for pose in self.poses]).reshape(-1, 2)
        return WalkResult(
            arrived=self.has_arrived and not self.has_fallen,
            problem=self.problem,
            position_error=None if last is None else last.distance_to(self.goal),
            heading_error=None
            if last is None
            else abs(math.degrees(wrap_angle(last.yaw - self.goal.yaw))),
            largest_path_distance=self._largest_path_distance(track),
            least_stability_margin=None if math.isinf(self.least_margin) else self.least_margin,
            walking_time=duration,
            path_length=self.plans[-1].length if self.plans else None,
            turning_points=len(self.plans[-1].poses) if self.plans else 0,
            walked_distance=float(np.sum(np.linalg.norm(np.diff(track, axis=0), axis=1))),
            cycles=self.cycles,
            plans=len(self.plans),
            contacts=self.contacts,
            fallen=self.has_fallen,
            late_trajectories=self.late_trajectories,
            wall_time=self.wall_time,
            real_time_factor=(
                duration / self.wall_time if duration is not None and self.wall_time > 0.0 else None
            ),
        )

    def _largest_path_distance(self, track: Array) -> float | None:
        """Return the largest distance of poses, shape (n, 2), from their plans; None if none."""
        counts = np.array(self.plan_counts, dtype=int)
        return max(
            (
                float(np.max(distances_to_polyline(track[counts == count], plan.corners)))
                for count, plan in enumerate(self.plans, start=1)
                if count in counts
            ),
            default=None,
        )


@dataclass(frozen=True)
class WalkResult:
    """The figures of one walk."""

    arrived: bool
    problem: str
    position_error: float | None
    """From the goal at the end [m]."""
    heading_error: float | None
    """From the goal's heading at the end [deg]."""
    largest_path_distance: float | None
    """From the plan in force, of base_link [m]."""
    least_stability_margin: float | None
    """As planned [m]."""
    walking_time: float | None
    """Simulated [s]; None where the clock went back on the way."""
    path_length: float | None
    """[m]"""
    turning_points: int
    walked_distance: float
    """Of base_link, sway included [m]."""
    cycles: int
    """Gait cycles; of a trot that keeps its balance, decisions."""
    plans: int
    contacts: str
    fallen: bool
    late_trajectories: int
    wall_time: float
    """[s]"""
    real_time_factor: float | None
    """Simulated over wall-clock time."""

    def as_dict(self) -> dict[str, object]:
        """Return the figures for JSON."""
        return asdict(self)


def _duration(times: list[float]) -> float | None:
    """Return how long a walk took [s]; None where the clock went back on the way."""
    if not times:
        return 0.0
    duration = times[-1] - times[0]
    return None if duration < 0.0 or np.min(np.diff(times), initial=0.0) < -_LATE else duration
