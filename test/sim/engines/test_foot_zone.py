"""A calf stands on the ground as its foot does where its foot is, and nowhere else."""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import make_simulator

ROBOT = load_robot('cuhk')


def contacts_when_lowered(engine, depth):
    """Return the contacts of a robot in its initial posture that is this far in the ground [m]."""
    simulator = make_simulator(engine, ROBOT, None)
    try:
        joints = ROBOT.initial_joint_angles.reshape(-1)
        height = ROBOT.standing_height - depth
        simulator.place(np.array([0.0, 0.0, height]), np.array([0.0, 0.0, 0.0, 1.0]), joints)
        simulator.step(joints, np.zeros(12))
        return {str(contact) for contact in simulator.observe().contacts}
    finally:
        simulator.close()


@pytest.mark.parametrize(('engine', 'package'), [('bullet', 'pybullet'), ('mujoco', 'mujoco')])
def test_the_end_of_a_calf_in_its_foot_is_no_contact_of_its_own(engine, package):
    pytest.importorskip(package)
    pressed = 0.75 * ROBOT.foot_radius
    assert contacts_when_lowered(engine, pressed) == set()
    # Deeper in, what lies above the feet touches the ground as well.
    beyond = contacts_when_lowered(engine, 5.0 * ROBOT.foot_radius)
    assert {contact.partition('_')[0] for contact in beyond} == {'lf', 'rf', 'lh', 'rh'}
