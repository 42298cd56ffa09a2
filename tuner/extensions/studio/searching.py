"""A search from the page: the command `tuner run` in a process of its own, whose folder the page watches.

The folder is the one that the command writes, to the byte, because the command writes it. To stop is to interrupt it, as Ctrl-C
does.
"""

import json
import os
import signal
import subprocess
from collections import deque
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock, Thread
from typing import Any

from plant.errors import InputError
from plant.own_code import HAVE_RUN
from plant.python_process import python_command
from tuner.cli.answer import PROGRESS
from tuner.extensions.studio.answering import Bench
from tuner.extensions.studio.messages import PageRequest, whole_number
from tuner.extensions.studio.run_folder import RunFolder
from tuner.store.advice import RECORD

MAX_LINES = 20
"""Lines of the command's messages that are kept."""
MAX_SINCE = 1_000_000
"""Largest number of a generation."""
PATIENCE = 5.0
"""Time [s] that an interrupted command has to end."""
Answer = dict[str, Any]


class Searches:
    """The search of a studio, one at a time; place: checked place of a folder by its name, see `Outputs.place`."""

    def __init__(self, bench: Bench, place: Callable[[Any, str], Path]) -> None:
        self._bench, self._place = bench, place
        self._guard = Lock()
        self._process: subprocess.Popen[str] | None = None
        self._starts: TemporaryDirectory[str] | None = None
        self._stage, self._done, self._total = "", 0, 0
        self._follower: Thread | None = None
        self._messages: deque[str] = deque(maxlen=MAX_LINES)

    def start(self, request: PageRequest, message: Answer) -> Answer:
        """Start `tuner run` into a new folder, from setting or study."""
        folder = self._place(message.get("folder"), "folder")
        if os.path.lexists(folder):
            raise InputError(f"{folder} exists already; give another name", key="folder")
        with self._guard:
            if self.is_running:
                raise InputError("a search is running already; stop it first")
            starts = self._start_file(request) if message.get("from") == "setting" else None
            self._start(command_line(self._bench, folder, starts))
            self._bench.front.run = RunFolder(folder, self._bench.session.study)
        return {"text": f"Started: {folder}"}

    def _start_file(self, request: PageRequest) -> Path:
        """Return a file of the setting, which ends with the studio."""
        self._starts = TemporaryDirectory()
        return self._bench.session.gains(request.settings[0].row).write(Path(self._starts.name) / "gains.json")

    def _start(self, arguments: list[str]) -> None:
        self._stage, self._done, self._total = "", 0, 0
        self._messages.clear()
        self._process = subprocess.Popen(
            python_command("from tuner.__main__ import run; run()", *arguments),
            env=os.environ | {PROGRESS: "json"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
            start_new_session=True,
        )
        self._follower = Thread(target=self._follow, args=(self._process,), daemon=True)
        self._follower.start()

    def _follow(self, process: "subprocess.Popen[str]") -> None:
        """Keep the command's progress and messages until it ends."""
        with process:
            for line in process.stderr or ():
                self._take(line)

    def _take(self, line: str) -> None:
        event = progress_of(line)
        if event is None:
            self._messages.append(line.strip()[:500])
        elif "stage" in event:
            self._stage, self._done, self._total = str(event["stage"]), 0, int(event["flights"])
        else:
            self._done += int(event.get("done", 0))

    @property
    def is_running(self) -> bool:
        """Whether the command works."""
        return self._process is not None and self._process.poll() is None

    def stop(self, *_: Any) -> Answer:
        """Interrupt the command, as Ctrl-C does; its folder can be resumed."""
        process, run = self._process, self._bench.front.run
        if process is None or process.poll() is not None or run is None:
            return {"text": "No search is running."}
        process.send_signal(signal.SIGINT)
        try:
            process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        return {"text": f"Stopped. Continue with: tuner resume {run.path}"}

    def close(self) -> None:
        """End what is running."""
        self.stop()
        if self._follower is not None:
            self._follower.join(PATIENCE)
        if self._starts is not None:
            self._starts.cleanup()

    def state(self, message: Answer) -> Answer:
        """Return stage, flights and new points of the run; since: generations that the page has."""
        since = whole_number(message.get("since", 0), MAX_SINCE, "since")
        run = self._bench.front.run
        if run is None:
            return {"running": False, "generations": 0, "points": {}, "text": ""}
        count, ended = len(run.generations()), run.has_ended
        return {
            "running": self.is_running or (self._process is None and not ended and (run.path / RECORD).exists()),
            "mine": self._process is not None,
            "ended": ended,
            "generations": count,
            "points": run.points(since),
            "text": self._text(run, count, ended),
        }

    def _text(self, run: RunFolder, count: int, ended: bool) -> str:
        total = self._bench.session.study.generations
        if ended:
            return f"The run has ended: {run.path}. Open it with: tuner studio {run.path}"
        if self.is_running:
            flights = f", {self._stage}: {self._done} of {self._total} flights" if self._total else ""
            return f"Generation {count} of {total}{flights}."
        if self._process is not None and self._process.returncode:
            return " ".join(self._messages)[-400:] or "The search was stopped."
        return f"Generation {count} of {total}."


def command_line(bench: Bench, folder: Path, starts: Path | None) -> list[str]:
    """Return the arguments of `tuner` for a search into a folder."""
    study = bench.session.study.path
    # Code of a results folder runs where it was named for this process alone.
    named = (
        [str(entry.file.resolve()) for entry in HAVE_RUN.values()] if (study.parent.parent / RECORD).exists() else []
    )
    code = [word for file in named for word in ("--code", file)]
    begin = [] if starts is None else ["--starts", str(starts)]
    return [*code, "run", str(study), "--out", str(folder), "--json", *begin]


def progress_of(line: str) -> dict[str, Any] | None:
    """Return an event of progress, None for another line."""
    try:
        content = json.loads(line)
    except ValueError:
        return None
    event = content.get("progress") if isinstance(content, dict) else None
    return event if isinstance(event, dict) else None
