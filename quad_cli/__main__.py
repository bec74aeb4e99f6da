"""
Starts the ``quadwalk`` command: signals count from here, before anything large is imported.
"""

from __future__ import annotations

from quad_common.process.early_signals import end_command_at_once

end_command_at_once()

import contextlib  # noqa: E402
import sys  # noqa: E402

from quad_common.process.end_signals import (  # noqa: E402
    EndSignals,
    Interrupted,
    Raises,
    end_process,
    ended_by,
    ignore_signals,
)

_PATIENCE = 4.5
"""Time for nodes, worker processes and recordings to end after a signal [s]."""


def main(args: list[str] | None = None) -> int:
    """
    Run the command in a process of its own.

    Parameters
    ----------
    args : list of str, optional
        Arguments; those of the process if not given.

    Returns
    -------
    int
        The command's exit code; 128 and the number of the signal that ended it.
    """
    signals = EndSignals(Raises(), lambda number: 128 + number, _PATIENCE)
    code = 1
    try:
        signals.install()
        from quad_cli.main import main as run

        code = run(args)
    except BaseException as error:
        if not signals.noted and not isinstance(error, Interrupted):
            raise
    # A closed terminal adds errors of its own to what its signal has raised.
    if signals.noted:
        with contextlib.suppress(OSError, ValueError):
            print(ended_by(signals.noted[0]), file=sys.stderr)
        end_process(128 + signals.noted[0])
    ignore_signals()
    return code


if __name__ == '__main__':
    raise SystemExit(main())
