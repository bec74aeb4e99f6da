"""
Packaging of quadwalk, for pip and for colcon alike.

All metadata is here, because colcon reads it from ``setup.py``; the version is
the one in ``package.xml``. Files that are not Python go to the places where ROS
looks for them: ``share/quadwalk`` and ``share/ament_index``, and
``lib/quadwalk`` so that ``ros2 run`` finds the nodes after a plain pip too.
"""

from pathlib import Path
from xml.etree import ElementTree

from setuptools import find_packages, setup

NAME = 'quadwalk'
HERE = Path(__file__).resolve().parent

# Small modules, which hear signals before they import what is large.
NODES = {
    'planner_node': 'quad_planner.__main__:main',
    'gait_node': 'quad_gait.__main__:main',
    'sim_node': 'quad_sim.__main__:main',
    'ceiling_camera_node': 'quad_perception.__main__:main',
    'viewer_node': 'quad_view.__main__:main',
}
COMMANDS = {'quadwalk': 'quad_cli.__main__:main'}

EXTRAS = {
    # A ROS 2 installation brings its own rclpy and messages: these are for machines without one.
    'ros': ['ros-jazzy-rclpy[fastrtps]>=7.1', 'ros-jazzy-common-interfaces>=5.3'],
    # PyBullet has wheels for Python up to 3.11; above it pip compiles for about seven minutes.
    # MuJoCo 4 splits its package, and an upgrade in place across the split breaks.
    'sim': ['mujoco>=3.3,<4', 'pybullet>=3.2.5; python_version < "3.12"'],
    # Robots from other people's descriptions: URDF, xacro, and with MuJoCo MJCF.
    'robots': ['yourdfpy>=0.0.56', 'trimesh>=4.0', 'lxml>=4.8', 'xacro>=2.0'],
    # Recordings of the demo as rosbag2 files, without a ROS installation.
    'record': ['rosbags>=0.11'],
    # Films of recordings; its wheels bring ffmpeg.
    'film': ['imageio-ffmpeg>=0.4.9'],
    # The page of viewer_node, and what measures it. viser wants rich below 15. It is held to what
    # is known of its inside: the viewer closes connections of pages that are not its own.
    'view': ['viser>=1.1,<1.2', 'trimesh', 'msgspec', 'websockets', 'zstandard'],
    # "pytest" by this name makes colcon test use it. Jazzy's launch_testing breaks with pytest 9.
    'test': [
        'pytest>=7.4,<9',
        'pytest-timeout>=2.1',
        'pytest-xdist>=3.4',
        'catkin_pkg>=0.5',
        'setuptools>=64',
        'wheel',
    ],
    # Campaigns of walks on many processors and machines: Dask with its page, Parquet, CMA-ES.
    'campaign': ['dask[distributed]>=2024.1', 'bokeh>=3.1', 'pyarrow>=14', 'cma>=3.3'],
    'lint': ['ruff>=0.6', 'mypy>=1.10', 'types-PyYAML'],
}
EXTRAS['all'] = [requirement for extra in EXTRAS.values() for requirement in extra]
# What "quadwalk bench" compares with, if it is there: neither in "all" nor locked.
EXTRAS['bench'] = ['ikpy>=3.4', 'mcap>=1.1', 'pyastar2d>=1.1', 'scikit-image>=0.22', 'tcod>=16']
# The documents as a site, for "make site": neither of the two either. Its plugins want MkDocs 1.
EXTRAS['docs'] = ['mkdocs-material>=9.5,<10']


def version() -> str:
    """Version in ``package.xml``, the one place where it is written."""
    return ElementTree.parse(HERE / 'package.xml').getroot().findtext('version', '').strip()


def readme() -> str:
    """Text of the README; empty where a build leaves it out."""
    path = HERE / 'README.md'
    return path.read_text(encoding='utf-8') if path.is_file() else ''


def files(pattern: str) -> list:
    """Files that match a pattern, relative to this folder as setuptools wants them."""
    return sorted(str(path.relative_to(HERE)) for path in HERE.glob(pattern) if path.is_file())


def tree(folder: str, destination: str) -> list:
    """Every file below a folder, as ``data_files`` entries that keep its subfolders."""
    entries = {}
    for path in files(f'{folder}/**/*'):
        if '__pycache__' not in path and not Path(path).name.startswith('.'):
            target = Path(destination) / Path(path).parent
            entries.setdefault(str(target), []).append(path)
    return sorted(entries.items())


setup(
    name=NAME,
    version=version(),
    description='Path planning, gaits and simulation for quadruped walking robots on ROS 2',
    long_description=readme(),
    long_description_content_type='text/markdown',
    author='The quadwalk developers',
    maintainer='The quadwalk developers',
    maintainer_email='maintainers@quadwalk.example',
    license='Apache-2.0',
    keywords=['ROS', 'quadruped', 'legged robot', 'gait', 'path planning', 'PyBullet'],
    classifiers=[
        'Intended Audience :: Developers',
        'Intended Audience :: Science/Research',
        'Programming Language :: Python :: 3',
        'Programming Language :: Python :: 3.10',
        'Programming Language :: Python :: 3.11',
        'Programming Language :: Python :: 3.12',
        'Programming Language :: Python :: 3.13',
        'Topic :: Scientific/Engineering',
        'Typing :: Typed',
    ],
    python_requires='>=3.10',
    # The lower bounds are what Ubuntu 24.04 has, so a ROS 2 Jazzy installation satisfies them.
    install_requires=[
        'numpy>=1.26',
        'numba>=0.58',
        'scipy>=1.11',
        'opencv-python-headless>=4.6',
        'pillow>=9.1',
        'pyyaml>=6.0',
        'matplotlib>=3.6',
        'rich>=13.0',
    ],
    extras_require=EXTRAS,
    packages=find_packages(include=['quad_*']),
    package_data={
        '': ['py.typed'],
        'quad_common': ['robots/*', 'robots/calibration/*', 'robots/pace/*'],
        'quad_gait': ['gaits/*'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        *tree('launch', f'share/{NAME}'),
        *tree('config', f'share/{NAME}'),
        *tree('maps', f'share/{NAME}'),
        (f'lib/{NAME}', [f'scripts/{node}' for node in NODES]),
    ],
    zip_safe=False,
    entry_points={
        'console_scripts': [f'{name} = {target}' for name, target in (NODES | COMMANDS).items()],
    },
)
