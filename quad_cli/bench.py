"""
``quadwalk bench``: measurements, each a table or, with ``--json``, one object of bars.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
from dataclasses import asdict
from types import ModuleType

from quad_cli.arguments import seed_argument
from quad_common.errors import ParameterError
from quad_lab.tools.criterion import make_console, print_bars
from quad_sim.engines.registry import AUTO, ENGINES, PREFERRED, preferred, resolved

BENCHMARKS = {
    'walk': 'quad_lab.benchmarks.bench_walk',
    'gaits': 'quad_lab.benchmarks.bench_gaits',
    'planner': 'quad_lab.benchmarks.planning.bench_planner',
    'camera': 'quad_lab.benchmarks.bench_camera',
    'terrain': 'quad_lab.benchmarks.ground.bench_terrain',
    'ground': 'quad_lab.benchmarks.ground.bench_ground',
    'engines': 'quad_lab.benchmarks.bench_engines',
    'localisation': 'quad_lab.benchmarks.bench_localisation',
    'robots': 'quad_lab.robots.bench_robots',
    'balance': 'quad_lab.balance.bench_balance',
    'view': 'quad_lab.benchmarks.viewing.bench_view',
    'campaign': 'quad_lab.campaigns.bench_campaign',
    'fleet': 'quad_lab.benchmarks.bench_fleet',
    'faults': 'quad_lab.attacks.bench_faults',
    'matrix': 'quad_lab.attacks.bench_matrix',
}
"""The module of each benchmark."""

EXAMPLES = """examples:
  quadwalk bench walk --quick
  quadwalk bench walk --json > walk.json
  quadwalk bench gaits
  quadwalk bench planner --quick
  quadwalk bench planner --only worst
  quadwalk bench planner --only footprint
  quadwalk bench camera --quick
  quadwalk bench terrain --quick
  quadwalk bench terrain --backend mujoco
  quadwalk bench ground --quick
  quadwalk bench ground --only genibo boxes --seed 100
  quadwalk bench ground --only wrong_map wave
  quadwalk bench ground --only topics
  quadwalk bench engines --only steps creep
  quadwalk bench localisation --quick
  quadwalk bench balance --quick
  quadwalk bench balance --only pushes --backend mujoco
  quadwalk bench view --only updates
  quadwalk bench campaign --quick
  quadwalk bench fleet --only cancels
  quadwalk bench fleet --only network
  quadwalk bench fleet --only recording
  quadwalk bench fleet --only warehouse corridor speed --backend mujoco
  quadwalk bench faults --only messages kills
  quadwalk bench matrix --only pukyong wave
  quadwalk bench robots --only imports broken
  quadwalk bench robots --robot my_robot.yaml
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('benchmark', choices=sorted(BENCHMARKS))
    parser.add_argument(
        '--quick', action='store_true', help='a small sample, within 45 s but for matrix'
    )
    parser.add_argument(
        '--seed', type=seed_argument, default=0, help='seed of what is drawn at random'
    )
    parser.add_argument(
        '--only',
        nargs='+',
        default=[],
        metavar='PART',
        help='parts to run, of benchmarks with parts',
    )
    parser.add_argument(
        '--robot',
        nargs='+',
        default=[],
        metavar='ROBOT',
        help='robots that walk, by name or data file, of the benchmark robots',
    )
    parser.add_argument(
        '--backend', choices=sorted(ENGINES), help='the simulator, in place of the usual one'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if every bar holds."""
    console = make_console(stderr=arguments.json)
    module = importlib.import_module(BENCHMARKS[arguments.benchmark])
    only = _parts(arguments.benchmark, module, arguments.only)
    if arguments.robot:
        if arguments.benchmark != 'robots':
            valid = "left out: only 'quadwalk bench robots' takes it"
            raise ParameterError('--robot', arguments.robot[0], valid)
        only['robots'] = tuple(arguments.robot)
    with preferred(arguments.backend or _usual_backend(module)):
        bars, details = module.measure(console, arguments.quick, arguments.seed, **only)
    if arguments.json:
        print(json.dumps({'bars': [asdict(bar) for bar in bars], **details}))
    else:
        print_bars(console, f'quadwalk bench {arguments.benchmark}', bars)
    return 0 if all(bar.holds is not False for bar in bars) else 1


def _usual_backend(module: ModuleType) -> str:
    """Return the simulator of a benchmark: the one that it prefers, where that is installed."""
    wanted: str = getattr(module, 'PREFERRED_BACKEND', AUTO)
    is_usable = wanted in ENGINES and PREFERRED not in os.environ and ENGINES[wanted].is_installed
    return wanted if is_usable else resolved(AUTO)


def _parts(benchmark: str, module: ModuleType, wanted: list[str]) -> dict[str, tuple[str, ...]]:
    """Return the argument ``only`` of a benchmark that is run in part; ParameterError if not so."""
    if not wanted:
        return {}
    parts = tuple(getattr(module, 'PARTS', ()))
    for name in wanted:
        if name not in parts:
            valid = f'one of {", ".join(parts)}' if parts else f'left out: {benchmark} has no parts'
            raise ParameterError('--only', name, valid)
    return {'only': tuple(wanted)}
