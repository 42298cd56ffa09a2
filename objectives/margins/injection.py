"""Signals added to the loop that flies, and read from it.

Functions stand in for a few that it calls:

    speed_commands   adds thrust and torque to the rotor commands in force, behind the controller's model of them
    tilt_for         adds acceleration to what the position loops ask for, roll and pitch to what they ask of the attitude
    `Law.nonlinear`  each term f(s) of a law gives back an input w instead; s and f(s) are read
    norm3            has its derivative, 0, at the zero vector too

So the break point of a channel is the plant input: the controller's record of its command holds no injected signal.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca

from plant.backends import symbolic
from plant.laws.law import Law, Nonlinearity
from plant.quadrotor.allocation import speed_commands
from plant.quadrotor.cascade import AXES, POSITION_AXES, Cascade, Tilt, tilt_for
from plant.quadrotor.nominal import Nominal
from plant.references.track import Reference
from plant.vectors import Rotors, Vec3, axpy_rotors, norm3

Functions = dict[Callable[..., Any], Callable[..., Any]]

# Keeps speed commands finite [N] where the search for a steady flight asks for negative thrust.
MIN_THRUST = 1e-9


@dataclass(frozen=True)
class Term:
    """A nonlinear term of the law on one axis."""

    axis: str
    law: Law
    nonlinearity: Nonlinearity

    @property
    def unit(self) -> str:
        """Unit of the term's signal s."""
        return self.nonlinearity.unit_in("position" if self.axis in POSITION_AXES else "attitude")


def terms_of(cascade: Cascade) -> tuple[Term, ...]:
    """Return the nonlinear terms of a cascade, axis by axis."""
    laws = {axis: cascade.position if axis in POSITION_AXES else cascade.attitude for axis in AXES}
    return tuple(Term(axis, law, entry) for axis, law in laws.items() for entry in law.nonlinear)


class Signals(NamedTuple):
    """Inputs of the linearized loop besides the state.

    injected v (6): added at the break point of each channel, in the unit of its command: m/s2 for x, y and z, N m for roll,
    pitch and yaw. terms w: outputs of the nonlinear terms. reference r (6): added to the set point, m and rad. A fourth, the
    load (6), acts on the plant alone: acceleration in world and angular acceleration in body axes, m/s2 and rad/s2.
    """

    injected: Any
    terms: Any
    reference: Any


class InstantReadings(NamedTuple):
    """Outputs of the linearized loop besides the next state.

    command c (6): at the break point of each channel, without v. signals s of the nonlinear terms. values f(s): what the terms
    would give. output y (6): position [m] and roll, pitch, yaw [rad]. error e (6): output minus set point.
    """

    command: Any
    signals: Any
    values: Any
    output: Any
    error: Any


class TermInjection:
    """Stand-ins of nonlinear terms at one control instant, which return inputs w.

    constants: of all axes, as the laws are handed them; w: a symbol for each term; seen: s and f(s) of each term by its number.
    """

    def __init__(self, terms: tuple[Term, ...], constants: Any, w: list[Any]) -> None:
        self._plain, self._terms, self._constants, self._w = symbolic.rebinder(), terms, constants, w
        self.seen: dict[int, tuple[Any, Any]] = {}

    def stand_ins(self) -> Functions:
        """Return the stand-ins of model functions."""
        return {term.nonlinearity.function: self._term(term.nonlinearity) for term in self._terms}

    def _term(self, nonlinearity: Nonlinearity) -> Callable[..., Any]:
        function = self._plain(nonlinearity.function)

        def stand_in(s: Any, constants: Any) -> Any:
            axis = next(axis for axis in self._constants._fields if getattr(self._constants, axis) is constants)
            index = next(i for i, t in enumerate(self._terms) if t.axis == axis and t.nonlinearity is nonlinearity)
            assert index not in self.seen, f"{nonlinearity.name} of {axis} is called twice a period"
            self.seen[index] = (s, function(s, constants))
            return self._w[index]

        return stand_in


class SignalInjection(TermInjection):
    """Functions called in place of the cascade's at one control instant.

    constants: of all axes, as the laws are handed them; signals: columns v, w, r.
    """

    def __init__(self, terms: tuple[Term, ...], constants: Any, signals: Signals) -> None:
        self._v, w, self._r = (ca.vertsplit(part) if part.numel() else [] for part in signals)
        super().__init__(terms, constants, w)

    def stand_ins(self) -> Functions:
        """Return the stand-ins of model functions."""
        return {speed_commands: self._speeds, tilt_for: self._tilt, **super().stand_ins()}

    def shifted(self, reference: Reference) -> Reference:
        """Return the reference with r added to its set points; those of roll and pitch count in attitude mode."""
        place, by = reference.position, self._r
        return reference._replace(
            position=Vec3(place.x + by[0], place.y + by[1], place.z + by[2]),
            roll=reference.roll + by[3],
            pitch=reference.pitch + by[4],
            yaw=reference.yaw + by[5],
        )

    def _speeds(self, thrust: Rotors, nominal: Nominal) -> Rotors:
        columns = nominal.allocation
        lift = nominal.vehicle.mass * self._v[2]
        for amount, column in zip((lift, *self._v[3:]), columns, strict=True):
            thrust = axpy_rotors(thrust, amount, column)
        up = Rotors(*[ca.fmax(part, MIN_THRUST) for part in thrust])
        return self._plain(speed_commands)(up, nominal)

    def _tilt(self, acceleration: Vec3, heading: Vec3, gravity: Any) -> Tilt:
        pushed = acceleration._replace(x=acceleration.x + self._v[0], y=acceleration.y + self._v[1])
        setpoint = self._plain(tilt_for)(pushed, heading, gravity)
        return Tilt(setpoint.roll + self._r[3], setpoint.pitch + self._r[4])


def _norm3(a: Vec3) -> Any:
    """Euclidean length, with derivative 0 where it is below 1e-30."""
    return ca.sqrt(ca.fmax(a.x * a.x + a.y * a.y + a.z * a.z, 1e-60))


SMOOTH: Functions = {norm3: _norm3}
"""Stand-ins that a plant at rest in still air needs to be differentiated."""
