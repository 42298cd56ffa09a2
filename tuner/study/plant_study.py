"""Study of a user's plant."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from objectives.mission import USUAL, Mission
from objectives.plant_mission import quantities_of, with_plant_floor
from objectives.plant_system import PlantSystem
from objectives.problem import FlightBatch
from plant.backends.identity import identity
from plant.errors import InputError, UnknownNameError, check_name
from plant.loop import Timing
from plant.model.linear import SignalNames, linear_plant
from plant.model.plan import Actuator, Channel, LoopPlan, WatchedSignal, plan_loop
from plant.model.plant_model import PlantRecords, plant_from
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Signal, signal_from
from plant.origin import origins
from plant.own_code import run_own_code
from plant.records import flatten, paths
from plant.texts import PlainTable, PlainValue
from tuner.extension import find, refuse_lacking
from tuner.gains import TunedLoops, plant_gains_document, read_loops
from tuner.gains.channels import channel_of
from tuner.gains.ranges import LONGEST_OF_PLANTS, SHORTEST_OF_PLANTS, check_multiple, check_period, timing_of
from tuner.study.assembly import assembled, judging_of
from tuner.study.files import is_shipped
from tuner.study.judged_reading import mission_of, unique
from tuner.study.metric_bounds import check_bounds
from tuner.study.own_code import SystemMaker, use_files_of
from tuner.study.plant_gains import plant_space
from tuner.study.plant_margins import margin_screen_of, margins_asked, plant_margins
from tuner.study.plant_schema import PLANT_KEYS, ActuatorTable, PlantScenarioTable, PlantStudyTable, PlantTable
from tuner.study.reading import checked_table
from tuner.study.requirement_kinds import screens_of
from tuner.study.searched import Followed, StudyScenario
from tuner.study.starts import EarlierGains
from tuner.study.tuning_study import TuningStudy
from tuner.text.input_errors import check_sizes, listed, located
from tuner.text.sentences import listing

if TYPE_CHECKING:
    from objectives.margins.plant_margins import PlantMargins
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


@dataclass(frozen=True, kw_only=True)
class PlantStudy(TuningStudy):
    """A study of a plant of the user's own. code_digest: of its file and what that imports."""

    kind: ClassVar[str] = "plant"
    guards: ClassVar[frozenset[str]] = frozenset(
        ("unjudged", "signals_after_end", "unlimited_margins", "unsampled_modes")
    )
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
        """True if a file holds the plant, and not a notebook's cell."""
        return self.table.plant.is_given

    @property
    def flown(self) -> str:
        """Name of the plant."""
        return self.system.plant.name

    @property
    def about(self) -> tuple[tuple[str, str], ...]:
        """Its plant, laws and observer."""
        rows = [
            ("plant", self.system.plant.title),
            ("laws", self.law_text),
            ("observer", self.system.plan.observer_title),
        ]
        return tuple(row for row in rows if row[1])

    @property
    def followed(self) -> list[Followed]:
        """Its channels that follow references."""
        return sorted(Followed(each.name, each.output, each.limit) for each in self.system.plan.outer)

    def margin_model(self, state: str | None = None) -> "PlantMargins":
        """Return the margins of its loops."""
        return plant_margins(self.system, self.space)

    def flown_margins(self, gains: np.ndarray) -> "tuple[Margins, Margins] | None":
        """Return the margins of gains rows (n, gains), exact and as flown.

        As flown: of the loop in its plant steps. None of an FMU.
        """
        if not self.system.has_equations:
            return None
        try:
            model = self.margin_model()
            return model.evaluate(gains), model.as_flown().evaluate(gains)
        except InputError:
            return None

    def read_row(self, file: Path) -> np.ndarray:
        """Return the gains row (gains,) of a file of its loops; InputError names all that differs."""
        return read_loops(file).checked_row(self.system, file)

    def earlier_gains(self, file: Path) -> EarlierGains:
        """Return the gains of a file that mean the same here; InputError where no channel has its law there.

        Gains in units of the command become those of accelerations where only one of the two channels states b0.
        """
        loops = read_loops(file)
        theirs = {channel.name: channel for channel in loops.channels}
        shared = {
            channel.name: _command_factor(theirs[channel.name], channel)
            for channel in self.system.plan.channels
            if channel.name in theirs and theirs[channel.name].law.name == channel.law.name
        }
        if not shared:
            its, mine = (
                listing(f"{each.name} ({each.law.name})" for each in channels)
                for channels in (loops.channels, self.system.plan.channels)
            )
            message = f"its channels are {its}, those of this study {mine}; give a run of the same channels and laws"
            raise InputError(message, file=file, key="channels")
        factors = {
            gain.address: 1.0 if gain.info.integrals is None else shared[gain.axis]
            for gain in self.system.gains
            if gain.axis in shared
        }
        return EarlierGains(loops.gains, factors)

    def gains_document(self, row: np.ndarray, parts: PlainTable) -> PlainTable:
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
        plan = plan_loop(system.plant, channels, system.plan.actuators, system.plan.watched, system.plan.observer)
        if loops.observer != plan.observer_title:
            raise InputError(
                f"given {loops.observer or 'none'}; allowed: {plan.observer_title or 'none'}, as the study has: compare loops "
                "with one observer",
                key="observer",
            )
        judged = {axis for metric in self.judged_metrics for axis in metric.axes}
        missing = sorted(judged - set(plan.judged))
        if {(each.name, each.output) for each in plan.outer} != set(limits) or missing:
            raise InputError(
                f"its loops follow references in {_listed(plan.outer)}, those of {self.path} in {_listed(system.plan.outer)}"
                f"{f', and it judges {listing(missing)}' if missing else ''}; compare loops for the same outputs",
                key="channels",
            )
        return replace(system, plan=plan)

    def comparable(self, without: tuple[str, ...] = ()) -> PlainTable:
        """Return the values that decide the result, by table, without paths.

        They are JSON-able data; without: tables to leave out.
        """
        # A study that asks for nothing else has the digest that it had before there was a floor.
        content = super().comparable((*without, *(("mission",) if self.mission == USUAL else ())))
        plant = content.get("plant")
        if isinstance(plant, Mapping):
            content["plant"] = {key: value for key, value in plant.items() if key not in PATHS}
        return content

    @property
    def own_code(self) -> dict[str, dict[str, str] | None]:
        """Digests of the user's laws and metrics, by table and name; None where there are none."""
        laws = origins(channel.law for channel in self.system.plan.channels)
        return {"law": laws or None, "metric": origins(entry.metric for entry in self.judged_metrics) or None}

    def _values(self) -> PlainTable:
        system = self.system
        parameters = dict(zip(paths(system.plant.Parameters), flatten(system.parameters), strict=True))
        # A plant in Python is as it was before there were FMUs.
        given = self.table.plant.model_dump(
            mode="json", exclude={"fmu", *FMU_KEYS} if self.table.plant.fmu is None else None
        )
        unused = {key for key in ("disturbance_gain", "observer") if not getattr(self.table, key)}
        plant = {"parameters": parameters, "plant_step": system.timing.plant_step, "digest": self.code_digest}
        return {
            **self.table.model_dump(mode="json", by_alias=True, exclude=unused),
            # By digest: where a file lies does not count.
            **self.own_code,
            "plant": {**given, **plant, "name": system.plant.name, "title": system.plant.title},
            "search": self.search.values,
            "gains": {gain.address: self.space.base[gain.column] for gain in system.gains},
            "variables": [variable.content() for variable in self.space.variables],
        }


