"""A study of a plant of the user's own, from its tables to what runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, inf, isfinite
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from objectives.decisions import DecisionSpace, Variable
from objectives.fmu.system import FmuSystem
from objectives.margins.quantities import LIMITABLE
from objectives.margins.requirement import MarginRequirement, requirement_label
from objectives.mission import USUAL, Mission
from objectives.own_meters import metering
from objectives.plant_mission import quantities_of, with_plant_floor
from objectives.plant_system import PlantSystem
from objectives.problem import Constraint, FlightBatch, Objective
from objectives.requirements import Screen
from plant.backends.identity import identity
from plant.errors import InputError, UnknownNameError
from plant.fmu.fmu_model import FmuModel, read_fmu
from plant.gains import GainAddress
from plant.laws import law
from plant.loop import Timing
from plant.model.modes import accurate_timing, check_plant_step, poles_at_rest
from plant.model.plan import Actuator, Channel, LoopPlan, plan_loop
from plant.model.plant_model import PlantModel, PlantRecords, check_rest, plant_from
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Signal, signal_from
from plant.own_code import run_own_code
from plant.records import flatten, paths
from tuner.gains.ranges import (
    LONGEST_OF_PLANTS,
    SHORTEST_OF_PLANTS,
    check_multiple,
    check_period,
    check_value,
    timing_of,
)
from tuner.study.files import is_shipped
from tuner.study.judged_reading import constraint_of, held_with, listed, mission_of, objective_of, pick_rule, unique
from tuner.study.margins import MarginValues, check_amplitude, margin_limit
from tuner.study.own_code import use_files_of
from tuner.study.plant_schema import ChannelTable, PlantGainTable, PlantScenarioTable, PlantStudyTable, PlantTable
from tuner.study.reading import checked_table
from tuner.study.schema import MarginTable
from tuner.study.search_reading import least_tail, search_of
from tuner.study.size import ScenarioSize, check_size
from tuner.study.study import StudyScenario, TuningStudy, usual_keys
from tuner.text.input_errors import located

# Keys of [plant] that name files, and those that only an FMU has.
PATHS, FMU_KEYS = ("file", "fmu"), ("disturbances", "states", "units", "patience")
# Units of gains that have no sign whatever the plant's is: times, frequencies, ratios.
SIGNLESS = ("s", "Hz", "rad/s", "1")


@dataclass(frozen=True, kw_only=True)
class PlantStudy(TuningStudy):
    """A study of a plant of the user's own. code_digest: of its file and what that imports."""

    kind: ClassVar[str] = "plant"
    plant_step_key: ClassVar[str] = "plant.plant_step"
    system: PlantSystem
    table: PlantStudyTable
    code_digest: str
    mission: Mission = USUAL

    @property
    def fixes_plant_step(self) -> bool:
        """Whether the study writes the plant step."""
        return self.table.plant.plant_step is not None

    @property
    def is_in_files(self) -> bool:
        """Whether a file holds the plant, and not the cell of a notebook."""
        return self.table.plant.file is not None or self.table.plant.fmu is not None

    @property
    def flown(self) -> str:
        """Name of the plant."""
        return self.system.plant.name

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """Plant, and the law of each channel."""
        laws = ", ".join(f"{each.law.name} ({each.name})" for each in self.system.plan.channels)
        return ("plant", self.system.plant.title), ("laws", laws)

    def comparable(self, without: tuple[str, ...] = ()) -> dict[str, Any]:
        """Return what decides the result, as JSON-able data by table, but for some tables; paths do not count."""
        values = self._values()
        plant = {key: value for key, value in values["plant"].items() if key not in PATHS}
        content = {**values, "plant": plant}
        # A study that asks for nothing else has the digest that it had before there was a floor.
        usual = (*usual_keys(self.table.confidence), *(("mission",) if self.mission == USUAL else ()))
        left = ("title", "description", *usual, *without)
        return {key: value for key, value in content.items() if key not in left}

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
        actuators = tuple(listed("actuator", path, table.actuator, lambda entry: _actuator(entry.model_dump(), h)))
        plan = plan_loop(plant, channels, actuators)
        with located(path, "plant"):
            timing = plant_timing(plant, actuators, parameters, h, table.plant.plant_step)
        system = _system(plant, plan, parameters, timing, table.plant.patience)
        with located(path, "gains"):
            space = plant_space(table.gains, system)
        scenarios = tuple(listed("scenario", path, table.scenario, lambda entry: _scenario(entry, system)))
        unique("scenario", [entry.spec.name for entry in scenarios], ".name")
        objectives = tuple(
            listed("objective", path, table.objective, lambda entry: objective_of(entry, scenarios, system))
        )
        unique("objective", [entry.label for entry in objectives])
        constraints = tuple(
            listed("constraint", path, table.constraint, lambda entry: constraint_of(entry, scenarios, system))
        )
        unique("constraint", [entry.objective.label for entry in constraints])
        judged = [entry.metric for entry in (*objectives, *(each.objective for each in constraints))]
        system = metering(system, judged)
        check_bounds(system, judged)
        mission, constraints = _with_floor(path, table, scenarios, objectives, constraints, system, space)
        constraints = held_with(table.confidence, constraints)
        margins = margins_asked(table.margin, path, system)
        unique("margin", [entry.label for entry in margins])
        with located(path, "search"):
            most = max(entry.search for entry in scenarios)
            tail = least_tail(objectives, len(scenarios))
            search = search_of(table.search, len(space.variables), len(objectives), most, tail)
            sizes = [
                ScenarioSize(entry.spec.duration / timing.plant_step, entry.search, entry.held_out)
                for entry in scenarios
            ]
            check_size(search.population, search.generations, sizes)
        with located(path, "pick"):
            rule = pick_rule(table.pick, objectives)
    screens = (margin_screen_of(margins, path, system, space),) if margins else ()
    return PlantStudy(
        path=path, title=table.title, description=table.description, seed=table.seed, system=system, space=space,
        scenarios=scenarios, objectives=objectives, constraints=constraints, screens=screens, search=search, pick=rule,
        table=table, code_digest=digest, mission=mission,
    )  # fmt: skip


