"""A study of a plant of the user's own, from its tables to what runs."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from objectives.decisions import DecisionSpace, Variable
from objectives.flown_system import FlownSystem
from objectives.fmu.system import FmuSystem
from objectives.margins.quantities import LIMITABLE
from objectives.margins.requirement import MarginRequirement, requirement_label
from objectives.mission import USUAL, Mission
from objectives.plant_mission import quantities_of, with_plant_floor
from objectives.plant_system import PlantSystem
from objectives.problem import FlightBatch
from objectives.requirements import Screen
from plant.backends.identity import identity
from plant.errors import InputError, UnknownNameError
from plant.fmu.fmu_model import FmuModel, read_fmu
from plant.loop import Timing
from plant.model.linear import SignalNames, linear_plant
from plant.model.modes import accurate_timing, check_plant_step, poles_at_rest
from plant.model.plan import Actuator, Channel, LoopPlan, plan_loop
from plant.model.plant_model import PlantModel, PlantRecords, check_rest, plant_from
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Signal, signal_from
from plant.own_code import run_own_code
from plant.quadrotor.gains import GainAddress
from plant.records import flatten, paths
from tuner.gains import TunedLoops, plant_gains_document, read_loops
from tuner.gains.channels import channel_of
from tuner.gains.ranges import (
    LONGEST_OF_PLANTS,
    SHORTEST_OF_PLANTS,
    check_multiple,
    check_period,
    check_value,
    timing_of,
)
from tuner.study.assembly import assembled, judging_of
from tuner.study.files import is_shipped
from tuner.study.judged_reading import mission_of, unique
from tuner.study.margins import MarginValues, check_amplitude, margin_limit
from tuner.study.own_code import use_files_of
from tuner.study.plant_schema import (
    PLANT_KEYS,
    ActuatorTable,
    PlantGainTable,
    PlantScenarioTable,
    PlantStudyTable,
    PlantTable,
)
from tuner.study.reading import checked_table
from tuner.study.schema import MarginTable
from tuner.study.searched import Followed, StudyScenario, TuningStudy
from tuner.text.input_errors import listed, located
from tuner.text.sentences import listing

if TYPE_CHECKING:
    from objectives.margins.results import Margins

# Keys of [plant] that name files, and those that a plant in Python has not.
PATHS, FMU_KEYS = ("file", "fmu"), ("disturbances", "states", "units", "patience")
# Ways to give a plant that take a key of [plant], and why the others do not.
OF_FMU, OF_NUMBERS = "belongs to an FMU; a plant in Python says so itself", "belongs to a linear plant given by numbers"
KEYS_OF = {
    **dict.fromkeys(("disturbances", "patience"), (("fmu",), OF_FMU)),
    **dict.fromkeys(("states", "units"), (("fmu", "transfer_function", "state_space"), OF_FMU)),
    **dict.fromkeys(("dead_time", "inputs", "outputs"), (("transfer_function", "state_space"), OF_NUMBERS)),
}
# Units of gains that have no sign whatever the plant's is: times, frequencies, ratios.
SIGNLESS = ("s", "Hz", "rad/s", "1")


@dataclass(frozen=True, kw_only=True)
class PlantStudy(TuningStudy):
    """A study of a plant of the user's own. code_digest: of its file and what that imports."""

    kind: ClassVar[str] = "plant"
    guards: ClassVar[frozenset[str]] = frozenset(("unjudged",))
    plant_step_key: ClassVar[str] = "plant.plant_step"
    period_key: ClassVar[str] = "control_period"
    flies: ClassVar[str] = "a plant of one's own"
    limit_tables: ClassVar[str] = "or a [[margin]]"
    is_reread: ClassVar[bool] = False
    system: PlantSystem
    table: PlantStudyTable
    code_digest: str
    mission: Mission = USUAL

    @property
    def fixes_plant_step(self) -> bool:
        """Whether the study writes the plant step."""
        return self.table.plant.plant_step is not None

    @property
    def is_resumable(self) -> bool:
        """Whether a file holds the plant, and not the cell of a notebook."""
        return self.table.plant.is_given

    @property
    def flown(self) -> str:
        """Name of the plant."""
        return self.system.plant.name

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """Its plant."""
        return ("plant", self.system.plant.title), ("laws", self.law_text)

    @property
    def followed(self) -> list[Followed]:
        """Its channels that follow references."""
        return sorted(Followed(each.name, each.output, each.limit) for each in self.system.plan.outer)

    def margin_model(self) -> Any:
        """Return the margins of its loops."""
        return plant_margins(self.system, self.space)

    def flown_margins(self, gains: np.ndarray) -> "tuple[Margins, Margins] | None":
        """Return the margins of gains rows (n, gains), exact and of the loop in its plant steps; None of an FMU."""
        if self.table.plant.fmu is not None:
            return None
        try:
            model = self.margin_model()
            return model.evaluate(gains), model.as_flown().evaluate(gains)
        except InputError:
            return None

    def read_row(self, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of a file of its loops; InputError names all that differs."""
        return read_loops(file).checked_row(self.system, file)

    def gains_document(self, row: np.ndarray, parts: dict[str, Any]) -> dict[str, Any]:
        """Return the content of gains.json for a gains row (gains,) with its parts: study, objectives, margins."""
        return plant_gains_document(self.system, row, self.code_digest) | parts

    def controller(self, gains: Iterable[float]) -> TunedLoops:
        """Return its loops with a gains row."""
        return TunedLoops.of(self.system, np.array(gains))

    def row_of(self, controller: TunedLoops, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of loops of a file."""
        return controller.row(self.system, file)

    def under(self, controller: TunedLoops, file: Path) -> Self:
        """Return the study under other loops, lost at its own errors; InputError where they do not fit."""
        with located(file, ""):
            return replace(self, system=self._system_under(controller))

    def _system_under(self, loops: TunedLoops) -> PlantSystem:
        system = self.system
        limits = {(each.name, each.output): each.limit for each in system.plan.outer}
        channels = [replace(each, limit=limits.get((each.name, each.output), each.limit)) for each in loops.channels]
        plan = plan_loop(system.plant, channels, system.plan.actuators)
        judged = {
            axis
            for quantity in (*self.objectives, *[each.objective for each in self.constraints])
            for axis in quantity.metric.axes
        }
        missing = sorted(judged - set(plan.names))
        if {(each.name, each.output) for each in plan.outer} != set(limits) or missing:
            raise InputError(
                f"its loops follow references in {_listed(plan.outer)}, those of {self.path} in {_listed(system.plan.outer)}"
                f"{f', and it judges {listing(missing)}' if missing else ''}; compare loops for the same outputs",
                key="channels",
            )
        return replace(system, plan=plan)

    def comparable(self, without: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return the values that decide the result, as JSON-able data by table, but for some tables; paths do not count."""
        # A study that asks for nothing else has the digest that it had before there was a floor.
        content = super().comparable((*without, *(("mission",) if self.mission == USUAL else ())))
        if "plant" in content:
            content["plant"] = {key: value for key, value in content["plant"].items() if key not in PATHS}
        return content

    def _values(self) -> dict[str, Any]:
        system = self.system
        parameters = dict(zip(paths(system.plant.Parameters), flatten(system.parameters), strict=True))
        # A plant in Python is as it was before there were FMUs.
        given = self.table.plant.model_dump(
            mode="json", exclude={"fmu", *FMU_KEYS} if self.table.plant.fmu is None else None
        )
        plant = {"parameters": parameters, "plant_step": system.timing.plant_step, "digest": self.code_digest}
        return {
            **self.table.model_dump(mode="json", by_alias=True),
            "plant": {**given, **plant, "name": system.plant.name, "title": system.plant.title},
            "search": self.search.values,
            "gains": {gain.address: self.space.base[gain.column] for gain in system.gains},
            "variables": [variable.content() for variable in self.space.variables],
        }


def _listed(channels: Sequence[Channel]) -> str:
    return listing(f"{each.name} (output {each.output})" for each in channels)


def plant_study_from_table(path: Path, raw: Mapping[str, Any], plant: PlantRecords | None = None) -> PlantStudy:
    """Check the content of a study of a plant; errors name path and key, files are relative to its folder.

    plant: the plant, where it comes from no file.
    """
    return _build(path, checked_table(path, raw, PlantStudyTable), plant)


def _build(path: Path, table: PlantStudyTable, plant: PlantRecords | None) -> PlantStudy:
    with located(path, ""):
        use_files_of(path, {"law": table.law, "metric": table.metric})
        plant, digest = _plant(path, table.plant) if plant is None else (plant, identity(plant))
        with located(path, "plant"):
            check_period("control_period", table.plant.control_period, LONGEST_OF_PLANTS)
            parameters = _parameters(plant, table.plant.parameters)
            if isinstance(plant, PlantModel):
                check_rest(plant, parameters)
        h = table.plant.control_period
        channels = tuple(listed("channel", path, table.channel, channel_of))
        actuators = tuple(listed("actuator", path, table.actuator, lambda entry: _actuator(entry, h)))
        if table.plant.dead_time:
            actuators = tuple(_behind_dead_time(actuators, plant, table.plant.dead_time, h))
        plan = plan_loop(plant, channels, actuators)
        with located(path, "plant"):
            timing = plant_timing(plant, actuators, parameters, h, table.plant.plant_step)
        system = _system(plant, plan, parameters, timing, table.plant.patience)
        with located(path, "gains"):
            space = plant_space(table.gains, system)
        judging = judging_of(path, table, system, lambda entry: _scenario(entry, system))
        system, scenarios = judging.system, judging.scenarios
        check_bounds(system, judging.metrics)
        with located(path, "mission"):
            mission = mission_of(table.mission, [entry.spec.name for entry in scenarios], quantities_of(system))
        flights = [FlightBatch(entry.spec, "", entry.held_out) for entry in scenarios]
        constraints = with_plant_floor(
            judging.constraints, judging.objectives, flights, system, space, table.seed, mission
        )
        margins = margins_asked(table.margin, path, system)
        unique("margin", [entry.label for entry in margins])
        screens = (margin_screen_of(margins, path, system, space),) if margins else ()
        return assembled(PlantStudy, path, table, space, judging, mission, constraints, screens, code_digest=digest)


def _plant(path: Path, table: PlantTable) -> tuple[PlantRecords, str]:
    """Return the plant of a file, an FMU or numbers in a study, and its digest."""
    given = [key for key in PLANT_KEYS if getattr(table, key) is not None]
    if len(given) != 1:
        raise InputError(
            'needs a file or an FMU, one of them; write file = "motor.py" or fmu = "motor.fmu", or give a linear plant: '
            "transfer_function = { numerator = [...], denominator = [...] } or state_space = { A = ..., B = ..., C = ... }",
            key="plant",
        )
    for key, (kinds, reason) in KEYS_OF.items():
        if key in table.model_fields_set and given[0] not in kinds:
            raise InputError(f"{reason}: leave it out", key=f"plant.{key}")
    with located(path, "plant"):
        if table.fmu is not None:
            fmu = read_fmu(path.parent / table.fmu, table.disturbances, table.states, table.units, path)
            return fmu, fmu.interface.digest
        if table.file is None:
            names = SignalNames(table.inputs, table.outputs, table.states, table.units)
            plant = linear_plant(path.stem, {given[0]: getattr(table, given[0]).model_dump()}, names)
            return plant, identity(plant)
    with located(path, "plant.file"):
        file = path.parent / str(table.file)
        code = run_own_code(file, None if is_shipped(file) else path)
        return plant_from(code.names, file.stem, str(file)), code.digest


def _behind_dead_time(actuators: tuple[Actuator, ...], plant: PlantRecords, late: float, h: float) -> list[Actuator]:
    """Return an actuator for every input, with a dead time [s] behind its delay; control period h [s]."""
    try:
        Actuator("", delay=late).periods(h)
    except InputError as error:
        raise InputError(error.message, key="plant.dead_time") from None
    every = {name: Actuator(name) for name in paths(plant.Input)} | {each.name: each for each in actuators}
    return [replace(each, delay=each.delay + late) for each in every.values()]


def _system(plant: PlantRecords, plan: LoopPlan, parameters: Any, timing: Timing, patience: float) -> PlantSystem:
    if isinstance(plant, FmuModel):
        return FmuSystem(plant, plan, parameters, timing, patience=patience)
    return PlantSystem(plant, plan, parameters, timing)


def plant_timing(
    plant: PlantRecords,
    actuators: Sequence[Actuator],
    parameters: Any,
    control_period: float,
    plant_step: float | None = None,
) -> Timing:
    """Return the periods of a plant with these parameters and actuators; InputError with the key where they do not fit.

    Args:
        plant: Its equations, or those of an FMU, which nobody knows.
        actuators: Of its inputs.
        parameters: Of the plant.
        control_period: [s].
        plant_step: [s], by default the longest that is accurate at rest; of an FMU the control period.

    """
    for actuator in actuators:
        actuator.periods(control_period)
    step = control_period if plant_step is None else plant_step
    timing = timing_of(control_period, step, LONGEST_OF_PLANTS, SHORTEST_OF_PLANTS)
    if not isinstance(plant, PlantModel):
        _check_lags(actuators, timing)
        return timing
    poles = poles_at_rest(plant, parameters, actuators)
    if plant_step is None:
        return accurate_timing(poles, control_period)
    check_plant_step(poles, timing)
    return timing


def _check_lags(actuators: Sequence[Actuator], timing: Timing) -> None:
    """Refuse lags beside an FMU that settle within a step, over which it feels their mean."""
    for actuator in actuators:
        if 0.0 < actuator.lag < 0.5 * timing.plant_step:
            raise InputError(
                f"given {timing.plant_step:g} s; it must be at most twice the lag of {actuator.name}, {actuator.lag:g} s: write "
                f"plant_step = {timing.control_period / ceil(0.5 * timing.control_period / actuator.lag):.12g}, or lag = 0",
                key="plant_step",
            )


def _parameters(plant: PlantRecords, given: Mapping[str, float]) -> Any:
    names = paths(plant.Parameters)
    for name, value in given.items():
        if name not in names:
            raise UnknownNameError("parameter", name, names, key=f"parameters.{name}")
        if not isfinite(value):
            raise InputError(f"given {value}; numbers must be finite", key=f"parameters.{name}")
    return plant.parameters._replace(**given)


def _actuator(table: ActuatorTable, control_period: float) -> Actuator:
    made = Actuator(**table.model_dump(exclude_none=True))
    made.periods(control_period)
    return made


def plant_space(table: Mapping[str, float | PlantGainTable], system: PlantSystem) -> DecisionSpace:
    """Return the decision space of a [gains] table of a plant, which names every gain; InputError with the key inside it."""
    every_gain = system.gains
    by_address = {gain.address: gain for gain in every_gain}
    for key in table:
        if key not in by_address:
            raise UnknownNameError("gain", key, by_address, key=key)
    base, variables, columns = [0.0] * len(every_gain), [], []
    for gain in every_gain:
        entry = table.get(gain.address)
        if entry is None:
            raise InputError(
                f"is not given; write a number, or a range {{ low = ..., high = ... }} [{gain.unit}]: {gain.info.meaning}",
                key=gain.address,
            )
        if isinstance(entry, PlantGainTable):
            variable, base[gain.column] = _variable(entry, gain, system)
            variables.append(variable)
            columns.append((gain.column,))
        else:
            _check_sign(gain, entry, system)
            check_value(gain.address, gain, entry, system.timing.control_period)
            base[gain.column] = entry
    return DecisionSpace(tuple(variables), tuple(columns), tuple(base))


def _variable(entry: PlantGainTable, gain: GainAddress, system: PlantSystem) -> tuple[Variable, float]:
    if entry.tie is not None:
        raise InputError("gains of channels are not tied; give a range or a number", key=f"{gain.address}.tie")
    if entry.low is None or entry.high is None:
        raise InputError(
            f"needs low and high [{gain.unit}]; the usual ranges are those of quadrotors", key=gain.address
        )
    _check_sign(gain, entry.low, system)
    variable = Variable(gain.address, (gain.address,), entry.low, entry.high, entry.scale or gain.info.scale)
    default = variable.middle() if entry.default is None else entry.default
    for value in (entry.low, entry.high, default):
        check_value(gain.address, gain, value, system.timing.control_period)
    if not entry.low <= default <= entry.high:
        raise InputError(
            f"given {default:g}, outside its range of {entry.low:g} to {entry.high:g}", key=f"{gain.address}.default"
        )
    return variable, default


def _check_sign(gain: GainAddress, value: float, system: PlantSystem) -> None:
    """Refuse a gain that is negative because the plant is, and say where its sign belongs."""
    b0 = system.plan.channel(gain.axis).b0
    if value < 0.0 < b0 and (gain.info.integrals is not None or gain.unit not in SIGNLESS):
        raise InputError(
            f"given {value:g} {gain.unit}; gains are not negative: where more command lowers the output, write b0 = {-b0:g} for "
            f"channel '{gain.axis}' and the gain without its sign",
            key=gain.address,
        )


def _scenario(table: PlantScenarioTable, system: PlantSystem) -> StudyScenario:
    if not table.name.strip():
        raise InputError('given an empty name; write for instance name = "gusts"', key="name")
    spec = PlantScenario(
        table.name,
        table.duration,
        _signals("reference", table.reference),
        _signals("disturbance", table.disturbance),
        {name: SensorNoise(entry.rms, entry.bias) for name, entry in table.sensors.items()},
        table.spread,
        table.settling,
        table.band,
        table.recovery_from,
        table.steady_share,
    )
    spec.check(system.loop)
    check_multiple(spec.duration, system.timing.control_period, "duration", "plant.control_period")
    return StudyScenario(spec, table.search, table.held_out)


def _signals(key: str, tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Signal]:
    by_name = {}
    for name, values in tables.items():
        with located(None, f"{key}.{name}"):
            by_name[name] = signal_from(values)
    return by_name


def check_bounds(system: FlownSystem, metrics: list[Any]) -> None:
    """Refuse metrics whose cost of a failure would be infinite: an error without a limit, a command without a range."""
    bounds = system.metric_limits()
    for metric in metrics:
        for axis in metric.axes:
            if not isfinite(bounds.error(axis)):
                raise InputError(
                    f"'{metric}' judges {axis}, which has no limit; write limit = ..., the |error| at which a flight has failed",
                    key=f"channel.{axis}.limit",
                )
        if metric.metric.name in ("travel", "effort", "command_peak", "noise") and not isfinite(bounds.travel):
            raise InputError(
                f"'{metric}' judges commands, and an input has no range; write an [[actuator]] with low and high",
                key="actuator",
            )


def _margin(table: MarginTable, system: PlantSystem) -> MarginRequirement:
    if table.quantity not in LIMITABLE:
        raise UnknownNameError("margin", table.quantity, LIMITABLE, key="quantity")
    quantity, names = LIMITABLE[table.quantity], system.plan.names
    if table.axis is not None and table.axis not in names:
        raise UnknownNameError("channel", table.axis, names, key="axis")
    if table.spread:
        raise InputError("margins over a spread are those of quadrotors; leave spread out", key="spread")
    if "at" in table.model_fields_set:
        raise InputError("trims are those of quadrotors; a plant is judged at rest, so leave at out", key="at")
    check_amplitude(table)
    axes = () if quantity.is_multiloop else names if table.axis is None else (table.axis,)
    label = requirement_label(quantity.name, table.axis, hard=table.hard, amplitude=table.amplitude)
    limit = margin_limit(table, quantity)
    return MarginRequirement(quantity, label, axes, limit, table.hard, amplitude=table.amplitude)


def margins_asked(tables: list[MarginTable], path: Path, system: PlantSystem) -> tuple[MarginRequirement, ...]:
    """Return the requirements of the [[margin]] tables of a study; errors name path and key."""
    return tuple(listed("margin", path, tables, lambda entry: _margin(entry, system)))


def margin_screen_of(
    required: tuple[MarginRequirement, ...], path: Path, system: PlantSystem, space: DecisionSpace
) -> Screen:
    """Return all requirements on margins as one screen; errors of its analysis name path and the key "margin"."""
    return Screen(tuple(entry.requirement for entry in required), margin_values(required, path, system, space).values)


def margin_values(
    required: tuple[MarginRequirement, ...], path: Path, system: PlantSystem, space: DecisionSpace
) -> MarginValues:
    """Return the values of requirements on the margins of a plant's loops."""
    return MarginValues(required, lambda _, cases: plant_margins(system, space, cases), path)


def plant_margins(system: PlantSystem, space: DecisionSpace, cases: Any = None) -> Any:
    """Return the margins of a plant's loops, their structure looked at between the corners of the search."""
    # Here, because a study that asks for no margins needs no CasADi.
    from objectives.margins.describing import DEFAULT_CASES
    from objectives.margins.plant_margins import PlantMargins

    ends = [space.gains(np.full((1, len(space.variables)), end))[0] for end in (0.0, 1.0)]
    return PlantMargins(system, *ends, cases=DEFAULT_CASES if cases is None else cases)