def _command_factor(theirs: Channel, mine: Channel) -> float:
    """Return the factor from their gains on errors to mine; 1 where both are accelerations or both commands."""
    return mine.b0 / theirs.b0 if 1.0 in (theirs.b0, mine.b0) else 1.0


def _listed(channels: Sequence[Channel]) -> str:
    return listing(f"{each.name} (output {each.output})" for each in channels)


def plant_study_from_table(path: Path, raw: Mapping[str, PlainValue], plant: PlantRecords | None = None) -> PlantStudy:
    """Check the content of a study of a plant; errors name path and key, files are relative to its folder.

    plant: the plant, where it comes from no file.
    """
    table = checked_table(path, raw, PlantStudyTable)
    check_sizes(table.model_dump(), path)
    return _build(path, table, plant)


def _build(path: Path, table: PlantStudyTable, plant: PlantRecords | None) -> PlantStudy:
    with located(path, ""):
        use_files_of(path, {"law": table.law, "metric": table.metric})
        plant, digest, kind = _plant(path, table.plant) if plant is None else (plant, identity(plant), PlantSystem)
        with located(path, "plant"):
            check_period("control_period", table.plant.control_period, LONGEST_OF_PLANTS)
            parameters = _parameters(plant, table.plant.parameters)
            plant.check_rest(parameters)
        h = table.plant.control_period
        channels = tuple(listed("channel", path, table.channel, channel_of))
        actuators = tuple(listed("actuator", path, table.actuator, lambda entry: _actuator(entry, h)))
        if table.plant.dead_time:
            actuators = tuple(_behind_dead_time(actuators, plant, table.plant.dead_time, h))
        plan = plan_loop(plant, channels, actuators)
        if table.observer is not None:
            refuse_lacking("tables", "observer")
            with located(path, "observer"):
                plan = find("observers", "observer", "observer")(table.observer, plant, plan, parameters, h)
        with located(path, "plant"):
            plan = plan.watching(_signals_with_limits(plant, plan, table.plant.lost_beyond))
            made = partial(kind, plant, plan, parameters)
            system = with_timing(made, actuators, h, table.plant.plant_step)
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
        specs = [entry.spec for entry in scenarios]
        margins = margins_asked(table.margin, path, system, specs)
        unique("margin", [entry.label for entry in margins])
        screens = [margin_screen_of(margins, path, system, space, specs)] if margins else []
        screens += screens_of("disturbance_gain", path, table.disturbance_gain, system, specs, table.seed)
        return assembled(
            PlantStudy, path, table, space, judging, mission, constraints, tuple(screens), code_digest=digest
        )


