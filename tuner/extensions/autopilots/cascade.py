"""Autopilots with our PID as parameters of a cascade: loops in our units, parameter files written and read.

An angle loop P around a rate loop PI in normalised torque, a position loop P around a velocity loop PI: the form that
`autopilot.pid` gives our PID. Other parameters scale these loops or act in addition. On a known vehicle (`aboard`) they stay
unchanged; otherwise they are chosen such that the autopilot flies our loops.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Self

from plant.input_files import ReadableFile
from plant.law_registry import law
from plant.laws.pid import Gains
from plant.quadrotor.airframes import Airframe
from plant.quadrotor.airframes.actuation import Actuation
from plant.quadrotor.cascade import AXES, Cascade, close_cascade
from plant.quadrotor.vehicle import Vehicle
from tuner.documents.export import FilteredLoop
from tuner.exchange.aboard import DERIVATIVE, KEEP, OTHERS, VehicleParameters, describe_unmanaged
from tuner.exchange.target import Bundle, GyroFilter, ImportedController, Request
from tuner.exchange.texts import heading, parameter_comment
from tuner.extensions.autopilots import pid
from tuner.extensions.autopilots.assembly import (
    LOOPS,
    OUR_LOOPS,
    assumed_note,
    by_default,
    filled,
    filters,
    inertia_note,
    position_every,
    record_of,
    tilt_note,
    untuned_notes,
)
from tuner.extensions.autopilots.native_loops import LIKE, NativeLaw, flown, with_authorities
from tuner.extensions.autopilots.parameters import ParameterInfo, Values, defaults, option_changes, parameters, single
from tuner.gains import Controller

Differences = Callable[[Values, Values], tuple[str, ...]]
"""Return what an autopilot adds or lacks, of the values that are written and of all of them."""


class CascadeNames(NamedTuple):
    """Parameters of one axis: outer P, P and I of the loop on the rate, and its D on the measured acceleration."""

    outer: str
    p: str
    i: str
    d: str


@dataclass(frozen=True)
class ParameterSet:
    """Parameters of a version of an autopilot.

    Attributes:
        target: Its name in the registry.
        name: Name with the version.
        file: Name of the file that is written.
        table: Every parameter that is written, in the order of the file.
        names: Names by axis of ours, y goes with x.
        carried: Parameters that our loops carry.
        scaling: Other parameters that turn our gains into its units.
        yaw_filter: Low-pass on yaw torque [Hz].
        gyro: Low-pass of the gyro.
        gyro_cutoff: Default of that low-pass [Hz].
        native: Laws of its native loops.
        native_table: Parameters that act in those alone.
    """

    target: str
    name: str
    file: str
    table: Mapping[str, ParameterInfo]
    names: Mapping[str, CascadeNames]
    carried: frozenset[str]
    scaling: tuple[str, ...]
    yaw_filter: str
    gyro: str
    gyro_cutoff: float
    native: tuple[NativeLaw, ...] = field(default=(), kw_only=True)
    native_table: Mapping[str, ParameterInfo] = field(default_factory=dict[str, ParameterInfo], kw_only=True)

    def flying(self, cascade: Cascade) -> Self:
        """Return the set for a cascade with some native loops."""
        laws = flown(self.native, cascade)
        axes = {axis for entry in laws for axis in entry.names}
        foreign = {name for axis in axes if axis in self.names for name in self.names[axis][:3]}
        native = frozenset(name for entry in laws for name in entry.parameters)
        # A gain of its own loops has another name than the one of our PID that a parameter otherwise follows from.
        sources = {name: address for entry in laws for name, address in entry.addresses.items()}
        entries = {**self.table, **{name: entry for name, entry in self.native_table.items() if name in native}}
        return replace(
            self,
            table={name: replace(entry, source=sources.get(name, entry.source)) for name, entry in entries.items()},
            names={axis: names for axis, names in self.names.items() if axis not in axes},
            carried=(self.carried - foreign) | native,
            native=laws,
        )


@dataclass(frozen=True)
class Autopilot(ABC):
    """A version of an autopilot on an airframe: "complete" values hold every parameter of it."""

    version: ParameterSet
    vehicle: Vehicle
    rotors: Actuation

    @abstractmethod
    def units(self, values: Values) -> dict[str, float]:
        """Return the unit of the inner P in ours [1/s], by axis; values: complete."""

    @abstractmethod
    def tilt_limit(self, values: Values) -> tuple[float, str]:
        """Return the largest tilt [rad] and the parameter that it comes from."""

    @abstractmethod
    def written_tilt(self, limit: float, present: Values | None) -> dict[str, float]:
        """Return the tilt limit [rad] as a parameter: unchanged where ours follows from the vehicle's."""

    @abstractmethod
    def switched_off(self, settings: Mapping[str, str]) -> dict[str, float]:
        """Return the other parameters at values with which it flies our loops."""

    @abstractmethod
    def chosen(self, settings: Mapping[str, str], unchanged: dict[str, float]) -> dict[str, float]:
        """Return a vehicle's unchanged parameters, updated by the options."""

    @abstractmethod
    def written(self, values: Values, settings: Mapping[str, str], comments: Sequence[str]) -> bytes:
        """Return the content of a parameter file."""

    @abstractmethod
    def check(self, values: Values) -> None:
        """Raise InputError for parameters that prevent arming; values: of the vehicle with the file."""

    @property
    def filters_yaw(self) -> bool:
        """True where its low-pass on yaw is part of its native loops."""
        return any(self.version.yaw_filter in entry.parameters for entry in self.version.native)

    def yaw_cutoff(self, values: Values) -> float:
        """Return the low-pass on yaw torque outside of the loops [Hz]; values: complete."""
        return 0.0 if self.filters_yaw else pid.held_cutoff(values[self.version.yaw_filter])

    def completed(self, values: Values) -> dict[str, float]:
        """Return all parameters, those that are not given at their default."""
        return {**defaults(self.version.table), **values}

    def added_inertia(self, values: Values) -> dict[str, float]:
        """Return the relative inertia or mass added by acceleration gains [1]; values: complete."""
        units = self.units(values)
        return {axis: values[names.d] * units[axis] for axis, names in self.version.names.items()}

    def weights(self, values: Values, counted: bool) -> dict[str, float]:
        """Return the factor on inertia or mass by axis: 1, or with the added inertia where it counts."""
        return {axis: 1.0 + counted * share for axis, share in self.added_inertia(values).items()}

    def loops(self, values: Values) -> dict[str, pid.RateLoop]:
        """Return its loops by axis in our units; values: complete."""
        units = self.units(values)
        return {
            axis: pid.RateLoop(values[names.outer], units[axis] * values[names.p], units[axis] * values[names.i])
            for axis, names in self.version.names.items()
        }

    def to_parameters(
        self, controller: Controller, others: Values, present: Values | None = None, counted: bool = False
    ) -> dict[str, float]:
        """Return the parameters that our loops carry, unrounded.

        Raises InputError where the gains have no such form.

        Args:
            controller: with our gains.
            others: complete other parameters.
            present: those on the vehicle.
            counted: gains on acceleration count as inertia.
        """
        theirs = {} if present is None else self.loops(self.completed(present))
        heavier, units, values = self.weights(others, counted), self.units(others), dict[str, float]()
        for entry in self.version.native:
            values |= entry.to_parameters(controller, units)
        for axis, names in self.version.names.items():
            loop = pid.rate_loop(pid.weighted(pid.axis_gains(controller, axis), heavier[axis]), axis, theirs.get(axis))
            values |= {names.outer: loop.outer, names.p: loop.p / units[axis], names.i: loop.i / units[axis]}
        if not self.filters_yaw:
            values[self.version.yaw_filter] = pid.written_cutoff(
                controller, (present or {}).get(self.version.yaw_filter)
            )
        return values | self.written_tilt(controller.options.tilt_limit, present)

    def to_gains(self, values: Values, filters: Mapping[str, float], counted: bool = False) -> dict[str, Gains]:
        """Return our gains.

        Args:
            values: Complete values.
            filters: Filter time constant t_f by axis [s].
            counted: Whether D counts as inertia, else it does not enter.
        """
        heavier = self.weights(values, counted)
        gains = {
            axis: pid.weighted(pid.parallel(loop, filters[axis]), 1.0 / heavier[axis])
            for axis, loop in self.loops(values).items()
        }
        return gains | ({"y": gains["x"]._replace(t_f=filters["y"])} if "x" in gains else {})

    def native_gains(self, values: Values, controller: Controller) -> dict[str, Any]:
        """Return the gains of the native loops, with a controller's authorities; values: complete."""
        units = self.units(values)
        return {
            axis: gains
            for entry in self.version.native
            for axis, gains in entry.to_gains(values, units, controller).items()
        }

    def held(self, requested: Controller, values: Values, counted: bool) -> Controller:
        """Return the controller that it flies with rounded parameters; our derivative filters stay as asked."""
        native = {axis for entry in self.version.native for axis in entry.names}
        plain = [axis for axis in AXES if LIKE.get(axis, axis) not in native]
        gains: dict[str, Any] = {
            **self.to_gains(values, {axis: pid.axis_gains(requested, axis).t_f for axis in plain}, counted),
            **self.native_gains(values, requested),
        }
        tilt, cutoff = pid.held_tilt(self.tilt_limit(values)[0]), self.yaw_cutoff(values)
        options = replace(requested.options, tilt_limit=tilt, yaw_torque_cutoff=cutoff)
        return replace(pid.with_gains(requested, gains), options=options)

    def others(self, settings: Mapping[str, str], present: VehicleParameters | None) -> dict[str, float]:
        """Return the other written parameters: as on the vehicle, or such that nothing else acts."""
        if present is None or settings[OTHERS.name] != KEEP:
            off = self.switched_off(settings)
            return {name: value for name, value in off.items() if name not in self.version.carried}
        unchanged = {
            name: value
            for name, value in present.values.items()
            if name in self.version.table and name not in self.version.carried
        }
        return self.chosen(settings, unchanged)

    def export(
        self, request: Request, present: VehicleParameters | None, setup: tuple[str, str], differences: Differences
    ) -> Bundle:
        """Return the parameter file; present: what is on the vehicle; setup: comments on the version and the vehicle.

        Raises InputError where the gains have no such form or leave the documented ranges.
        """
        gyro = self.version.gyro
        requested, settings = (
            pid.with_measured_rates(request.controller, yaw_filter=not self.filters_yaw),
            request.settings,
        )
        if "x" in self.version.names:
            pid.check_horizontal(requested, self.version.name)
        before = {} if present is None else present.values
        others = self.others(settings, present)
        complete, counted = self.completed(others), settings[DERIVATIVE.name] == "inertia"
        carried = self.to_parameters(requested, complete, None if present is None else before, counted)
        wanted = {name: {**carried, **others}[name] for name in self.version.table if name in carried or name in others}
        unchanged = [name for name, value in others.items() if before.get(name) == value]
        written = parameters(self.version.table, wanted, single, self.version.name, before, unchanged)
        values = {parameter.name: parameter.held for parameter in written}
        self.check({**before, **values})
        assumed = {name: complete[name] for name in self.version.scaling if name not in others}
        return Bundle(
            files={self.version.file: self.written(values, settings, (*heading(request, parameter_comment), *setup))},
            rollback={self.version.file: self.rollback(request, values, present)},
            held=self.held(requested, {**before, **complete, **values}, counted),
            differences=(
                *(() if present is None else option_changes(self.version.table, written)),
                *describe_unmanaged(present, {name: others[name] for name in unchanged}, assumed),
                *differences(values, complete),
            ),
            target_version=self.version.name,
            parameters=written,
            # Where our loops carry it, it is part of what is verified.
            gyro=None
            if gyro in self.version.carried
            else GyroFilter(gyro, before.get(gyro, self.version.gyro_cutoff), gyro in before, phase_margins),
        )

    def rollback(self, request: Request, values: Values, present: VehicleParameters | None) -> bytes:
        """Return the file that restores the previous parameters, or the defaults."""
        before, usual = {} if present is None else present.values, defaults(self.version.table)
        missing = [name for name in values if name not in before]
        source = (
            f"the defaults of {self.version.name}: no previous parameter file was given"
            if present is None
            else present.origin
        )
        about = [*heading(request, parameter_comment)[:2], f"Rollback to {source}."]
        if present is not None and missing:
            about.append(f"At the default of {self.version.name}, for that file lacks them: {', '.join(missing)}")
        return self.written({name: before.get(name, usual[name]) for name in values}, request.settings, about)


