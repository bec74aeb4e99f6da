"""Cycles one after the other are one motion, and it always ends at rest."""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.planar_pose import STILL, Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import CycleEnds
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.following.motion_sequence import MotionSequence, ScheduledCycle

ROBOT = load_robot('cuhk')
WAVE = load_gait('wave', ROBOT)
PERIOD = WAVE.cycle_period
MOTION = BodyMotion(0.05, 0.01, 0.1)
SPEED, HALF = MOTION.rate(PERIOD), MOTION.scaled(0.5)
BEGIN = generate_cycle(ROBOT, WAVE, HALF, CycleEnds(exit=SPEED))
GO_ON = generate_cycle(ROBOT, WAVE, MOTION, CycleEnds(BEGIN.end_feet, entry=SPEED, exit=SPEED))
STOP = generate_cycle(ROBOT, WAVE, HALF, CycleEnds(BEGIN.end_feet, entry=SPEED))
GO_ON_AGAIN = generate_cycle(
    ROBOT, WAVE, MOTION, CycleEnds(GO_ON.end_feet, entry=SPEED, exit=SPEED)
)
STOP_LATER = generate_cycle(ROBOT, WAVE, HALF, CycleEnds(GO_ON.end_feet, entry=SPEED))
WHERE = Pose2D(1.0, 2.0, 0.5)


def scheduled(*cycles, start=10.0, pose=WHERE):
    """Put cycles one after the other."""
    placed = []
    for cycle in cycles:
        placed.append(ScheduledCycle(cycle, start, pose))
        start, pose = placed[-1].end, placed[-1].end_pose
    return placed


def sequence_of(*cycles):
    sequence = MotionSequence()
    sequence.replace(*scheduled(*cycles))
    return sequence


def test_without_cycles_there_is_nothing():
    sequence = MotionSequence()
    assert not sequence
    assert sequence.end == -math.inf
    assert (sequence.last, sequence.final, sequence.at(0.0)) == (None, None, None)
    assert sequence.in_contact_at(3.0).all()


def test_a_cycle_runs_from_its_start_to_before_its_end():
    sequence = sequence_of(BEGIN, STOP)
    first, second = scheduled(BEGIN, STOP)
    assert sequence
    assert sequence.end == 10.0 + 2.0 * PERIOD
    assert sequence.at(9.99) is None
    assert sequence.at(10.0) == sequence.at(10.0 + 0.99 * PERIOD) == first
    assert sequence.at(10.0 + PERIOD) == second
    assert sequence.at(sequence.end) is None


def test_poses_go_on_from_cycle_to_cycle():
    first, second = scheduled(BEGIN, STOP)
    before, after = first.pose_at(10.0 + PERIOD), second.pose_at(10.0 + PERIOD)
    assert (before.x, before.y, before.yaw) == pytest.approx((after.x, after.y, after.yaw))
    end = WHERE @ MOTION.end
    for pose in (second.end_pose, second.pose_at(second.end)):
        assert (pose.x, pose.y, pose.yaw) == pytest.approx((end.x, end.y, end.yaw))


def test_the_last_cycle_is_the_last_that_does_not_stop_and_the_final_one_stops():
    sequence = sequence_of(BEGIN, GO_ON, STOP_LATER)
    assert sequence.last.cycle is GO_ON
    assert sequence.final.cycle is STOP_LATER
    assert not sequence.final.cycle.exit
    alone = sequence_of(STOP)
    assert alone.last is alone.final is not None


def test_going_on_takes_the_place_of_the_stop():
    sequence = sequence_of(BEGIN, STOP)
    _, go_on, stop = scheduled(BEGIN, GO_ON, STOP_LATER)
    sequence.replace(go_on, stop)
    assert sequence.end == 10.0 + 3.0 * PERIOD
    assert [sequence.at(10.0 + (k + 0.5) * PERIOD).cycle for k in range(3)] == [
        BEGIN,
        GO_ON,
        STOP_LATER,
    ]


def test_of_the_past_one_cycle_is_kept():
    placed = scheduled(BEGIN, GO_ON, GO_ON, GO_ON, STOP_LATER)
    sequence = MotionSequence()
    sequence.replace(*placed[:2])
    for k in range(2, 5):
        sequence.replace(placed[k])
    assert sequence.at(placed[3].start) is placed[3]
    assert sequence.at(placed[0].start) is None
    assert sequence.end == placed[4].end


