"""The command for agents: mcp."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from plant.errors import InputError, require_package
from tuner.cli.app import app


@app.command()
def mcp(
    root: Annotated[Path, typer.Option(help="Working folder; an agent names files below it alone.")] = Path(),
    allow_code: Annotated[
        bool, typer.Option("--allow-code", help="Let studies run the Python files and FMUs that they name.")
    ] = False,
) -> None:
    """Serve commands to agents over the Model Context Protocol (stdio).

    Tools check, plan, run, show and export; none of them speaks to a vehicle.

    Example: tuner mcp --root my_quad
    """
    require_package("mcp", "mcp", key="tuner mcp")
    if not root.is_dir():
        raise InputError("is no folder; make it first", file=root, key="--root")
    import anyio

    from tuner.cli.agents.server import serve

    anyio.run(partial(serve, root.resolve(), allow_code))
