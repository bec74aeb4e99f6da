"""A walk that cannot succeed ends at once, and says what the robot says."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy')

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_gait.behaviours.activity import Activity
from quad_lab.topic_walk import walk
from quad_lab.topic_walk.walk import _problem
from quad_lab.topic_walk.walk_record import WalkRecord

GOAL = Pose2D(2.0, 0.0, 0.0)


def seen(activity: Activity, sentence: str) -> SimpleNamespace:
    """Stand in for an observer that has heard of a plan and of this activity."""
    record = WalkRecord(GOAL)
    record.plans.append(Plan.through([[0.0, 0.0], [2.0, 0.0]], 0.0))
    statuses = {'gait_node': (b'', sentence, {'activity': activity.value})}
    return SimpleNamespace(record=record, statuses=statuses, activity=activity)


@pytest.mark.parametrize('activity', [Activity.LAME, Activity.FALLEN])
def test_a_robot_that_no_plan_moves_ends_the_walk_with_its_reason(activity: Activity) -> None:
    assert _problem(seen(activity, 'lame: a knee'), 1.0, 0.0, 1.0) == 'lame: a knee'


@pytest.mark.parametrize('activity', [Activity.WALKING, Activity.BLOCKED, Activity.STOPPED])
def test_a_robot_that_a_new_plan_may_move_is_waited_for(activity: Activity) -> None:
    assert _problem(seen(activity, 'blocked'), 1.0, 0.0, 1.0) == ''


class LameAfterAWhile:
    """An observer of a robot whose knee fails on its way."""

    def __init__(self) -> None:
        self.record = WalkRecord(GOAL)
        self.record.plans.append(Plan.through([[0.0, 0.0], [2.0, 0.0]], 0.0))
        self.time = 0.0

    @property
    def activity(self) -> Activity:
        return Activity.WALKING if self.time < 5.0 else Activity.LAME

    @property
    def statuses(self) -> dict[str, tuple[bytes, str, dict[str, str]]]:
        return {'gait_node': (b'', f'{self.activity.value}: a knee', {})}

    def planner_is_ready(self) -> bool:
        return True

    def give_goal(self) -> None:
        pass

    def listen(self, duration: float) -> None:
        self.time += 1.0

    def note_poses(self) -> None:
        pass


def test_a_robot_that_falls_lame_ends_the_walk_at_once():
    observer = LameAfterAWhile()
    nodes = SimpleNamespace(check=lambda: None)
    record = walk._watch(observer, nodes, observer.listen, lambda observer: None)
    assert (record.problem, record.has_arrived, observer.time) == ('lame: a knee', False, 5.0)


class TooWeak(LameAfterAWhile):
    """An observer of a robot that falls before it walks, and may be set upright again."""

    def __init__(self, lies_for: float) -> None:
        super().__init__()
        self._lies_for = lies_for

    @property
    def activity(self) -> Activity:
        return Activity.STANDING if self.time > 2.0 + self._lies_for else Activity.FALLEN

    @property
    def statuses(self) -> dict[str, tuple[bytes, str, dict[str, str]]]:
        lies = 2.0 <= self.time <= 2.0 + self._lies_for
        said = {'sim_node': (b'', 'fallen', {'has_fallen': str(lies)})}
        return {**said, 'gait_node': (b'', 'the knees give way', {})}

    def has_found_gait(self) -> bool:
        return True


def test_a_robot_that_falls_before_it_walks_is_not_waited_for():
    observer, nodes = TooWeak(lies_for=1000.0), SimpleNamespace(check=lambda: None)
    with pytest.raises(walk.DoesNotStand) as caught:
        walk._wait_until_ready(observer, nodes, observer.listen, 'jelly.yaml')
    assert str(caught.value) == (
        'the robot falls as it is to stand (the knees give way); whether its motors are strong '
        'enough says quadwalk robot check jelly.yaml'
    )
    assert observer.time < 10.0


def test_a_robot_that_stands_up_again_is():
    observer, nodes = TooWeak(lies_for=3.0), SimpleNamespace(check=lambda: None)
    walk._wait_until_ready(observer, nodes, observer.listen, 'titan_viii')
    assert observer.time > 5.0
