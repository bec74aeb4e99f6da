"""
A process that tries cases of the attack on files, and is ended when one takes too long.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import resource
import time
from multiprocessing.connection import Connection
from pathlib import Path
from types import TracebackType

from quad_common.process.temporary_folder import temporary_folder
from quad_lab.attacks.files.argument_cases import warm_up
from quad_lab.attacks.files.file_cases import (
    ARGUMENTS,
    HANG,
    TRACEBACK,
    Fault,
    emptied,
    run_case,
)
from quad_lab.tools.workers import end_with_parent

_START = 120.0
"""For the process to import what it needs [s]."""

_PATIENCE = 10.0
"""Wall clock over the processor's time that is waited for: the machine may have other work."""

_MEMORY = 6 * 2**30
"""Address space of the process: what wants more fails there, and not the machine [bytes]."""


class Worker:
    """
    Tries cases one at a time; use it in a ``with`` block.

    Parameters
    ----------
    seed : int
        Seed of the attack.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        # Spawned: a fork would inherit threads of ROS in the middle of what they do.
        self._context = multiprocessing.get_context('spawn')
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None
        self._is_warm = False
        self._stack = contextlib.ExitStack()
        self.folder = Path()
        """Folder of the cases, in the block."""

    def __enter__(self) -> Worker:
        # One of its own in there: each case empties it, and the other says whose it is.
        self.folder = self._stack.enter_context(temporary_folder()) / 'cases'
        self.folder.mkdir()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._stack:
            self._end()

    def run(self, kind: str, index: int, time_limit: float) -> Fault | None:
        """
        Try a case.

        Parameters
        ----------
        kind : str
            Kind of file.
        index : int
            Number of the case.
        time_limit : float
            Largest time of the processor; more counts as a hang, and so does a case that waits
            for something that does not come [s].

        Returns
        -------
        Fault or None
            None if all went well.
        """
        pipe = self._started()
        if kind == ARGUMENTS and not self._is_warm:
            # Commands import what they need: that is not the time of a case.
            pipe.send(None)
            self._wait(pipe)
            self._is_warm = True
        pipe.send((kind, index))
        try:
            if pipe.poll(_PATIENCE * time_limit):
                fault, spent = pipe.recv()
                answer: Fault | None = fault
                if answer is None and spent > time_limit:
                    sentence = f'it took {spent:.1f} s of the processor'
                    answer = Fault(HANG, kind, self._seed, index, sentence)
                return answer
        except EOFError:
            self._end()
            return Fault(TRACEBACK, kind, self._seed, index, 'the process died')
        self._end()
        waited = f'no end within {_PATIENCE * time_limit:g} s'
        return Fault(HANG, kind, self._seed, index, waited)

    def _started(self) -> Connection:
        """Start the process if there is none, and wait until it is ready."""
        if self._pipe is None:
            self._pipe, other = self._context.Pipe()
            self._process = self._context.Process(
                target=_work, args=(self._seed, self.folder, other), daemon=True
            )
            self._process.start()
            other.close()
            self._wait(self._pipe)
            self._is_warm = False
        return self._pipe

    @staticmethod
    def _wait(pipe: Connection) -> None:
        """Wait until the process is ready."""
        if not pipe.poll(_START):
            raise TimeoutError(f'the process for the attack is not ready after {_START:g} s')
        pipe.recv()

    def _end(self) -> None:
        if self._pipe is not None and self._process is not None:
            self._pipe.close()
            self._process.kill()
            self._process.join()
            self._pipe = self._process = None


def _work(seed: int, folder: Path, pipe: Connection) -> None:
    """Try cases until no more are requested."""
    # A case that hangs must not outlive an attack that is killed.
    end_with_parent()
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    # Decoders complain about damage on stderr by themselves.
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    os.chdir(folder)
    pipe.send('ready')
    while True:
        try:
            case = pipe.recv()
        except EOFError:
            return
        if case is None:
            warm_up()
            pipe.send('ready')
        else:
            kind, index = case
            began = time.process_time()
            fault = run_case(seed, kind, index, emptied(folder))
            pipe.send((fault, time.process_time() - began))
