"""Contestants in turns: every round each of them flies the batch once, in its own process."""

import json
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.course import SUBSTEPS, Course
from benchmarks.peers.contestant import Contestant
from benchmarks.peers.environments import ROOT, worker_environment

MIN_PERIODS = 5
"""Shorter flights would measure how a flight starts."""


@dataclass
class Runner:
    """A contestant's process; results of each batch in the order of the rounds, or the reason why there are none.

    messages: file of its standard error.
    """

    contestant: Contestant
    process: subprocess.Popen[str]
    messages: Path
    rounds: dict[int, list[dict[str, Any]]] = field(default_factory=dict)
    failed: dict[int, str] = field(default_factory=dict)

    @classmethod
    def begin(cls, contestant: Contestant, python: str, course: Path, scratch: Path) -> "Runner":
        """Start the process."""
        command = [python, "-m", "benchmarks.peers.worker", contestant.name, str(course), str(scratch)]
        messages = scratch / f"{contestant.name}.messages"
        with messages.open("w") as stderr:
            process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stderr,
                text=True,
                cwd=ROOT,
                env=worker_environment(),
            )
        return cls(contestant, process, messages)

    def fly(self, batch: int, periods: int) -> None:
        """Fly a batch once and keep what it took."""
        assert self.process.stdin is not None and self.process.stdout is not None
        try:
            self.process.stdin.write(json.dumps({"batch": batch, "periods": periods}) + "\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline()
            answer = json.loads(line) if line else {"error": self._last_message()}
        except BrokenPipeError:
            answer = {"error": self._last_message()}
        except ValueError as error:
            answer = {"error": str(error)}
        if "error" in answer:
            self.failed[batch] = answer["error"]
        else:
            self.rounds.setdefault(batch, []).append(answer)

    def _last_message(self) -> str:
        """Return the last line that a process that ended wrote to standard error."""
        self.process.wait(timeout=60)
        lines = self.messages.read_text(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"the process ended with code {self.process.returncode}"

    def end(self) -> None:
        """Close the process."""
        try:
            self.process.communicate(timeout=60)
        except BrokenPipeError:
            self.process.wait(timeout=60)


def periods_of(contestant: Contestant, batch: int, course: Course) -> int:
    """Return how many control periods a contestant flies of a batch, so that a round takes it a second or so."""
    wanted = contestant.budget // (batch * SUBSTEPS)
    return max(MIN_PERIODS, min(course.periods, contestant.periods, wanted))


def race(runners: list[Runner], batches: list[int], rounds: int, course: Course, told: Callable[[str], None]) -> None:
    """Let all contestants fly all batches, in turns; told(what) is called after every round."""
    for batch in batches:
        for number in range(rounds):
            for runner in runners:
                if batch <= runner.contestant.largest and batch not in runner.failed:
                    runner.fly(batch, periods_of(runner.contestant, batch, course))
            told(f"batch {batch}: round {number + 1} of {rounds}")
