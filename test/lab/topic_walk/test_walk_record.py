"""The figures of a walk follow from what was noted down, and from nothing else."""

import json
import math
from dataclasses import fields

import pytest

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_lab.topic_walk.walk_record import WalkRecord, WalkResult

GOAL = Pose2D(2.0, 1.0, math.pi / 2)
PLAN = Plan.through([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]], math.pi / 2)


def walked(*poses, plan=PLAN, first=10.0):
    record = WalkRecord(GOAL)
    if plan is not None:
        record.plans.append(plan)
    for k, pose in enumerate(poses):
        record.note_pose(first + k, pose)
    return record


def test_nothing_noted_is_nothing_measured():
    result = WalkRecord(GOAL).result()
    assert not result.arrived
    for name in (
        'position_error',
        'heading_error',
        'largest_path_distance',
        'least_stability_margin',
        'path_length',
        'real_time_factor',
    ):
        assert getattr(result, name) is None
    assert (result.walking_time, result.walked_distance, result.plans) == (0.0, 0.0, 0)


def test_errors_are_those_of_the_last_pose():
    result = walked(Pose2D(0.0, 0.0, 0.0), Pose2D(2.03, 1.04, math.pi / 2 + 0.01)).result()
    assert result.position_error == pytest.approx(0.05)
    assert result.heading_error == pytest.approx(math.degrees(0.01))


def test_the_heading_error_is_taken_the_shorter_way():
    record = WalkRecord(Pose2D(0.0, 0.0, math.pi))
    record.note_pose(0.0, Pose2D(0.0, 0.0, -math.pi + 0.02))
    assert record.result().heading_error == pytest.approx(math.degrees(0.02))


def test_the_largest_distance_from_the_path_is_over_all_poses():
    poses = [Pose2D(x, y, 0.0) for x, y in ((0.0, 0.0), (1.0, 0.07), (1.5, -0.03), (2.1, 0.5))]
    assert walked(*poses).result().largest_path_distance == pytest.approx(0.1)


def test_distances_are_measured_from_the_plan_in_force_at_the_time():
    record = walked(Pose2D(1.0, 0.05, 0.0))
    record.plans.append(Plan.through([[1.0, 1.0], [2.0, 1.0]], 0.0))
    record.note_pose(11.0, Pose2D(1.2, 0.98, 0.0))
    result = record.result()
    assert result.largest_path_distance == pytest.approx(0.05)
    assert (result.plans, result.turning_points) == (2, 2)
    assert result.path_length == pytest.approx(1.0)


def test_a_pose_that_is_noted_later_is_measured_from_the_plan_of_its_time():
    record = walked()
    record.plans.append(Plan.through([[1.0, 1.0], [2.0, 1.0]], 0.0))
    record.note_pose(10.0, Pose2D(1.0, 0.05, 0.0), plan_count=1)
    record.note_pose(11.0, Pose2D(1.2, 0.98, 0.0), plan_count=2)
    assert record.result().largest_path_distance == pytest.approx(0.05)


def test_before_the_first_plan_no_distance_is_measured():
    record = walked(Pose2D(5.0, 5.0, 0.0), plan=None)
    record.plans.append(PLAN)
    assert record.result().largest_path_distance is None


def test_the_walked_distance_is_the_length_of_the_track():
    poses = [Pose2D(x, y, 0.0) for x, y in ((0.0, 0.0), (0.3, 0.4), (0.3, 1.4), (0.3, 0.4))]
    assert walked(*poses).result().walked_distance == pytest.approx(2.5)


def test_times_are_simulated_and_their_ratio_to_the_wall_clock_is_told():
    record = walked(Pose2D(0.0, 0.0, 0.0), Pose2D(0.1, 0.0, 0.0), Pose2D(0.2, 0.0, 0.0))
    record.wall_time = 0.25
    result = record.result()
    assert result.walking_time == pytest.approx(2.0)
    assert result.real_time_factor == pytest.approx(8.0)


@pytest.mark.parametrize(
    ('said', 'fallen', 'arrived'),
    [(True, False, True), (True, True, False), (False, False, False)],
)
def test_a_robot_has_arrived_if_it_says_so_and_has_not_fallen(said, fallen, arrived):
    record = walked(Pose2D(2.0, 1.0, math.pi / 2))
    record.has_arrived, record.has_fallen = said, fallen
    assert record.result().arrived is arrived


def test_the_figures_are_one_json_object():
    record = walked(Pose2D(0.0, 0.0, 0.0), Pose2D(2.0, 1.0, math.pi / 2))
    record.least_margin = 0.04
    result = record.result()
    told = json.loads(json.dumps(result.as_dict(), allow_nan=False))
    assert set(told) == {field.name for field in fields(WalkResult)}
    assert told['least_stability_margin'] == 0.04
    assert told['path_length'] == pytest.approx(3.0)
    json.dumps(WalkRecord(GOAL).result().as_dict(), allow_nan=False)


@pytest.mark.parametrize('times', [(5.0, 4.9), (1.0, 60.0, 0.0, 70.0)])
def test_a_walk_on_which_the_clock_went_back_has_no_time(times):
    record = WalkRecord(Pose2D(1.0, 0.0, 0.0), wall_time=10.0)
    for time in times:
        record.note_pose(time, Pose2D(0.0, 0.0, 0.0))
    result = record.result()
    assert (result.walking_time, result.real_time_factor) == (None, None)
