"""
Poses of markers: two discs of different colors on a level plane of known height.

The center of a disc is the centroid of its pixels, which is good to a small fraction of a
pixel. A ray through it meets the plane of the discs; the line between both centers is the
marker's x axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MarkerHidden, MarkerNotSeen, ParameterError, SeveralMarkers
from quad_common.planar_pose import Pose2D
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import GoalMarker, RobotMarker
from quad_perception.picture.color_segmentation import Mask, Segmentation

Array = NDArray[np.float64]

_LEAST_FRACTION = 0.05
"""Least area of a spot that is no noise, as a fraction of the disc's."""
_WHOLE_FRACTION = 0.8
"""A disc of which less is seen has its center elsewhere than its centroid."""
_TOO_LARGE = 1.5
"""What is larger than a disc by this is none."""
_DISTANCE_TOLERANCE = 0.2
"""Error that the distance of two discs may have, as a fraction, and in metres besides."""
_DISTANCE_SLACK = 0.02
_EDGE_DEVIATION = 0.3
"""Standard deviation of where a pixel cuts an edge [pixels]."""


@dataclass(frozen=True)
class DiscOnMarker:
    """A disc of a marker."""

    color: str
    """Name of its range of colors."""
    offset: float
    """Place of its center along the marker's x axis [m]."""
    radius: float
    """Radius of the disc [m]."""


@dataclass(frozen=True)
class MarkerShape:
    """
    What is looked for.

    Raises
    ------
    ParameterError
        If the discs coincide, or a number is not valid.
    """

    what: str
    """What carries the marker, for example ``robot``."""
    rear: DiscOnMarker
    front: DiscOnMarker
    """Farther along the marker's x axis than the other one."""
    height: float
    """Height of the discs above the floor [m]."""
    height_deviation: float = 0.0
    """Standard deviation of the height [m]."""
    tilt_deviation: float = 0.0
    """Standard deviation of pitch and roll of the marker [rad]."""
    lever: float = 0.0
    """Height of the discs above the point whose position is wanted [m]."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not self.front.offset > self.rear.offset:
            raise ParameterError('front', self.front, 'ahead of the rear disc')
        if not (self.front.radius > 0.0 and self.rear.radius > 0.0):
            raise ParameterError('radius', self.front.radius, 'above 0')
        for name in ('height', 'height_deviation', 'tilt_deviation', 'lever'):
            value = getattr(self, name)
            if not 0.0 <= value < math.inf:
                raise ParameterError(name, value, 'a finite number of at least 0')

    @property
    def distance(self) -> float:
        """Distance between the centers [m]."""
        return self.front.offset - self.rear.offset

    @classmethod
    def of_robot(
        cls,
        marker: RobotMarker,
        base_height: float,
        height_deviation: float = 0.015,
        tilt_deviation: float = math.radians(2.0),
    ) -> MarkerShape:
        """
        Describe the marker on a robot's back, whose colors are ``robot_rear`` and ``robot_front``.

        Parameters
        ----------
        marker : RobotMarker
            The marker.
        base_height : float
            Of base_link above the floor as the robot walks [m].
        height_deviation : float
            By which this varies [m].
        tilt_deviation : float
            By which the body pitches and rolls [rad].
        """
        half = marker.disc_distance / 2.0
        return cls(
            'robot',
            DiscOnMarker('robot_rear', -half, marker.disc_radius),
            DiscOnMarker('robot_front', half, marker.disc_radius),
            base_height + marker.height,
            height_deviation,
            tilt_deviation,
            max(marker.height, 0.0),
        )

    @classmethod
    def of_goal(cls, marker: GoalMarker) -> MarkerShape:
        """Describe the marker at the goal, whose colors are ``goal`` and ``goal_heading``."""
        return cls(
            'goal',
            DiscOnMarker('goal', 0.0, marker.radius),
            DiscOnMarker('goal_heading', marker.heading_distance, marker.heading_radius),
            marker.height,
        )


@dataclass(frozen=True, eq=False)
class MarkerPose:
    """Pose of a marker, and how exactly it is known."""

    pose: Pose2D
    """Pose in the world [m, m, rad]."""
    covariance: Array
    """Covariance of x, y and yaw, shape (3, 3) [m^2, m rad, rad^2]."""


@dataclass(frozen=True, eq=False)
class _Spot:
    """A connected part of a color that may be a disc."""

    center: Array
    """Center on the plane of the discs, shape (2,) [m]."""
    fraction: float
    """Fraction of the area that the whole disc would have in the picture."""
    is_cut: bool
    """Whether the picture's border cuts it."""
    deviation: float
    """Standard deviation of the center, by the pixels [m]."""


