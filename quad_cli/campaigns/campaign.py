"""
``quadwalk campaign``: thousands of walks over what varies, kept, and summed up.
"""

from __future__ import annotations

import argparse
import json
import time
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table

from quad_cli.arguments import count_argument, folder_argument
from quad_common.files.bounded_file import check_folder_target, make_folder
from quad_common.files.whole_file import write_text
from quad_common.robot_files.robot_file import load_robot
from quad_lab.campaigns.campaign_picture import draw_campaign
from quad_lab.campaigns.campaign_run import run_campaign
from quad_lab.campaigns.campaign_spec import CampaignSpec
from quad_lab.campaigns.jobs import jobs_of
from quad_lab.campaigns.result_store import ResultStore
from quad_lab.campaigns.spec_file import load_campaign, shipped_campaigns
from quad_lab.campaigns.summary import Summary, markdown, summarise
from quad_lab.campaigns.walk_pool import DaskPool, InProcess, WalkPool, dask_pool
from quad_lab.seeded_walks.gait_changes import changed_gait, gait_text
from quad_lab.seeded_walks.walk_settings import walk_of
from quad_lab.seeded_walks.walk_task import Result, key_of
from quad_lab.tools.criterion import make_console

EXAMPLES = """examples:
  quadwalk campaign reliability
  quadwalk campaign tune_trot --output tuned
  quadwalk campaign my_campaign.yaml --workers 4 --json > summary.json
  quadwalk campaign reliability --scheduler tcp://192.0.2.7:8786
"""

_LINE_EVERY = 10.0
"""Where there is no terminal [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        'campaign', help=f'a campaign file, or one that ships: {", ".join(shipped_campaigns())}'
    )
    parser.add_argument(
        '--output',
        type=folder_argument,
        metavar='FOLDER',
        help='where results go, and where earlier ones are taken from (default: campaigns/ and '
        "the campaign's name)",
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        '--workers', type=count_argument, help='processes (default: one for each processor)'
    )
    where.add_argument(
        '--scheduler',
        default='',
        metavar='ADDRESS',
        help='a scheduler of Dask in place of a cluster of this machine, tcp://host:port',
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the campaign; return 0 if every walk arrived without a fall or contact."""
    console = make_console(stderr=arguments.json)
    spec = load_campaign(arguments.campaign)
    folder = arguments.output or default_folder(spec.name)
    check_folder_target(folder)
    store = ResultStore(folder / 'results')
    try:
        with _pool(spec, store, arguments) as pool:
            if isinstance(pool, DaskPool):
                said = f'workers: {pool.workers}; dashboard: {pool.dashboard or "none"}'
                console.print(said, highlight=False)
            with _bar(console) as bar:
                outcome = run_campaign(spec, store, pool, Shown(console, bar))
    except KeyboardInterrupt:
        console.print(
            f'interrupted: {len(store.results)} results are kept in {folder}; the same command '
            'goes on with the others', highlight=False, markup=False,
        )  # fmt: skip
        return 130
    summary = summarise(spec, outcome)
    _write(folder, summary)
    if arguments.json:
        print(json.dumps(summary.as_dict()))
    else:
        _print(console, summary, folder)
    for job in pool.lost:
        console.print(f'its worker ended each time: the walk of seed {job.seed}; not kept')
    failed = summary.groups[0].walks - summary.groups[0].succeeded
    return 0 if not pool.lost and (summary.tuned is not None or failed == 0) else 1


def _pool(
    spec: CampaignSpec, store: ResultStore, arguments: argparse.Namespace
) -> AbstractContextManager[WalkPool]:
    """Start or join a cluster, unless every walk is there already."""
    if spec.tuning is None and all(key_of(job) in store.results for job in jobs_of(spec)):
        return nullcontext(InProcess())
    return dask_pool(arguments.scheduler, arguments.workers)


def _bar(console: Console) -> Progress:
    columns = TextColumn('{task.fields[state]}'), BarColumn(), TimeRemainingColumn()
    return Progress(*columns, console=console, transient=True, disable=not console.is_terminal)


