"""
Draws survival curves: which part of pushes a robot survives, over how hard they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.files.whole_file import whole_file
from quad_lab.balance.pushes import HARDEST_PUSH, Survival

_COLORS = ('#1f4fd8', '#2a9d3a', '#d62728', '#e08a00', '#7b3fb5', '#444444')

_DPI = 110


def draw_survival(path: Path, columns: Mapping[str, Sequence[Survival]]) -> None:
    """
    Draw survival curves.

    Parameters
    ----------
    path : Path
        Where the picture goes; its ending says in which format.
    columns : mapping
        Robots beside one another, by what is said above them. The first row is over the impulse,
        the second one over the velocity that the body had gained when the push ended.
    """
    figure = Figure(figsize=(4.2 * len(columns), 6.4), layout='constrained')
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(columns), sharey=True, sharex='row', squeeze=False)
    for column, (title, found) in enumerate(columns.items()):
        impulse, gained = axes[:, column]
        for one, color in zip(found, _COLORS):
            name = _name_of(one)
            _draw(impulse, np.array(one.impulses), color, name)
            _draw(gained, np.array(one.gained), color, name)
        impulse.set_title(title, fontsize=10)
        impulse.set_xlabel('impulse over m sqrt(g h)')
        gained.set_xlabel('velocity gained by the body, over sqrt(g h)')
        impulse.set_xlim(0.0, HARDEST_PUSH)
        gained.set_xlim(left=0.0)
        for each in (impulse, gained):
            each.axhline(90.0, color='#bbbbbb', linewidth=0.8)
            each.grid(color='#eeeeee')
    axes[0, 0].legend(fontsize=8, loc='lower left')
    for row in axes[:, 0]:
        row.set_ylabel('pushes survived [%]')
        row.set_ylim(0.0, 103.0)
    with whole_file(path, 'picture') as beside:
        figure.savefig(beside, dpi=_DPI)


def _name_of(one: Survival) -> str:
    period = '' if one.case.period is None else f', {one.case.period:g} s'
    return f'{one.case.robot}{period}'


def _draw(axes: Axes, hardest: NDArray[np.float64], color: str, name: str) -> None:
    """Draw which part survives at least so much; nothing of a robot that fell before."""
    if not len(hardest):
        return
    over = np.concatenate(([0.0], np.sort(hardest)))
    survived = 100.0 * (1.0 - np.arange(len(over)) / len(hardest))
    axes.step(over, survived, where='post', color=color, linewidth=1.4, label=name)
