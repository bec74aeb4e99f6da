"""
A real browser without a window: Chromium, driven by its DevTools protocol.
"""

from __future__ import annotations

import base64
import contextlib
import itertools
import json
import shutil
import subprocess
import threading
import time
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any
from urllib.parse import urlsplit

from quad_common.errors import MissingOptionalDependency, QuadError
from quad_common.process.end_signals import blocked_signals, released_at_last, shielded
from quad_common.process.temporary_folder import temporary_folder
from quad_lab.tools.workers import end_with_parent

NAMES = ('chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable')
"""What the program is called."""

_TIMEOUT = 120.0
"""For anything that is waited for [s]: a busy machine takes a minute to show the first page."""

_SHORT_WAIT = 0.05
"""Between two looks [s]."""

_SETTLING = 0.3
"""What stands still for so long has its place [s]."""

_SHIFT = 8
"""Number of the key in the protocol."""

_ARGUMENTS = (
    '--headless=new',
    '--no-sandbox',
    '--no-first-run',
    '--disable-extensions',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
    '--disable-dev-shm-usage',
    '--hide-scrollbars',
    '--use-gl=angle',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    '--remote-debugging-port=0',
    'about:blank',
)


@dataclass(eq=False, repr=False)
class BrowserFailed(QuadError):
    """The browser did not do what it was asked to."""

    what: str
    """What was waited for, as a clause."""

    def sentence(self) -> str:
        """Say what was waited for."""
        return f'the browser: {self.what}'


