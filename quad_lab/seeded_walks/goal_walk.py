"""
A walk to a goal on a map, with the planner beside the gait, as figures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from quad_common.plan import Plan
from quad_common.planar_pose import distance_to_polyline
from quad_gait.behaviours.activity import Activity
from quad_lab.closed_loop.closed_loop import ClosedLoop, Place
from quad_lab.closed_loop.guided_end import GuidedEnd
from quad_lab.closed_loop.planner_in_loop import PlannerInLoop
from quad_lab.seeded_walks.noisy_loop import NoisyLoop
from quad_lab.seeded_walks.ready_robot import ReadyRobot
from quad_lab.seeded_walks.scene import Scene, draw_scene
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_settings import Walk
from quad_sim.engines.simulator import Observation

_GRAVITY = 9.80665

_SETTLING = 0.5
"""Time for the robot to come to rest before it receives its goal [s]."""


def walk_to_goal(
    walk: Walk, seed: int, watch: Callable[[ClosedLoop], None] = lambda loop: None
) -> WalkFigures:
    """
    Draw a scene, and walk to its goal.

    Parameters
    ----------
    walk : Walk
        What to walk.
    seed : int
        Of the scene and the noise.
    watch : callable
        Called with the loop before the robot walks.

    Returns
    -------
    WalkFigures
        How it went.
    """
    ready = ReadyRobot.of_walk(walk)
    scene = draw_scene(walk, ready.robot, seed)
    loop = ready.stand(walk, scene.world, scene.start, seed)
    try:
        watch(loop)
        return _guided(walk, ready, scene, loop)
    finally:
        loop.close()


def _guided(walk: Walk, ready: ReadyRobot, scene: Scene, loop: NoisyLoop) -> WalkFigures:
    controller, contacts = ready.controller, set[str]()
    planner = PlannerInLoop(ready.robot, controller, walk.planner_node)
    planner.session.take_grid(scene.grid, planner.frame.name)
    terrain = scene.world.terrain
    if terrain is not None:
        planner.session.take_heights(terrain.height_map, planner.frame.name)
        controller.set_height_map(terrain.height_map)

    def note(seen: Observation) -> None:
        contacts.update(str(contact) for contact in seen.contacts)

    def locate(seen: Observation) -> Place:
        place = loop.noisy_place(seen)
        planner.take_pose(seen.time, place[0])
        return place

    loop.on_observation.append(note)
    loop.locate = locate
    loop.run(_SETTLING)
    planner.session.give_goal(planner.frame.name, scene.goal)
    first = controller.wanted_plan
    end = GuidedEnd()
    ended = loop.run(walk.settings.timeout, lambda: end.is_over(loop.time, controller.activity))
    arrived = controller.activity is Activity.ARRIVED
    problem = '' if arrived else planner.problem or controller.reason
    if not ended:
        problem = f'the walk was not over after {walk.settings.timeout:g} s: {problem}'
    true = loop.simulation.observe().pose
    return replace(
        _measured(loop, first, ready.robot.mass + walk.settings.payload),
        arrived=arrived,
        has_fallen=loop.record.has_fallen or controller.activity is Activity.FALLEN,
        contacts='; '.join(sorted(contacts)),
        problem=problem,
        plans=float(planner.plans),
        position_error=true.distance_to(scene.goal),
        heading_error=abs((true.inverse() @ scene.goal).yaw),
        start_x=scene.start.x, start_y=scene.start.y, start_yaw=scene.start.yaw,
        goal_x=scene.goal.x, goal_y=scene.goal.y, goal_yaw=scene.goal.yaw,
    )  # fmt: skip


def _measured(loop: NoisyLoop, plan: Plan | None, mass: float) -> WalkFigures:
    """Work out the figures that follow from the record and the first plan."""
    record = loop.record
    walked = int(np.searchsorted(record.times, _SETTLING))
    duration = loop.time - _SETTLING
    tilts, power = record.tilts[walked:], record.power[walked:]
    figures = WalkFigures(
        duration=duration,
        tilt_rms=float(np.sqrt(np.mean(np.square(tilts)))),
        largest_tilt=float(np.max(tilts)),
        least_margin=float(np.min(record.margins[walked:])),
        torque_rms=float(np.sqrt(np.mean(np.square(record.torques[walked:])))),
    )
    if plan is None:
        return figures
    corners = plan.corners
    return replace(
        figures,
        length=plan.length,
        off_plan=max(
            distance_to_polyline((pose.x, pose.y), corners) for pose in record.poses[walked:]
        ),
        speed=plan.length / duration,
        transport_cost=float(np.mean(power)) * duration / (mass * _GRAVITY * plan.length),
    )
