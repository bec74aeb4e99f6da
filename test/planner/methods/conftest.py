"""What tests of planning methods need."""

import pytest

from quad_planner.methods import planner_options


@pytest.fixture
def nothing_is_compiled(monkeypatch):
    """Have all time of a search count: a first one compiles, and that counts for nothing."""
    monkeypatch.setattr(planner_options, 'compilation_count', lambda: 0)
