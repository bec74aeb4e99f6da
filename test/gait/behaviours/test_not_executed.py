"""A robot whose trajectories nobody executes says so, and goes on when somebody does again."""

import numpy as np
import pytest

from quad_common.plan import Plan
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, turning_gait_for
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.disturbed_walk import UNDISTURBED, Disturbance, DisturbedWalk

ROBOT = load_robot('titan_viii')
DEAF = Disturbance(0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
AHEAD = Plan.through([[0.0, 0.0], [1.0, 0.0]], 0.0)


@pytest.fixture(params=['crawl', 'trot'])
def walk(request):
    gait = load_gait(request.param, ROBOT)
    controller = Supervisor(ROBOT, gait, turning_gait_for(gait, ROBOT), SupervisorOptions())
    walk = DisturbedWalk(
        ROBOT, controller, UNDISTURBED, np.random.default_rng(1), backend='kinematic'
    )
    walk.run(0.5)
    controller.set_plan(AHEAD)
    yield walk
    walk.close()


def walks(walk):
    return walk.controller.activity is Activity.WALKING


def test_a_robot_that_is_executed_from_the_beginning_never_says_that_it_is_not(walk):
    said = set()
    walk.run(
        60.0, lambda: said.add(walk.controller.activity) or walk.controller.activity.is_terminal
    )
    assert walk.controller.activity is Activity.ARRIVED
    assert Activity.NOT_EXECUTED not in said


def test_a_controller_that_ends_in_mid_walk_is_named_and_the_walk_goes_on_with_the_next_one(walk):
    assert walk.run(10.0, lambda: walks(walk))
    walk.run(1.3)
    walk._disturbance = DEAF
    controller = walk.controller
    assert walk.run(15.0, lambda: controller.activity is Activity.NOT_EXECUTED)
    assert 'is the controller that executes' in controller.reason
    # It stays so for as long as nobody does, and blames no joint.
    walk.run(20.0)
    assert controller.activity is Activity.NOT_EXECUTED, controller.reason
    walk._disturbance = UNDISTURBED
    assert walk.run(90.0, lambda: controller.activity is Activity.ARRIVED), controller.reason


def test_a_robot_that_wants_nothing_forgets_that_it_was_not_heard(walk):
    walk._disturbance = DEAF
    controller = walk.controller
    assert walk.run(15.0, lambda: controller.activity is Activity.NOT_EXECUTED)
    controller.stop()
    assert walk.run(15.0, lambda: controller.activity is Activity.STANDING), controller.reason


class FrozenEncoders(ClosedLoop):
    """A robot whose joints obey, and are measured where they were when its encoders froze."""

    frozen = None

    def _readings(self, seen):
        readings = super()._readings(seen)
        if self.frozen is None:
            return readings
        return readings._replace(positions=self.frozen, velocities=np.zeros(12))


@pytest.mark.parametrize('moment', [1.3, 2.0, 2.7])
def test_joints_that_are_measured_where_they_were_are_not_led_there_again_and_again(moment):
    gait = load_gait('crawl', ROBOT)
    controller = Supervisor(ROBOT, gait, turning_gait_for(gait, ROBOT), SupervisorOptions())
    walk = FrozenEncoders(ROBOT, controller, 'kinematic')
    walk.run(0.5)
    controller.set_plan(AHEAD)
    assert walk.run(10.0, lambda: walks(walk))
    walk.run(moment)
    walk.frozen = walk.simulation.observe().joint_positions.copy()
    assert walk.run(15.0, lambda: controller.activity is Activity.NOT_EXECUTED)
    said = set()
    walk.run(20.0, lambda: said.add(controller.activity))
    # One that is to turn while all others rest may be blamed: then the robot stays as it is, too.
    assert said <= {Activity.NOT_EXECUTED, Activity.LAME}
    if Activity.LAME not in said:
        walk.frozen = None
        assert walk.run(90.0, lambda: controller.activity is Activity.ARRIVED), controller.reason
