"""The command for agents: mcp."""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from plant.errors import InputError, require_package
from plant.python_process import HOME, is_same
from tuner.cli.app import app
from tuner.extensions.agents import DEFAULT_CALLS


@app.command()
def mcp(
    root: Annotated[Path, typer.Option(help="Working folder; an agent names files below it alone.")] = Path(),
    allow_code: Annotated[
        bool,
        typer.Option(
            "--allow-code", help="Run the Python files and FMUs that studies name, and the programs of --binary."
        ),
    ] = False,
    calls: Annotated[int, typer.Option(help="Commands that run at once; further calls wait.", min=1)] = DEFAULT_CALLS,
) -> None:
    """Serve commands to agents over the Model Context Protocol (stdio).

    Tools check, plan, run, show and export; none of them speaks to a vehicle.

    Example: tuner mcp --root my_quad
    """
    require_package("mcp", "mcp", key="tuner mcp")
    if not root.is_dir():
        raise InputError("is no folder; make it first", file=root, key="--root")
    if not is_same(str(HOME), root) and any(is_same(folder, root) for folder in sys.path if folder):
        raise InputError(
            "is a folder from which Python imports, so that its files would run; take it out of PYTHONPATH",
            file=root,
            key="--root",
        )
    import anyio

    from tuner.extensions.agents.server import serve

    anyio.run(partial(serve, root.resolve(), allow_code, calls))
