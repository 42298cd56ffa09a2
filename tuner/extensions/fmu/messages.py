"""Messages between a parent and a worker that flies an FMU: pickled, each after its length."""

import pickle
import struct
from typing import IO, Any, NamedTuple

import numpy as np

from plant.backends.stepping import Inputs
from plant.loop import Timing

LENGTH = struct.Struct("<Q")


class Fly(NamedTuple):
    """Asks for one flight; answered by `Flown`.

    Attributes:
        inputs: Inputs of its scenario.
        nominal: Leaves of the record.
        targets: Leaves of the record.
        limits: Leaves of the record.
        traced: Rows of the flight that are noted at every `every`-th instant, none for no trace.
    """

    gains: np.ndarray
    inputs: Inputs
    nominal: tuple[float, ...]
    targets: tuple[float, ...]
    limits: tuple[float, ...]
    timing: Timing
    traced: tuple[int, ...] = ()
    every: int = 1


class Flown(NamedTuple):
    """A flight that ended.

    Attributes:
        result: Its numbers.
        trace: Rows of the flight (instants, rows).
        failed: Message of the FMU that ended the flight, else "".
    """

    result: list[float]
    trace: list[list[float]]
    failed: str


class Linearize(NamedTuple):
    """Asks for a plant's slope over a control period; answered by `plant.model.slope.Slope`.

    dynamics: the plant's constants.
    """

    dynamics: np.ndarray


class Ready(NamedTuple):
    """Says that the FMU is loaded. loop: identity of the loop that the worker built."""

    loop: str


class Refused(NamedTuple):
    """Says that what was asked cannot be done, and why. key: of the study that decides it, if any."""

    why: str
    key: str | None = None


def send(pipe: IO[bytes], message: Any) -> None:
    """Write a message; OSError where nobody reads."""
    content = pickle.dumps(message)
    pipe.write(LENGTH.pack(len(content)) + content)
    pipe.flush()


def receive(pipe: IO[bytes]) -> Any:
    """Read a message; EOFError where the other side is gone."""
    return pickle.loads(_exactly(pipe, LENGTH.unpack(_exactly(pipe, LENGTH.size))[0]))


def _exactly(pipe: IO[bytes], count: int) -> bytes:
    content = pipe.read(count)
    if len(content) < count:
        raise EOFError
    return content
