"""Loaded by the worker processes of `local:N`: Ctrl-C in a terminal reaches them too, and it is the driver that ends them."""

import signal
from threading import current_thread, main_thread
from typing import Any


def dask_setup(worker: Any) -> None:  # noqa: ARG001
    """Leave interrupts to the driver."""
    if current_thread() is main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
