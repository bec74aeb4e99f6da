"""
A plain pip installation has every file where Python and ROS look for it.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.slow


@pytest.fixture(scope='module')
def prefix(tmp_path_factory) -> Path:
    """Install a copy of the source tree, with pip and without the network."""
    for tool in ('pip', 'setuptools', 'wheel'):
        if importlib.util.find_spec(tool) is None:
            pytest.skip(f'{tool} is not installed')
    folder = tmp_path_factory.mktemp('installation')
    unwanted = shutil.ignore_patterns(
        '.*', '__pycache__', '*.egg-info', 'build', 'install', 'log', 'dist', 'output', 'test'
    )
    shutil.copytree(ROOT, folder / 'source', ignore=unwanted)
    command = [
        *(sys.executable, '-m', 'pip', '--disable-pip-version-check', 'install', '--no-index'),
        *('--no-deps', '--no-build-isolation', '--ignore-installed', '--no-warn-script-location'),
        *('--prefix', str(folder / 'prefix'), str(folder / 'source')),
    ]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    # Debian's own Python puts everything into a further folder, "local".
    [manifest] = (folder / 'prefix').glob('**/share/quadwalk/package.xml')
    return manifest.parents[2]


@pytest.fixture(scope='module')
def site(prefix) -> Path:
    """The folder that the packages were installed to."""
    [package] = prefix.glob('lib/python3*/*-packages/quad_common')
    return package.parent


def python(site: Path, prefix: Path, code: str) -> str:
    """Run code with the installed packages, far from the source tree; return its output."""
    environment = dict(os.environ)
    environment['AMENT_PREFIX_PATH'] = str(prefix)
    environment['PYTHONPATH'] = os.pathsep.join(
        [str(site)] + ([environment['PYTHONPATH']] if environment.get('PYTHONPATH') else [])
    )
    result = subprocess.run(
        [sys.executable, '-c', code],
        capture_output=True, text=True, check=False, cwd=prefix, env=environment,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    return result.stdout.strip()


def test_the_packages_carry_their_data(site):
    for data in ('quad_common/robots', 'quad_gait/gaits'):
        installed = {path.name for path in (site / data).glob('*.yaml')}
        assert installed == {path.name for path in (ROOT / data).glob('*.yaml')} != set()
    assert (site / 'quad_common' / 'py.typed').is_file()


def test_only_the_projects_own_packages_are_installed(site):
    packages = {path.name for path in site.iterdir() if not path.name.endswith('.dist-info')}
    assert packages == {path.name for path in ROOT.glob('quad_*') if path.is_dir()}


def test_ros_finds_the_package_and_its_shared_files(prefix):
    assert (prefix / 'share/ament_index/resource_index/packages/quadwalk').is_file()
    for folder in ('launch', 'config', 'maps'):
        installed = {path.name for path in (prefix / 'share/quadwalk' / folder).iterdir()}
        assert installed - {'__pycache__'} == {
            path.name for path in (ROOT / folder).iterdir() if path.name != '__pycache__'
        }


@pytest.mark.parametrize('node', ['planner_node', 'gait_node', 'sim_node'])
def test_a_node_can_be_run_by_name_and_by_ros2_run(prefix, node):
    for path in (prefix / 'bin' / node, prefix / 'lib' / 'quadwalk' / node):
        assert os.access(path, os.X_OK), path


def test_the_quadwalk_command_is_installed(prefix):
    assert os.access(prefix / 'bin' / 'quadwalk', os.X_OK)


def test_ament_index_knows_the_package(site, prefix):
    pytest.importorskip('ament_index_python')
    code = (
        'from ament_index_python.packages import get_package_share_directory as share;'
        'print(share("quadwalk"))'
    )
    assert Path(python(site, prefix, code)) == prefix / 'share' / 'quadwalk'


def test_the_installed_package_finds_its_own_shared_files(site, prefix):
    code = 'from quad_common import resources; print(resources.share_directory())'
    assert Path(python(site, prefix, code)) == prefix / 'share' / 'quadwalk'
