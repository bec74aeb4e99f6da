"""
A robot with its controller and its noisy sensors, as a case wants them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import Gait, load_gait, turning_gait_for
from quad_gait.following.slip_compensation import compensation_for
from quad_gait.supervisor import Supervisor
from quad_lab.seeded_walks.gait_changes import changed_gait
from quad_lab.seeded_walks.noisy_loop import NoisyLoop, SensorNoise
from quad_lab.seeded_walks.payload import loaded
from quad_lab.seeded_walks.scene import noise_generator
from quad_lab.seeded_walks.walk_settings import Walk
from quad_sim.world.world import World


@dataclass(frozen=True)
class ReadyRobot:
    """A robot, and what moves it."""

    robot: Robot
    """Robot as its data file has it."""
    derived: Gait
    """Gait with none of its numbers changed."""
    controller: Supervisor
    """Controller that is put together as gait_node does it."""
    least_margin: float
    """Static stability margin that its cycles keep [m]."""

    @classmethod
    def of_walk(cls, walk: Walk) -> ReadyRobot:
        """Load robot and gait, and change the gait; raise QuadError if it cannot be."""
        parameters = walk.gait_node
        robot = load_robot(walk.settings.robot)
        derived, turning = parameters.gaits(robot)
        gait = changed_gait(load_gait(parameters.gait, robot), walk.gait_numbers)
        if turning.name == derived.name:
            turning = turning_gait_for(gait, robot, parameters.turning_gait)
        options = parameters.supervisor_options
        if walk.settings.task == 'steer':
            options = replace(options, twist_timeout=math.inf)
        compensation = compensation_for(parameters.robot, parameters.calibration)
        controller = Supervisor(robot, gait, turning, options, compensation)
        return cls(robot, derived, controller, options.least_margin)

    def stand(self, walk: Walk, world: World, start: Pose2D, seed: int) -> NoisyLoop:
        """Put the robot, with what it carries, into a world."""
        settings = walk.settings
        noise = SensorNoise(settings.position_noise, settings.heading_noise, settings.joint_noise)
        return NoisyLoop(
            loaded(self.robot, settings.payload),
            self.controller,
            noise,
            noise_generator(seed),
            backend=settings.engine,
            world=world,
            start=start,
        )
