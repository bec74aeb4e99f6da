"""The definitions that ``make nav2`` builds from, against the messages that are installed."""

from __future__ import annotations

import importlib
import runpy
from pathlib import Path
from xml.etree import ElementTree

import pytest

from quad_common import errors
from quad_common.task_result import FollowCode

ROOT = Path(__file__).resolve().parents[2]
TOOL = runpy.run_path(str(ROOT / 'tools' / 'build_messages.py'))
PACKAGES = TOOL['PACKAGES']
FILES = sorted(TOOL['INTERFACES'].glob('*/*/*'))


def parts(path: Path) -> list[tuple[dict[str, str], dict[str, int]]]:
    """Read fields, type by name, and constants of each part of a definition."""
    found = []
    for part in path.read_text(encoding='utf-8').split('---\n'):
        fields, constants = {}, {}
        for line in part.splitlines():
            kind, _, rest = line.partition('#')[0].strip().partition(' ')
            if '=' in rest:
                name, _, value = rest.partition('=')
                constants[name] = int(value)
            elif rest:
                fields[rest] = kind
        found.append((fields, constants))
    return found


@pytest.mark.parametrize('name', sorted(PACKAGES))
def test_a_package_has_definitions_of_no_type_that_it_does_not_depend_on(name):
    package = PACKAGES[name]
    assert package.files
    depends = {each.text for each in ElementTree.fromstring(package.manifest).iter('depend')}
    assert depends == set(package.depends)
    for path in package.files:
        assert f'"{path.parent.name}/{path.name}"' in package.cmake
        for fields, _ in parts(path):
            types = {kind.partition('/')[0] for kind in fields.values() if '/' in kind}
            assert types <= depends | {name}
        assert path.suffix != '.action' or 'action_msgs' in depends
        assert path.suffix != '.srv' or 'service_msgs' in depends


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_a_definition_is_that_of_the_message_that_is_installed(path):
    package, folder = path.parts[-3:-1]
    pytest.importorskip(package, reason=f'{package} is not installed; see the Makefile')
    kind = getattr(importlib.import_module(f'{package}.{folder}'), path.stem)
    names = {'action': ('Goal', 'Result', 'Feedback'), 'srv': ('Request', 'Response')}
    types = [getattr(kind, name) for name in names[folder]] if folder in names else [kind]
    assert len(parts(path)) == len(types)
    for (fields, constants), each in zip(parts(path), types, strict=True):
        installed = {
            name: kind_name.removeprefix('sequence<').removesuffix('>')
            for name, kind_name in each.get_fields_and_field_types().items()
        }
        short = {'float32': 'float', 'float64': 'double', 'bool': 'boolean'}
        wanted = {
            name: short.get(kind_name, kind_name).removesuffix('[]')
            for name, kind_name in fields.items()
        }
        # An empty message has a field that is never sent.
        assert wanted == (installed if wanted else {})
        for name, value in constants.items():
            assert getattr(each, name) == value


def test_codes_are_those_of_the_actions():
    actions = pytest.importorskip('nav2_msgs.action', reason='nav2_msgs is not installed')
    follow = actions.FollowPath.Result
    names = {'NO_POSE': 'TF_ERROR', 'NO_PROGRESS': 'FAILED_TO_MAKE_PROGRESS',
             'NO_CONTROL': 'NO_VALID_CONTROL'}  # fmt: skip
    for code in FollowCode:
        assert getattr(follow, names.get(code.name, code.name)) == code
    compute = actions.ComputePathToPose.Result
    for error, name in (
        (errors.PlannerError, 'UNKNOWN'),
        (errors.InvalidPlanner, 'INVALID_PLANNER'),
        (errors.NoRobotPose, 'TF_ERROR'),
        (errors.StartOutsideMap, 'START_OUTSIDE_MAP'),
        (errors.GoalOutsideMap, 'GOAL_OUTSIDE_MAP'),
        (errors.StartOccupied, 'START_OCCUPIED'),
        (errors.GoalOccupied, 'GOAL_OCCUPIED'),
        (errors.PlannerTimedOut, 'TIMEOUT'),
        (errors.NoPathFound, 'NO_VALID_PATH'),
    ):
        assert getattr(compute, name) == error.code
        assert getattr(actions.ComputePathThroughPoses.Result, name) == error.code + 100
    assert errors.NoGoals.code + 100 == actions.ComputePathThroughPoses.Result.NO_VIAPOINTS_GIVEN