def _write(folder: Path, summary: Summary) -> None:
    """Write tables, figures, a picture, and a tuned gait."""
    make_folder(folder)
    write_text(folder / 'summary.md', markdown(summary))
    write_text(folder / 'summary.json', json.dumps(summary.as_dict(), indent=1))
    draw_campaign(folder / 'summary.png', summary)
    _write_gait(folder, summary)


def default_folder(name: str) -> Path:
    """Return where the results of a campaign go if nothing else is said."""
    return Path('campaigns') / Path(name).name


@dataclass
class Shown:
    """Shows progress: a bar on a terminal, now and then a line elsewhere."""

    console: Console
    """Where to."""
    bar: Progress
    """The bar."""
    total: int = 0
    """Number of walks."""
    done: int = 0
    """Number that are there."""
    failed: int = 0
    """Number that failed."""
    _known: int = 0
    _began: float = field(default_factory=time.monotonic)
    _said_at: float = field(default_factory=time.monotonic)
    _task: TaskID | None = None

    def begin(self, total: int, known: int) -> None:
        """Take how many walks there are, and how many of them were walked before."""
        self.total, self._known = total, known
        self._began = self._said_at = time.monotonic()
        self._task = self.bar.add_task('', total=total, state='')
        if known:
            self.console.print(f'{known} of {total} walks are there already', highlight=False)

    def advance(self, results: list[Result]) -> None:
        """Take walks that were just walked."""
        self.done += len(results)
        self.failed += sum(not result.figures.succeeded for result in results)
        state = f'{self.done} of {self.total} walks, {self.failed} failed'
        if self._task is not None:
            self.bar.update(self._task, completed=self.done, state=state)
        now = time.monotonic()
        if self.console.is_terminal or now - self._said_at < _LINE_EVERY:
            return
        self._said_at = now
        walked = max(self.done - self._known, 1)
        left = (now - self._began) / walked * max(self.total - self.done, 0)
        self.console.print(f'{state}, {left / 60.0:.0f} min left', highlight=False)


def _write_gait(folder: Path, summary: Summary) -> None:
    """Write a tuned gait as a file, where one gait of one robot was tuned."""
    tuned, spec = summary.tuned, summary.spec
    varied = {'robot', 'gait'} & set(spec.vary)
    if tuned is None or varied or not any(name.startswith('gait.') for name in tuned.numbers):
        return
    walk = walk_of({**spec.fixed, **tuned.numbers})
    robot = load_robot(walk.settings.robot)
    gait = changed_gait(walk.gait_node.gaits(robot)[0], walk.gait_numbers)
    name = f'{Path(walk.settings.robot).stem}_{gait.name}_tuned'
    comment = f'Tuned by quadwalk campaign {spec.name}, for {walk.settings.robot} only.'
    write_text(folder / f'{name}.yaml', gait_text(gait, robot, name, comment))


def _print(console: Console, summary: Summary, folder: Path) -> None:
    columns = ('', 'value', 'walks', 'succeeded', '95 % interval', 'arrived', 'fell', 'contacts')
    table = Table(*columns, title=f'quadwalk campaign {escape(summary.spec.name)}')
    for group in summary.groups:
        low, high = group.interval
        table.add_row(
            group.name, escape(group.value), str(group.walks), str(group.succeeded),
            f'{100.0 * low:.2f} to {100.0 * high:.2f} %', str(group.arrived), str(group.fell),
            str(group.touched),
        )  # fmt: skip
    console.print(table)
    tuned = summary.tuned
    if tuned is not None:
        changes = Table('tuned', 'derived', 'tuned to', title='what was changed, and what it does')
        for name, value in tuned.numbers.items():
            changes.add_row(name, f'{tuned.before[name]:.4g}', f'{value:.4g}')
        for name, (before, after) in tuned.figures.items():
            changes.add_row(name, f'{before:.4g}', f'{after:.4g}')
        changes.add_row('weighted', '1', f'{tuned.cost:.4g}')
        console.print(changes)
    else:
        for failure in summary.failures[:20]:
            console.print(
                f'failed: seed {failure.seed}, {failure.case}: {failure.problem}',
                highlight=False, markup=False,
            )  # fmt: skip
    console.print(f'{folder}: summary.md, summary.png, summary.json, results', highlight=False)
