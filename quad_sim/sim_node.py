"""
The node that walks the robot in simulation and closes the loop.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_sim.__main__ import main as start

    raise SystemExit(start())

import time
from typing import Any

from geometry_msgs.msg import PoseStamped
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from quad_common.frames.frame_names import check_frame
from quad_common.ros.pose_conversions import pose_from_message
from quad_common.ros.ros_node import QuadNode
from quad_common.ros.run_node import run_node
from quad_sim.engines.registry import AUTO, resolved
from quad_sim.entities.entity_services import EntityServices
from quad_sim.entities.obstacle_conversions import (
    MOST_OBSTACLE_BYTES,
    obstacle_changes_from_message,
)
from quad_sim.fleet_session import session_from_parameters
from quad_sim.parameters import SimParameters
from quad_sim.sim_topics import SimTopics


class SimNode(QuadNode[SimParameters]):
    """Steps the simulation, publishes its state and takes joint trajectories."""

    def __init__(self, **kwargs: Any) -> None:
        # It makes the simulated time, and so cannot wait for it.
        super().__init__('sim_node', SimParameters, **kwargs)
        p = self.parameters
        self._session = session_from_parameters(p, time.monotonic)
        self._topics = SimTopics(self, self._session)
        self.create_subscription(
            MarkerArray, 'obstacles', self._on_obstacles, 10, most_bytes=MOST_OBSTACLE_BYTES
        )
        self.create_subscription(PoseStamped, 'goal_marker', self._on_goal_marker, 10)
        self.create_service(Trigger, 'pause', self._on_pause)
        self.create_service(Trigger, 'unpause', self._on_unpause)
        EntityServices(self, self._session)
        if p.backend == AUTO:
            self.get_logger().info(f"backend '{AUTO}': simulating with {resolved(AUTO)}")
        self._session.observe(self._topics)
        self.update_status()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._session.time

    def drive(self) -> float:
        """Simulate up to the next observation, if it is due; return how long it is not [s]."""
        wait = self._session.wait()
        if wait == 0.0:
            self._session.advance(self._topics)
            if self._session.has_news:
                self.update_status()
        else:
            self._topics.send_batches()
        return wait

    def take_parameters(self, parameters: SimParameters) -> None:
        """Let a joint fail, or let robots come and go."""
        self._session.take_parameters(parameters)
        self._topics.match_robots()

    def update_status(self) -> None:
        """Report how the simulation goes."""
        self.report_status(self._session.status().with_notes(self._topics.clock_problem()))

    def destroy_node(self) -> None:
        """Release the simulator."""
        self._session.close()
        super().destroy_node()

    def _on_obstacles(self, message: MarkerArray) -> None:
        changes = obstacle_changes_from_message(message, self._session.frames_on_map)
        self._session.simulation.change_obstacles(changes, self.parameters.most_obstacles)
        self._topics.publish_obstacles()

    def _on_goal_marker(self, message: PoseStamped) -> None:
        check_frame('goal_marker', message.header.frame_id, *self._session.frames_on_map)
        pose = pose_from_message(message.pose, 'goal_marker')
        self._session.put_goal_marker(pose)

    def _on_pause(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._session.pause()
        return self._answered(response, f'paused at {self._session.time:.2f} s')

    def _on_unpause(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._session.unpause()
        return self._answered(response, 'running')

    def _answered(self, response: Trigger.Response, sentence: str) -> Trigger.Response:
        """Answer a service that has done what was requested."""
        self.update_status()
        response.success, response.message = True, sentence
        return response


def main(args: list[str] | None = None) -> int:
    """Run the simulator node."""
    return run_node(SimNode, args, drive=SimNode.drive)
