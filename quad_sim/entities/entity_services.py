"""
The services that simulators have in common, where simulation_interfaces is installed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from geometry_msgs.msg import PoseStamped, Vector3
from rclpy.parameter import Parameter

from quad_common.errors import FilterUnsupported, QuadError, RobotNotFound
from quad_common.errors.quoting import clipped, quoted
from quad_common.frames.frame_names import check_frame
from quad_common.named_robots.known_robots import known_names
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots
from quad_common.ros.pose_conversions import pose_from_message, time_from_seconds
from quad_common.ros.ros_node import QuadNode
from quad_common.rotations import matrix_from_quaternion
from quad_sim.engines.simulator import Observation
from quad_sim.entities.entity_codes import ALREADY_IN_TARGET_STATE, Feature, ResultCode, code_of
from quad_sim.entities.spawn_request import FORMATS, SpawnRequest, names_like

try:
    from simulation_interfaces.msg import EntityState, Result, SimulationState, Spawnable
    from simulation_interfaces.srv import (
        DeleteEntity,
        GetEntities,
        GetEntityState,
        GetSimulationState,
        GetSimulatorFeatures,
        GetSpawnables,
        SetSimulationState,
        SpawnEntity,
    )
except ImportError:
    SpawnEntity = None

_WORLD = ('', 'world')
"""What the world's own frame is called, besides the map's."""


class EntityWorld(Protocol):
    """The simulation in which robots come and go."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def is_paused(self) -> bool:
        """Whether simulated time stands still."""

    @property
    def can_spawn(self) -> bool:
        """Whether robots may come and go."""

    @property
    def frames_on_map(self) -> tuple[str, ...]:
        """Frames that coincide with the world, the map's first."""

    @property
    def robots_text(self) -> str:
        """Robots that there are, as the parameter ``robots`` has them."""

    def observations(self) -> Mapping[str, Observation]:
        """Return the state of each robot by its name."""

    def spawn_robot(self, name: str, kind: str, start: Pose2D) -> None:
        """Put a robot into the world."""

    def remove_robot(self, name: str) -> None:
        """Take a robot out of the world."""

    def pause(self) -> None:
        """Let simulated time stand still."""

    def unpause(self) -> None:
        """Go on."""


