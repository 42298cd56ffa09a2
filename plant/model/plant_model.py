"""A plant in one file: NamedTuples with units, and pure functions of scalars.

    State, Input, Parameters, Output     what moves, what drives it, its constants with their nominal values, what is measured
    Disturbance                          what acts on it from outside; may be left out
    derivative(state, input, disturbance, parameters) -> State
    output(state, input, disturbance, parameters) -> Output
    rest(parameters) -> (State, Input)   where flights start, at rest under no disturbance; all zero where it is left out

Every field is Annotated[float, "unit"]. Functions take their mathematics from `plant.primitives`, as those of the quadrotor do.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import isfinite
from types import FunctionType
from typing import Any, NamedTuple

from plant import primitives
from plant.errors import InputError, shortened
from plant.model.functions import check_model_function, place_of, place_of_field
from plant.own_code import place_of_error
from plant.records import flatten, is_record, paths, unit_of, zeros

RECORDS = ("State", "Input", "Parameters", "Output")
# Functions that every plant has.
EQUATIONS = ("derivative", "output")
# Largest share of a state's size that may be left of its derivative at rest [1/s].
STILL = 1e-6


class NoDisturbance(NamedTuple):
    """Disturbance of a plant that knows none."""


@dataclass(frozen=True)
class PlantRecords(ABC):
    """The records of a plant: what moves, what drives and disturbs it, its constants, what is measured.

    name: of kernels and reports. title: first line of its file. file: where it was written, "" for a notebook's cell.
    """

    name: str
    title: str = field(compare=False)
    file: str = field(compare=False)
    State: Any
    Input: Any
    Disturbance: Any
    Parameters: Any
    Output: Any

    @property
    @abstractmethod
    def parameters(self) -> Any:
        """Nominal parameters."""

    @abstractmethod
    def at_rest(self, parameters: Any) -> tuple[Any, Any, Any]:
        """Return the state, the input and the output with which a plant of these parameters starts."""

    @abstractmethod
    def check_rest(self, parameters: Any) -> None:
        """Raise InputError where a plant of these parameters does not rest."""

    @property
    def signals(self) -> dict[str, str]:
        """The record of each signal, "Output" or "Input"; an output precedes an input of its name."""
        outputs = dict.fromkeys(paths(self.Output), "Output")
        return outputs | {name: "Input" for name in paths(self.Input) if name not in outputs}

    def unit(self, path: str) -> str:
        """Return the unit of a field by "Output.angle" or "Input.voltage"."""
        record, _, field = path.partition(".")
        return unit_of(getattr(self, record).__annotations__[field])


@dataclass(frozen=True)
class PlantModel(PlantRecords):
    """A plant whose equations are known, and where it rests.

    make: makes it in another process out of names and numbers alone; None where its equations are code of the user's own.
    """

    derivative: Callable[..., Any]
    output: Callable[..., Any]
    rest: Callable[..., Any]
    make: "Callable[[], PlantModel] | None" = field(default=None, compare=False)

    @property
    def parameters(self) -> Any:
        """Nominal parameters: the defaults of the record."""
        return self.Parameters()

    def at_rest(self, parameters: Any) -> tuple[Any, Any, Any]:
        """Return the state and the input that hold it, and what it shows under no disturbance."""
        state, held = self.rest(parameters)
        return state, held, self.output(state, held, zeros(self.Disturbance), parameters)

    def check_rest(self, parameters: Any) -> None:
        """Raise InputError where the equations do not work, or do not rest."""
        quiet = zeros(self.Disturbance)
        state, command = _rest(self, parameters)
        rate = _called(self, "derivative", self.derivative, state, command, quiet, parameters)
        seen = _called(self, "output", self.output, state, command, quiet, parameters)
        _check_numbers(self, "derivative", self.derivative, rate, self.State)
        _check_numbers(self, "output", self.output, seen, self.Output)
        for path, value, speed in zip(paths(self.State), flatten(state), flatten(rate), strict=True):
            if abs(speed) > STILL * (1.0 + abs(value)):
                raise InputError(
                    f"{path} changes by {speed:.3g} a second where the plant should rest; write rest(parameters), which gives "
                    "the state and the input that hold it",
                    file=place_of(self.derivative, self.file),
                    key="derivative",
                )


def _check_presence(names: Mapping[str, object], file: str) -> None:
    """Raise InputError for a missing function, with those that there are."""
    missing = next((key for key in EQUATIONS if names.get(key) is None), None)
    if missing is not None:
        functions = [value for value in names.values() if isinstance(value, FunctionType)]
        names_of_file = [each.__name__ for each in functions if each.__module__ not in (primitives.__name__, "typing")]
        raise InputError(
            f"given {'the functions ' + shortened(', '.join(names_of_file)) if names_of_file else 'no function'}; write "
            f"def {missing}(state, input, disturbance, p): a plant needs {' and '.join(EQUATIONS)}",
            file=file,
            key=missing,
        )


def plant_from(names: Mapping[str, object], name: str, file: str = "") -> PlantModel:
    """Return the plant that a module's names, or those of a notebook's cell, describe; InputError with the line where not."""
    for kind in RECORDS:
        _check_record(kind, names.get(kind), file)
    disturbance = names.get("Disturbance", NoDisturbance)
    if disturbance is not NoDisturbance:
        _check_record("Disturbance", disturbance, file)
    _check_presence(names, file)
    equations = {key: check_model_function(names.get(key), key, 4, file) for key in EQUATIONS}
    kinds = {kind: names[kind] for kind in RECORDS}
    given = names.get("rest")
    rest = _nothing(kinds["State"], kinds["Input"]) if given is None else check_model_function(given, "rest", 1, file)
    title = str(names.get("__doc__") or name).strip().splitlines()[0]
    plant = PlantModel(name, title, file, Disturbance=disturbance, rest=rest, **kinds, **equations)
    plant.check_rest(plant.parameters)
    return plant


def _nothing(state: Any, command: Any) -> Callable[[Any], Any]:
    nothing = zeros(state), zeros(command)

    def rest(parameters: Any) -> Any:  # noqa: ARG001
        return nothing

    return rest


def _check_record(kind: str, record: Any, file: str) -> None:
    if not is_record(record):
        given = "nothing" if record is None else repr(record)
        raise InputError(
            f"given {given} for {kind}; write class {kind}(NamedTuple) with a unit for every field", file=file
        )
    for name, part in record.__annotations__.items():
        if getattr(part, "__origin__", None) is not float or not unit_of(part):
            raise InputError(
                f'no unit; write {name}: Annotated[float, "m"], with "1" for a number without one',
                file=place_of_field(record, name, file),
                key=f"{kind}.{name}",
            )
    missing = [name for name in record._fields if kind == "Parameters" and name not in record._field_defaults]
    if missing:
        raise InputError(
            "no nominal value; write it behind the unit, as in = 0.5",
            file=place_of_field(record, missing[0], file),
            key=f"{kind}.{missing[0]}",
        )


def _check_numbers(plant: PlantModel, name: str, function: Callable[..., Any], record: Any, kind: Any) -> None:
    """Raise InputError where a function gives no finite record of a kind."""
    place = place_of(function, plant.file)
    if type(record) is not kind:
        raise InputError(f"gives {type(record).__name__}; it must give {kind.__name__}", file=place, key=name)
    for path, value in zip(paths(kind), flatten(record), strict=True):
        if not (isinstance(value, (int, float)) and isfinite(value)):
            raise InputError(f"gives {value!r} for {path} at rest; numbers must be finite", file=place, key=name)


def _rest(plant: PlantModel, parameters: Any) -> Any:
    """Return the state and the input of a plant at rest; InputError where rest gives something else."""
    given = _called(plant, "rest", plant.rest, parameters)
    place = place_of(plant.rest, plant.file)
    if not (isinstance(given, tuple) and [type(each) for each in given] == [plant.State, plant.Input]):
        raise InputError(f"gives {given!r}; it must give State, Input", file=place, key="rest")
    for path, value in zip((*paths(plant.State), *paths(plant.Input)), flatten(given), strict=True):
        if not (isinstance(value, (int, float)) and isfinite(value)):
            raise InputError(f"gives {value!r} for {path}; numbers must be finite", file=place, key="rest")
    return given


def _called(plant: PlantModel, name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    try:
        return function(*arguments)
    except Exception as error:
        place = place_of_error(error) or place_of(function, plant.file)
        raise InputError(f"fails at rest: {type(error).__name__}: {error}", file=place, key=name) from error
