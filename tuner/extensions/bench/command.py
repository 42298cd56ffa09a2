"""The command `tuner bench`."""

from typing import Annotated

import typer

from tuner.cli.app import AsJson, Threads, app


@app.command()
def bench(
    flights: Annotated[int, typer.Option(help="Flights of 10 s on the lanes backend.", min=16)] = 1024,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Measure simulation speed of each backend.

    Example: tuner bench --json
    """
    from tuner.api.frames import json_text
    from tuner.extensions.bench.speed import bench as measure

    if not as_json:
        print("Measuring closed-loop plant steps per second; the first run on a machine compiles two kernels.")
    figures = measure(flights, threads)
    if as_json:
        print(json_text(figures))
        return
    for key, value in figures.items():
        print(f"{key:28} {f'{value:,.3g}' if isinstance(value, float) else value}")
