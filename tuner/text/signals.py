"""Ctrl-C and SIGTERM: one line, the exit code of the signal, within a bounded time, wherever the signal lands.

An exception that is raised inside an import leaves modules half made, and threads that wait for them wait for ever; one inside a
model of pydantic is taken for a value that does not fit. So a signal that comes there waits until they are done. And
whatever becomes of it, a watchdog ends the process after `PATIENCE`. Imports little, because it is in place before everything
else.
"""

import _thread
import atexit
import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import FrameType
from typing import Any, NoReturn

SIGNALLED = 128
"""Exit code of an end by a signal, less the number of the signal."""
CRASHED = 70
"""Exit code of an error of the tool itself (EX_SOFTWARE of sysexits.h): no verdict has it."""
INTERRUPTED = SIGNALLED + signal.SIGINT
TERMINATED = SIGNALLED + signal.SIGTERM
PATIENCE = 3.0
"""Time from a signal to the end of the process, at most [s]."""
RETRY = 0.02
"""Time after which a signal is raised again that could not be taken where it came [s]."""
END = threading.RLock()
"""Held by the thread that ends the process: others, which the same signal reached, print nothing."""
SWALLOWING = ("<frozen importlib._bootstrap>", f"{os.sep}pydantic{os.sep}")
"""Parts of the names of files whose code makes something else of an exception: half a module, another branch of a union."""

ENDINGS: list[BaseException] = []
"""Exceptions of signals, held to the end: destructors of half-made objects in their frames raise errors or free memory twice."""


class Interrupted(BaseException):
    """A signal that asks this process to end; no KeyboardInterrupt, which the libraries of the command line take for theirs."""

    def __init__(self, number: int) -> None:
        self.number = number
        super().__init__(signal.Signals(number).name)


class Signals:
    """Turns Ctrl-C and SIGTERM into `Interrupted` while it is entered; a second one ends the process where it stands.

    number: of the signal that came, None before; it stays, whatever became of the exception. Outside the main thread, and for
    signals that are ignored, nothing changes.
    """

    def __init__(self) -> None:
        self.number: int | None = None
        self._is_open = False
        self._is_retried = False
        self._retries = 0
        self._pipe: int | None = None
        self._before: dict[int, Any] = {}
        self._hook = sys.unraisablehook

    def __enter__(self) -> "Signals":
        self._is_open = True
        if threading.current_thread() is threading.main_thread():
            self._hook, sys.unraisablehook = sys.unraisablehook, self._retry_unraisable
            for number in (signal.SIGINT, signal.SIGTERM):
                if signal.getsignal(number) is not signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._interrupt)
        return self

    def __exit__(self, *_: object) -> None:
        self._is_open = False
        for number, handler in self._before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        if self._pipe is not None:
            signal.set_wakeup_fd(-1)
            os.close(self._pipe)
            self._pipe = None
        sys.unraisablehook = self._hook

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if self.number is None:
            end_after(PATIENCE, number, lambda: self._is_open)
            self._end_at_next(number)
        elif not self._is_retried:
            end_now(number)
        self.number, self._is_retried = number, False
        if is_swallowed(frame):
            self._retry(number)
        else:
            raise Interrupted(number)

    def _end_at_next(self, number: int) -> None:
        """Have a thread end the process at the next signal.

        Python's handlers run in the main thread, which may have begun to wait just after the signal came. On Windows only
        they run: there a pipe cannot be listened to.
        """
        with suppress(AttributeError, OSError, ValueError):
            reader, self._pipe = os.pipe()
            os.set_blocking(self._pipe, False)
            signal.set_wakeup_fd(self._pipe, warn_on_full_buffer=False)
            _thread.start_new_thread(self._read_signals, (reader, number))

    def _read_signals(self, reader: int, number: int) -> None:
        """Read a byte for each signal until the pipe is closed; end the process at one that is no retry."""
        while os.read(reader, 1):
            if self._retries:
                self._retries -= 1
            elif self._is_open:
                end_now(number)
        os.close(reader)

    def _retry_unraisable(self, unraisable: Any) -> None:
        """Resend a signal raised in an uncatchable place, such as a destructor."""
        if isinstance(unraisable.exc_value, Interrupted):
            self._retry(unraisable.exc_value.number)
        else:
            self._hook(unraisable)

    def _retry(self, number: int) -> None:
        self._is_retried = True
        self._retries += self._pipe is not None
        _later(RETRY, lambda: self._is_open and os.kill(os.getpid(), number))


def is_swallowed(frame: FrameType | None) -> bool:
    """Return True for frames of imports or pydantic models; they would swallow an exception."""
    while frame is not None:
        if any(part in frame.f_code.co_filename for part in SWALLOWING):
            return True
        frame = frame.f_back
    return False


def end_now(number: int, frame: FrameType | None = None) -> None:
    """Print one line and end the process where it stands: a handler of a signal before and after a command's own work."""
    if END.acquire(timeout=PATIENCE):
        with suppress(OSError):
            os.write(2, b"Interrupted.\n")
    os._exit(SIGNALLED + number)


def end_after(seconds: float, number: int, is_wanted: Callable[[], bool]) -> None:
    """End the process after `seconds` as if by a signal; if `is_wanted` then."""
    _later(seconds, lambda: is_wanted() and end_now(number))


def end_without_joining(code: int) -> NoReturn:
    """End an interrupted process: what was registered for the end is done, threads that are at work are not waited for.

    The interpreter's own end joins threads that may wait for each other, and aborts where another is inside of C++.
    """
    end_after(PATIENCE, code - SIGNALLED, lambda: True)
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def end_at_interrupts() -> None:
    """Let Ctrl-C end this process with one line, unless handled or ignored."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, end_now)


def _later(seconds: float, do: Callable[[], object]) -> None:
    """Call a function after so many seconds; no `threading.Timer`, whose locks the interrupted code may hold."""

    def wait() -> None:
        time.sleep(seconds)
        do()

    _thread.start_new_thread(wait, ())
