"""One control period of a user's plant, linearized at rest: x+ = A x + B u, o = C x + D u.

The controller's functions are those that fly (`plant.model.closing`), rebound to CasADi, with signals added where a command
goes to the plant or to another channel; the plant moves by the exponential of its slope, which is exact whatever steps fly it.
Inputs u and readings o are those of `objectives.margins.linearise`. Where channels step at several rates there is one
linearization for each control period of their common period.
"""

from copy import copy
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from objectives.margins.derivative import Batch, Derivative, column_of, columns, record_of
from objectives.margins.injection import Functions, TermInjection
from objectives.margins.lifting import common_period, rates_of
from objectives.margins.linearise import LinearLoops, chained
from objectives.margins.period import NO_METERS, NoMeters, Term
from objectives.margins.twins import merge_twins, twins_of
from objectives.plant_system import PlantSystem
from plant.backends import array, symbolic
from plant.errors import InputError
from plant.model.closing import close_plant, to_plant
from plant.model.controller import to_channel
from plant.records import flatten, pack, paths, record_type, size, zeros

Array = NDArray[np.float64]
# Drift of a state in one period, relative to 1 + |state|, up to which it counts as at rest.
STEADY = 1e-9
# Lowest frequency that is looked at [rad in a control period]: a plant of hours is seen like one of milliseconds.
LOWEST = 1e-5


class PlantPeriod:
    """One control period of a plant's loops about rest.

    terms: nonlinear terms of the laws, channel by channel. state: record of all that one period hands to the next. periods: those
    after which all channels step at once again. Raises InputError where these are too many.
    """

    def __init__(self, system: PlantSystem, parameters: Any | None = None) -> None:
        self.system, self.plan, self.plant = system, system.plan, system.plant
        self.control_period = system.timing.control_period
        self.rates = rates_of(self.plan, self.control_period)
        self.periods = common_period(range(len(self.rates)), self.rates)
        self.channels, self.lowest = self.plan.names, LOWEST / self.control_period
        self.plant_inputs = tuple(i for i, each in enumerate(self.plan.channels) if not self.plan.cascades(each))
        self.columns = {name: [gain.column for gain in system.gains if gain.axis == name] for name in self.channels}
        self.loop = close_plant(system.plant, system.plan, NO_METERS, self.control_period)
        self.terms = tuple(
            Term(each.name, each.law, term) for each in self.plan.channels for term in each.law.nonlinear
        )
        parts = {name: part for name, part in self.loop.Flight.__annotations__.items() if name not in LEFT_OUT}
        self.state = record_type("PlantState", parts)
        self.parameters = system.parameters if parameters is None else parameters
        self._nominal = np.array(flatten(system.nominal), dtype=float)
        self._body, self._slope = system.slope(self.parameters)
        shown = pack(self.loop.Body, self._body.tolist()).shown
        self._reference = np.array([[getattr(shown, each.output), 0.0, 0.0] for each in self.plan.channels]).ravel()
        names = paths(self.state)
        self._twins = twins_of(self.plan, names) if self.periods == 1 else []
        self._counters = [
            (names.index(f"control.phase.{each.name}"), each) for each in self.plan.channels if each.every > 1
        ]

    def as_flown(self) -> "PlantPeriod":
        """Return the same with the plant moved by its flights' steps."""
        flown = copy(self)
        flown._slope = self.system.flown_slope(self.parameters).by  # noqa: SLF001
        return flown

    def phases(self, gains: Array) -> list[LinearLoops]:
        """Return the linear loops about rest in each control period.

        gains: gains rows (n, g). The control periods are those of the common period.
        Raises InputError where a law does not keep the plant at rest.
        """
        states = self._start(gains, self._body, self._nominal, self._reference)[0]
        return [self._loops(self._at_phase(states, number), gains) for number in range(self.periods)]

    def _at_phase(self, states: Array, number: int) -> Array:
        """States (n, x) so many control periods after all channels stepped at once."""
        states = states.copy()
        for i, channel in self._counters:
            states[:, i] = number % channel.every
        return states

    def _loops(self, states: Array, gains: Array) -> LinearLoops:
        n, k, w = len(gains), len(self.channels), len(self.terms)
        none = np.zeros((n, k + w + k))
        outputs, entries, _ = self._decide(
            np.concatenate([states, none], axis=1), gains, self._nominal, self._reference
        )
        self._check_rest(states, outputs)
        by_body, by_speed = np.split(self._slope, [len(self._body)], axis=-1)
        slope, m = self._decide.full(entries), by_speed.shape[1]
        x = states.shape[1]
        loops = chained(slope, by_body, by_speed, by_speed @ slope[:, :m, x : x + k], k, w)
        return merge_twins(loops, self._twins)

    def constants(self, gains: Array) -> Any:
        """Return the constants of all channels for gains rows (n, g): leaves are arrays (n, 1, 1) or numbers."""
        stacked = gains.T[..., None, None]
        return array.rebinder()(self.loop.prepare)(pack(self.loop.records.Gains, stacked), self.control_period)

    @cached_property
    def _start(self) -> Batch:
        """State in which a flight starts."""
        kinds = self.loop.records
        gains, body, nominal, reference = columns(
            size(kinds.Gains), len(self._body), size(kinds.Nominal), size(kinds.Reference)
        )
        bind = symbolic.rebinder()
        constants = bind(self.loop.prepare)(record_of(kinds.Gains, gains), self.control_period)
        flight = bind(self.loop.start)(
            record_of(self.loop.Body, body),
            constants,
            record_of(kinds.Nominal, nominal),
            record_of(kinds.Reference, reference),
            zeros(kinds.Noise),
            zeros(kinds.Targets),
            zeros(kinds.Dynamics),
        )
        sampled = self.state(*[getattr(flight, name) for name in self.state._fields])
        return Batch("rest", [gains, body, nominal, reference], [column_of(sampled)])

    @cached_property
    def _decide(self) -> Derivative:
        """The controller's instant, differentiated by state, v, w and r.

        Outputs are the commands to the plant, the next memory, then c, s, y, e.
        """
        kinds, k, w = self.loop.records, len(self.channels), len(self.terms)
        state, v, terms, r, gains, nominal, reference = columns(
            size(self.state), k, w, k, size(kinds.Gains), size(kinds.Nominal), size(kinds.Reference)
        )
        plain = symbolic.rebinder()
        constants = plain(self.loop.prepare)(record_of(kinds.Gains, gains), self.control_period)
        signals = _Signals(self, constants, ca.vertsplit(v), ca.vertsplit(terms) if w else [])
        goal = self._shifted(record_of(kinds.Reference, reference), ca.vertsplit(r))
        before = record_of(self.state, state)
        idle = dict.fromkeys(("status", "end_time"), 0.0)
        flight = self.loop.Flight(
            **{name: getattr(before, name) for name in self.state._fields},
            speed=before.control.command,
            meters=NoMeters(),
            **idle,
        )
        after = symbolic.rebinder(signals.stand_ins())(self.loop.decide)(
            flight,
            constants,
            record_of(kinds.Nominal, nominal),
            goal,
            zeros(kinds.Noise),
            zeros(kinds.Targets),
            pack(kinds.Limits, [1.0] * size(kinds.Limits)),
            0.0,
            self.control_period,
        )
        memory = [column_of(getattr(after, name)) for name in self.state._fields if name != "body"]
        seen = signals.readings(before, goal, after)
        outputs = ca.vertcat(column_of(after.speed), *memory, *seen)
        inputs = ca.vertcat(state, v, terms, r)
        return Derivative("decide", inputs, [inputs, gains, nominal, reference], outputs, ca.SX(0, 1))

    def _shifted(self, goal: Any, by: list[Any]) -> Any:
        """Return the references with r added to their values."""
        parts = [getattr(goal, name) for name in self.plan.names]
        return goal._replace(
            **{
                name: part._replace(value=part.value + r)
                for name, part, r in zip(self.plan.names, parts, by, strict=True)
            }
        )

    def _check_rest(self, states: Array, outputs: Array) -> None:
        m, b = size(self.plant.Input), len(self._body)
        after = outputs[:, m : m + states.shape[1] - b]
        drift = np.abs(after - states[:, b:]) / (1.0 + np.abs(states[:, b:]))
        drift[:, [i - b for i, _ in self._counters]] = 0.0
        if not np.all(drift < STEADY):
            worst = int(np.argmax(drift.max(axis=0), axis=0))
            raise InputError(
                f"the loop does not stay at rest: {paths(self.state)[b + worst]} changes by {drift.max():.3g} in the first "
                "period; let rest(parameters) give a state and an input within the actuators' ranges, and the start of the law "
                "hold them",
                key="margin",
            )


