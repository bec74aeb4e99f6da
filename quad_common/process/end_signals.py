"""
Signals that end a process: noted from its first line on, bounded in what they take.

A process installs one `EndSignals` before it imports anything large. What a signal does is
the choice of its owner; that the process ends in time is seen to here, by a thread that
notices signals even while the main thread is deep in compiled code.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType

from quad_common.process.early_signals import SIGNALS, hand_over

_AGAIN = 0.02
"""Time until a signal that was swallowed, or has not reached Python, is sent again [s]."""


class Interrupted(KeyboardInterrupt):
    """
    A signal came.

    Parameters
    ----------
    number : int
        The signal's.
    """

    def __init__(self, number: int) -> None:
        self.number = number
        super().__init__(ended_by(number))


def ended_by(number: int) -> str:
    """Say in a few words what ended a process."""
    return 'interrupted' if number == signal.SIGINT else f'ended by {signal.Signals(number).name}'


class EndSignals:
    """
    The signals that this process has had, and the end that they set it.

    Parameters
    ----------
    react : callable
        Called in the main thread with the number of each signal, the object's `noted`
        holding it already.
    exit_code : callable
        Makes the exit code of a signal, for an end that had to be forced.
    patience : float
        Time after the first signal at which the process is ended in any case [s].
    """

    def __init__(
        self, react: Callable[[int], None], exit_code: Callable[[int], int], patience: float
    ) -> None:
        self.noted: list[int] = []
        """The signals that came, in order."""
        self._react = react
        self.patience = patience
        """May be changed; what it is when the first signal comes counts [s]."""
        self._exit_code = exit_code
        self._wakeup: tuple[int, int] | None = None

    def install(self) -> None:
        """Receive signals from now on; those that were blocked meanwhile are handled at once."""
        self._wakeup = os.pipe()
        os.set_blocking(self._wakeup[1], False)
        signal.set_wakeup_fd(self._wakeup[1], warn_on_full_buffer=False)
        hand_over()
        threading.Thread(target=self._watch, name='end_signals', daemon=True).start()
        for number in SIGNALS:
            # As in early_signals: a terminal that nohup has cut off stays cut off.
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._on_signal)
        os.register_at_fork(after_in_child=self._forget)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.noted.append(number)
        self._react(number)

    def _watch(self) -> None:
        """Wait for the first signal, and then as long as the owner may take."""
        assert self._wakeup is not None
        number = 0
        while number not in SIGNALS:
            received = os.read(self._wakeup[0], 1)
            number = received[0] if received else 0
        patience = self.patience
        deadline = time.monotonic() + patience
        while (left := deadline - time.monotonic()) > 0.0:
            time.sleep(min(left, _AGAIN) if not self.noted else left)
            if not self.noted:
                # It came just before the main thread began to wait for something in the kernel,
                # where Python does not look for it: what interrupts the wait is another one.
                signal.pthread_kill(threading.main_thread().ident or 0, number)
        _say(f'did not end within {patience:.1f} s of {_name(number)}: {_whereabouts()}')
        end_process(self._exit_code(number))

    def _forget(self) -> None:
        """Start a forked process without what is its parent's alone."""
        signal.set_wakeup_fd(-1)
        for number in SIGNALS:
            if signal.getsignal(number) == self._on_signal:
                signal.signal(number, signal.SIG_DFL)


_releases: list[Callable[[], object]] = []
"""What must be given back even if the process is ended by force."""

_shields = 0
"""Number of blocks that must not be interrupted just now."""

_waiting: list[int] = []
"""Signals that came meanwhile."""

os.register_at_fork(after_in_child=_releases.clear)


@contextlib.contextmanager
def released_at_last(release: Callable[[], object]) -> Iterator[None]:
    """Have something called if the process is ended by force inside this block."""
    _releases.append(release)
    try:
        yield
    finally:
        _releases.remove(release)


@contextlib.contextmanager
def shielded() -> Iterator[None]:
    """Let no signal raise inside this block; it raises behind it. In other threads none does."""
    global _shields
    if threading.current_thread() is not threading.main_thread():
        # Were they counted, what the main thread is to be told would be raised here.
        yield
        return
    _shields += 1
    try:
        yield
    finally:
        _shields -= 1
        if not _shields and _waiting:
            raise Interrupted(_waiting.pop())


@contextlib.contextmanager
def blocked_signals() -> Iterator[None]:
    """Have what is started here inherit that signals wait until it is ready for them."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Raises:
    """
    A reaction to signals: the first one is raised in the main thread, once.

    What unwinds then gives everything back, and is not to be disturbed by a second signal.
    """

    def __init__(self) -> None:
        self._is_raised = False
        self._hook = sys.unraisablehook
        sys.unraisablehook = self._on_unraisable

    def __call__(self, number: int) -> None:
        """Raise Interrupted, at once or behind the block that must not be interrupted."""
        if self._is_raised:
            return
        self._is_raised = True
        if _shields:
            _waiting.append(number)
        else:
            raise Interrupted(number)

    def _on_unraisable(self, unraisable: sys.UnraisableHookArgs) -> None:
        """Raise again what came where Python swallows exceptions, as in a destructor."""
        if isinstance(unraisable.exc_value, Interrupted):
            self._is_raised = False
            # From another thread, and a little later: here it would be swallowed again.
            again = threading.Timer(_AGAIN, os.kill, (os.getpid(), unraisable.exc_value.number))
            again.daemon = True
            again.start()
        else:
            self._hook(unraisable)


def end_process(code: int) -> None:
    """
    End this process now, without Python's own end, which may wait for threads for long.

    Parameters
    ----------
    code : int
        Exit code.
    """
    for release in reversed(_releases.copy()):
        # The last thing that is done: an error can no longer be reported.
        with contextlib.suppress(Exception):
            release()
    for stream in (sys.stdout, sys.stderr):
        # The terminal may be closed, or whoever read may have gone.
        with contextlib.suppress(Exception):
            stream.flush()
    os._exit(code)


def ignore_signals() -> None:
    """Ignore further signals: while Python ends, it restores the handlers that kill."""
    hook = sys.unraisablehook
    # A signal that comes just now makes Python complain of a race; it is ignored all the same.
    sys.unraisablehook = lambda _: None
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)
    sys.unraisablehook = hook


def _name(number: int) -> str:
    return signal.Signals(number).name


def _whereabouts() -> str:
    """Say in which function the main thread is."""
    frame = sys._current_frames().get(threading.main_thread().ident or 0)
    if frame is None:
        return 'the main thread has ended'
    code = frame.f_code
    return f'it was in {code.co_name} ({code.co_filename}:{frame.f_lineno})'


def _say(sentence: str) -> None:
    with contextlib.suppress(Exception):
        print(sentence, file=sys.stderr)
