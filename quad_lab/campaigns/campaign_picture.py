"""
Draws a campaign: successes with their intervals, or how a tuning went.
"""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from quad_common.files.whole_file import whole_file
from quad_lab.campaigns.summary import Group, Summary
from quad_lab.campaigns.tuning import Tuned

_BLUE, _RED, _GRAY = '#1f4fd8', '#d62728', '#8a8a8a'

_ROW = 0.28
"""Height of a group's row [in]."""

_WORST_SHOWN = 2.0
"""Costs above it are drawn at it: they stand for limits that were missed, and falls."""


def draw_campaign(path: Path, summary: Summary) -> None:
    """
    Draw a campaign.

    Parameters
    ----------
    path : Path
        Where the picture goes; its ending says in which format.
    summary : Summary
        What to draw.
    """
    rows = len(summary.groups)
    figure = Figure(figsize=(8.0, max(3.0, 1.2 + _ROW * rows)), layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    if summary.tuned is None:
        _draw_groups(axes, summary.groups)
        total = summary.groups[0]
        axes.set_title(
            f'{summary.spec.name}: {total.succeeded} of {total.walks} walks arrived without a fall '
            f'or contact',
            fontsize=10,
        )
    else:
        _draw_tuning(axes, summary.tuned)
        axes.set_title(f'{summary.spec.name}: cost of the candidates', fontsize=10)
    with whole_file(path, 'picture') as beside:
        figure.savefig(beside, dpi=150)


def _draw_groups(axes: Axes, groups: tuple[Group, ...]) -> None:
    labels = []
    for row, group in enumerate(groups):
        low, high = (100.0 * bound for bound in group.interval)
        part = 100.0 * group.succeeded / group.walks if group.walks else float('nan')
        color = _BLUE if group.succeeded == group.walks else _RED
        axes.plot([low, high], [row, row], color=color, linewidth=2.0)
        axes.plot([part], [row], 'o', color=color, markersize=4)
        name = f'{group.name} {group.value}' if group.name else group.value
        labels.append(f'{name} ({group.succeeded} of {group.walks})')
    axes.set_yticks(range(len(groups)), labels, fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel('walks that succeed, and 95 % interval [%]')
    axes.grid(axis='x', color='#dddddd')


def _draw_tuning(axes: Axes, tuned: Tuned) -> None:
    best, so_far = [], 1.0
    for number, costs in enumerate(tuned.history, 1):
        shown = [min(cost, _WORST_SHOWN) for cost in costs]
        axes.plot([number] * len(shown), shown, '.', color=_GRAY, markersize=4)
        so_far = min(so_far, *costs)
        best.append(so_far)
    axes.axhline(1.0, color=_RED, linewidth=1.0, label='derived numbers')
    axes.plot(range(1, len(best) + 1), best, color=_BLUE, label='best so far')
    axes.set_xlabel('generation')
    axes.set_ylabel('weighted figures over those untuned')
    axes.legend(fontsize=8)
    axes.grid(color='#dddddd')