LEFT_OUT = ("speed", "meters", "status", "end_time")
"""Parts of a flight that no period hands to the next, or that only judge it."""


class _Signals(TermInjection):
    """Stand-ins of model functions at one control instant, with recorded signals."""

    def __init__(self, period: PlantPeriod, constants: Any, v: list[Any], w: list[Any]) -> None:
        super().__init__(period.terms, constants, w)
        self._plan, self._v = period.plan, v
        self._commands: dict[int, Any] = {}

    def stand_ins(self) -> Functions:
        """Return the stand-ins of model functions."""
        return {to_plant: self._passed, to_channel: self._passed, **super().stand_ins()}

    def _passed(self, command: Any, channel: float) -> Any:
        self._commands[int(channel)] = command
        return command + self._v[int(channel)]

    def readings(self, before: Any, goal: Any, after: Any) -> list[Any]:
        """Return c, s, y and e; channels on one input have the command of that input."""
        plan = self._plan
        first = [
            int(plan.number(plan.acting_on(each.to)[0].name)) if not plan.cascades(each) else i
            for i, each in enumerate(plan.channels)
        ]
        commands = [self._commands[i] for i in first]
        outputs = [getattr(before.body.shown, each.output) for each in plan.channels]
        goals = [
            getattr(after.control.commands, plan.commanded[each.name])
            if each.name in plan.commanded
            else getattr(goal, each.name).value
            for each in plan.channels
        ]
        errors = [y - target for y, target in zip(outputs, goals, strict=True)]
        signals = [self.seen[i][0] for i in range(len(self.seen))]
        return [ca.vertcat(*part) if part else ca.SX(0, 1) for part in (commands, signals, outputs, errors)]