def test_cleared_it_is_empty():
    sequence = sequence_of(BEGIN, STOP)
    sequence.clear()
    assert not sequence
    assert sequence.final is None


def test_contacts_are_those_of_the_cycle_and_between_cycles_all_feet_are_down():
    sequence = sequence_of(BEGIN, STOP)
    seen = set()
    for time in np.linspace(10.0, 10.0 + 2.0 * PERIOD, 101)[:-1]:
        placed = sequence.at(time)
        contact = sequence.in_contact_at(time)
        sample = placed.cycle.sample(time - placed.start)
        assert (contact == placed.cycle.in_contact[sample]).all()
        seen.add(int(contact.sum()))
    assert seen == {3, 4}
    assert sequence.in_contact_at(9.0).all()
    assert sequence.in_contact_at(99.0).all()


@pytest.mark.parametrize(
    'cycles', [(BEGIN, STOP), (BEGIN, GO_ON, STOP_LATER), (BEGIN, GO_ON, GO_ON_AGAIN, STOP_LATER)]
)
def test_joined_trajectories_have_no_point_twice_and_no_jump(cycles):
    trajectory = sequence_of(*cycles).trajectory(ROBOT, since=0.0)
    steps = np.diff(trajectory.times)
    assert steps == pytest.approx(np.full(len(steps), BEGIN.times[1]))
    assert trajectory.stamp == 10.0
    assert trajectory.end == pytest.approx(10.0 + len(cycles) * PERIOD)
    fastest = np.abs(trajectory.velocities).max()
    jumps = np.abs(np.diff(trajectory.positions, axis=0)).max()
    assert jumps < 1.1 * fastest * steps[0]
    for place, cycle in enumerate(cycles):
        first = round(place * PERIOD / steps[0])
        assert trajectory.positions[first] == pytest.approx(
            cycle.joint_positions[0].reshape(-1), abs=1e-9
        )


@pytest.mark.parametrize('cycles', [(BEGIN, STOP), (BEGIN, GO_ON, STOP_LATER)])
def test_a_trajectory_always_ends_at_rest_in_the_initial_posture(cycles):
    sequence = sequence_of(*cycles)
    for since in (0.0, 10.0, 10.0 + PERIOD / 2.0, 10.0 + PERIOD, sequence.end - 0.1):
        trajectory = sequence.trajectory(ROBOT, since)
        assert trajectory.velocities[-1] == pytest.approx(np.zeros(12), abs=1e-9)
        assert trajectory.positions[-1] == pytest.approx(
            ROBOT.initial_joint_angles.reshape(-1), abs=1e-9
        )
        assert trajectory.end == pytest.approx(sequence.end)


def test_points_long_before_a_time_are_left_out():
    sequence = sequence_of(BEGIN, GO_ON, STOP_LATER)
    whole = sequence.trajectory(ROBOT, 0.0)
    times = whole.stamp + whole.times
    step = times[1] - times[0]
    for since in (10.0, 11.03, 10.0 + PERIOD, 10.0 + 1.7 * PERIOD, sequence.end - 0.001):
        part = sequence.trajectory(ROBOT, since)
        begin = part.stamp + part.times[0]
        assert since - step - 1e-9 <= begin <= since + 1e-9
        kept = times >= begin - 1e-9
        assert part.stamp + part.times == pytest.approx(times[kept])
        assert part.positions == pytest.approx(whole.positions[kept])
        assert part.velocities == pytest.approx(whole.velocities[kept])


def test_gaits_may_change_where_the_robot_rests():
    turn = load_gait('turn', ROBOT)
    turning = generate_cycle(ROBOT, turn, BodyMotion(turn=0.3))
    trajectory = sequence_of(BEGIN, STOP, turning).trajectory(ROBOT, 0.0)
    assert trajectory.end == pytest.approx(10.0 + 2.0 * PERIOD + turn.cycle_period)
    assert all(after > before for before, after in pairwise(trajectory.times))
    assert not turning.entry
    assert turning.exit == STILL
