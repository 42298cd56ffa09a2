"""A command in a process of its own: its progress while it works, and its end by Ctrl-C after a cancellation.

A run that is cancelled leaves the folder that Ctrl-C leaves, which `resume` goes on with.
"""

import json
import math
import os
import signal
import subprocess
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple

import anyio
from anyio.abc import ByteReceiveStream, Process

from plant.own_code import OWN_CODE
from plant.python_process import python_command
from tuner.cli.answer import PROGRESS

PATIENCE = 10.0
"""Time that an interrupted command has to write its files [s]."""

INTERVAL = 0.25
"""Time between reports of one stage [s]."""

MAX_LINES = 200
"""Last lines of standard error that are kept."""
MAX_LETTERS = 2000
"""Letters of each of these lines."""

SEARCHED = ("PATH", "LD_LIBRARY_PATH")
"""Environment variables of folders in which programs and libraries are looked for."""

OnProgress = Callable[[str, int, int], Awaitable[None]]
"""on_progress(stage, flights done, flights expected)."""


class Outcome(NamedTuple):
    """End of a command.

    Attributes:
        code: exit code.
        document: its answer, None where it printed no JSON.
        messages: lines of its standard error that are no progress.
    """

    code: int
    document: Any
    messages: tuple[str, ...]


async def run_command(arguments: Sequence[str], root: Path, allow_code: bool, on_progress: OnProgress) -> Outcome:
    """Run `tuner` with these arguments in a folder; cancellation interrupts it.

    Args:
        arguments: arguments of the command line.
        root: working folder.
        allow_code: whether studies may name Python files and FMUs, which run.
        on_progress: awaited as stages begin and flights end.
    """
    process = await anyio.open_process(
        python_command("from tuner.__main__ import run; run()", *arguments, excluded=root),
        cwd=root,
        env=environment(allow_code),
        stdin=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        output, messages = bytearray(), deque[str](maxlen=MAX_LINES)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(_collect, process.stdout, output)
            tasks.start_soon(_follow, process.stderr, messages, on_progress)
            await process.wait()
    finally:
        with anyio.CancelScope(shield=True):
            await _end(process)
    return Outcome(process.returncode or 0, _document(bytes(output)), tuple(messages))


def environment(allow_code: bool) -> dict[str, str]:
    """Return the environment of a command; an empty or relative folder to search would be the root."""
    absolute = {
        name: os.pathsep.join(filter(os.path.isabs, os.environ[name].split(os.pathsep)))
        for name in SEARCHED
        if name in os.environ
    }
    return os.environ | absolute | {PROGRESS: "json", OWN_CODE: "allow" if allow_code else "refuse"}


async def _end(process: Process) -> None:
    """Interrupt a working process; kill it where it does not end."""
    if process.returncode is None:
        process.send_signal(signal.SIGINT)
        with anyio.move_on_after(PATIENCE):
            await process.wait()
    if process.returncode is None:
        process.kill()
    await process.aclose()


async def _collect(stream: ByteReceiveStream | None, output: bytearray) -> None:
    if stream is not None:
        async for chunk in stream:
            output += chunk


async def _follow(stream: ByteReceiveStream | None, messages: deque[str], on_progress: OnProgress) -> None:
    """Pass progress on and collect all other lines.

    Flights count on from stage to stage, for the protocol's progress grows with every report.
    """
    stage, done, total, reported, latest = "", 0, 0, -1, -math.inf
    async for line in _lines(stream):
        event = _progress(line)
        if event is None:
            messages.append(line[:MAX_LETTERS])
            continue
        if "stage" in event:
            stage, total, latest = event["stage"], done + event["flights"], -math.inf
        done += event.get("done", 0)
        if done > reported and monotonic() - latest >= INTERVAL:
            reported, latest = done, monotonic()
            await on_progress(stage, done, max(total, done))


async def _lines(stream: ByteReceiveStream | None) -> AsyncIterator[str]:
    """Yield the lines of a stream as they come."""
    if stream is None:
        return
    rest = b""
    async for chunk in stream:
        *lines, rest = (rest + chunk).split(b"\n")
        for line in lines:
            yield line.decode(errors="replace").rstrip("\r")
    if rest:
        yield rest.decode(errors="replace")


def _progress(line: str) -> dict[str, Any] | None:
    """Return an event of progress, None for another line."""
    if not line.startswith('{"progress": '):
        return None
    try:
        return json.loads(line)["progress"]
    except ValueError:
        return None


def _document(output: bytes) -> Any:
    try:
        return json.loads(output)
    except ValueError:
        return None
