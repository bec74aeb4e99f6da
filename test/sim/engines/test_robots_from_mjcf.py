"""A robot that is read from MJCF stands and walks in either engine as one that ships does."""

import numpy as np
import pytest

pytest.importorskip('mujoco')
pytest.importorskip('yourdfpy')

from mjcf_robots import STYLES

from quad_common.importing.options import ImportOptions
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import measuring_controller
from quad_sim.engines.registry import make_simulator
from quad_sim.engines.simulator import GRAVITY

ENGINES = ('bullet', 'mujoco')

START = Pose2D(1.0, 2.0, 0.5)


@pytest.fixture(params=STYLES)
def robot(tmp_path, request):
    imported = import_robot(STYLES[request.param](tmp_path), ImportOptions(speed=(20.0,)))
    data_file, _ = write_robot(imported, tmp_path / 'imported.yaml')
    return load_robot(data_file)


@pytest.fixture(params=ENGINES)
def engine(request):
    if request.param == 'bullet':
        pytest.importorskip('pybullet')
    return request.param


@pytest.mark.sweep(kept=2)
def test_it_stands_level_on_four_feet_that_bear_its_weight(robot, engine):
    simulator = make_simulator(engine, robot, None)
    try:
        simulator.reset(START)
        posture = robot.initial_joint_angles.reshape(-1)
        for _ in range(round(2.0 / simulator.time_step)):
            simulator.step(posture, np.zeros(12))
        seen = simulator.observe()
        assert not seen.has_fallen
        assert not seen.contacts
        assert seen.position[2] == pytest.approx(robot.standing_height, abs=0.001)
        np.testing.assert_allclose(seen.position[:2], [START.x, START.y], atol=0.003)
        assert abs(seen.pose.yaw - START.yaw) < 0.005
        np.testing.assert_allclose(seen.joint_positions, posture, atol=0.01)
        forces = simulator.foot_forces()
        assert forces.sum() == pytest.approx(robot.mass * GRAVITY, rel=0.01)
        assert np.all(forces > 0.1 * robot.mass * GRAVITY)
    finally:
        simulator.close()


# Each in one of the engines: which of them walks it is no matter of how it was written.
@pytest.mark.slow
@pytest.mark.parametrize(
    ('robot', 'engine'), list(zip(STYLES, ENGINES * len(STYLES))), indirect=True
)
@pytest.mark.sweep(kept=1)
def test_it_crawls_forward_as_far_as_it_is_asked_to(robot, engine):
    gait = load_gait('crawl', robot)
    controller = measuring_controller(robot, gait, least_margin=0.005)
    walk = ClosedLoop(robot, controller, engine)
    try:
        walk.run(0.1)
        pair = controller.gait_pair.of_twist(BodyMotion(1.0, 0.0, 0.0).rate(1.0))
        asked = BodyMotion(0.5 * pair.largest_scale(BodyMotion(1.0, 0.0, 0.0)), 0.0, 0.0)
        controller.set_twist(asked.rate(pair.period))
        walk.run(0.5)
        ends = [walk.next_cycle_end() for _ in range(4)]
        assert not walk.record.has_fallen
        assert not walk.simulation.contacts_seen
        step = ends[-2].inverse() @ ends[-1]
        assert step.x == pytest.approx(asked.forward, rel=0.05)
        assert abs(step.y) < 0.1 * asked.forward
    finally:
        walk.close()