def find_chromium() -> str | None:
    """Return the path of the program; None if there is none."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


class Chromium:
    """
    One page of a browser, for as long as the block runs.

    Parameters
    ----------
    size : tuple of int
        Width and height of the page [pixels].
    pixel_ratio : float
        Pixels that are drawn along one of the page. Most of a page's time goes into drawing a
        scene without a graphics card, and with 0.25 that is a sixteenth.

    Raises
    ------
    MissingOptionalDependency
        If there is no Chromium, or the package websockets is missing.
    """

    def __init__(self, size: tuple[int, int] = (1280, 800), pixel_ratio: float = 1.0) -> None:
        program = find_chromium()
        if program is None:
            raise MissingOptionalDependency('chromium', 'sudo apt install chromium')
        try:
            from websockets.sync.client import connect
        except ImportError as error:
            raise MissingOptionalDependency('websockets', 'pip install websockets') from error
        self.problems: list[str] = []
        """Errors on the page's console, and errors that nothing on it has caught."""
        self.requests: list[str] = []
        """Addresses that the page has asked for."""
        self._numbers = itertools.count(1)
        self._answers: dict[int, dict[str, Any]] = {}
        self._received = threading.Condition()
        self._stack = contextlib.ExitStack()
        try:
            profile = self._stack.enter_context(temporary_folder())
            self._process = self._start(program, profile, size)
            self._socket = connect(
                self._page_address(profile), max_size=None, open_timeout=_TIMEOUT
            )
        except BaseException:
            self._end()
            raise
        threading.Thread(target=self._listen, name='chromium', daemon=True).start()
        for domain in ('Page', 'Runtime', 'Network', 'Log'):
            self.command(f'{domain}.enable')
        width, height = size
        self.command(
            'Emulation.setDeviceMetricsOverride',
            width=width, height=height, deviceScaleFactor=pixel_ratio, mobile=False,
        )  # fmt: skip

    def __enter__(self) -> Chromium:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with shielded():
            self._end()

    def command(self, method: str, **parameters: object) -> dict[str, Any]:
        """Send a command of the protocol and return its result; BrowserFailed if it has none."""
        number = next(self._numbers)
        self._socket.send(json.dumps({'id': number, 'method': method, 'params': parameters}))
        with self._received:
            if not self._received.wait_for(lambda: number in self._answers, _TIMEOUT):
                raise BrowserFailed(f'no answer to {method} within {_TIMEOUT:.0f} s')
            answer = self._answers.pop(number)
        if 'error' in answer:
            raise BrowserFailed(f'{method}: {answer["error"]}')
        result: dict[str, Any] = answer['result']
        return result

    def prepare(self, script: str) -> None:
        """Have a script run in every page, before its own."""
        self.command('Page.addScriptToEvaluateOnNewDocument', source=script)

    def open(self, address: str) -> None:
        """Go to a page."""
        self.command('Page.navigate', url=address)

    def evaluate(self, expression: str) -> Any:
        """Return the value of an expression of JavaScript, as JSON has it."""
        answer = self.command(
            'Runtime.evaluate', expression=expression, returnByValue=True, awaitPromise=True
        )
        if 'exceptionDetails' in answer:
            raise BrowserFailed(f'{expression}: {answer["exceptionDetails"]}')
        return answer['result'].get('value')

    def wait_for(self, expression: str, timeout: float = _TIMEOUT) -> Any:
        """Wait until an expression is true; return its value."""
        deadline = time.monotonic() + timeout
        reason = 'it is false'
        while time.monotonic() < deadline:
            # A page that is only beginning has no body, for example.
            try:
                value = self.evaluate(expression)
            except BrowserFailed as error:
                value, reason = None, str(error)
            if value:
                return value
            time.sleep(_SHORT_WAIT)
        raise BrowserFailed(f'within {timeout:.0f} s never true: {expression} ({reason})')

    def text(self) -> str:
        """Return what can be read on the page."""
        return str(self.evaluate('document.body.innerText'))

    def press(self, x: float, y: float, shift: bool = False) -> None:
        """Press the left button at a place of the page [pixels]."""
        self._mouse('mouseMoved', x, y, shift, 0)
        self._mouse('mousePressed', x, y, shift, 1)

    def release(self, x: float, y: float, shift: bool = False) -> None:
        """Let the left button go."""
        self._mouse('mouseReleased', x, y, shift, 0)

    def click(self, x: float, y: float) -> None:
        """Click at a place of the page [pixels]."""
        self.press(x, y)
        self.release(x, y)

    def drag(self, start: tuple[float, float], end: tuple[float, float], shift: bool) -> None:
        """Drag from one place of the page to another, in steps [pixels]."""
        self.press(*start, shift)
        steps = 10
        for k in range(1, steps + 1):
            x, y = (a + (b - a) * k / steps for a, b in zip(start, end, strict=True))
            self._mouse('mouseMoved', x, y, shift, 1)
            time.sleep(_SHORT_WAIT)
        self.release(*end, shift)

    def place_of(self, text: str) -> tuple[float, float]:
        """Return the middle of the smallest element that begins with a text [pixels]."""
        find = f"""(() => {{
                const found = [...document.querySelectorAll('button, [role=tab], label, p, div')]
                    .filter(e => e.innerText && e.innerText.trim().startsWith({json.dumps(text)}))
                    .map(e => e.getBoundingClientRect())
                    .filter(r => r.width > 0 && r.height > 0)
                    .sort((a, b) => a.width * a.height - b.width * b.height)[0];
                return found && [found.x + found.width / 2, found.y + found.height / 2];
            }})()"""
        # A page that is still arranged moves what is pointed at.
        place, before = self.wait_for(find), None
        while place != before:
            time.sleep(_SETTLING)
            place, before = self.wait_for(find), place
        return float(place[0]), float(place[1])

    def key(self, letter: str) -> None:
        """Press a letter's key and let it go."""
        code, number = f'Key{letter.upper()}', ord(letter.upper())
        for kind in ('keyDown', 'keyUp'):
            self.command(
                'Input.dispatchKeyEvent',
                type=kind, key=letter.lower(), code=code, windowsVirtualKeyCode=number,
                text=letter.lower() if kind == 'keyDown' else '',
            )  # fmt: skip

    def screenshot(self, path: Path) -> None:
        """Write a picture of the page, a PNG."""
        picture = self.command('Page.captureScreenshot', format='png')
        path.write_bytes(base64.b64decode(picture['data']))

    def hosts(self) -> set[str]:
        """Return the hosts that the page has asked for anything."""
        inside = ('data', 'blob', 'about')
        parts = [urlsplit(request) for request in self.requests]
        return {part.hostname or '' for part in parts if part.scheme not in inside}

    def _mouse(self, kind: str, x: float, y: float, shift: bool, buttons: int) -> None:
        pressed: dict[str, object] = {} if kind == 'mouseMoved' else {'clickCount': 1}
        self.command(
            'Input.dispatchMouseEvent',
            type=kind, x=x, y=y, modifiers=_SHIFT if shift else 0, buttons=buttons,
            button='none' if kind == 'mouseMoved' and not buttons else 'left', **pressed,
        )  # fmt: skip

    def _start(self, program: str, profile: Path, size: tuple[int, int]) -> subprocess.Popen[bytes]:
        width, height = size
        command = [program, f'--user-data-dir={profile}', f'--window-size={width},{height}']
        with shielded(), blocked_signals():
            process = subprocess.Popen(
                [*command, *_ARGUMENTS],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                preexec_fn=end_with_parent,
            )
        self._stack.enter_context(released_at_last(process.kill))
        return process

    def _page_address(self, profile: Path) -> str:
        """Wait for the browser; return where its page is driven."""
        deadline = time.monotonic() + _TIMEOUT
        ports = profile / 'DevToolsActivePort'
        while time.monotonic() < deadline:
            with contextlib.suppress(OSError, IndexError, StopIteration, ValueError):
                port = int(ports.read_text(encoding='ascii').splitlines()[0])
                with urllib.request.urlopen(f'http://127.0.0.1:{port}/json/list') as answer:
                    pages = json.load(answer)
                page = next(page for page in pages if page['type'] == 'page')
                return str(page['webSocketDebuggerUrl'])
            if self._process.poll() is not None:
                raise BrowserFailed(f'it ended with code {self._process.returncode}')
            time.sleep(_SHORT_WAIT)
        raise BrowserFailed(f'it was not there within {_TIMEOUT:.0f} s')

    def _listen(self) -> None:
        """Take answers and events until the connection ends."""
        events: dict[str, Callable[[dict[str, Any]], None]] = {
            'Runtime.consoleAPICalled': self._on_console,
            'Runtime.exceptionThrown': lambda said: self.problems.append(
                str(said['exceptionDetails'].get('exception', said['exceptionDetails']))
            ),
            'Log.entryAdded': self._on_log,
            'Network.requestWillBeSent': lambda said: self.requests.append(said['request']['url']),
            'Network.webSocketCreated': lambda said: self.requests.append(said['url']),
        }
        for text in self._socket:
            message = json.loads(text)
            if 'id' in message:
                with self._received:
                    self._answers[message['id']] = message
                    self._received.notify_all()
            elif message['method'] in events:
                events[message['method']](message['params'])

    def _on_console(self, said: dict[str, Any]) -> None:
        if said['type'] in ('error', 'assert'):
            self.problems.append(' '.join(str(a.get('value', a)) for a in said['args']))

    def _on_log(self, said: dict[str, Any]) -> None:
        if said['entry']['level'] == 'error':
            self.problems.append(said['entry']['text'])

    def _end(self) -> None:
        """End the browser, and remove its profile."""
        if hasattr(self, '_socket'):
            self._socket.close()
        process = getattr(self, '_process', None)
        if process is not None:
            process.terminate()
            try:
                process.wait(5.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._stack.close()