def _with_floor(
    path: Path,
    table: PlantStudyTable,
    scenarios: tuple[StudyScenario, ...],
    objectives: tuple[Objective, ...],
    constraints: tuple[Constraint, ...],
    system: PlantSystem,
    space: DecisionSpace,
) -> tuple[Mission, tuple[Constraint, ...]]:
    """Return the mission of a study, and its constraints with the automatic limits behind them."""
    with located(path, "mission"):
        mission = mission_of(table.mission, [entry.spec.name for entry in scenarios], quantities_of(system))
    flights = [FlightBatch(entry.spec, "", entry.held_out) for entry in scenarios]
    return mission, with_plant_floor(constraints, objectives, flights, system, space, table.seed, mission)


def _plant(path: Path, table: PlantTable) -> tuple[PlantRecords, str]:
    """Return the plant of a file or an FMU beside a study, and its digest."""
    if (table.file is None) == (table.fmu is None):
        raise InputError(
            'needs a file or an FMU, one of them; write file = "motor.py" or fmu = "motor.fmu"', key="plant"
        )
    if table.fmu is not None:
        with located(path, "plant"):
            fmu = read_fmu(path.parent / table.fmu, table.disturbances, table.states, table.units, path)
        return fmu, fmu.interface.digest
    for key in FMU_KEYS:
        if key in table.model_fields_set:
            raise InputError("belongs to an FMU; a plant in Python says so itself: leave it out", key=f"plant.{key}")
    with located(path, "plant.file"):
        file = path.parent / str(table.file)
        code = run_own_code(file, None if is_shipped(file) else path)
        return plant_from(code.names, file.stem, str(file)), code.digest


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


