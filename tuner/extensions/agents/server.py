"""The server: commands as tools, their progress and answers, and what agents read.

Model Context Protocol, https://modelcontextprotocol.io, over standard input and output. Texts of files may be a stranger's, so
every answer that can hold one begins with a sentence that says so.
"""

from pathlib import Path
from typing import Any

import anyio
from mcp.server.lowlevel import Server
from mcp.server.stdio import stdio_server
from mcp.shared.exceptions import MCPError
from mcp.types import (
    INVALID_PARAMS,
    CallToolRequestParams,
    CallToolResult,
    ListResourcesResult,
    ListResourceTemplatesResult,
    ListToolsResult,
    ReadResourceRequestParams,
    ReadResourceResult,
    TextResourceContents,
)

import tuner
from plant.errors import InputError, ToolError
from tuner.extensions.agents import DEFAULT_CALLS
from tuner.extensions.agents.answers import DATA, answer, meaning_of, refusal
from tuner.extensions.agents.child import OnProgress, Outcome, run_command
from tuner.extensions.agents.resources import JSON, content_of, resources, run_of, templates
from tuner.extensions.agents.tools import command_line, schema_of, tools
from tuner.extensions.agents.wire import ReadableMessages
from tuner.store.document import json_text

INSTRUCTIONS = (
    "Tune controller gains of multirotors and other plants. Usual order: make a study, check it, plan it, run it, show the "
    "result; judge and export gains. Files lie below the working folder. Nothing here speaks to a vehicle: export writes files, "
    "and a person loads them. A run that is cancelled is continued by resume. " + DATA
)
MAX_WAITING = 32
"""Calls that wait for one of them to end."""


class Commands:
    """Commands that run in the root, so many at once; others wait.

    Args:
        root: working folder; files lie below it.
        allow_code: whether code of the user's runs.
        calls: number of commands at once.
    """

    def __init__(self, root: Path, allow_code: bool, calls: int) -> None:
        self._root, self._allow_code = root.resolve(), allow_code
        self._limiter = anyio.CapacityLimiter(calls)

    async def run(self, name: str, given: dict[str, Any], on_progress: OnProgress) -> Outcome:
        """Run the command of a tool; InputError where it is refused."""
        arguments = command_line(name, given, self._root)
        if self._limiter.statistics().tasks_waiting >= MAX_WAITING:
            most = f"{self._limiter.total_tokens:g} commands run and {MAX_WAITING} wait"
            raise InputError(f"{most}; call again when one has ended, or start `tuner mcp --calls` with more")
        async with self._limiter:
            return await run_command(arguments, self._root, self._allow_code, on_progress)


def make_server(root: Path, allow_code: bool = False, calls: int = DEFAULT_CALLS) -> Server[Any]:
    """Return the server of a folder.

    Args:
        root: working folder of all commands; files lie below it.
        allow_code: whether studies may name Python files and FMUs, which run, and calls programs.
        calls: number of commands that run at once.
    """
    commands = Commands(root, allow_code, calls)

    async def call_tool(context: Any, params: CallToolRequestParams) -> CallToolResult:
        async def report(stage: str, done: int, total: int) -> None:
            await context.session.report_progress(done, total or None, stage)

        try:
            return answer(await commands.run(params.name, params.arguments or {}, report))
        except ToolError as error:
            return refusal(str(error))

    async def read_resource(context: Any, params: ReadResourceRequestParams) -> ReadResourceResult:
        try:
            if (folder := run_of(str(params.uri))) is None:
                text, mime_type = await anyio.to_thread.run_sync(content_of, str(params.uri))
            else:
                text, mime_type = await shown(folder), JSON
        except ToolError as error:
            raise MCPError(code=INVALID_PARAMS, message=str(error), data={"note": DATA}) from error
        content = TextResourceContents(uri=params.uri, text=text, mime_type=mime_type, _meta={"note": DATA})
        return ReadResourceResult(contents=[content])

    async def shown(folder: str) -> str:
        outcome = await commands.run("show", {"results": folder}, _ignore)
        if outcome.document is None:
            raise InputError("; ".join([meaning_of(outcome), *outcome.messages]))
        return json_text(outcome.document, ascii_only=True)

    async def list_tools(context: Any, params: Any) -> ListToolsResult:
        return ListToolsResult(tools=tools())

    async def list_resources(context: Any, params: Any) -> ListResourcesResult:
        return ListResourcesResult(resources=resources(root))

    async def list_templates(context: Any, params: Any) -> ListResourceTemplatesResult:
        return ListResourceTemplatesResult(resource_templates=templates())

    return Server(
        "tuner",
        version=tuner.__version__,
        title="Controller tuning",
        instructions=INSTRUCTIONS,
        get_tool_input_schema=lambda name: schema_of(name),
        on_list_tools=list_tools,
        on_call_tool=call_tool,
        on_list_resources=list_resources,
        on_list_resource_templates=list_templates,
        on_read_resource=read_resource,
    )


async def _ignore(stage: str, done: int, total: int) -> None:
    """Report no progress."""


async def serve(root: Path, allow_code: bool, calls: int) -> None:
    """Serve over standard input and output until the client goes."""
    server = make_server(root, allow_code, calls)
    async with stdio_server() as (received, sent):
        await server.run(ReadableMessages(received, sent), sent, server.create_initialization_options())
