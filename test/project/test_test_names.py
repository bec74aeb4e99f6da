"""Modules of tests have names of their own: pytest imports no two of one name."""

from collections import Counter
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]


def test_no_two_modules_of_tests_have_one_name():
    counts = Counter(path.name for path in TESTS.glob('**/test_*.py'))
    assert len(counts) > 300
    assert not [name for name, count in counts.items() if count > 1]
