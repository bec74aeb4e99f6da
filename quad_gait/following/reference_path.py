"""
The line that a robot follows: straight pieces and arcs of circles, joined end to end.

A plan's corners may stay as they are, or be rounded by circles (S2: any curve is a
sequence of circles of different radius; a straight piece is one of curvature zero).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_gait.cycle.body_motion import BodyMotion

_TURN = 0.25
"""A turn of 1 rad is as much to do as so many metres."""

_SHORTEST = 1e-6
"""Length below which pieces are left out [m]."""


@dataclass(frozen=True)
class Piece:
    """A straight line, or an arc of a circle."""

    start: Pose2D
    """Pose at which it begins, heading along it."""
    length: float
    """Length along it [m]."""
    curvature: float = 0.0
    """1 / radius, positive to the left [1/m]."""
    ends_in_stop: bool = False
    """Whether the robot rests at its end: a corner, or the goal."""

    @property
    def end(self) -> Pose2D:
        """Where it ends, heading along it."""
        return self.at(self.length)

    def at(self, distance: float) -> Pose2D:
        """Return the pose at a distance from the start, heading along the piece [m]."""
        return (
            self.start @ BodyMotion(forward=distance, turn=self.curvature * distance).end
            if self.curvature
            else self.start @ Pose2D(distance, 0.0, 0.0)
        )

    def project(self, pose: Pose2D) -> float:
        """Return the distance along the piece, not limited to it, nearest to a pose [m]."""
        seen = self.start.inverse() @ pose
        if not self.curvature:
            return seen.x
        radius = 1.0 / self.curvature
        angle = math.atan2(seen.x * abs(self.curvature), (radius - seen.y) * self.curvature)
        # Before its start an arc is left backwards, after its end forwards.
        middle = abs(self.curvature) * self.length / 2.0
        return (middle + wrap_angle(angle - middle)) / abs(self.curvature)

    def distance_to(self, pose: Pose2D) -> float:
        """Return how far a pose is from the piece [m]."""
        return pose.distance_to(self.at(min(max(self.project(pose), 0.0), self.length)))


def work_left(pieces: Sequence[Piece], pose: Pose2D, goal: Pose2D) -> float:
    """
    Measure what is left to do along a path: distances, and turns towards each piece and the goal.

    Parameters
    ----------
    pieces : sequence of Piece
        What is left of the path, the piece that is followed first.
    pose : Pose2D
        Where the robot is.
    goal : Pose2D
        Where the path leads, with the heading at its end.

    Returns
    -------
    float
        A turn of 1 rad counts as much as 0.25 m [m].
    """
    ahead = pieces[0].end if pieces else goal
    distance = pose.distance_to(ahead) + sum(piece.length for piece in pieces[1:])
    heading, turns = pose.yaw, 0.0
    for piece in pieces:
        turns += abs(wrap_angle(piece.start.yaw - heading)) + abs(piece.curvature) * piece.length
        heading = piece.end.yaw
    return distance + _TURN * (turns + abs(wrap_angle(goal.yaw - heading)))


def straight_pieces(plan: Plan, stop_angle: float) -> list[Piece]:
    """
    Follow a plan from turning point to turning point.

    Parameters
    ----------
    plan : Plan
        Turning points.
    stop_angle : float
        The robot rests at corners sharper than this [rad].

    Returns
    -------
    list of Piece
        Straight ones; the last ends in a stop.
    """
    pieces: list[Piece] = []
    for a, b in pairwise(plan.poses):
        length = a.distance_to(b)
        if length > _SHORTEST:
            pieces.append(Piece(Pose2D(a.x, a.y, a.heading_to(b)), length))
    return _with_stops(pieces, stop_angle)


def rounded_pieces(plan: Plan, deviation: float, radius: float, stop_angle: float) -> list[Piece]:
    """
    Follow a plan with its corners rounded by circles that touch both sides.

    Parameters
    ----------
    plan : Plan
        Turning points; may be as dense as a curve, whose bends become circles.
    deviation : float
        How far an arc may pass inside its corner [m].
    radius : float
        Largest radius; where sides are short, or the deviation is small, it is less [m].
    stop_angle : float
        The robot rests where a corner could not be rounded and is sharper [rad].

    Returns
    -------
    list of Piece
        Straight ones and arcs; the last ends in a stop.
    """
    lines = straight_pieces(plan, math.pi)
    pieces: list[Piece] = []
    offset = 0.0
    for line, after in pairwise(lines):
        turn = wrap_angle(after.start.yaw - line.start.yaw)
        tangent = _tangent_length(abs(turn), deviation, radius)
        # A side shared by two corners is divided between them.
        tangent = min(tangent, line.length / 2.0, after.length / 2.0)
        if abs(turn) < 1e-6 or abs(turn) > math.pi - 1e-3:
            tangent = 0.0
        straight = line.length - offset - tangent
        if straight > _SHORTEST:
            pieces.append(Piece(line.at(offset), straight))
        if tangent > _SHORTEST:
            arc_radius = tangent / math.tan(abs(turn) / 2.0)
            pieces.append(
                Piece(
                    line.at(line.length - tangent),
                    arc_radius * abs(turn),
                    math.copysign(1.0 / arc_radius, turn),
                )
            )
        offset = tangent
    if lines and lines[-1].length - offset > _SHORTEST:
        pieces.append(Piece(lines[-1].at(offset), lines[-1].length - offset))
    return _with_stops(pieces, stop_angle)


def circle_pieces(start: Pose2D, radius: float, turn: float) -> list[Piece]:
    """
    Follow a circle.

    Parameters
    ----------
    start : Pose2D
        Where it begins, heading along it.
    radius : float
        [m]
    turn : float
        How far round, positive to the left; more than 2 pi for several laps [rad].

    Returns
    -------
    list of Piece
        Arcs of a quarter each, or what is left; the last ends in a stop.
    """
    pieces = []
    count = max(1, math.ceil(abs(turn) / (math.pi / 2.0) - 1e-9))
    length = radius * abs(turn) / count
    for _ in range(count):
        pieces.append(Piece(start, length, math.copysign(1.0 / radius, turn)))
        start = pieces[-1].end
    return _with_stops(pieces, math.pi)


def _tangent_length(turn: float, deviation: float, radius: float) -> float:
    """Return the distance before a corner at which the arc begins [m]."""
    half = turn / 2.0
    if half < 1e-6 or half > math.pi / 2.0 - 1e-3:
        return 0.0
    # The middle of the arc is radius (1 / cos - 1) away from the corner.
    from_deviation = deviation / (1.0 / math.cos(half) - 1.0)
    return min(radius, from_deviation) * math.tan(half)


def _with_stops(pieces: Sequence[Piece], stop_angle: float) -> list[Piece]:
    stopping = []
    for piece, after in pairwise(pieces):
        corner = abs(wrap_angle(after.start.yaw - piece.end.yaw)) > stop_angle
        stopping.append(Piece(piece.start, piece.length, piece.curvature, corner))
    if pieces:
        last = pieces[-1]
        stopping.append(Piece(last.start, last.length, last.curvature, True))
    return stopping


def pose_ahead(pieces: list[Piece], pose: Pose2D, distance: float, most_turn: float) -> Pose2D:
    """
    Return the pose so far along a path, heading along it, and no farther than the next stop.

    Parameters
    ----------
    pieces : list of Piece
        What is left of the path, at least one.
    pose : Pose2D
        Where the robot is.
    distance : float
        From beside it on [m].
    most_turn : float
        Angle from the path's heading beyond which the robot is to turn first [rad]: then it is the
        pose beside it.

    Returns
    -------
    Pose2D
    """
    piece = pieces[0]
    done = min(max(piece.project(pose), 0.0), piece.length)
    beside = piece.at(done)
    if abs(wrap_angle(beside.yaw - pose.yaw)) > most_turn:
        return beside
    for piece in pieces:
        left = piece.length - done
        if piece.ends_in_stop or left > distance:
            break
        distance, done = distance - left, 0.0
    return piece.at(min(done + distance, piece.length))