def channel_of(table: ChannelTable) -> Channel:
    """Return a loop as a [[channel]] table describes it; InputError with the key inside the table."""
    try:
        chosen = law(table.law)
    except UnknownNameError as error:
        raise error.located(key="law") from None
    low, high = _or_infinite(table.low, table.high)
    return Channel(
        table.name, chosen, table.output, table.to, table.b0, table.rate_output, table.every,
        inf if table.limit is None else table.limit, low, high,
    )  # fmt: skip


def _actuator(values: dict[str, Any], control_period: float) -> Actuator:
    low, high = _or_infinite(values["low"], values["high"])
    rate = inf if values["rate"] is None else values["rate"]
    made = Actuator(values["name"], low, high, rate, values["delay"], values["lag"], values["scale"])
    made.periods(control_period)
    return made


def _or_infinite(low: float | None, high: float | None) -> tuple[float, float]:
    return (-inf if low is None else low, inf if high is None else high)


def plant_space(table: Mapping[str, float | PlantGainTable], system: PlantSystem) -> DecisionSpace:
    """Return the decision space of a [gains] table of a plant, which names every gain; InputError with the key inside it."""
    known = system.gains
    by_address = {gain.address: gain for gain in known}
    for key in table:
        if key not in by_address:
            raise UnknownNameError("gain", key, by_address, key=key)
    base, variables, columns = [0.0] * len(known), [], []
    for gain in known:
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
            _check_gain(gain, entry, system)
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


def _check_gain(gain: GainAddress, value: float, system: PlantSystem) -> None:
    """Refuse a value that a gain cannot have."""
    _check_sign(gain, value, system)
    check_value(gain.address, gain, value, system.timing.control_period)


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
        table.name, table.duration, _signals("reference", table.reference), _signals("disturbance", table.disturbance),
        {name: SensorNoise(entry.rms, entry.bias) for name, entry in table.sensors.items()}, table.spread, table.settling,
        table.band, table.recovery_from, table.steady_share,
    )  # fmt: skip
    spec.check(system.loop)
    check_multiple(spec.duration, system.timing.control_period, "duration", "plant.control_period")
    return StudyScenario(spec, table.search, table.held_out)


def _signals(key: str, tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Signal]:
    found = {}
    for name, values in tables.items():
        with located(None, f"{key}.{name}"):
            found[name] = signal_from(values)
    return found


def check_bounds(system: PlantSystem, metrics: list[Any]) -> None:
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
    axes = () if quantity.whole else names if table.axis is None else (table.axis,)
    label = requirement_label(quantity.name, table.axis, hard=table.hard, amplitude=table.amplitude)
    limit = margin_limit(table, quantity)
    return MarginRequirement(quantity, label, axes, limit, table.hard, amplitude=table.amplitude)


def margins_asked(tables: list[MarginTable], path: Path, system: PlantSystem) -> tuple[MarginRequirement, ...]:
    """Return the requirements of the [[margin]] tables of a study; errors name path and key."""
    return tuple(listed("margin", path, tables, lambda entry: _margin(entry, system)))


def margin_screen_of(
    asked: tuple[MarginRequirement, ...], path: Path, system: PlantSystem, space: DecisionSpace
) -> Screen:
    """Return all requirements on margins as one screen; errors of its analysis name path and the key "margin"."""
    return Screen(tuple(entry.requirement for entry in asked), margin_values(asked, path, system, space).values)


def margin_values(
    asked: tuple[MarginRequirement, ...], path: Path, system: PlantSystem, space: DecisionSpace
) -> MarginValues:
    """Return the values of requirements on the margins of a plant's loops."""
    return MarginValues(asked, lambda _, cases: plant_margins(system, space, cases), path)


def plant_margins(system: PlantSystem, space: DecisionSpace, cases: Any = None) -> Any:
    """Return the margins of a plant's loops, their structure looked at between the corners of the search."""
    # Here, because a study that asks for no margins needs no CasADi.
    from objectives.margins.describing import DEFAULT_CASES
    from objectives.margins.plant_margins import PlantMargins

    ends = [space.gains(np.full((1, len(space.variables)), end))[0] for end in (0.0, 1.0)]
    return PlantMargins(system, *ends, cases=DEFAULT_CASES if cases is None else cases)
