"""
The figures of one walk as a table.
"""

from __future__ import annotations

from collections.abc import Mapping

from rich.console import Console
from rich.table import Table


def print_walk(console: Console, summary: Mapping[str, object]) -> None:
    """
    Print the figures of a walk.

    Parameters
    ----------
    console : rich.console.Console
        Where they go.
    summary : mapping of str to object
        Those of :class:`~quad_lab.topic_walk.walk_record.WalkResult`, and ``map``; ``picture`` and
        ``recording`` where there are any.
    """
    table = Table(title=f'Walk on {summary["map"]}', show_header=False)
    of_which = ', of the last plan' if summary['plans'] != 1 else ''
    rows = (
        ('arrived', 'yes' if summary['arrived'] else f'no: {summary["problem"]}', ''),
        ('final position error', summary['position_error'], 'm'),
        ('final heading error', summary['heading_error'], 'deg'),
        ('largest distance from the path', summary['largest_path_distance'], 'm'),
        ('least stability margin, planned', summary['least_stability_margin'], 'm'),
        ('walking time, simulated', summary['walking_time'], 's'),
        *((('plans', summary['plans'], ''),) if of_which else ()),
        (f'path{of_which}', summary['path_length'], 'm'),
        (f'turning points{of_which}', summary['turning_points'], ''),
        ('gait cycles, or decisions that balance', summary['cycles'], ''),
        ('contacts other than feet on the ground', summary['contacts'] or 'none', ''),
        ('fallen', 'yes' if summary['fallen'] else 'no', ''),
        ('speed', summary['real_time_factor'], 'x real time'),
    )
    for name, value, unit in rows:
        table.add_row(name, _cell(value), unit)
    console.print(table)
    for name in ('picture', 'recording'):
        if summary.get(name) is not None:
            console.print(f'{f"{name}:":10} {summary[name]}', highlight=False)


def _cell(value: object) -> str:
    if value is None:
        return 'not measured'
    return f'{value:.3f}' if isinstance(value, float) else str(value)