@dataclass(frozen=True)
class ParameterFile:
    """A parameter file as read.

    Attributes:
        values: Values as given, by the autopilot's names.
        target: The autopilot's name in records.
        loop_parameters: Parameters that act in the loops.
        notes: Notes before that on the added inertia.
        later_notes: Notes after it.
        tells_period: Whether the control period is the file's.
    """

    path: ReadableFile
    values: Values
    target: str
    loop_parameters: Collection[str]
    notes: tuple[str, ...]
    later_notes: tuple[str, ...]
    tells_period: bool = False


def cascade_for(version: ParameterSet, settings: Mapping[str, str]) -> Cascade:
    """Return the cascade that a file is read into: our PID, or native loops."""
    if settings.get(LOOPS.name, OUR_LOOPS) == OUR_LOOPS:
        return close_cascade(law("pid"), law("pid"))
    native = {"attitude" if "roll" in entry.names else "position": entry.law for entry in version.native}
    every = position_every(settings) if "position" in native else 1
    return close_cascade(law(native.get("position", "pid")), law(native.get("attitude", "pid")), every)


def imported(
    autopilot: Autopilot,
    read: ParameterFile,
    airframe: Airframe,
    cascade: Cascade,
    settings: Mapping[str, str],
    values: Values,
) -> ImportedController:
    """Return the controller of a parameter file; raises InputError naming file and gain.

    cascade: of `cascade_for`; values: complete.
    """
    counted = settings[DERIVATIVE.name] == "inertia"
    shares = {autopilot.version.names[axis].d: share for axis, share in autopilot.added_inertia(values).items()}
    tilt, tilt_name = autopilot.tilt_limit(values)
    record = record_of(
        read.path,
        autopilot.version.target,
        read.target,
        settings,
        read.values,
        read.loop_parameters,
        autopilot.version.carried,
    )
    untouched = tuple(name for name in read.values if name not in record.parameters)
    notes = (
        *read.notes,
        *inertia_note(shares, counted),
        *read.later_notes,
        *tilt_note(tilt, tilt_name),
        *untuned_notes(record, untouched),
        *((assumed_note(settings, read.tells_period),) if "x" in autopilot.version.names else ()),
    )
    controller = with_authorities(by_default(airframe, cascade, tilt, settings), autopilot.units(values))
    gains = {**autopilot.to_gains(values, filters(settings), counted), **autopilot.native_gains(values, controller)}
    controller = filled(controller, gains, read.path)
    options = replace(controller.options, yaw_torque_cutoff=autopilot.yaw_cutoff(values))
    return ImportedController(replace(controller, options=options, vehicle=record), notes, untouched)


def phase_margins(controller: Controller, cutoff: float) -> list[FilteredLoop]:
    """Return `filter_rows` of a controller; a listing of targets does not wait for the compiler that margins take."""
    from tuner.extensions.autopilots.gyro_filter import filter_rows

    return filter_rows(controller, cutoff)
