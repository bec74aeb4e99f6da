"""
What is made of pictures and odometry, and what is wrong with them: the core of the camera's node.

The session knows no topics and no clock. Its node hands it what was received, and publishes what
comes of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from quad_common.errors import QuadError
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.ros.timing.stamp_order import StampOrder
from quad_common.status import Level, Status
from quad_common.vision.camera import CameraModel
from quad_common.vision.camera_file import load_camera
from quad_common.vision.color_parameters import color_from, markers_from
from quad_perception.parameters import CeilingCameraParameters
from quad_perception.picture.color_segmentation import Picture
from quad_perception.picture.perception import Perceiver
from quad_perception.picture.scene_model import SceneModel, default_ranges
from quad_perception.tracking.pose_fusion import FusionOptions
from quad_perception.tracking.scene_tracker import SceneTracker, Sighting, TrackerOptions

_LONGEST_PAUSE = 60.0
"""Step ahead beyond which odometry is of another time [s]."""

_INPUTS = ('camera_info', 'picture', 'odometry')
"""What is received; the problem of the first that has one is reported."""


class CameraSession:
    """
    Tracks the scene under a camera as soon as its lens is known.

    Parameters
    ----------
    parameters : CeilingCameraParameters
        Of the node.
    robot : Robot
        The robot.
    """

    def __init__(self, parameters: CeilingCameraParameters, robot: Robot) -> None:
        p = self._parameters = parameters
        self._robot = robot
        self._markers = markers_from(p, robot)
        self.place = _camera_place(p)
        """Place of the camera; its lens comes with :meth:`take_camera`."""
        self.tracker: SceneTracker | None = None
        """The scene; None before the camera's lens is known."""
        self._problems: dict[str, QuadError] = {}
        self._sighting: Sighting | None = None
        self._seen_at: float | None = None
        self._legs_at: float | None = None
        self._picture_order = StampOrder('image', patience=3)
        self._odometry_order = StampOrder(p.odometry_topic, _LONGEST_PAUSE)

    @contextmanager
    def receiving(self, what: str) -> Iterator[None]:
        """
        Keep the error of whatever is done with an input as its problem, until one is good.

        Parameters
        ----------
        what : str
            ``camera_info``, ``picture`` or ``odometry``.
        """
        try:
            yield
        except QuadError as error:
            self._problems[what] = error
            raise
        self._problems.pop(what, None)

    def take_camera(self, camera: CameraModel) -> None:
        """Look through this camera from now on; what was seen before is forgotten."""
        p = self._parameters
        robot, goal = self._markers
        ranges = default_ranges(color_from(p, 'obstacle_color'), robot, goal)
        scene = SceneModel.of_robot(self._robot, ranges, robot, goal)
        bounds = _bounds(p.map_bounds)
        perceiver = Perceiver(camera, scene, resolution=p.resolution, bounds=bounds)
        self.tracker = SceneTracker(
            perceiver,
            TrackerOptions(p.confirmations, p.goal_distance, p.goal_angle, p.largest_age),
            FusionOptions(p.slip, p.turning_slip),
        )

    def take_picture(self, time: float, rgb: Picture) -> Sighting:
        """
        Take a picture; see :meth:`SceneTracker.add_picture`.

        Parameters
        ----------
        time : float
            When it was taken [s].
        rgb : ndarray of uint8, shape (height, width, 3)
            Red, green, blue.

        Returns
        -------
        Sighting
            What has changed.
        """
        assert self.tracker is not None
        self._picture_order.check(time)
        self._sighting = self.tracker.add_picture(time, rgb)
        self._seen_at = time
        return self._sighting

    def take_odometry(self, time: float, pose: Pose2D) -> SceneTracker | None:
        """
        Take an odometry of the legs.

        Parameters
        ----------
        time : float
            Of the odometry [s].
        pose : Pose2D
            base_link in odometry's frame.

        Returns
        -------
        SceneTracker or None
            The scene with the robot moved; None before the camera's lens is known.
        """
        self._odometry_order.check(time)
        self._legs_at = time
        if self.tracker is not None:
            self.tracker.add_odometry(time, pose)
        return self.tracker

    def status(self, now: float) -> Status | QuadError:
        """
        Return what is seen, or what is missing.

        Parameters
        ----------
        now : float
            The node's time [s].
        """
        oldest = now - self._parameters.largest_age
        problem = next((self._problems[what] for what in _INPUTS if what in self._problems), None)
        sighting = self._sighting
        if problem is not None:
            return problem
        if self.tracker is None:
            message = "no camera_info: waiting for it on 'ceiling_camera/camera_info'"
        elif sighting is None or self._seen_at is None:
            message = "no picture: waiting for one on 'ceiling_camera/image_raw'"
        elif self._seen_at < oldest:
            message = f'the last picture is {now - self._seen_at:.1f} s old'
        elif self._legs_at is None or self._legs_at < oldest:
            message = f"no odometry: waiting for it on '{self._parameters.odometry_topic}'"
        elif sighting.problem is not None:
            message = str(sighting.problem)
        elif sighting.goal_problem is not None:
            message = str(sighting.goal_problem)
        else:
            return Status(Level.OK, 'the map, and the robot on it, are seen')
        return Status(Level.WARN, message, is_waiting=self.tracker is None or sighting is None)


def _camera_place(p: CeilingCameraParameters) -> CameraModel:
    if p.camera_file:
        return load_camera(p.camera_file)
    return CameraModel.looking_down(p.camera_position, p.camera_yaw, 1.0)


def _bounds(numbers: list[float]) -> tuple[float, float, float, float] | None:
    """Read the corners of the map; None if there are none."""
    return tuple(numbers) if numbers else None  # type: ignore[return-value]
