"""Scenes in which every guard and every behaviour acts, on a robot in a simulator."""

from contextlib import contextmanager
from dataclasses import replace

import numpy as np
from told_supervisor import ToldSupervisor

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import Done
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.faults.joint_fault import JointFault
from quad_gait.state.measurement import ImuMotion, Measurement
from quad_gait.transitions import GUARDS, ROUTINE
from quad_gait.uneven.uneven_options import UnevenOptions
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.simulation import Simulation

ROBOT = load_robot('titan_viii')
ORIGIN = Pose2D(0.0, 0.0, 0.0)
FLAT = SupervisorOptions(watches_joints=False)
UNEVEN = replace(FLAT, uneven=UnevenOptions())
BALANCED = replace(FLAT, balance=BalanceOptions())
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
AT_REST = ImuMotion(np.zeros(3), np.array([0.0, 0.0, 9.80665]))
CORNER = Plan.through([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]], 1.5)
FAULT = JointFault(4, ROBOT.joint_names[4], 'free', 0.0, 0.1, None, 0.0, is_slack=True)


class Traced:
    """A robot in a simulator whose every transition is compared with the table."""

    def __init__(self, options=FLAT, gait='crawl'):
        walking = load_gait(gait, ROBOT)
        self.supervisor = ToldSupervisor(ROBOT, walking, turning_gait_for(walking, ROBOT), options)
        self.simulation = Simulation(KinematicSimulator(ROBOT, 0.02), ROBOT, ORIGIN)
        self.change = {}
        self.is_deaf = False
        self.acting = []
        self.acted = set()
        self.said = set()
        routine = self.supervisor._routine
        for row in ROUTINE:
            behaviour = routine._behaviours.get(row.takes)
            if type(behaviour) is row.behaviour:
                self._trace(behaviour, row, ('begin', 'update'))
        for guard, row in zip(self.supervisor._guards, GUARDS):
            self._trace(guard, row, ('update', 'take'))
        report = self.supervisor._report
        say = report.say

        def checked_say(activity, reason):
            if self.acting:
                row = self.acting[-1]
                assert activity in row.says, (row, activity)
                self.said.add(activity)
            say(activity, reason)

        report.say = checked_say

    def _trace(self, actor, row, names):
        for name in names:
            method = getattr(actor, name)

            def traced(*args, method=method):
                with self._as(row):
                    outcome = method(*args)
                if isinstance(outcome, Done) and outcome.next is not None:
                    assert outcome.next in row.hands_over_to, (row, outcome)
                if not isinstance(outcome, Done):
                    self.acted.add(row)
                return outcome

            setattr(actor, name, traced)

    @contextmanager
    def _as(self, row):
        self.acting.append(row)
        try:
            yield
        finally:
            self.acting.pop()

    def run(self, seconds, until=None):
        for _ in range(round(seconds / 0.02)):
            seen = self.simulation.observe()
            now = Measurement(
                seen.time, seen.pose, 0.0, seen.joint_positions, seen.joint_velocities
            )
            trajectory = self.supervisor.update(replace(now, **self.change))
            if trajectory is not None and not self.is_deaf:
                self.simulation.accept(trajectory)
            self.simulation.step()
            if until is not None and self.supervisor.activity is until:
                return
        assert until is None, f'{self.supervisor.activity}: {self.supervisor.reason}'


def arrive(walk):
    walk.supervisor.set_plan(CORNER)
    walk.run(60.0, Activity.TURNING)
    walk.run(60.0, Activity.ARRIVED)


def sit_and_stand(walk):
    walk.supervisor.sit()
    walk.run(10.0, Activity.SITTING)
    walk.supervisor.stand()
    walk.run(10.0, Activity.STANDING_UP)
    walk.run(10.0, Activity.STANDING)


def freeze(walk):
    walk.supervisor.set_twist(Twist2D(0.02))
    walk.run(2.0, Activity.WALKING)
    walk.supervisor.freeze()
    walk.run(1.0, Activity.EMERGENCY_STOP)
    walk.supervisor.release()
    walk.run(1.0, Activity.STOPPED)
    walk.supervisor.stand()
    walk.run(10.0, Activity.STANDING)


def fall(walk):
    walk.change = {'tilt': 1.0}
    walk.run(1.0, Activity.FALLEN)
    walk.change = {}
    walk.run(1.0)
    assert walk.supervisor.activity is Activity.FALLEN
    walk.supervisor.stand()
    walk.run(10.0, Activity.STANDING)


def go_lame(walk):
    # Found once; what follows is the guard's.
    watch = walk.supervisor._joints.watch

    def find(state):
        watch(state)
        walk.supervisor._joints.fault = FAULT
        walk.supervisor._joints.watch = watch

    walk.supervisor._joints.watch = find
    walk.run(1.0, Activity.LAME)
    walk.run(6.0)
    assert walk.supervisor.activity is Activity.LAME
    walk.supervisor.stand()
    walk.run(6.0, Activity.STANDING_UP)


def fall_silent(walk):
    walk.change = {'problem': 'no joint states for 1.0 s'}
    walk.run(1.0, Activity.WAITING)
    walk.change = {}
    walk.run(1.0, Activity.STANDING)


def be_unexecuted(walk):
    walk.is_deaf = True
    for _ in range(20):
        walk.supervisor.set_twist(Twist2D(0.05))
        walk.run(0.5)
    assert walk.supervisor.activity is Activity.NOT_EXECUTED
    walk.supervisor.stop()
    walk.run(15.0, Activity.STANDING)


def be_blocked(walk):
    walk.change = {'pose': ORIGIN}
    walk.supervisor.set_plan(Plan.through([[0.0, 0.0], [2.0, 0.0]], 0.0))
    walk.run(60.0, Activity.BLOCKED)


def lose_the_plan(walk):
    walk.supervisor.set_plan(CORNER)
    walk.change = {'pose': Pose2D(5.0, 5.0, 0.0)}
    walk.run(5.0, Activity.STOPPED)


SCENES = {
    arrive: FLAT,
    sit_and_stand: FLAT,
    freeze: FLAT,
    fall: FLAT,
    go_lame: FLAT,
    fall_silent: FLAT,
    be_unexecuted: replace(FLAT, watches_joints=True),
    be_blocked: FLAT,
    lose_the_plan: FLAT,
}


def walk_uneven(walk):
    walk.supervisor.set_twist(Twist2D(0.02))
    walk.run(5.0, Activity.WALKING)
    walk.run(40.0, Activity.STANDING)


SCENES[walk_uneven] = UNEVEN


def keep_the_balance(walk):
    walk.change = {'imu': AT_REST, 'orientation': LEVEL}
    trot = load_gait('trot', ROBOT)
    walk.supervisor.set_gaits(trot, trot, FLAT.follower)
    walk.run(0.2)
    walk.supervisor.set_twist(Twist2D(0.1))
    walk.run(1.0, Activity.BALANCING)
    walk.run(1.0)
    walk.supervisor.set_twist(Twist2D())
    walk.run(10.0, Activity.STANDING)


SCENES[keep_the_balance] = BALANCED


def play(scene):
    """Play a scene on a robot of its own; return it."""
    walk = Traced(SCENES[scene])
    walk.run(0.5)
    scene(walk)
    return walk
