"""What all tests need."""

import signal
from pathlib import Path

# Where tests run under nohup, or as a service, hangups are ignored, and whatever they start would
# ignore them as well: what a process does when its terminal closes could not be tested.
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# Each worker begins with as many tests as the others. The first compiles the planner's searches
# while the others do what needs none, and find them compiled; all would compile them at once.
# Tests over topics, which wait for nodes, come last and are taken over in small numbers: the
# longest of them first.
_FOLDERS = (
    'planner', 'lab', 'sim', 'cli', 'common', 'project', 'perception', 'view', 'gait',
    'integration/view', 'integration',
)  # fmt: skip


def pytest_collection_modifyitems(items):
    """Put folders into an order; within each nothing changes."""
    here = Path(__file__).parent

    def place(item):
        path = item.path.relative_to(here).as_posix() if item.path.is_relative_to(here) else ''
        places = (k for k, folder in enumerate(_FOLDERS) if path.startswith(f'{folder}/'))
        return next(places, len(_FOLDERS))

    items.sort(key=place)