class EntityServices:
    """
    Serves what simulation_interfaces asks of simulators; without the package there is nothing.

    Parameters
    ----------
    node : QuadNode
        The node; its parameter ``robots`` follows what is spawned and deleted.
    world : EntityWorld
        What is simulated.
    """

    def __init__(self, node: QuadNode[Any], world: EntityWorld) -> None:
        self._node, self._world = node, world
        if SpawnEntity is None:
            node.get_logger().info(
                'simulation_interfaces is not installed: robots are spawned by the parameter '
                "'robots' alone"
            )
            return
        node.create_service(GetSimulatorFeatures, 'get_simulator_features', self._on_features)
        node.create_service(GetSpawnables, 'get_spawnables', self._on_spawnables)
        node.create_service(SpawnEntity, 'spawn_entity', self._on_spawn)
        node.create_service(DeleteEntity, 'delete_entity', self._on_delete)
        node.create_service(GetEntities, 'get_entities', self._on_entities)
        node.create_service(GetEntityState, 'get_entity_state', self._on_entity_state)
        node.create_service(GetSimulationState, 'get_simulation_state', self._on_state)
        node.create_service(SetSimulationState, 'set_simulation_state', self._on_set_state)

    def _on_features(self, _: Any, response: Any) -> Any:
        unsupported = () if self._world.can_spawn else (Feature.SPAWNING, Feature.DELETING)
        response.features.features = [int(f) for f in Feature if f not in unsupported]
        response.features.spawn_formats = list(FORMATS)
        response.features.custom_info = "quadwalk: a robot's name is its namespace"
        return response

    def _on_spawnables(self, request: Any, response: Any) -> Any:
        for names, source in (
            (available_robots(), 'comes with quadwalk'),
            (known_names(), 'description of an installed package'),
        ):
            response.spawnables += [Spawnable(uri=name, description=source) for name in names]
        response.result = _succeeded()
        if request.sources:
            unknown = ', '.join(quoted(source, 60) for source in request.sources[:5])
            response.result.error_message = f'these sources are not known: {unknown}'
        return response

    def _on_spawn(self, request: Any, response: Any) -> Any:
        # Versions from 2.0 have the resource in a message of its own.
        resource = getattr(request, 'entity_resource', request)
        wanted = SpawnRequest(
            resource.uri,
            request.name,
            request.entity_namespace,
            request.allow_renaming,
            resource.resource_string,
        )
        try:
            name = wanted.name_among(self._world.observations())
            self._world.spawn_robot(name, wanted.kind, self._pose(request.initial_pose))
        except QuadError as error:
            response.result = _failed(error)
            return response
        self._follow()
        response.result, response.entity_name = _succeeded(), name
        return response

    def _on_delete(self, request: Any, response: Any) -> Any:
        try:
            self._world.remove_robot(request.entity)
        except QuadError as error:
            response.result = _failed(error)
            return response
        self._follow()
        response.result = _succeeded()
        return response

    def _on_entities(self, request: Any, response: Any) -> Any:
        wanted = request.filters
        try:
            for part, is_given in (
                ('categories', wanted.categories),
                ('tags', wanted.tags.tags),
                ('bounds', wanted.bounds.type),
            ):
                if is_given:
                    raise FilterUnsupported(part)
            response.entities = names_like(wanted.filter, self._world.observations())
        except QuadError as error:
            response.result = _failed(error)
            return response
        response.result = _succeeded()
        return response

    def _on_entity_state(self, request: Any, response: Any) -> Any:
        seen = self._world.observations()
        if request.entity not in seen:
            response.result = _failed(RobotNotFound(request.entity, seen))
            return response
        frame = self._world.frames_on_map[0]
        response.state = _entity_state(seen[request.entity], frame)
        response.result = _succeeded()
        return response

    def _on_state(self, _: Any, response: Any) -> Any:
        playing, paused = SimulationState.STATE_PLAYING, SimulationState.STATE_PAUSED
        response.state.state = paused if self._world.is_paused else playing
        response.result = _succeeded()
        return response

    def _on_set_state(self, request: Any, response: Any) -> Any:
        wanted = request.state.state
        if wanted not in (SimulationState.STATE_PLAYING, SimulationState.STATE_PAUSED):
            why = 'simulated time can be played (1) and paused (2), and nothing else'
            response.result = Result(result=ResultCode.FEATURE_UNSUPPORTED, error_message=why)
            return response
        shall_pause = wanted == SimulationState.STATE_PAUSED
        response.result = _succeeded()
        if shall_pause == self._world.is_paused:
            response.result.result = ALREADY_IN_TARGET_STATE
            response.result.error_message = 'it is already'
            return response
        if shall_pause:
            self._world.pause()
        else:
            self._world.unpause()
        self._node.update_status()
        return response

    def _pose(self, message: PoseStamped) -> Pose2D:
        """Read where a robot is to stand: its height is that of the ground."""
        check_frame('initial pose', message.header.frame_id, *self._world.frames_on_map, *_WORLD)
        return pose_from_message(message.pose, 'initial pose')

    def _follow(self) -> None:
        """Have the node's parameter, and topics, for the robots that there are now."""
        text = Parameter('robots', Parameter.Type.STRING, self._world.robots_text)
        self._node.set_parameters_atomically([text])
        self._node.update_status()


def _succeeded() -> Any:
    return Result(result=ResultCode.OK)


def _failed(error: QuadError) -> Any:
    return Result(result=int(code_of(error)), error_message=clipped(str(error)))


def _entity_state(seen: Observation, frame: str) -> Any:
    """Write where a robot is and how it moves, in the world's axes."""
    state = EntityState()
    state.header.frame_id = frame
    state.header.stamp = time_from_seconds(seen.time)
    p, q = state.pose.position, state.pose.orientation
    p.x, p.y, p.z = seen.position.tolist()
    q.x, q.y, q.z, q.w = seen.orientation.tolist()
    rotation = matrix_from_quaternion(np.asarray(seen.orientation))
    state.twist.linear = _vector(rotation @ seen.linear_velocity_base_in_base)
    state.twist.angular = _vector(rotation @ seen.angular_velocity_base_in_base)
    return state


def _vector(values: np.ndarray[Any, Any]) -> Vector3:
    x, y, z = values.tolist()
    return Vector3(x=x, y=y, z=z)
