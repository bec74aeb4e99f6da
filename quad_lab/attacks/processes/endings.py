"""
How processes end under attack, and how they should.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_lab.tools.criterion import Criterion, at_least, at_most, figure

LONGEST_END = 5.0
"""From a signal until a process and all that it started have ended [s]."""


@dataclass(frozen=True)
class Ending:
    """How one process ended."""

    what: str
    """Name of the node or the command."""
    signal: str
    """Name of the signal."""
    delay: float
    """Time of the signal after the start [s]."""
    duration: float
    """Time until it and all that it started had ended [s]."""
    code: int
    """Exit code."""
    is_code_right: bool
    has_traceback: bool
    """Whether its output holds one."""
    left: tuple[str, ...]
    """Processes, names in shared memory and temporary files that it left behind."""
    next_run: bool | None = None
    """Whether a demo with the same output walked afterwards; None if it was not tried."""


def is_bad(ending: Ending) -> bool:
    """Return whether something about an ending is not as it should be."""
    return (
        ending.duration > LONGEST_END
        or not ending.is_code_right
        or ending.has_traceback
        or bool(ending.left)
        or ending.next_run is False
    )


def ending_bars(kind: str, endings: list[Ending]) -> list[Criterion]:
    """
    Count what was not as it should be.

    Parameters
    ----------
    kind : str
        What ended: ``node`` or ``command``.
    endings : list of Ending
        How.

    Returns
    -------
    list of Criterion
        One for each thing that can go wrong, and the longest end.
    """
    of = f'of {len(endings)}'
    tried = [ending.next_run for ending in endings if ending.next_run is not None]
    longest = max((ending.duration for ending in endings), default=None)
    slow = sum(ending.duration > LONGEST_END for ending in endings)
    bars = [
        at_most(f'{kind}s that took longer than {LONGEST_END:.0f} s to end', slow, of, 0),
        at_most(f'{kind}s with a wrong code', sum(not e.is_code_right for e in endings), of, 0),
        at_most(f'{kind}s with a traceback', sum(e.has_traceback for e in endings), of, 0),
        at_most(f'{kind}s that left something', sum(bool(e.left) for e in endings), of, 0),
        figure(f'the longest end of a {kind}', longest, 's'),
    ]
    if tried:
        bars.append(
            at_least(
                f'demos that walked after a {kind}', sum(tried), f'of {len(tried)}', len(tried)
            )
        )
    return bars
