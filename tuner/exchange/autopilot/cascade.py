"""Autopilots that hold our PID as parameters of a cascade: their loops in our units, and a parameter file written or read.

An angle loop P around a rate loop PI in normalised torque, a position loop P around a velocity loop PI: the form that
`autopilot.pid` gives our PID. Parameters that our loops do not carry scale them or act beside them. On a vehicle that is known
(`aboard`) they stay as they are; otherwise they are chosen so that the autopilot flies what ours fly.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Self

from plant.airframes import Airframe
from plant.airframes.actuation import Actuation
from plant.cascade import AXES, Cascade, close_cascade
from plant.laws import law
from plant.laws.pid import Gains
from plant.vehicle import Vehicle
from tuner.exchange.aboard import DERIVATIVE, KEEP, OTHERS, Aboard, said_of_others
from tuner.exchange.autopilot.assembly import (
    LOOPS,
    OUR_LOOPS,
    assumed_note,
    by_default,
    filled,
    filters,
    inertia_note,
    kept_notes,
    position_every,
    record_of,
    tilt_note,
)
from tuner.exchange.autopilot.own_loops import LIKE, OwnLaw, flown, with_authorities
from tuner.exchange.autopilot.parameters import ParameterInfo, Values, defaults, parameters, single
from tuner.exchange.autopilot.pid import (
    RateLoop,
    axis_gains,
    check_horizontal,
    held_cutoff,
    held_tilt,
    parallel,
    rate_loop,
    weighted,
    with_gains,
    with_measured_rates,
    written_cutoff,
)
from tuner.exchange.target import Bundle, GyroFilter, ImportedController, Request
from tuner.exchange.texts import heading, parameter_comment
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

    target: its name in the registry; name: with the version; file: name of the file that is written. table: every parameter that
    is written, in the order of the file. names: by axis of ours, y goes with x. carried: parameters that our loops carry;
    scaling: those beside them that turn our gains into its units. yaw_filter: low-pass on yaw torque [Hz]; gyro, gyro_cutoff:
    low-pass of the gyro and its default [Hz]. own: laws that are its own loops; own_table: parameters that act in those alone.
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
    own: tuple[OwnLaw, ...] = field(default=(), kw_only=True)
    own_table: Mapping[str, ParameterInfo] = field(default_factory=dict[str, ParameterInfo], kw_only=True)

    def flying(self, cascade: Cascade) -> Self:
        """Return the set for a cascade, some loops of which may be the autopilot's own."""
        laws = flown(self.own, cascade)
        axes = {axis for entry in laws for axis in entry.names}
        foreign = {name for axis in axes if axis in self.names for name in self.names[axis][:3]}
        own = frozenset(name for entry in laws for name in entry.parameters)
        # A gain of its own loops has another name than the one of our PID that a parameter otherwise follows from.
        sources = {name: address for entry in laws for name, address in entry.addresses.items()}
        known = {**self.table, **{name: entry for name, entry in self.own_table.items() if name in own}}
        return replace(
            self,
            table={name: replace(entry, source=sources.get(name, entry.source)) for name, entry in known.items()},
            names={axis: names for axis, names in self.names.items() if axis not in axes},
            carried=(self.carried - foreign) | own,
            own=laws,
        )

    @property
    def filters_gyro(self) -> bool:
        """Whether its low-pass on the gyro is none of what our loops carry."""
        return self.gyro not in self.carried


