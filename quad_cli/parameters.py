"""
``quadwalk parameters``: a node's parameters as a commented YAML file.
"""

from __future__ import annotations

import argparse

from quad_common.parameters import parameters_of, yaml_from_parameters
from quad_gait.parameters import GaitParameters
from quad_perception.parameters import CeilingCameraParameters
from quad_planner.parameters import PlannerParameters
from quad_sim.parameters import SimParameters
from quad_view.parameters import ViewerParameters

TABLES = {
    'planner_node': PlannerParameters,
    'gait_node': GaitParameters,
    'sim_node': SimParameters,
    'ceiling_camera_node': CeilingCameraParameters,
    'viewer_node': ViewerParameters,
}
"""The parameter table of each node."""

EXAMPLES = """examples:
  quadwalk parameters gait_node > gait.yaml
  gait_node --ros-args --params-file gait.yaml
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('node', choices=sorted(TABLES))


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    print(yaml_from_parameters(arguments.node, parameters_of(TABLES[arguments.node])), end='')
    return 0
