"""From the tables of a study file to what runs; every value is checked here or by the type that it becomes."""

from collections.abc import Mapping
from math import cos, isfinite, radians, sqrt
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from objectives.mission import with_mission_floor
from objectives.requirements import Screen
from objectives.system import System
from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.spec import AirSpec
from plant.errors import InputError, UnknownNameError
from plant.law_registry import law
from plant.loop import Timing
from plant.quadrotor.airframes import Airframe, load, names
from plant.quadrotor.airframes.uncertainty import Uncertainty
from plant.quadrotor.cascade import AXES, Cascade, close_cascade
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.scenarios import Bands, ScenarioSpec, Spread
from plant.quadrotor.sensors import SensorSpec
from plant.references import ReferenceSpec, from_mapping
from plant.references.spec import HOLD, POSITION, VELOCITY
from plant.texts import PlainValue
from tuner.gains import Controller, read_gains
from tuner.gains.ranges import check_multiple, check_plant_step, timing_of, usual_timing
from tuner.study.assembly import assembled, judging_of
from tuner.study.gains import decision_space
from tuner.study.judged_reading import mission_of, unique
from tuner.study.margins import margin_requirement, margin_screen
from tuner.study.own_code import use_files_of
from tuner.study.reading import checked_table, read_study_table
from tuner.study.requirement_kinds import screens_of
from tuner.study.schema import (
    AirframeTable,
    ControllerTable,
    LimitsTable,
    ScenarioTable,
    StudyTable,
)
from tuner.study.study import Study, StudyScenario
from tuner.study.targets import check_target
from tuner.study.trim import check_trim
from tuner.text.input_errors import check_magnitudes, listed, located

T = TypeVar("T")
# Longest flight [control periods], an hour at 250 Hz: beyond it a digit slipped, and the run would fill the memory or not end.
MAX_PERIODS = 1_000_000
# Fastest reference [m/s]: a third above the fastest quadrotors.
MAX_SPEED = 150.0
# What [scenario.spread] may draw from.
AIRFRAME = "airframe"


def load_study(path: Path, overrides: Mapping[str, PlainValue] | None = None) -> Study:
    """Read and check a study file; overrides: dotted keys that replace values of the file.

    Raises InputError naming file and key.
    """
    return _build(path, read_study_table(path, overrides or {}))


def study_from_table(path: Path, raw: Mapping[str, PlainValue]) -> Study:
    """Check the content of a study that was put together elsewhere; errors name path, files are relative to its folder."""
    return _build(path, checked_table(path, raw, StudyTable))


def _build(path: Path, table: StudyTable) -> Study:
    with located(path, ""):
        use_files_of(path, {"law": table.law, "metric": table.metric, "reference": table.reference})
        with located(path, "airframe"):
            airframe = _airframe(table.airframe, path)
        with located(path, "controller"):
            timing = _timing(table.controller, airframe)
            cascade = _cascade(table.controller)
            options = _options(table.controller)
            default = _default(table.controller, cascade, path)
        with located(path, "limits"):
            limits = _limits(table.limits)
        with located(path, "airframe"):
            knowledge = nominal(airframe.vehicle, options, timing.control_period)
            vehicle_features(airframe.vehicle, timing.control_period)
        system = System(airframe.vehicle, cascade, knowledge, limits, timing)
        with located(path, "gains"):
            row = default_row(cascade, airframe.vehicle) if default is None else default.gains
            space = decision_space(table.gains, cascade, timing.control_period, row)
            if table.target is not None:
                check_target(space, system.gains, None if default is None else np.asarray(row))
        judging = judging_of(path, table, system, lambda entry: _scenario(entry, timing, path, airframe))
        system, specs = judging.system, [entry.spec for entry in judging.scenarios]
        # Behind what each number's own limits have to say, before anything is worked out from them.
        check_magnitudes(table.model_dump(), path)
        for i, spec in enumerate(specs):
            with located(path, f"scenario[{i}].reference"):
                _check_motion(spec, limits, timing)
            with located(path, f"scenario[{i}]"):
                check_trim(spec, system)
        with located(path, "mission"):
            mission = mission_of(table.mission, [spec.name for spec in specs])
        constraints = with_mission_floor(judging.constraints, specs, limits, timing, mission)
        screens = _screens(table, path, system, tuple(specs))
        vehicle = None if default is None else default.vehicle
        return assembled(
            Study,
            path,
            table,
            space,
            judging,
            mission,
            constraints,
            screens,
            airframe=airframe,
            options=options,
            vehicle=vehicle,
        )


