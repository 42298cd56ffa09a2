"""The command `tuner studio`."""

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from plant.errors import InputError, require_package
from tuner.cli.app import Threads, app, study_option


@app.command()
def studio(
    given: Annotated[
        Path | None,
        typer.Argument(
            metavar="[STUDY|RESULTS|GAINS]",
            help="A study, a results folder or a gains.json; default: quickstart.",
            show_default=False,
        ),
    ] = None,
    study: Annotated[Path | None, study_option("Study of gains that lie in no results folder.")] = None,
    out: Annotated[Path, typer.Option(help="Folder that takes what is saved; default: this one.", show_default=False)] = Path(),
    present: Annotated[
        Path | None,
        typer.Option(help="Parameter file of what the vehicle flies, for judge and rollback.", show_default=False),
    ] = None,
    port: Annotated[int, typer.Option(help="Port on 127.0.0.1; 0: any free one.", min=0, max=65535)] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Print the address and open no browser.")] = False,
    threads: Threads = None,
) -> None:
    """Move gains by hand on a local page; responses, margins and limits follow.

    The page is served to this machine alone, and Ctrl-C ends it.

    Example: tuner studio quickstart

    Example: tuner studio results/quickstart --no-browser
    """
    for package in ("starlette", "uvicorn"):
        require_package(package, "studio", key="tuner studio")
    from tuner.extensions.studio.answering import Bench
    from tuner.extensions.studio.guard import Door
    from tuner.extensions.studio.outputs import Outputs
    from tuner.extensions.studio.server import Studio, bound_socket, server_of
    from tuner.extensions.studio.session import open_session
    from tuner.extensions.studio.work import Work

    if not out.is_dir():
        raise InputError("is no folder; make it first", file=out, key="--out")
    session = open_session(given, study)
    listening = bound_socket(port)
    door = Door(listening.getsockname()[1])
    bench = Bench.of(session, threads)
    work = Work(bench)
    print(f"Studio: {door.address}\nCtrl-C ends it.", flush=True)
    if not no_browser:
        webbrowser.open(door.address)
    page = Studio(work, door, Outputs(bench, out.resolve(), present))
    try:
        server_of(page).run([listening])
    finally:
        page.searches.close()
        work.close()
        listening.close()
