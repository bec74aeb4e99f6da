"""What all tests need."""

import signal
from pathlib import Path

# Where tests run under nohup, or as a service, hangups are ignored, and whatever they start would
# ignore them as well: what a process does when its terminal closes could not be tested.
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# Of two workers each begins with a half of the tests. The first compiles the planner's searches
# while the second does what needs none, and finds them compiled; both would compile them all at
# once. Then one computes while the other waits for nodes, and what takes no time comes last.
_FOLDERS = (
    'planner', 'cli', 'lab', 'sim', 'perception', 'view', 'project',
    'gait', 'integration', 'common',
)  # fmt: skip


def pytest_collection_modifyitems(items):
    """Put folders into an order; within each nothing changes."""
    here = Path(__file__).parent

    def place(item):
        folder = item.path.relative_to(here).parts[0] if item.path.is_relative_to(here) else ''
        return _FOLDERS.index(folder) if folder in _FOLDERS else len(_FOLDERS)

    items.sort(key=place)
