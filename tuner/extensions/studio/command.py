"""The command `tuner studio`."""

import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from plant.errors import InputError, require_package
from tuner.cli.app import Threads, app, study_option

if TYPE_CHECKING:
    from socket import socket

    from tuner.extensions.studio.server import Studio


@app.command()
def studio(
    given: Annotated[
        Path | None,
        typer.Argument(
            metavar="STUDY|RESULTS|GAINS",
            help="A study, a results folder or a gains.json; default: quickstart.",
            show_default=False,
        ),
    ] = None,
    study: Annotated[Path | None, study_option("Study of gains that lie in no results folder.")] = None,
    out: Annotated[
        Path, typer.Option(help="Folder that takes what is saved; default: this one.", show_default=False)
    ] = Path(),
    present: Annotated[
        Path | None,
        typer.Option(help="Parameter file of what the vehicle flies, for judge and rollback.", show_default=False),
    ] = None,
    pin: Annotated[
        list[Path] | None, typer.Option(metavar="FILE", help="Gains to pin; up to four times.", show_default=False)
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
    require_server("tuner studio")
    from tuner.extensions.studio.server import opened_page
    from tuner.extensions.studio.session import open_session, with_pins

    check_places(out, present)
    session = with_pins(open_session(given, study), pin or ())
    page = opened_page(session, out.resolve(), present, port, threads)
    serve(*page, None if no_browser else webbrowser.open)


def check_places(out: Path, present: Path | None) -> None:
    """Raise InputError where the folder or the present file is missing."""
    if not out.is_dir():
        raise InputError("is no folder; make it first", file=out, key="out")
    if present is not None and not present.is_file():
        raise InputError("there is no such file", file=present, key="present")


def require_server(command: str) -> None:
    """Raise MissingPackageError where the packages of the server are not installed."""
    for package in ("starlette", "uvicorn"):
        require_package(package, "studio", key=command)


def serve(page: "Studio", listening: "socket", browse: Callable[[str], object] | None) -> None:
    """Serve a page until Ctrl-C; browse: opens the address, None to print it alone."""
    from tuner.extensions.studio.server import server_of

    print(f"Studio: {page.door.address}\nCtrl-C ends it.", flush=True)
    if browse is not None:
        browse(page.door.address)
    try:
        server_of(page).run([listening])
    finally:
        page.close()
        listening.close()
