"""Work behind the page: one answer at a time, in stages, and none that a newer request has overtaken."""

import json
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from time import perf_counter, process_time
from typing import Any

from tuner.experiments.tuning.problem import warm_up
from tuner.extensions.studio.answering import Bench, answer, opening
from tuner.extensions.studio.messages import PageRequest, read_request
from tuner.search.watcher import Watcher

MAX_PAGES = 16
"""Pages whose latest number is kept."""


class Notes(Watcher):
    """Watcher that keeps the latest message for the page."""

    def __init__(self) -> None:
        self.text = ""

    def on_message(self, text: str) -> None:
        """Keep it."""
        self.text = text

    def on_compile_start(self) -> None:
        """Say that flights wait for the compiler."""
        self.text = "Compiling the closed loop for this machine: once, 10 to 60 s."

    def on_compile_end(self, seconds: float) -> None:
        """Say how long it took."""
        self.text = f"Compiled in {seconds:.0f} s."


class Latest:
    """Largest request number of each page: an answer to a smaller one is stale."""

    def __init__(self) -> None:
        self._guard = Lock()
        self._numbers: dict[str, int] = {}

    def take(self, request: PageRequest) -> None:
        """Note a request."""
        with self._guard:
            self._numbers[request.page] = max(request.number, self._numbers.pop(request.page, -1))
            while len(self._numbers) > MAX_PAGES:
                del self._numbers[next(iter(self._numbers))]

    def is_stale(self, request: PageRequest) -> bool:
        """Return True where the page has sent something newer."""
        with self._guard:
            return self._numbers.get(request.page, request.number) > request.number


class Work:
    """Answers of a bench, one at a time in a thread."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.notes, self.latest = bench, Notes(), Latest()
        self._pool = ThreadPoolExecutor(1, "studio")
        self._warmed = False

    def close(self) -> None:
        """Drop what is waiting."""
        self._pool.shutdown(wait=False, cancel_futures=True)

    def submit(self, task: Callable[[], Any]) -> Any:
        """Return the future of a task, behind those that wait."""
        return self._pool.submit(task)

    def open(self) -> dict[str, Any]:
        """Return the description of the study, once all is compiled."""
        self._warm()
        return opening(self.bench)

    def _warm(self) -> None:
        if not self._warmed:
            session = self.bench.session
            self.notes.text = "Reading the study and its loops."
            warm_up(self.bench.flights.problem, session.study, self.notes)
            self.notes.text = ""
            self._warmed = True

    def checked(self, message: Any) -> PageRequest:
        """Return a checked request, noted as the latest of its page."""
        request = read_request(self.bench.session, self.bench.loops.channels, message)
        self.latest.take(request)
        return request

    def stage(self, request: PageRequest, count: int) -> str | None:
        """Return an answer as a line of JSON, None if stale."""
        if self.latest.is_stale(request):
            return None
        self._warm()
        begin, processor = perf_counter(), process_time()
        document = answer(self.bench, request, count)
        document["seconds"] = round(perf_counter() - begin, 4)
        document["processor"] = round(process_time() - processor, 4)
        return line(document)


def line(document: Any) -> str:
    """Return a document as a line of JSON."""
    return json.dumps(document, allow_nan=False, separators=(",", ":")) + "\n"