def find_marker(segmentation: Segmentation, camera: CameraModel, shape: MarkerShape) -> MarkerPose:
    """
    Find a marker.

    Parameters
    ----------
    segmentation : Segmentation
        The picture by colors, with those of both discs.
    camera : CameraModel
        What took it.
    shape : MarkerShape
        What is looked for.

    Returns
    -------
    MarkerPose
        Pose of the marker.

    Raises
    ------
    MarkerNotSeen
        If neither disc is seen.
    MarkerHidden
        If less than both discs is seen, or not enough of one.
    SeveralMarkers
        If there are several.
    """
    rears, fronts = (
        _spots(segmentation.masks[disc.color], camera, disc.radius, shape.height)
        for disc in (shape.rear, shape.front)
    )
    whole = [[s for s in spots if _is_whole(s)] for spots in (rears, fronts)]
    pairs = [
        (rear, front) for rear in whole[0] for front in whole[1] if _is_pair(rear, front, shape)
    ]
    places = [_pose(rear, front, shape) for rear, front in pairs]
    if len(pairs) > 1:
        raise SeveralMarkers(shape.what, [(place.x, place.y) for place in places])
    if not pairs:
        raise _missing(shape, rears, fronts)
    (rear, front), (pose,) = pairs[0], places
    return MarkerPose(pose, _covariance(rear, front, pose, shape, camera))


def _is_whole(spot: _Spot) -> bool:
    return not spot.is_cut and spot.fraction >= _WHOLE_FRACTION


def _missing(
    shape: MarkerShape, rears: Sequence[_Spot], fronts: Sequence[_Spot]
) -> MarkerNotSeen | MarkerHidden:
    """Say why there is no pair of discs."""
    if not rears and not fronts:
        return MarkerNotSeen(shape.what, (shape.rear.color, shape.front.color))
    worst, worst_disc = None, shape.rear
    for disc, spots in ((shape.rear, rears), (shape.front, fronts)):
        best = max(spots, key=lambda spot: spot.fraction, default=None)
        if best is None:
            return MarkerHidden(shape.what, disc.color, 0.0, 'something hides it, or the light')
        if worst is None or (not _is_whole(best) and best.fraction < worst.fraction):
            worst, worst_disc = best, disc
    assert worst is not None
    if worst.is_cut:
        why = "the picture's border cuts it"
    elif _is_whole(worst):
        why = (
            f'the discs that are whole are not {shape.distance:.2f} m from each other, as those '
            'of the marker are'
        )
    else:
        why = 'something hides it'
    return MarkerHidden(shape.what, worst_disc.color, min(worst.fraction, 1.0), why)


def _is_pair(rear: _Spot, front: _Spot, shape: MarkerShape) -> bool:
    error = abs(float(np.linalg.norm(front.center - rear.center)) - shape.distance)
    return error <= _DISTANCE_TOLERANCE * shape.distance + _DISTANCE_SLACK


def _pose(rear: _Spot, front: _Spot, shape: MarkerShape) -> Pose2D:
    along = front.center - rear.center
    fraction = -shape.rear.offset / shape.distance
    x, y = rear.center + fraction * along
    return Pose2D(float(x), float(y), math.atan2(along[1], along[0]))


def _covariance(
    rear: _Spot, front: _Spot, pose: Pose2D, shape: MarkerShape, camera: CameraModel
) -> Array:
    """Add up what pixels, height and tilt do to a pose."""
    fraction = -shape.rear.offset / shape.distance
    of_rear, of_front = rear.deviation**2, front.deviation**2
    # position = (1 - fraction) rear + fraction front; yaw = across (front - rear) / distance.
    of_position = (1.0 - fraction) ** 2 * of_rear + fraction**2 * of_front
    of_yaw = (of_rear + of_front) / shape.distance**2
    together = (fraction * of_front - (1.0 - fraction) * of_rear) / shape.distance
    left = np.array([-math.sin(pose.yaw), math.cos(pose.yaw)])
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = np.eye(2) * (of_position + (shape.lever * shape.tilt_deviation) ** 2)
    covariance[2, 2] = of_yaw + shape.tilt_deviation**4
    covariance[:2, 2] = covariance[2, :2] = together * left
    # A wrong height moves the pose along the ray from below the camera.
    outward = np.array([pose.x, pose.y]) - camera.position[:2]
    moved = outward * shape.height_deviation / (camera.position[2] - shape.height)
    covariance[:2, :2] += np.outer(moved, moved)
    return covariance


def _spots(mask: Mask, camera: CameraModel, radius: float, height: float) -> list[_Spot]:
    """Find the parts of a mask that may be a disc."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    spots = []
    for outline in outlines:
        x, y, w, h = cv2.boundingRect(outline)
        if w * h < 4:
            continue
        part = np.zeros((h, w), np.uint8)
        cv2.drawContours(part, [outline], -1, 255, cv2.FILLED, offset=(-x, -y))
        part = cv2.bitwise_and(part, mask[y : y + h, x : x + w])
        moments = cv2.moments(part, binaryImage=True)
        area = moments['m00']
        if area < 4.0:
            continue
        pixel = np.array([moments['m10'], moments['m01']]) / area + (x + 0.5, y + 0.5)
        places = camera.on_plane(pixel + [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5)], height)
        (ax, ay), (bx, by) = 2.0 * (places[1:] - places[0])
        of_pixel = abs(float(ax * by - ay * bx))
        fraction = area * of_pixel / (math.pi * radius**2)
        if not (np.isfinite(places).all() and _LEAST_FRACTION <= fraction <= _TOO_LARGE):
            continue
        is_cut = x <= 0 or y <= 0 or x + w >= camera.width or y + h >= camera.height
        side = math.sqrt(of_pixel)
        # Of n = 2 pi r edge pixels each moves the centroid by its error times r/A.
        deviation = _EDGE_DEVIATION * side / math.sqrt(math.pi * radius / side)
        spots.append(_Spot(places[0], fraction, is_cut, deviation))
    return spots
