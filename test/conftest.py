"""What all tests need."""

import contextlib
import resource
import signal
import sys
from pathlib import Path
from unittest import mock

import pytest
from sweeps import leave_out

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


def pytest_addoption(parser):
    """Let all cases of sweeps be asked for."""
    parser.addoption('--sweeps', action='store_true', help='run the tests of sweeps in all cases')


# Last: of the cases that are left by -k and -m.
@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    """Leave most cases of sweeps out, unless asked for; put folders into an order."""
    if not config.getoption('--sweeps'):
        items[:], left_out = leave_out(items)
        config.hook.pytest_deselected(items=left_out)
    here = Path(__file__).parent

    def place(item):
        path = item.path.relative_to(here).as_posix() if item.path.is_relative_to(here) else ''
        places = (k for k, folder in enumerate(_FOLDERS) if path.startswith(f'{folder}/'))
        return next(places, len(_FOLDERS))

    items.sort(key=place)


@contextlib.contextmanager
def _most_bytes(count):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (count, before[1]))
    try:
        # Python would cut off the bytecode of what is imported now, and could not read it again.
        with mock.patch.object(sys, 'dont_write_bytecode', True):
            yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


@pytest.fixture
def most_bytes():
    """Have every file refuse what is beyond its first bytes, as a full disk does."""
    return _most_bytes
