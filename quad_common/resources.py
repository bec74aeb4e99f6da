"""
Finds the files that ship with quadwalk: sample maps, parameter files, launch files.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path


def share_directory() -> Path:
    """
    Find the folder with ``maps``, ``config`` and ``launch``.

    Returns
    -------
    Path
        The package's share folder of a colcon or pip installation, or the source tree.
    """
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    source = Path(__file__).resolve().parents[1]
    candidates = [Path(prefix) / 'share' / 'quadwalk' for prefix in prefixes if prefix]
    if (source / 'package.xml').is_file():
        # An editable installation has no share folder; its source tree comes first, so
        # that edited maps are the ones in use.
        candidates.append(source)
    candidates.append(Path(sys.prefix) / 'share' / 'quadwalk')
    for candidate in candidates:
        if (candidate / 'maps').is_dir():
            return candidate
    raise FileNotFoundError(
        f'the shared files of quadwalk are in none of {", ".join(map(str, candidates))}; '
        f'reinstall the package'
    )


def sample_map(name: str = 'room') -> Path:
    """Return the map file of a sample map."""
    return share_directory() / 'maps' / f'{name}.yaml'