def _airframe(table: AirframeTable, path: Path) -> Airframe:
    if (table.name is None) == (table.file is None):
        raise InputError('give either name = "hummingbird" (a bundled airframe) or file = "my_quad.toml"')
    if table.file is None:
        # Asked here because `load` takes a text like "my_quad.toml" for a path from the working directory.
        if table.name not in names():
            raise UnknownNameError("airframe", str(table.name), names(), key="name")
        return load(str(table.name), allow_unphysical=table.allow_unphysical)
    file = path.parent / table.file
    if not file.is_file():
        raise InputError(f"there is no file {file}; the path is relative to the study file", key="file")
    return load(file, allow_unphysical=table.allow_unphysical)


def _timing(table: ControllerTable, airframe: Airframe) -> Timing:
    if table.plant_step is None:
        return usual_timing(table.control_period, airframe)
    timing = timing_of(table.control_period, table.plant_step)
    check_plant_step(timing, airframe)
    return timing


def _cascade(table: ControllerTable) -> Cascade:
    laws = []
    for key in ("position", "attitude"):
        try:
            laws.append(law(getattr(table, key)))
        except UnknownNameError as error:
            raise error.located(key=key) from None
    position, attitude = laws
    return close_cascade(position, attitude, table.position_every)


def _options(table: ControllerTable) -> ControlOptions:
    if not 3.0 <= table.tilt_limit_deg <= 60.0:
        raise InputError(f"given {table.tilt_limit_deg} deg; allowed: 3 to 60 deg", key="tilt_limit_deg")
    tilt = radians(table.tilt_limit_deg)
    rates = (table.attitude_rate, table.position_rate)
    notches = (table.rpm_notches, table.rpm_notch_q, table.rpm_notch_min)
    battery = (table.battery_compensation, table.battery_cutoff)
    return ControlOptions(*rates, table.lag_aware, table.delay, tilt, table.yaw_torque_cutoff, *notches, *battery)


def _default(table: ControllerTable, cascade: Cascade, path: Path) -> Controller | None:
    """Return the controller of the file that controller.default names; its laws must be those of the study."""
    if table.default is None:
        return None
    file = path.parent / table.default
    if not file.is_file():
        raise InputError(f"there is no file {file}; the path is relative to the study file", key="default")
    given = read_gains(file)
    for loop in ("position", "attitude"):
        mine, its = getattr(cascade, loop).name, getattr(given.cascade, loop).name
        if mine != its:
            raise InputError(
                f"{file} holds the {loop} law '{its}', this study flies '{mine}'; give gains of the same laws, or write "
                f'{loop} = "{its}"',
                key="default",
            )
    return given


def _limits(table: LimitsTable) -> Limits:
    if not (isfinite(table.position) and table.position > 0.0):
        raise InputError(f"given {table.position} m; must be above 0 m", key="position")
    if not 10.0 <= table.tilt_deg < 90.0:
        raise InputError(f"given {table.tilt_deg} deg; allowed: 10 to below 90 deg", key="tilt_deg")
    return Limits(table.position, cos(radians(table.tilt_deg)))


def _scenario(table: ScenarioTable, timing: Timing, path: Path, airframe: Airframe) -> StudyScenario:
    with located(None, "air"):
        air = _air(table.air)
    with located(None, "sensors"):
        sensors = _sensors(table.sensors, timing, airframe)
    with located(None, "spread"):
        spread = Spread(**_widths(table.spread))
    with located(None, "bands"):
        bands = Bands(**table.bands.model_dump())
    reference = _reference(table.reference, path)
    if not table.name.strip():
        raise InputError('given an empty name; write for instance name = "gusts"', key="name")
    spec = ScenarioSpec(
        name=table.name,
        duration=table.duration,
        reference=reference,
        recovery_from=table.recovery_from,
        steady_share=table.steady_share,
        uncertainty=_uncertainty(table.spread, airframe),
        air=air,
        sensors=sensors,
        spread=spread,
        bands=bands,
    )
    _check_duration(spec.duration, timing.control_period)
    _check_steady_share(spec, timing.control_period)
    _check_air(spec)
    with located(None, "reference"):
        spec.track(timing)
    return StudyScenario(spec, table.search, table.held_out)


def _air(table: Any) -> AirSpec:
    """Return the air that a [scenario.air] describes, whose lists are tuples here."""
    gust, injection, window = table.gust, table.injection, table.window
    if gust is not None:
        direction = tuple(gust.direction) if isinstance(gust.direction, list) else gust.direction
        gust = Gust(gust.amplitude, gust.start, gust.length, direction)
    if injection is not None:
        injection = Injection(**{name: tuple(values) for name, values in injection.model_dump().items()})
    parts = {"gust": gust, "injection": injection, "window": None if window is None else tuple(window)}
    return AirSpec(**table.model_dump(exclude=set(parts)), **parts)


def _sensors(table: Any, timing: Timing, airframe: Airframe) -> SensorSpec:
    """Return the noise of the sensors; the gyro's is the airframe's where the study gives none."""
    given = table.model_dump()
    if airframe.gyro_noise is not None and "rate" not in table.model_fields_set:
        given["rate"] = airframe.gyro_noise * sqrt(0.5 / timing.control_period)
    return SensorSpec(**given)


