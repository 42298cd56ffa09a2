"""An FMU as a plant: the records that its loop is closed around, from its description and a study."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from plant.errors import InputError, UnknownNameError, check_name
from plant.model.plant_model import NoDisturbance, PlantRecords
from plant.records import pack, record_type, zeros
from plant.texts import check_text
from tuner.extensions.fmu.archive import Archive, open_archive
from tuner.extensions.fmu.description import INPUT, OUTPUT, PARAMETER, Description, FmuVariable, read_description


@dataclass(frozen=True)
class Interface:
    """Interface of an FMU to a study, as plain data.

    digest: of the FMU. states: what margins are linearised in; derivatives: value references, one for each state, or none. The
    other groups are as the records of a plant.
    """

    name: str
    title: str
    digest: str
    version: int
    identifier: str
    token: str
    states: tuple[FmuVariable, ...]
    inputs: tuple[FmuVariable, ...]
    disturbances: tuple[FmuVariable, ...]
    parameters: tuple[FmuVariable, ...]
    outputs: tuple[FmuVariable, ...]
    derivatives: tuple[int, ...]


@dataclass(frozen=True)
class FmuModel(PlantRecords):
    """A plant that moves in a process of its own. interface: what it is made from."""

    interface: Interface

    @property
    def parameters(self) -> Any:
        """Parameters as its description has them."""
        return pack(self.Parameters, [each.start for each in self.interface.parameters])

    def at_rest(self, parameters: Any) -> tuple[Any, Any, Any]:  # noqa: ARG002
        """Return its inputs as its description has them; its state and what it shows are known once it is initialised."""
        held = pack(self.Input, [each.start for each in self.interface.inputs])
        return zeros(self.State), held, zeros(self.Output)

    def check_rest(self, parameters: Any) -> None:
        """Pass: what moves is known once it is initialised."""


def read_fmu(
    file: Path,
    disturbances: Sequence[str] = (),
    states: Sequence[str] = (),
    units: Mapping[str, str] | None = None,
    study: Path | None = None,
) -> FmuModel:
    """Return the plant that an FMU is; nothing of its machine code runs.

    Args:
        file: The FMU, for co-simulation.
        disturbances: Inputs that disturb it instead of being commanded.
        states: Its states, by default those that its description names, or else its outputs.
        units: Of variables for which the description has none.
        study: The file that names it, None where the user does, see `plant.own_code`.

    Raises:
        InputError: It is no FMU that can be used here; the message names file and variable.
    """
    archive, description = looked_at(file, study)
    interface = interface_of(description, file, archive.digest, disturbances, states, units or {})
    return fmu_model(interface, str(file))


def looked_at(file: Path, study: Path | None = None) -> tuple[Archive, Description]:
    """Return an FMU and its description, without a study.

    Raises InputError where it is none that can be used here.
    """
    archive = open_archive(file, study)
    description = read_description(archive.description, file)
    archive.check_library(description.version, description.identifier)
    return archive, description


def interface_of(
    description: Description,
    file: Path,
    digest: str,
    disturbances: Sequence[str],
    states: Sequence[str],
    units: Mapping[str, str],
) -> Interface:
    """Return the interface of an FMU to a study: InputError where a name is unknown, ambiguous or has no unit."""
    described = _with_units(description, units)
    inputs = [each for each in described if each.role == INPUT]
    outputs = [each for each in described if each.role == OUTPUT]
    parameters = [each for each in described if each.role == PARAMETER and each.unit]
    for each in (*inputs, *outputs):
        if not each.unit:
            raise InputError(
                f"its {each.role} {each.name} has no unit; write one behind units.{each.name} in [plant], "
                '"1" for a number without one',
                file=file,
            )
    for kind, group in (("input", inputs), ("output", outputs)):
        if not group:
            raise InputError(f"has no {kind} that is a real number; a loop needs one", file=file)
    _check_distinct([*inputs, *outputs, *parameters], file)
    for name in disturbances:
        if name not in [each.name for each in inputs]:
            raise UnknownNameError("input", name, [each.name for each in inputs], key="disturbances")
    moving, rates = _states(description, described, states, outputs)
    return Interface(
        file.stem,
        description.title or description.model,
        digest,
        description.version,
        description.identifier,
        description.token,
        moving,
        tuple(each for each in inputs if each.name not in disturbances),
        tuple(each for each in inputs if each.name in disturbances),
        tuple(parameters),
        tuple(outputs),
        rates,
    )


def _with_units(description: Description, units: Mapping[str, str]) -> list[FmuVariable]:
    """Return all variables; those without a unit get that of the study."""
    names = {each.name for each in description.variables}
    for name, unit in units.items():
        check_name("variable", name, names, key=f"units.{name}")
        check_text(unit, 40, key=f"units.{name}")
    return [each if each.unit else each._replace(unit=units.get(each.name, "")) for each in description.variables]


def _check_distinct(variables: Sequence[FmuVariable], file: Path) -> None:
    seen: dict[str, FmuVariable] = {}
    for each in variables:
        other = seen.setdefault(each.name, each)
        if other is not each:
            raise InputError(
                f"its variables '{other.given}' and '{each.given}' are both written {each.name}; rename one in the model",
                file=file,
            )


def _states(
    description: Description, described: Sequence[FmuVariable], named: Sequence[str], outputs: Sequence[FmuVariable]
) -> tuple[tuple[FmuVariable, ...], tuple[int, ...]]:
    """Return the states and the value references of their derivatives.

    There are none of these where the FMU does not differentiate itself by its states.
    """
    if named:
        by_name = {each.name: each for each in described}
        for name in named:
            check_name("variable", name, by_name, key="states")
        return tuple(by_name[name] for name in named), ()
    by_reference = {each.reference: each for each in reversed(described)}
    if description.states and all(reference in by_reference for reference in description.states):
        rates = description.derivatives if description.directional else ()
        return tuple(by_reference[reference] for reference in description.states), rates
    return tuple(outputs), ()


def fmu_model(interface: Interface, file: str = "") -> FmuModel:
    """Return the plant of an interface."""
    groups = {
        "State": interface.states,
        "Input": interface.inputs,
        "Parameters": interface.parameters,
        "Output": interface.outputs,
    }
    kinds = {kind: _record(kind, group) for kind, group in groups.items()}
    disturbance = _record("Disturbance", interface.disturbances) if interface.disturbances else NoDisturbance
    return FmuModel(interface.name, interface.title, file, Disturbance=disturbance, interface=interface, **kinds)


def _record(kind: str, group: Sequence[FmuVariable]) -> Any:
    return record_type(kind, {each.name: Annotated[float, each.unit or "1"] for each in group})
