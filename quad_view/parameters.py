"""The parameters of ``viewer_node``."""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.parameters import parameter
from quad_view.scene.page_options import PageOptions


@dataclass(frozen=True)
class ViewerParameters:
    """Parameters of ``viewer_node``."""

    host: str = parameter(
        '127.0.0.1',
        'Address to listen on. Whoever reaches it can steer the robot: other machines should come '
        'by ssh.',
    )
    port: int = parameter(
        8080, 'Port to listen on; the next free one if it is in use.', '', 0, 65535
    )
    robots: str = parameter(
        '',
        'Namespaces of robots, with commas between them; empty: all that publish joint_states.',
    )
    rate: float = parameter(30.0, 'Updates of the page in a second, at most.', 'Hz', 1.0, 60.0)
    plot_rate: float = parameter(4.0, 'Updates of the plots in a second.', 'Hz', 0.2, 20.0)
    odom_topic: str = parameter('odom', "Where the robot's pose comes from.")
    picture_topic: str = parameter(
        'ceiling_camera/image_annotated', "Where the camera's picture comes from."
    )
    map_frame: str = parameter('map', 'Frame of the map.')
    gaits: str = parameter(
        'crawl, wave, crab, trot, walk', 'Gaits to choose from, with commas between them.'
    )
    largest_speed: float = parameter(
        0.3,
        'Speed of the pad at its largest; the gait may be slower.',
        'm/s',
        0.01,
        10.0,
    )
    largest_turn: float = parameter(
        0.6, 'Rate of turning of the pad at its largest.', 'rad/s', 0.01, 10.0
    )
    stamped_cmd_vel: bool = parameter(
        False, 'Whether cmd_vel is a TwistStamped, as gait_node has it.'
    )

    @property
    def page_options(self) -> PageOptions:
        """Options of the page."""
        gaits = tuple(name.strip() for name in self.gaits.split(',') if name.strip())
        return PageOptions(
            self.host, self.port, self.plot_rate, gaits, self.largest_speed, self.largest_turn
        )
