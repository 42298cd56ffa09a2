"""A worker process from its parent's side: started when it is first asked, ended when it is silent too long, started again after.

An FMU that crashes takes its worker with it and nothing else.
"""

import subprocess
from contextlib import suppress
from threading import Timer
from typing import Any

from plant.errors import InputError
from plant.python_process import python_command
from plant.texts import signal_name
from tuner.extensions.fmu.loop_description import LoopDescription
from tuner.extensions.fmu.messages import Ready, Refused, receive, send

# Seconds in which a worker must have loaded an FMU; some unpack a whole run-time system of their tool.
START = 120.0
PROGRAM = "from tuner.extensions.fmu.worker import main; main()"


class WorkerLostError(Exception):
    """A worker that ended, or was ended, before it answered; the message has the reason."""


class FmuProcess:
    """A process that flies one FMU.

    Args:
        description: Description of the loop.
        loop: Identity of the loop that it must build.
        file: The FMU.
    """

    def __init__(self, description: LoopDescription, loop: str, file: str) -> None:
        self._description, self._loop, self._file = description, loop, file
        self._process: subprocess.Popen[bytes] | None = None

    def ask(self, request: Any, seconds: float) -> Any:
        """Return the answer to a request; WorkerLostError where there is none after so many seconds of the clock on the wall.

        Raises InputError where the FMU cannot be loaded at all.
        """
        if self._process is None:
            self._start()
        return self._answer(request, seconds)

    def close(self) -> None:
        """End the process, if there is one."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            for pipe in (process.stdin, process.stdout):
                with suppress(OSError):
                    pipe.close()  # pyright: ignore[reportOptionalMemberAccess]
            process.wait()

    def _start(self) -> None:
        self._process = subprocess.Popen(
            python_command(PROGRAM),
            cwd=self._description.folder,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        try:
            answer = self._answer(self._description, START)
        except WorkerLostError as error:
            raise InputError(f"{error} while it was loaded; try it in the tool that made it", file=self._file) from None
        if isinstance(answer, Refused):
            self.close()
            raise InputError(f"cannot be loaded: {answer.why}", file=self._file)
        if answer != Ready(self._loop):
            self.close()
            raise InputError(
                "its worker builds another loop; its sources have changed since this process began", file=self._file
            )

    def _answer(self, request: Any, seconds: float) -> Any:
        process, timed_out = self._process, False
        assert process is not None and process.stdin is not None and process.stdout is not None

        def end() -> None:
            nonlocal timed_out
            timed_out = True
            process.kill()

        timer = Timer(seconds, end)
        timer.daemon = True
        timer.start()
        try:
            send(process.stdin, request)
            answer = receive(process.stdout)
        except (EOFError, OSError):
            timer.cancel()
            code = process.wait()
            self.close()
            raise WorkerLostError(f"gave no answer for {seconds:g} s" if timed_out else _ended(code)) from None
        timer.cancel()
        if timed_out:
            self.close()
        return answer


def _ended(code: int) -> str:
    """Say how a process ended by its exit status."""
    if code >= 0:
        return f"ended its process with status {code}"
    return f"crashed ({signal_name(-code)})"