def _widths(table: Any) -> dict[str, float]:
    """Return the numbers of a [scenario.spread], none with an airframe's uncertainty."""
    return {} if getattr(table, "from") is not None else table.model_dump(exclude={"from"})


def _uncertainty(table: Any, airframe: Airframe) -> Uncertainty | None:
    """Return the uncertainty that a [scenario.spread] draws from; InputError with its key where there is none."""
    given = getattr(table, "from")
    if given is None:
        return None
    if given != AIRFRAME:
        raise UnknownNameError("source", given, [AIRFRAME], key="spread.from")
    others = sorted(table.model_fields_set - {"from"})
    if others:
        message = f"the airframe's uncertainty takes the place of {', '.join(others)}; leave either out"
        raise InputError(message, key="spread.from")
    if airframe.uncertainty is None:
        message = (
            f"the file of '{airframe.name}' has no [uncertainty]; write one with `tuner identify LOG --out NAME.toml`, or give "
            "mass, inertia, thrust and lag here"
        )
        raise InputError(message, key="spread.from")
    return airframe.uncertainty


def _reference(table: Mapping[str, PlainValue], path: Path) -> ReferenceSpec:
    try:
        return from_mapping(table, base=path.parent)
    except InputError as error:
        if error.file is None or Path(error.file).is_file():
            raise
        message = f"there is no file {error.file}; the path is relative to the study file"
        raise InputError(message, key="reference.path") from None


def _check_air(spec: ScenarioSpec) -> None:
    """Raise InputError for turbulence or a gust that begins after the flight."""
    window, gust = spec.air.window, spec.air.gust
    for key, start in (("window", window[0] if window else 0.0), ("gust.start", gust.start if gust else 0.0)):
        if start >= spec.duration:
            raise InputError(f"begins at {start:g} s, but the flight ends at {spec.duration:g} s", key=f"air.{key}")


def _check_duration(duration: float, control_period: float) -> None:
    longest = MAX_PERIODS * control_period
    if duration > longest:
        raise InputError(f"given {duration:g} s; at this control period allowed: up to {longest:g} s", key="duration")
    check_multiple(duration, control_period, "duration", "controller.control_period")


def _check_steady_share(spec: ScenarioSpec, control_period: float) -> None:
    """Raise InputError for a final window of less than one control period."""
    least = control_period / spec.duration
    if spec.steady_share < least * (1.0 - 1e-9):
        message = (
            f"given {spec.steady_share:g}, which is {spec.steady_share * spec.duration:g} s of the flight; allowed: "
            f"{least:g}, one control period, to 1"
        )
        raise InputError(message, key="steady_share")


def _check_motion(spec: ScenarioSpec, limits: Limits, timing: Timing) -> None:
    """Raise InputError for a reference with too large jumps or speeds.

    It may not jump further than a flight may be off, nor be faster than any quadrotor.
    """
    samples = spec.track(timing).samples
    leaps = np.abs(np.diff(samples[:, POSITION], axis=0))
    # In attitude mode x and y are free.
    leaps[samples[1:, HOLD] < 0.5, :2] = 0.0
    for axis, leap in zip(AXES[:3], leaps.max(axis=0, initial=0.0).tolist(), strict=True):
        if leap > limits.position:
            message = (
                f"leaps by {leap:g} m in one control period, and a flight ends {limits.position:g} m off (limits.position): "
                "no gains could fly it; make the step smaller or the limit larger"
            )
            raise InputError(message, key=axis if hasattr(spec.reference, axis) else None)
    fastest = float(np.max(np.linalg.norm(samples[:, VELOCITY], axis=1)))
    if fastest > MAX_SPEED:
        raise InputError(f"moves at {fastest:g} m/s; allowed: up to {MAX_SPEED:g} m/s: make it slower")


def _screens(table: StudyTable, path: Path, system: System, specs: tuple[ScenarioSpec, ...]) -> tuple[Screen, ...]:
    """Return the requirements that need no flight, in the tables' order."""
    guarantees = screens_of("guarantee", path, table.guarantee, system, specs, table.seed)
    first: dict[str, int] = {}
    for i, screen in enumerate(guarantees):
        for requirement in screen.requirements:
            if first.setdefault(requirement.label, i) != i:
                message = (
                    f"'{requirement.label}' is required by guarantee[{first[requirement.label]}] too; leave one out"
                )
                raise InputError(message, key=f"guarantee[{i}]")
    margins = tuple(listed("margin", path, table.margin, lambda entry: margin_requirement(entry, system.timing, specs)))
    unique("margin", [entry.label for entry in margins])
    costs = screens_of("cost", path, table.cost, system, specs, table.seed)
    unique("cost", [screen.requirements[0].label for screen in costs])
    return (*guarantees, *([margin_screen(margins, path, system, specs)] if margins else []), *costs)
