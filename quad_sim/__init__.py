"""
Simulators that walk the robot: PyBullet's physics, and one that follows commands exactly.

PyBullet is imported in ``bullet_simulator`` only.
"""

from quad_common.lazy_names import lazy_names

TYPE_CHECKING = False

if TYPE_CHECKING:
    from quad_sim.engines.registry import make_simulator as make_simulator
    from quad_sim.engines.simulator import Observation as Observation
    from quad_sim.engines.simulator import Simulator as Simulator
    from quad_sim.simulation import Simulation as Simulation
    from quad_sim.world.appearance import Appearance as Appearance
    from quad_sim.world.random_room import Room as Room
    from quad_sim.world.random_room import random_room as random_room
    from quad_sim.world.simulated_camera import SimulatedCamera as SimulatedCamera
    from quad_sim.world.terrain import Terrain as Terrain
    from quad_sim.world.terrain_spec import make_terrain as make_terrain
    from quad_sim.world.terrain_spec import specs_from_text as specs_from_text
    from quad_sim.world.world import Obstacle as Obstacle
    from quad_sim.world.world import World as World
    from quad_sim.world.world import world_from_map as world_from_map
else:
    __getattr__, __dir__, __all__ = lazy_names(
        __name__,
        {
            'quad_sim.engines.registry': ('make_simulator',),
            'quad_sim.simulation': ('Simulation',),
            'quad_sim.engines.simulator': ('Observation', 'Simulator'),
            'quad_sim.world.world': ('Obstacle', 'World', 'world_from_map'),
            'quad_sim.world.random_room': ('Room', 'random_room'),
            'quad_sim.world.terrain': ('Terrain',),
            'quad_sim.world.terrain_spec': ('make_terrain', 'specs_from_text'),
            'quad_sim.world.appearance': ('Appearance',),
            'quad_sim.world.simulated_camera': ('SimulatedCamera',),
        },
    )