@dataclass(frozen=True)
class Autopilot(ABC):
    """A version of an autopilot on the vehicle and the rotors of an airframe; "complete" values hold every parameter of it."""

    version: ParameterSet
    vehicle: Vehicle
    rotors: Actuation

    @abstractmethod
    def units(self, values: Values) -> dict[str, float]:
        """Return what one unit of the inner P makes of a rate or speed, in ours [1/s], by axis; values: complete."""

    @abstractmethod
    def tilt_limit(self, values: Values) -> tuple[float, str]:
        """Return the largest tilt [rad] and the parameter that it comes from."""

    @abstractmethod
    def written_tilt(self, limit: float, present: Values | None) -> dict[str, float]:
        """Return the tilt limit [rad] as a parameter, as it is on the vehicle where ours is what we hold of that."""

    @abstractmethod
    def switched_off(self, settings: Mapping[str, str]) -> dict[str, float]:
        """Return what it has beside what our loops carry such that it flies what ours fly."""

    @abstractmethod
    def chosen(self, settings: Mapping[str, str], kept: dict[str, float]) -> dict[str, float]:
        """Return what stays on a vehicle, with what the options choose anew."""

    @abstractmethod
    def written(self, values: Values, settings: Mapping[str, str], comments: Sequence[str]) -> bytes:
        """Return the content of a parameter file."""

    @abstractmethod
    def check(self, values: Values) -> None:
        """Refuse parameters with which a vehicle does not arm; values: what it has with the file."""

    @property
    def filters_yaw(self) -> bool:
        """Whether its low-pass on yaw is a part of its own loops, beside which ours has none."""
        return any(self.version.yaw_filter in entry.parameters for entry in self.version.own)

    def yaw_cutoff(self, values: Values) -> float:
        """Return the low-pass on yaw torque beside the loops as our controller holds it [Hz]; values: complete."""
        return 0.0 if self.filters_yaw else held_cutoff(values[self.version.yaw_filter])

    def completed(self, values: Values) -> dict[str, float]:
        """Return all parameters, those that are not given at their default."""
        return {**defaults(self.version.table), **values}

    def added_inertia(self, values: Values) -> dict[str, float]:
        """Return the share of inertia or mass that the gain on the acceleration adds, by axis [1]; values: complete."""
        units = self.units(values)
        return {axis: values[names.d] * units[axis] for axis, names in self.version.names.items()}

    def weights(self, values: Values, counted: bool) -> dict[str, float]:
        """Return by axis how many times heavier its loop has it than ours: 1, or with the added inertia where that counts."""
        return {axis: 1.0 + counted * share for axis, share in self.added_inertia(values).items()}

    def loops(self, values: Values) -> dict[str, RateLoop]:
        """Return its loops by axis in our units; values: complete."""
        units = self.units(values)
        return {
            axis: RateLoop(values[names.outer], units[axis] * values[names.p], units[axis] * values[names.i])
            for axis, names in self.version.names.items()
        }

    def to_parameters(
        self, controller: Controller, beside: Values, present: Values | None = None, counted: bool = False
    ) -> dict[str, float]:
        """Return the parameters that our loops carry, unrounded.

        beside: complete, what they act with. present: what is on the vehicle. counted: gains on acceleration count as inertia.
        Raises InputError where the gains have no such form.
        """
        theirs = {} if present is None else self.loops(self.completed(present))
        heavier, units, values = self.weights(beside, counted), self.units(beside), dict[str, float]()
        for entry in self.version.own:
            values |= entry.to_parameters(controller, units)
        for axis, names in self.version.names.items():
            loop = rate_loop(weighted(axis_gains(controller, axis), heavier[axis]), axis, theirs.get(axis))
            values |= {names.outer: loop.outer, names.p: loop.p / units[axis], names.i: loop.i / units[axis]}
        if not self.filters_yaw:
            values[self.version.yaw_filter] = written_cutoff(controller, (present or {}).get(self.version.yaw_filter))
        return values | self.written_tilt(controller.options.tilt_limit, present)

    def to_gains(self, values: Values, filters: Mapping[str, float], counted: bool = False) -> dict[str, Gains]:
        """Return our gains; values: complete; filters: t_f by axis [s]; counted: D counts as inertia, else it does not enter."""
        heavier = self.weights(values, counted)
        gains = {
            axis: weighted(parallel(loop, filters[axis]), 1.0 / heavier[axis])
            for axis, loop in self.loops(values).items()
        }
        return gains | ({"y": gains["x"]._replace(t_f=filters["y"])} if "x" in gains else {})

    def own_gains(self, values: Values, controller: Controller) -> dict[str, Any]:
        """Return the gains of the loops that are its own, with the authorities of a controller; values: complete."""
        units = self.units(values)
        return {
            axis: gains
            for entry in self.version.own
            for axis, gains in entry.to_gains(values, units, controller).items()
        }

    def held(self, asked: Controller, values: Values, counted: bool) -> Controller:
        """Return the controller that it flies with rounded parameters; our derivative filters stay as asked."""
        own = {axis for entry in self.version.own for axis in entry.names}
        plain = [axis for axis in AXES if LIKE.get(axis, axis) not in own]
        gains: dict[str, Any] = {
            **self.to_gains(values, {axis: axis_gains(asked, axis).t_f for axis in plain}, counted),
            **self.own_gains(values, asked),
        }
        tilt, cutoff = held_tilt(self.tilt_limit(values)[0]), self.yaw_cutoff(values)
        options = replace(asked.options, tilt_limit=tilt, yaw_torque_cutoff=cutoff)
        return replace(with_gains(asked, gains), options=options)

    def beside(self, settings: Mapping[str, str], present: Aboard | None) -> dict[str, float]:
        """Return what is written beside what our loops carry: as it is on the vehicle, or such that nothing else acts."""
        if present is None or settings[OTHERS.name] != KEEP:
            off = self.switched_off(settings)
            return {name: value for name, value in off.items() if name not in self.version.carried}
        kept = {
            name: value
            for name, value in present.values.items()
            if name in self.version.table and name not in self.version.carried
        }
        return self.chosen(settings, kept)

    def export(
        self, request: Request, present: Aboard | None, setup: tuple[str, str], differences: Differences
    ) -> Bundle:
        """Return the parameter file; present: what is on the vehicle; setup: comments on the version and the vehicle.

        Raises InputError where the gains have no such form or leave the documented ranges.
        """
        gyro = self.version.gyro
        asked, settings = (
            with_measured_rates(request.controller, yaw_filter=not self.filters_yaw),
            request.settings,
        )
        if "x" in self.version.names:
            check_horizontal(asked, self.version.name)
        before = {} if present is None else present.values
        beside = self.beside(settings, present)
        complete, counted = self.completed(beside), settings[DERIVATIVE.name] == "inertia"
        carried = self.to_parameters(asked, complete, None if present is None else before, counted)
        wanted = {name: {**carried, **beside}[name] for name in self.version.table if name in carried or name in beside}
        kept = [name for name, value in beside.items() if before.get(name) == value]
        written = parameters(self.version.table, wanted, single, self.version.name, before, kept)
        values = {parameter.name: parameter.held for parameter in written}
        self.check({**before, **values})
        assumed = {name: complete[name] for name in self.version.scaling if name not in beside}
        return Bundle(
            files={self.version.file: self.written(values, settings, (*heading(request, parameter_comment), *setup))},
            rollback={self.version.file: self.rollback(request, values, present)},
            held=self.held(asked, {**before, **complete, **values}, counted),
            differences=(
                *said_of_others(present, {name: beside[name] for name in kept}, assumed),
                *differences(values, complete),
            ),
            target_version=self.version.name,
            parameters=written,
            gyro=GyroFilter(gyro, before.get(gyro, self.version.gyro_cutoff), gyro in before)
            if self.version.filters_gyro
            else None,
        )

    def rollback(self, request: Request, values: Values, present: Aboard | None) -> bytes:
        """Return the file that restores the previous parameters; those that are not known are the defaults."""
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

    values: as given, by the names that the autopilot has for them. target: what a record calls the autopilot. known: parameters
    that act in the loops. notes, later_notes: what the autopilot has to say of the file, before and after the added inertia.
    tells_period: whether the control period is the file's.
    """

    path: Path
    values: Values
    target: str
    known: Collection[str]
    notes: tuple[str, ...]
    later_notes: tuple[str, ...]
    tells_period: bool = False


def cascade_for(version: ParameterSet, settings: Mapping[str, str]) -> Cascade:
    """Return the cascade that a file is read into: our PID, or those of the autopilot's own loops that are known."""
    if settings.get(LOOPS.name, OUR_LOOPS) == OUR_LOOPS:
        return close_cascade(law("pid"), law("pid"))
    own = {"attitude" if "roll" in entry.names else "position": entry.law for entry in version.own}
    every = position_every(settings) if "position" in own else 1
    return close_cascade(law(own.get("position", "pid")), law(own.get("attitude", "pid")), every)


