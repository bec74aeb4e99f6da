"""
Write the lock file: the exact version of everything that ``make venv`` installs.

pip resolves the requirements with the oldest supported Python; the newer ones
then get the same versions, and what only some of them need gets a marker. So
one file serves all of them, and names neither an address nor a registry.

Usage: ``python tools/lock.py --output requirements.lock PYTHON [PYTHON ...]``,
oldest Python first; ``make lock`` does it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# pytest as in Ubuntu 24.04, which ROS 2 Jazzy runs on; setuptools before it dropped pkg_resources.
PINS = ['pytest==7.4.4', 'setuptools<81', 'wheel']
# Above this Python pip would compile PyBullet for minutes: the environment does without it.
MARKERS = {'pybullet': 'python_version < "3.12"'}
HEADER = """\
# Every package that "make venv" installs, in the exact version that the tests run with.
# Written by "make lock"; do not edit.
"""


def run(*command: str) -> None:
    """Run a command and stop with its own words where it fails."""
    if subprocess.run(command, check=False).returncode != 0:
        sys.exit(f'failed: {" ".join(command)}')


def resolve(python: str, constraints: list[str], folder: Path) -> tuple[str, dict[str, str]]:
    """
    Let pip resolve the package with all extras, without installing anything.

    Parameters
    ----------
    python : str
        The interpreter to resolve for.
    constraints : list of str
        Versions that are decided already.
    folder : Path
        An empty folder for the environment that resolves.

    Returns
    -------
    version : str
        Version of the interpreter, as in '3.11'.
    packages : dict of str to str
        Version of each package, by its normalized name.
    """
    run(python, '-m', 'venv', str(folder / 'venv'))
    inside = str(folder / 'venv' / 'bin' / 'python')
    run(inside, '-m', 'pip', 'install', '-qq', '--upgrade', 'pip', 'wheel', 'setuptools<81')
    (folder / 'constraints.txt').write_text('\n'.join(constraints), encoding='utf-8')
    run(
        inside, '-m', 'pip', 'install', '-qq', '--dry-run', '--ignore-installed',
        '--report', str(folder / 'report.json'), '--constraint', str(folder / 'constraints.txt'),
        f'{ROOT}[all]', *PINS,
    )  # fmt: skip
    report = json.loads((folder / 'report.json').read_text(encoding='utf-8'))
    packages = {}
    for item in report['install']:
        name = item['metadata']['name'].lower().replace('_', '-').replace('.', '-')
        if name != 'quadwalk':
            packages[name] = item['metadata']['version']
    return '.'.join(report['environment']['python_version'].split('.')[:2]), packages


def merge(resolved: dict[str, dict[str, str]]) -> list[str]:
    """One line per package and version, with a marker where not every Python takes it."""
    pythons = list(resolved)
    lines = []
    for name in sorted(set().union(*resolved.values())):
        takers: dict[str, list[str]] = {}
        for python, packages in resolved.items():
            if name in packages:
                takers.setdefault(packages[name], []).append(python)
        for version, those in takers.items():
            if name in MARKERS:
                marker = MARKERS[name]
            elif those == pythons:
                marker = ''
            elif those[0] == pythons[0]:
                marker = f'python_version < "{pythons[len(those)]}"'
            else:
                marker = f'python_version >= "{those[0]}"'
            lines.append(f'{name}=={version}' + (f' ; {marker}' if marker else ''))
    return lines


def main() -> None:
    """Resolve for each Python and write the file."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n\n')[0].strip())
    parser.add_argument('pythons', nargs='+', metavar='PYTHON', help='oldest first')
    parser.add_argument('--output', type=Path, default=ROOT / 'requirements.lock')
    arguments = parser.parse_args()
    resolved: dict[str, dict[str, str]] = {}
    decided: dict[str, str] = {}
    for python in arguments.pythons:
        constraints = [f'{name}=={version}' for name, version in decided.items()]
        with tempfile.TemporaryDirectory() as folder:
            version, packages = resolve(python, constraints, Path(folder))
        print(f'Python {version}: {len(packages)} packages')
        resolved[version] = packages
        decided = packages | decided
    text = HEADER + '\n'.join(merge(resolved)) + '\n'
    arguments.output.write_text(text, encoding='utf-8')
    print(f'wrote {arguments.output.name}')


if __name__ == '__main__':
    main()
