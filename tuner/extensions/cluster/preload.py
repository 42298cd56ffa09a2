"""Loaded by worker processes: those of `local:N`, and others that need files of the user's own, which only their owner names.

dask worker tcp://head:8786 --preload tuner.extensions.cluster.preload --code motor.py
"""

import signal
from pathlib import Path
from threading import current_thread, main_thread
from typing import Any

import click


@click.command()
@click.option("--code", multiple=True)
@click.option("--driven", is_flag=True)
def dask_setup(worker: Any, code: tuple[str, ...], driven: bool) -> None:  # noqa: ARG001
    """Run files of the user's own; driven: leave interrupts, which reach these processes too, to the driver, who ends them."""
    if driven and current_thread() is main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if code:
        from tuner.study.own_code import use_named

        for file in code:
            use_named(Path(file))