def imported(
    autopilot: Autopilot,
    read: ParameterFile,
    airframe: Airframe,
    cascade: Cascade,
    settings: Mapping[str, str],
    values: Values,
) -> ImportedController:
    """Return the controller of a parameter file; cascade: of `cascade_for`; values: complete; raises InputError naming file and
    gain.
    """
    counted = settings[DERIVATIVE.name] == "inertia"
    shares = {autopilot.version.names[axis].d: share for axis, share in autopilot.added_inertia(values).items()}
    tilt, tilt_name = autopilot.tilt_limit(values)
    record = record_of(
        read.path, autopilot.version.target, read.target, settings, read.values, read.known, autopilot.version.carried
    )
    untouched = tuple(name for name in read.values if name not in record.parameters)
    notes = (
        *read.notes,
        *inertia_note(shares, counted),
        *read.later_notes,
        *tilt_note(tilt, tilt_name),
        *kept_notes(record, untouched),
        *((assumed_note(settings, read.tells_period),) if "x" in autopilot.version.names else ()),
    )
    found = with_authorities(by_default(airframe, cascade, tilt, settings), autopilot.units(values))
    gains = {**autopilot.to_gains(values, filters(settings), counted), **autopilot.own_gains(values, found)}
    found = filled(found, gains, read.path)
    options = replace(found.options, yaw_torque_cutoff=autopilot.yaw_cutoff(values))
    return ImportedController(replace(found, options=options, vehicle=record), notes, untouched)
