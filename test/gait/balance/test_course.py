"""Courses of balanced trots: from step to step, and how fast a robot is to be for them."""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_gait.balance.course import Course, Guide, Start
from quad_gait.cycle.body_motion import BodyMotion

ORIGIN = Pose2D(0.0, 0.0, 0.0)


def close(a, b):
    return (a.x, a.y, a.yaw) == pytest.approx((b.x, b.y, b.yaw), abs=1e-9)


def test_a_course_begins_and_ends_as_it_was_planned():
    start, entry, motion, after = (
        Pose2D(1.0, 2.0, 0.5),
        Twist2D(0.1),
        BodyMotion(0.2, 0.05, 0.1),
        Twist2D(0.3, 0.0, 0.2),
    )
    course = Course(3.0, 0.5, start, entry, motion, after)
    pose, twist = course.at(3.0)
    assert (pose, twist) == (start, entry)
    pose, twist = course.at(3.5)
    end = start @ motion.end
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((end.x, end.y, end.yaw))
    assert twist == after
    pace = course.pace(3.0, start, Guide(1.5, 0.1, 0.0, True))
    assert pace == pytest.approx((0.1, 0.0, 0.0))


def test_a_robot_beside_its_course_is_drawn_back_to_it():
    course = Course(0.0, 1.0, Pose2D(0.0, 0.0, 0.0), Twist2D(), BodyMotion(), Twist2D())
    pace = course.pace(0.5, Pose2D(0.02, -0.04, 0.1), Guide(1.5, 1.0, 0.0, True))
    assert pace.forward < 0.0 < pace.left
    assert pace.turn < 0.0
    far = course.pace(0.5, Pose2D(5.0, 0.0, 0.0), Guide(1.5, 0.1, 0.0, True))
    assert np.hypot(far.forward, far.left) == pytest.approx(0.1)


def test_a_course_slows_a_robot_as_early_as_its_velocity_comes_late():
    course = Course(
        0.0, 1.0, Pose2D(0.0, 0.0, 0.0), Twist2D(0.2), BodyMotion(forward=0.1), Twist2D()
    )
    on_it = course.at(0.8)[0]
    late, early = (course.pace(0.8, on_it, Guide(1.5, 0.1, lead, True)) for lead in (0.0, 0.15))
    assert early.forward == pytest.approx(course.at(0.95)[1].forward)
    assert early.forward < 0.5 * late.forward
    turned = Pose2D(on_it.x, on_it.y, 0.1)
    assert course.pace(0.8, turned, Guide(1.5, 0.1, 0.0, True)).turn < 0.0
    assert course.pace(0.8, turned, Guide(1.5, 0.1, 0.0, False)).turn == 0.0


def test_a_robot_that_goes_begins_its_next_step_where_it_should_be():
    course = Course(0.0, 1.0, ORIGIN, STILL, BodyMotion(forward=0.5), Twist2D(1.0))
    behind = Pose2D(0.46, 0.01, 0.02)
    start = course.start_after(1.0, behind, farthest=0.1)
    assert close(start.pose, Pose2D(0.5, 0.0, 0.0))
    assert start.entry == Twist2D(1.0)
    assert start.before is None


def test_a_robot_that_is_far_off_begins_nearer_to_where_it_is():
    course = Course(0.0, 1.0, ORIGIN, STILL, BodyMotion(forward=0.5), Twist2D(1.0))
    start = course.start_after(1.0, Pose2D(0.0, 0.0, 1.0), farthest=0.1)
    assert math.hypot(start.pose.x, start.pose.y) == pytest.approx(0.1)
    assert start.pose.yaw == pytest.approx(1.0 - math.radians(12.0))


def test_after_a_stop_the_next_step_begins_where_the_last_one_leads():
    course = Course(0.0, 1.0, ORIGIN, Twist2D(1.0), BodyMotion(forward=0.5), STILL)
    planned = course.at(0.8)[0]
    beside = planned @ Pose2D(0.0, 0.03, 0.1)
    start = course.start_after(0.8, beside, farthest=0.1)
    assert not start.entry
    assert close(start.pose, beside @ (planned.inverse() @ Pose2D(0.5, 0.0, 0.0)))
    # Until it begins, the course is the rest of the last one, from where the robot is.
    after = Course.from_start(start, (1.0, 0.6), BodyMotion(turn=0.4), STILL)
    pose, twist = after.at(0.8)
    assert close(pose, beside)
    assert twist == course.at(0.8)[1]
    times = np.linspace(0.8, 1.2, 401)
    apart = [after.at(a)[0].distance_to(after.at(b)[0]) for a, b in pairwise(times)]
    assert max(apart) < 1.1e-3 * twist.forward
    assert not after.at(1.0)[1]


def test_a_robot_that_waits_for_its_course_is_to_stay_where_it_is():
    course = Course.from_start(Start(ORIGIN), (1.0, 0.5), BodyMotion(forward=0.1), Twist2D(0.4))
    assert course.at(0.9) == (ORIGIN, STILL)
    assert course.end == 1.5
    early = course.pace(0.9, ORIGIN, Guide(1.5, 0.1, 0.3, True))
    assert early.forward == pytest.approx(course.at(1.2)[1].forward)
