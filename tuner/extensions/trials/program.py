"""A process that runs trials: it reads a line of JSON for each on its standard input and prints a line with the result.

One trial at a time. If a process ends or exceeds the timeout, its trial counts as failed and the next one starts a new
process; one that never answered anything stops the run. Its standard error is inherited.
"""

import os
import shlex
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Thread
from types import TracebackType

from plant.errors import InputError
from plant.own_code import refuse_program
from plant.texts import signal_name
from tuner.extensions.step_records.json_lines import line_of
from tuner.extensions.trials.answers import MAX_LINE_BYTES, ResultParser
from tuner.extensions.trials.record import Answer, Trial

KEY = "--run"
# Time [s] that a program has to end by itself once its input is closed.
GRACE = 2.0


class TrialProcess:
    """Process of a command line. timeout: largest time of a trial [s], None for no limit."""

    def __init__(self, command: str, timeout: float | None = None) -> None:
        try:
            self._command = shlex.split(command)
        except ValueError as error:
            raise InputError(f"given '{command}': {error}; write a command line", key=KEY) from None
        if not self._command:
            raise InputError('given an empty command; write one, for instance "python my_sim.py"', key=KEY)
        refuse_program(command, KEY)
        if self._command[0] == "python" and shutil.which("python") is None:
            # Debian has python3 alone unless an environment is active.
            self._command[0] = sys.executable
        self._timeout = timeout
        self._process: subprocess.Popen[bytes] | None = None
        self._lines: SimpleQueue[bytes] = SimpleQueue()
        self._answered = False

    def __enter__(self) -> "TrialProcess":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end(kind is None)

    def run(self, trial: Trial, answers: ResultParser) -> None:
        """Run a trial and record its result; InputError where the answer is malformed."""
        line = self._answer(trial)
        if not line:
            reason = self._ending(late=line is None)
            if not self._answered:
                raise InputError(
                    f"{shlex.join(self._command)} {reason} before it answered anything; correct it", key=KEY
                )
            answers.record.tell(Answer(id=trial.id, failed=True, reason=f"the program {reason}"))
            return
        given = answers.add(line, "what the program printed")
        if given.id != trial.id:
            message = f"answered {given.id}, and {trial.id} was asked; answer each line before the next one"
            raise InputError(message, key=KEY)
        self._answered = True

    def _answer(self, trial: Trial) -> bytes | None:
        """Return the program's answer to a trial: empty where it ended, None after the timeout."""
        process = self._started()
        assert process.stdin is not None
        try:
            process.stdin.write(line_of(trial).encode() + b"\n")
            process.stdin.flush()
            return self._lines.get(timeout=self._timeout)
        except OSError:
            return b""
        except Empty:
            return None

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is not None:
            return self._process
        try:
            # In a session of its own, Ctrl-C reaches this process alone, which then ends the other.
            self._process = subprocess.Popen(
                self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
            )
        except OSError as error:
            raise InputError(f"{self._command[0]} cannot be started ({error.strerror}); correct it", key=KEY) from None
        self._lines = SimpleQueue()
        Thread(target=_read, args=(self._process, self._lines), daemon=True).start()
        return self._process

    def _ending(self, late: bool) -> str:
        """End a program without an answer and return the reason in words; late: it still runs."""
        process = self._process
        assert process is not None, "a trial was sent"
        with suppress(subprocess.TimeoutExpired):
            process.wait(0.0 if late else GRACE)
        code = process.returncode
        self._end(False)
        if late:
            return f"gave no answer within {self._timeout:g} s"
        if code is None:
            return "closed its output"
        return f"was ended by {signal_name(-code)}" if code < 0 else f"ended with exit code {code}"

    def _end(self, kindly: bool) -> None:
        """End the program and all that it started; kindly: let it see the end of its input first."""
        process, self._process = self._process, None
        if process is None:
            return
        assert process.stdin is not None and process.stdout is not None
        with suppress(OSError):
            process.stdin.close()
        if kindly:
            with suppress(subprocess.TimeoutExpired):
                process.wait(GRACE)
        with suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _read(process: "subprocess.Popen[bytes]", lines: "SimpleQueue[bytes]") -> None:
    """Queue lines as they come, and an empty one at the end."""
    assert process.stdout is not None
    with process.stdout as out:
        while line := out.readline(MAX_LINE_BYTES + 1):
            if line.strip():
                lines.put(line)
    lines.put(b"")
