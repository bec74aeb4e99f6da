"""The parameters of ``planner_node``."""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.maps.occupancy_grid import MAX_CELLS, OCCUPIED
from quad_common.parameters import parameter
from quad_planner.grid.ground_limits import LARGEST_SLOPE, STEEPEST
from quad_planner.navigation.navigator_options import NavigatorOptions

LOW_OBSTACLES = ('keep', 'step_over')
"""Choices for obstacles of the map that the height map shows to be low."""

FOOTINGS = ('check', 'ignore')
"""Choices for whether plans keep to poses where the robot finds footholds."""

FOOTPRINTS = ('circle', 'outline')
"""What of the robot keeps its distance from obstacles."""

TURNINGS = ('in_place', 'crab', 'arc')
"""Manners in which the gait follows a plan."""

MAP_VALUES = ('occupancy', 'costmap')
"""Choices for what the values of a map mean."""

PLANNING_METHODS = ('mesh', 'shortest', 'quickest', 'potential')
"""Names of the planning methods."""


@dataclass(frozen=True)
class PlannerParameters:
    """Parameters of ``planner_node``."""

    robot: str = parameter('titan_viii', 'Name of a robot, or path of a robot data file.')
    method: str = parameter(
        'mesh',
        'How paths are searched: turning points on a mesh (S0), the shortest path over cells, '
        'the one that takes the least time to walk, or down a potential (S1). A change counts '
        'from the next plan on.',
        choices=PLANNING_METHODS,
        is_dynamic=True,
    )
    any_angle: bool = parameter(
        False,
        "Whether paths of 'shortest' and 'quickest' may have any direction, not only eight.",
        is_dynamic=True,
    )
    fewest_turns: bool = parameter(
        False,
        "Whether 'shortest' proves that no path over cells as short turns less; it takes longer.",
        is_dynamic=True,
    )
    gait: str = parameter(
        'crawl',
        "The gait that walks the plan: 'quickest' counts its cycles.",
        is_dynamic=True,
    )
    potential: str = parameter(
        'either',
        "What 'potential' descends: the paper's functions, a navigation function, which has no "
        "local minima, or that where the paper's descent sticks.",
        choices=('paper', 'navigation', 'either'),
        is_dynamic=True,
    )
    influence: float = parameter(
        1.5,
        "Farther from the safety boundary obstacles do not change a path of 'potential', Q* (S1).",
        'm',
        lower=0.01,
        is_dynamic=True,
    )
    path_deviation: float = parameter(
        0.05,
        "A path of 'potential' keeps this near to the descent, with few turning points.",
        'm',
        lower=0.0,
        upper=1.0,
        is_dynamic=True,
    )
    safety_distance: float = parameter(
        0.12,
        "Kept free around the circle that holds the robot's feet, and knees that reach far out of "
        'it. When it changes, the way to the goal is planned again.',
        'm',
        lower=0.0,
        upper=10.0,
        is_dynamic=True,
    )
    footprint: str = parameter(
        'circle',
        'What keeps the distance: the circle that holds the feet, or also the outline, which fits '
        'through narrower passages and is planned for with its heading.',
        choices=FOOTPRINTS,
        is_dynamic=True,
    )
    outline: str = parameter(
        '',
        "Corners of the robot with its load about base_link, in m, for footprint 'outline': "
        "[[x, y], ...], of which the convex hull counts; empty for the robot's own.",
        is_dynamic=True,
    )
    turning: str = parameter(
        'in_place',
        "How the gait follows a plan, as gait_node's turning: footprint 'outline' plans for it.",
        choices=TURNINGS,
        is_dynamic=True,
    )
    corner_deviation: float = parameter(
        0.1,
        "As gait_node's corner_deviation, for footprint 'outline' with turning 'arc'.",
        'm',
        lower=0.001,
        upper=10.0,
        is_dynamic=True,
    )
    corner_radius: float = parameter(
        1.0,
        "As gait_node's corner_radius, for footprint 'outline' with turning 'arc'.",
        'm',
        lower=0.01,
        upper=100.0,
        is_dynamic=True,
    )
    start_tolerance: float = parameter(
        -1.0,
        'How much nearer to obstacles the start may be than the rest of the path; -1: as much as '
        'still leaves the gait room to sway and to turn there.',
        'm',
        lower=-1.0,
        upper=10.0,
        is_dynamic=True,
    )
    occupied_threshold: int = parameter(
        65,
        'Cells of at least this occupancy are obstacles.',
        '%',
        lower=1,
        upper=100,
        is_dynamic=True,
    )
    map_values: str = parameter(
        'occupancy',
        "What the values of the map mean. 'costmap': those of Nav2's costmaps, where 100 (lethal) "
        'alone is an obstacle, and 1 to 99 are costs of walking there.',
        choices=MAP_VALUES,
        is_dynamic=True,
    )
    map_cost: float = parameter(
        5.0,
        "A path through cells of a costmap's highest cost, 99, counts so many times its length; "
        "less, where it is lower. For 'shortest', 'quickest' and the navigation function of "
        "'potential'.",
        lower=1.0,
        upper=15.0,
        is_dynamic=True,
    )
    unknown_is_free: bool = parameter(
        False,
        'Whether paths may lead through unknown cells.',
        is_dynamic=True,
    )
    step_height: float = parameter(
        0.0,
        "Steps of the height map that are higher are walked around; 0: the robot's own height.",
        'm',
        lower=0.0,
        upper=1.0,
    )
    largest_slope: float = parameter(
        LARGEST_SLOPE,
        'Ground of the height map that is steeper, on the average over the stance, is walked '
        'around.',
        'rad',
        lower=0.01,
        upper=STEEPEST,
    )
    footsteps: bool = parameter(
        False,
        'Whether paths lead over gaps of the height map that a foot bridges, from foothold to '
        "foothold. Only with gait_node's footsteps.",
    )
    footing: str = parameter(
        'check',
        'Whether plans keep to poses where the robot finds footholds by the height map: each foot '
        'by the criterion of the gait for uneven ground, within reach of its leg.',
        choices=FOOTINGS,
    )
    low_obstacles: str = parameter(
        'keep',
        'Whether obstacles of the map stay obstacles where the height map shows that they are '
        'low. step_over is for height maps that show all that stands on the ground.',
        choices=LOW_OBSTACLES,
    )
    unknown_cost: float = parameter(
        1.0,
        'A path through unknown cells counts so many times its length, if unknown_is_free is set. '
        "For 'shortest', 'quickest' and the navigation function of 'potential'.",
        lower=1.0,
        upper=15.0,
        is_dynamic=True,
    )
    clearance_cost: float = parameter(
        1.0,
        'A path along the safety boundary counts so many times its length; less, farther off. '
        "For 'shortest', 'quickest' and the navigation function of 'potential'.",
        lower=1.0,
        upper=15.0,
        is_dynamic=True,
    )
    clearance_cost_distance: float = parameter(
        0.5,
        'Farther from the safety boundary a path counts its length only.',
        'm',
        lower=0.01,
        upper=100.0,
        is_dynamic=True,
    )
    roughness_cost: float = parameter(
        1.0,
        'A path over ground of the height map as rough as a step of the step height counts so '
        'many times its length; less, where it is smoother. '
        "For 'shortest', 'quickest' and the navigation function of 'potential'.",
        lower=1.0,
        upper=15.0,
        is_dynamic=True,
    )
    slope_cost: float = parameter(
        1.0,
        'A path over ground of the height map of the largest slope counts so many times its '
        "length; less, where it is more level. For 'shortest', 'quickest' and the navigation "
        "function of 'potential'.",
        lower=1.0,
        upper=15.0,
        is_dynamic=True,
    )
    replan_distance: float = parameter(
        0.3,
        'The path is planned again when the robot has left it by more.',
        'm',
        lower=0.05,
        is_dynamic=True,
    )
    planning_timeout: float = parameter(
        5.0,
        'A search that takes longer is given up.',
        's',
        lower=0.01,
        is_dynamic=True,
    )
    largest_map: int = parameter(
        2**26,
        'Maps with more cells are refused: 2^26 are 8192 x 8192.',
        lower=1,
        upper=MAX_CELLS,
        is_dynamic=True,
    )
    odom_timeout: float = parameter(
        1.0,
        'No plan is made from a pose that is older: it waits for the next one.',
        's',
        0.05,
        is_dynamic=True,
    )
    correction_time_constant: float = parameter(
        3.0,
        'Corrections of odometry are followed as by a first-order filter; 0: each is taken whole.',
        's',
        0.0,
        60.0,
    )
    correction_timeout: float = parameter(
        5.0,
        'Corrections of odometry older than this are reported as old; they stay in force.',
        's',
        lower=0.1,
    )
    managed: bool = parameter(
        False,
        "Whether the node works only while ROS 2's lifecycle manager, or `ros2 lifecycle`, has it "
        'active.',
    )
    odom_topic: str = parameter('odom', "Where the robot's pose comes from.")
    gives_way: bool = parameter(
        True,
        'Whether the robot tells other planners on /fleet/robots where it is and wants to go, and '
        'waits for their robots or gives way to them.',
    )
    navigation_patience: float = parameter(
        10.0,
        "An action's goal fails when the robot does nothing for it for so long; before gait_node "
        'was first received, not before 30 s.',
        's',
        lower=1.0,
        is_dynamic=True,
    )
    navigation_retries: int = parameter(
        3,
        'How many times a path is planned again for a robot that is stuck on its way to the goal '
        'of an action.',
        lower=0,
        upper=100,
        is_dynamic=True,
    )
    passing_distance: float = parameter(
        0.3,
        'Distance at which a pose that is walked through counts as reached.',
        'm',
        lower=0.0,
        upper=10.0,
        is_dynamic=True,
    )

    @property
    def obstacle_threshold(self) -> int:
        """Least value of an obstacle on the map [%]."""
        return OCCUPIED if self.map_values == 'costmap' else self.occupied_threshold

    @property
    def navigator_options(self) -> NavigatorOptions:
        """Conditions under which goals of actions are pursued."""
        return NavigatorOptions(
            self.navigation_patience, self.navigation_retries, self.passing_distance
        )
