"""The side of a worker process: it loads one FMU, builds its loop from a description and answers requests until its pipe closes.

`main` reads a description, then requests, from its standard input and answers on its standard output, which
the FMU itself never sees: what it prints goes nowhere.
"""

import faulthandler
import os
import signal
import sys
from contextlib import suppress
from typing import IO, Any

from plant.backends.identity import identity
from plant.errors import InputError
from plant.model.closing import PlantLoop
from plant.records import flatten, pack
from tuner.extensions.fmu.flying import FmuPlant, fly, result
from tuner.extensions.fmu.instance import FmuError, Instance
from tuner.extensions.fmu.loop_description import LoopDescription, loop_of
from tuner.extensions.fmu.messages import Flown, Fly, Linearize, Ready, Refused, receive, send

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
    description: LoopDescription = receive(requests)
    try:
        loop = loop_of(description)
        instance = Instance(description.interface, description.folder)
    except (InputError, FmuError) as error:
        send(answers, Refused(str(error)))
        return
    send(answers, Ready(identity(loop)))
    while True:
        request = receive(requests)
        # Should its parent be gone, nobody else would end an FMU that hangs.
        faulthandler.dump_traceback_later(2.0 * description.patience, exit=True, file=NOWHERE)
        try:
            answer: Any = (
                _flown(loop, instance, request)
                if isinstance(request, Fly)
                else _slope(description, loop, instance, request)
            )
        except InputError as error:
            answer = Refused(error.message, error.key)
        except FmuError as error:
            answer = Refused(str(error))
        faulthandler.cancel_dump_traceback_later()
        send(answers, answer)


def _flown(loop: PlantLoop, instance: Instance, order: Fly) -> Flown:
    kinds, seen = loop.records, list[list[float]]()

    def note(k: int, flight: Any) -> None:
        if order.traced and k % order.every == 0:
            row = flatten(flight)
            seen.append([row[i] for i in order.traced])

    fmu_plant = FmuPlant(loop, instance, order.timing)
    flight = fly(
        loop,
        fmu_plant,
        order.gains,
        pack(kinds.Nominal, order.nominal),
        order.inputs,
        pack(kinds.Targets, order.targets),
        pack(kinds.Limits, order.limits),
        order.timing,
        note,
    )
    return Flown(result(loop, flight), seen, fmu_plant.failed)


def _slope(description: LoopDescription, loop: PlantLoop, instance: Instance, order: Linearize) -> Any:
    # Here, because flights need no SciPy.
    from tuner.extensions.fmu.slope import slope_at_start

    return slope_at_start(loop, instance, description.timing, order.dynamics, bool(description.interface.derivatives))


if __name__ == "__main__":
    main()
