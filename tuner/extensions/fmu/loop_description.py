"""The description of an FMU's loop: names and numbers, from which a worker builds the loop that its parent has.

Laws, metrics and records made at run time cannot be pickled. Content of a file is read again from it, if its digest is still the
same.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from objectives.named_channels import channels_by_name, channels_of
from objectives.plant_meters import meters_of
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import MeterModel, Timing
from plant.model.closing import PlantLoop, close_plant
from plant.model.plan import Actuator, LoopPlan, WatchedSignal
from plant.own_code import run_own_code
from plant.registry import Registry
from tuner.extensions.fmu.fmu_model import Interface, fmu_model

if TYPE_CHECKING:
    from objectives.metrics.address import MetricAddress

LAW, METRIC = "LAW", "METRIC"


@dataclass(frozen=True)
class LoopDescription:
    """A loop around an FMU, for a worker that flies it.

    Attributes:
        folder: Folder of the unpacked FMU.
        channels: Fields of each channel, its law by name.
        metered: Address, name and axes of the metrics whose accumulators run.
        code: Files of the user's that have to be read again, by digest.
        patience: Time after which its parent has given it up [s].
        watched: Signals with meters of their own.
    """

    interface: Interface
    folder: Path
    channels: tuple[dict[str, Any], ...]
    actuators: tuple[Actuator, ...]
    metered: tuple[tuple[str, str, tuple[str, ...]], ...]
    code: dict[str, Path]
    timing: Timing
    patience: float
    watched: tuple[WatchedSignal, ...]


def describe_loop(
    interface: Interface,
    folder: Path,
    plan: LoopPlan,
    metered: Sequence["MetricAddress"],
    timing: Timing,
    patience: float,
) -> LoopDescription:
    """Return the description for a worker: InputError where it could not load a law or a metric."""
    code = _files_of(LAWS, [each.law for each in plan.channels])
    if metered:
        code |= _files_of(_metrics(), [each.metric for each in metered])
    addresses = tuple((each.text, each.metric.name, each.axes) for each in metered)
    return LoopDescription(
        interface,
        folder,
        channels_by_name(plan.channels),
        plan.actuators,
        addresses,
        code,
        timing,
        patience,
        plan.watched,
    )


def _metrics() -> Registry[Any]:
    # Here, because a worker that runs no accumulators of metrics need not import any.
    from objectives.metrics.registry import METRICS

    return METRICS


def _files_of(registry: Registry[Any], entries: Sequence[Any]) -> dict[str, Path]:
    """Return the files, by digest, of entries not bundled with the package."""
    files: dict[str, Path] = {}
    for entry in entries:
        if registry.get(entry.name) is not entry:
            raise InputError(
                f"'{entry.name}' is a {registry.kind} of no file, and an FMU flies in processes of its own; write it to a file",
                key=registry.kind,
            )
        if entry.origin is not None and not entry.origin.packaged:
            files[entry.origin.digest] = Path(entry.origin.place).absolute()
    return files


def loop_of(description: LoopDescription) -> PlantLoop:
    """Return the loop of a description; InputError where a file of its code has changed."""
    for digest, file in description.code.items():
        code = run_own_code(file)
        if code.digest != digest:
            raise InputError("has changed since the study was read; run the study again", file=file)
        registry, name = (LAWS, LAW) if LAW in code.names else (_metrics(), METRIC)
        registry.add(code.names[name], code.origin)
    plan = LoopPlan(channels_of(description.channels), description.actuators, description.watched)
    return close_plant(
        fmu_model(description.interface), plan, _meters(description, plan), description.timing.control_period
    )


def _meters(description: LoopDescription, plan: LoopPlan) -> MeterModel:
    bundled = meters_of(plan)
    if not description.metered:
        return bundled
    from objectives.metrics.address import MetricAddress
    from objectives.own_meters import with_accumulators

    return with_accumulators(
        bundled,
        [MetricAddress(text, _metrics().find(name), axes) for text, name, axes in description.metered],
        plan.scales,
    )
