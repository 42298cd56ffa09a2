"""The server of the page, on the loopback address: the page, its files, and answers as lines of JSON that follow each other."""

import asyncio
import socket
from collections.abc import AsyncIterator, Callable
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import ClientDisconnect, Request
from starlette.responses import HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from plant.errors import InputError, ToolError
from plant.input_files import parse_json
from tuner.extensions.studio.answering import Bench
from tuner.extensions.studio.design import Rules
from tuner.extensions.studio.flights import STAGES
from tuner.extensions.studio.guard import HEADERS, HOST, Door, Guard, TooLongError
from tuner.extensions.studio.messages import PageRequest, read_request, table_of
from tuner.extensions.studio.outputs import Outputs
from tuner.extensions.studio.page import page_text, script, styles
from tuner.extensions.studio.searching import Searches
from tuner.extensions.studio.session import Session
from tuner.extensions.studio.similarity import Similarity
from tuner.extensions.studio.work import Work, line

PROGRESS_SECONDS = 0.4
"""Time [s] between two lines of progress while the page waits."""
STAGES_AFTER = dict(zip(STAGES, (0.0, 0.15, 0.05), strict=True))
"""Flights of a stage -> time [s] that a setting rests before they begin."""
LINES = "application/x-ndjson"


class Studio:
    """The application: answers of a study, its door, and files that may be written."""

    def __init__(self, work: Work, door: Door, outputs: Outputs) -> None:
        self.work, self.door, self.outputs = work, door, outputs
        session = work.bench.session
        self.rules = Similarity(session) if session.has_rotors else Rules(session)
        self.searches = Searches(work.bench, outputs.place)

    def app(self) -> Guard:
        """Return the application behind its guard."""
        routes = [
            Route("/", self.page),
            Route("/studio.js", lambda _: _file(script(), "text/javascript")),
            Route("/studio.css", lambda _: _file(styles(), "text/css")),
            Route("/plotly.js", lambda _: _packed("plotly-cartesian.min.js.gz")),
            Route("/open", self.open, methods=["POST"]),
            Route("/answer", self.answer, methods=["POST"]),
            Route("/design", self._written(self.rules.designed), methods=["POST"]),
            *[
                Route(f"/{name}", self._written(getattr(self.outputs, name)), methods=["POST"])
                for name in ("save", "export", "study", "judge", "compare")
            ],
            Route("/search", self._written(self.searches.start), methods=["POST"]),
            Route("/search-state", self._aside(self.searches.state), methods=["POST"]),
            Route("/search-stop", self._aside(self.searches.stop), methods=["POST"]),
        ]
        errors: dict[Any, Callable[..., Any]] = {
            ToolError: _failing(400),
            TooLongError: _failing(413, "The message is too long."),
            ClientDisconnect: _failing(499),
        }
        return Guard(Starlette(routes=routes, exception_handlers=errors), self.door)

    def close(self) -> None:
        """End a search, and drop what is waiting."""
        self.searches.close()
        self.work.close()

    async def page(self, _: Request) -> Response:
        """Return the page."""
        return HTMLResponse(page_text(self.work.bench.session, self.door.query), headers=self.door.headers)

    async def open(self, request: Request) -> Response:
        """Return the description of the study, behind lines of progress."""
        await message_of(request)
        return self._lines(
            self._waited(lambda: line(self.work.open() | self.outputs.offers | {"design": self.rules.offers}))
        )

    async def answer(self, request: Request) -> Response:
        """Return the answers to a setting, one line for each stage."""
        message = await message_of(request)
        page_request = self.work.checked(message)
        return self._lines(self._answers(page_request))

    def _written(self, write: Callable[[PageRequest, dict[str, Any]], Any]) -> Callable[[Request], Any]:
        """Return the end point of a file that a setting leaves."""

        async def made(request: Request) -> Response:
            message = await message_of(request)
            page_request = read_request(self.work.bench.session, [], message)
            return self._lines(self._waited(lambda: line(write(page_request, message))))

        return made

    def _aside(self, task: Callable[[Any], Any]) -> Callable[[Request], Any]:
        """Return the end point of a task next to the answers."""

        async def made(request: Request) -> Response:
            message = table_of(await message_of(request), "message")
            return JSONResponse(await run_in_threadpool(task, message), headers=dict(HEADERS))

        return made

    def _lines(self, lines: AsyncIterator[str]) -> Response:
        return StreamingResponse(lines, media_type=LINES, headers=dict(HEADERS))

    async def _answers(self, page_request: PageRequest) -> AsyncIterator[str]:
        for count, rest in STAGES_AFTER.items():
            # Flights that only a hand at rest waits for would hold up the next move.
            await asyncio.sleep(rest)
            stale = True
            async for text in self._waited(lambda count=count: self.work.stage(page_request, count)):
                if text is not None:
                    yield text
                    stale = False
            if stale:
                return

    async def _waited(self, task: Callable[[], str | None]) -> AsyncIterator[Any]:
        """Yield lines of progress during a task, then its line."""
        future, latest = self.work.submit(task), ""
        waiting = asyncio.wrap_future(future)
        try:
            while not (await asyncio.wait([waiting], timeout=PROGRESS_SECONDS))[0]:
                if self.work.notes.text != latest:
                    latest = self.work.notes.text
                    yield line({"progress": latest})
            yield waiting.result()
        except ToolError as error:
            yield line({"error": str(error)})
        finally:
            # A closed page drops a task that has not begun.
            waiting.cancel()


async def message_of(request: Request) -> Any:
    """Return the JSON of a request; InputError where it is none."""
    if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
        raise InputError("a message is JSON", key="content-type")
    body = await request.body()
    try:
        return parse_json(body.decode("utf-8"))
    except ValueError as error:
        raise InputError("the message is no JSON in UTF-8") from error


def _file(text: str, kind: str) -> Response:
    return Response(text, media_type=kind, headers=dict(HEADERS))


@cache
def _packed(name: str) -> Response:
    packed = files("tuner.report").joinpath("plotly", name).read_bytes()
    return Response(packed, media_type="text/javascript", headers={**HEADERS, "Content-Encoding": "gzip"})


def _failing(code: int, text: str = "") -> Callable[..., Any]:
    """Return the handler of an error; text: by default that of the error."""

    async def failed(_: Request, error: Exception) -> Response:
        return JSONResponse({"error": text or str(error)}, status_code=code, headers=dict(HEADERS))

    return failed


def bound_socket(port: int) -> socket.socket:
    """Return a socket that listens on the loopback address; port: 0 for a free one. InputError where it is taken."""
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        # A browser that is opened first waits for the server.
        listening.listen()
    except OSError as error:
        listening.close()
        raise InputError(
            f"given {port}, which cannot be used ({error.strerror}); choose another port", key="--port"
        ) from None
    return listening


def opened_page(
    session: Session,
    out: Path,
    present: Path | None = None,
    port: int = 0,
    threads: int | None = None,
    embeds: bool = False,
) -> tuple[Studio, socket.socket]:
    """Return the application of a session and its socket; arguments are those of the command.

    embeds: whether a notebook may frame the page.
    """
    listening = bound_socket(port)
    door = Door(listening.getsockname()[1], embeds=embeds)
    bench = Bench.of(session, threads)
    return Studio(Work(bench), door, Outputs(bench, out, present)), listening


def server_of(studio: Studio) -> uvicorn.Server:
    """Return a server that logs neither addresses nor requests."""
    config = uvicorn.Config(
        studio.app(),
        log_level="error",
        access_log=False,
        server_header=False,
        lifespan="off",
        timeout_graceful_shutdown=2,
    )
    return uvicorn.Server(config)
