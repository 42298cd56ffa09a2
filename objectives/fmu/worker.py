"""The side of a worker process: it loads one FMU, builds its loop from a brief and does what it is asked until its pipe closes.

`main` reads a brief, then requests, from its standard input and answers on its standard output, which
the FMU itself never sees: what it prints goes nowhere.
"""

import faulthandler
import os
import signal
import sys
from contextlib import suppress
from typing import IO, Any

from objectives.fmu.brief import Brief, loop_of
from objectives.fmu.messages import Flown, Fly, Linearise, Ready, Refused, receive, send
from plant.backends.identity import identity
from plant.errors import InputError
from plant.fmu.flying import Mover, fly, result
from plant.fmu.instance import FmuError, Instance
from plant.model.closing import PlantLoop
from plant.records import flatten, pack

NOWHERE = os.open(os.devnull, os.O_WRONLY)


def main() -> None:
    """Serve requests until there are no more."""
    # Ctrl-C in a terminal reaches workers too, and it is the parent that ends them.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    requests, answers = sys.stdin.buffer, os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(NOWHERE, sys.stdout.fileno())
    with suppress(ImportError, ValueError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        _serve(requests, answers)
    except (EOFError, BrokenPipeError):
        return


def _serve(requests: IO[bytes], answers: IO[bytes]) -> None:
    brief: Brief = receive(requests)
    try:
        loop = loop_of(brief)
        instance = Instance(brief.interface, brief.folder)
    except (InputError, FmuError) as error:
        send(answers, Refused(str(error)))
        return
    send(answers, Ready(identity(loop)))
    while True:
        request = receive(requests)
        # Should its parent be gone, nobody else would end an FMU that hangs.
        faulthandler.dump_traceback_later(2.0 * brief.patience, exit=True, file=NOWHERE)
        try:
            answer: Any = (
                _flown(loop, instance, request) if isinstance(request, Fly) else _slope(brief, loop, instance, request)
            )
        except InputError as error:
            answer = Refused(error.message, error.key)
        except FmuError as error:
            answer = Refused(str(error))
        faulthandler.cancel_dump_traceback_later()
        send(answers, answer)


def _flown(loop: PlantLoop, instance: Instance, asked: Fly) -> Flown:
    kinds, seen = loop.records, list[list[float]]()

    def note(k: int, flight: Any) -> None:
        if asked.traced and k % asked.every == 0:
            row = flatten(flight)
            seen.append([row[i] for i in asked.traced])

    mover = Mover(loop, instance, asked.timing)
    flight = fly(
        loop, mover, asked.gains, pack(kinds.Nominal, asked.nominal), asked.inputs, pack(kinds.Targets, asked.targets),
        pack(kinds.Limits, asked.limits), asked.timing, note,
    )  # fmt: skip
    return Flown(result(loop, flight), seen, mover.failed)


def _slope(brief: Brief, loop: PlantLoop, instance: Instance, asked: Linearise) -> Any:
    # Here, because flights need no SciPy.
    from plant.fmu.slope import slope_at_start

    return slope_at_start(loop, instance, brief.timing, asked.dynamics, bool(brief.interface.derivatives))


if __name__ == "__main__":
    main()
