"""One instance of an FMU, driven through FMPy. It runs foreign machine code: in a worker process and nowhere else."""

from collections.abc import Sequence
from ctypes import c_double, c_uint
from pathlib import Path
from typing import Any

from plant.errors import one_line, shortened
from tuner.extensions.fmu.fmu_model import Interface

MAX_ERROR_LETTERS = 200


class FmuError(Exception):
    """Answer of an FMU in place of a value: its function and status, on one line."""


class Instance:
    """An FMU, instantiated once and begun anew for every flight.

    Raises FmuError from every method where the FMU returns an error or asks to stop.
    """

    def __init__(self, interface: Interface, folder: Path) -> None:
        self._interface, self._version = interface, interface.version
        self._driven = _Block([each.reference for each in (*interface.inputs, *interface.disturbances)])
        self._shown = _Block([each.reference for each in (*interface.states, *interface.outputs)])
        self._unit = _loaded(interface, folder)
        self._call(self._unit.instantiate)
        self._fresh = True

    def begin(self, parameters: Sequence[float], states: Sequence[float] | None = None) -> None:
        """Initialise it at t = 0 with parameters; states: in place of its own."""
        self._anew()
        interface = self._interface
        changed = [pair for pair in zip(interface.parameters, parameters, strict=True) if pair[0].start != pair[1]]
        if states is not None:
            changed += zip(interface.states, states, strict=True)
        if changed:
            self._call(self._set, _Block([each.reference for each, _ in changed]), [value for _, value in changed])
        unit = self._unit
        if self._version == 2:
            self._call(unit.setupExperiment, startTime=0.0)
            self._call(unit.enterInitializationMode)
        else:
            self._call(unit.enterInitializationMode, startTime=0.0)
        self._call(unit.exitInitializationMode)

    def move(self, driven: Sequence[float], time: float, step: float) -> None:
        """Hold inputs and disturbances over a step [s] that begins at a time [s]."""
        self._call(self._set, self._driven, driven)
        ended = self._call(self._unit.doStep, time, step)
        if self._version == 3 and (ended[1] or ended[2]):
            raise FmuError("doStep asked to end the simulation" if ended[1] else "doStep returned early")

    def shown(self) -> list[float]:
        """Return its states, then its outputs."""
        block = self._shown
        self._call(self._get, block)
        return list(block.values)

    def slopes(self) -> list[list[float]]:
        """Return the directional derivatives of state rates and outputs.

        There is a row for each state and input.
        """
        interface = self._interface
        unknowns = [*interface.derivatives, *[each.reference for each in interface.outputs]]
        knowns = [each.reference for each in (*interface.states, *interface.inputs)]
        return [self._call(self._unit.getDirectionalDerivative, unknowns, [source], [1.0]) for source in knowns]

    def _anew(self) -> None:
        """Bring it back to where it has just been instantiated; a new instance where it cannot be reset."""
        if not self._fresh:
            try:
                self._unit.reset()
            except Exception:
                free = self._unit.fmi2FreeInstance if self._version == 2 else self._unit.fmi3FreeInstance
                free(self._unit.component)
                self._call(self._unit.instantiate)
        self._fresh = False

    def _set(self, block: "_Block", values: Sequence[float]) -> None:
        if not len(block.references):
            return
        block.values[:] = values
        n = len(block.references)
        if self._version == 2:
            self._unit.fmi2SetReal(self._unit.component, block.references, n, block.values)
        else:
            self._unit.fmi3SetFloat64(self._unit.component, block.references, n, block.values, n)

    def _get(self, block: "_Block") -> None:
        n = len(block.references)
        if self._version == 2:
            self._unit.fmi2GetReal(self._unit.component, block.references, n, block.values)
        else:
            self._unit.fmi3GetFloat64(self._unit.component, block.references, n, block.values, n)

    def _call(self, function: Any, *arguments: Any, **named: Any) -> Any:
        # FMPy raises plain exceptions where something is missing, and its own kind where a call fails.
        try:
            return function(*arguments, **named)
        except Exception as error:
            raise FmuError(_error_text(error)) from None


class _Block:
    """Value references with room for their values."""

    def __init__(self, references: Sequence[int]) -> None:
        self.references = (c_uint * len(references))(*references)
        self.values = (c_double * len(references))()


def _loaded(interface: Interface, folder: Path) -> Any:
    """Load the machine code and return FMPy's object for it; FmuError where it cannot be loaded."""
    named = {
        "guid": interface.token,
        "modelIdentifier": interface.identifier,
        "unzipDirectory": str(folder),
        "instanceName": "plant",
    }
    try:
        if interface.version == 2:
            from fmpy.fmi2 import FMU2Slave as Slave
        else:
            from fmpy.fmi3 import FMU3Slave as Slave
        return Slave(**named)
    except Exception as error:
        raise FmuError(_error_text(error)) from None


def _error_text(error: Exception) -> str:
    return shortened(one_line(" ".join(str(error).split())), MAX_ERROR_LETTERS).rstrip(".")