def _plant(path: Path, table: PlantTable) -> tuple[PlantRecords, str, SystemMaker]:
    """Return the plant of a study, its digest and its system class."""
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
            return find("plants", "kind of plant", "fmu").read(path.parent / table.fmu, table, path)
        if table.file is None:
            names = SignalNames(table.inputs, table.outputs, table.states, table.units)
            plant = linear_plant(path.stem, {given[0]: getattr(table, given[0]).model_dump()}, names)
            return plant, identity(plant), PlantSystem
    with located(path, "plant.file"):
        file = path.parent / str(table.file)
        code = run_own_code(file, None if is_shipped(file) else path)
        return plant_from(code.names, file.stem, str(file)), code.digest, PlantSystem


def _behind_dead_time(actuators: tuple[Actuator, ...], plant: PlantRecords, late: float, h: float) -> list[Actuator]:
    """Return the actuators of all inputs, each with a dead time [s] added.

    The dead time comes behind the actuator's delay; control period h [s].
    """
    try:
        Actuator("", delay=late).periods(h)
    except InputError as error:
        raise InputError(error.message, key="plant.dead_time") from None
    every = {name: Actuator(name) for name in paths(plant.Input)} | {each.name: each for each in actuators}
    return [replace(each, delay=each.delay + late) for each in every.values()]


def with_timing(
    made: Callable[[Timing], PlantSystem],
    actuators: Sequence[Actuator],
    control_period: float,
    plant_step: float | None = None,
) -> PlantSystem:
    """Return a system with the periods that it is flown in; InputError with the key where they do not fit.

    Args:
        made: Makes it with any periods.
        actuators: Actuators of its inputs.
        control_period: [s].
        plant_step: [s], by default the longest that is accurate at rest; of an FMU the control period.
    """
    for actuator in actuators:
        actuator.periods(control_period)
    step = control_period if plant_step is None else plant_step
    system = made(timing_of(control_period, step, LONGEST_OF_PLANTS, SHORTEST_OF_PLANTS))
    return replace(system, timing=system.checked_timing(plant_step is not None))


def _parameters(plant: PlantRecords, given: Mapping[str, float]) -> Any:
    names = paths(plant.Parameters)
    for name, value in given.items():
        if name not in names:
            raise UnknownNameError("parameter", name, names, key=f"parameters.{name}")
        if not isfinite(value):
            raise InputError(f"given {value}; numbers must be finite", key=f"parameters.{name}")
    return plant.parameters._replace(**given)


def _signals_with_limits(plant: PlantRecords, plan: LoopPlan, limits: Mapping[str, float]) -> list[WatchedSignal]:
    """Return the signals with a limit; InputError for a channel or an unknown name."""
    records = plant.signals
    for name in limits:
        key = f"lost_beyond.{name}"
        if name in plan.names:
            raise InputError("given for a channel; write lost_beyond in its [[channel]]", key=key)
        check_name("output or input", name, list(records), key=key)
    return [WatchedSignal(name, records[name], limit) for name, limit in limits.items()]


def _actuator(table: ActuatorTable, control_period: float) -> Actuator:
    made = Actuator(**table.model_dump(exclude_none=True))
    made.periods(control_period)
    return made


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
        table.joint_spread,
    )
    spec.check(system.loop)
    spec.check_jumps(system.loop, system.timing)
    check_multiple(spec.duration, system.timing.control_period, "duration", "plant.control_period")
    return StudyScenario(spec, table.search, table.held_out)


def _signals(key: str, tables: Mapping[str, Mapping[str, PlainValue]]) -> dict[str, Signal]:
    by_name = {}
    for name, values in tables.items():
        with located(None, f"{key}.{name}"):
            by_name[name] = signal_from(values)
    return by_name
