"""A supervisor for tests that make measurements by hand."""

from dataclasses import replace

import numpy as np

from quad_common.planar_pose import Pose2D
from quad_gait.behaviours.activity import Report
from quad_gait.behaviours.behaviour import Shared
from quad_gait.behaviours.guidance import Guidance
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.behaviours.wishes import ChangeGaits
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.faults.commanded_joints import CommandedJoints
from quad_gait.following.motion_sequence import MotionSequence
from quad_gait.following.slip_compensation import NO_SLIP
from quad_gait.state.measurement import Measurement
from quad_gait.state.state_estimator import EstimatorOptions, StateEstimator
from quad_gait.supervisor import Supervisor


class ToldSupervisor(Supervisor):
    """Makes a state of each measurement that it is told."""

    def __init__(self, robot, *args, rest_speed=0.1):
        super().__init__(robot, *args)
        self.estimator = StateEstimator(robot, EstimatorOptions(rest_speed=rest_speed))

    def update(self, state):
        """Judge the measurement first."""
        return super().update(self.estimator.judge(state))


def shared_for(robot, gait='crawl', **options):
    """Return what behaviours of a robot share."""
    options = SupervisorOptions(**options)
    report, joints = Report(), CommandedJoints(robot, options.watches_joints)
    walking = load_gait(gait, robot)
    gaits = ChangeGaits(walking, turning_gait_for(walking, robot), options.follower)
    guidance = Guidance(robot, gaits, options, report, joints)
    return Shared(robot, options, NO_SLIP, report, joints, guidance, MotionSequence())


def measurement(robot, time, **changes):
    """What is measured of a robot that stands in its initial posture."""
    posture = robot.initial_joint_angles.reshape(-1).copy()
    return replace(Measurement(time, Pose2D(0.0, 0.0, 0.0), 0.0, posture, np.zeros(12)), **changes)
