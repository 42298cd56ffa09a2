"""One axis in continuous time: double integrator, rotor lag, delay, observer and feedback as one linear state space.

    y'' = a/m + w,   a = actuator(u),   u = law(r, y, y', model of a) - phi(S)

All in acceleration units: u and a are b0 times the command, so b0 cancels. m is the true inertia (or mass) over the nominal
one, w an acceleration that disturbs, S the sliding variable and phi the part of a law that grows slower than S; a linear law
has S = 0. Sampling is a delay: h/2 of the hold, and h of computing where the loop has it, by a Pade approximant.

For certificates, which need a matrix. The loop as sampled is another model; the law stands here in its continuous form
(`Law.continuous`), and the phase of order-1 Pade is off by (w T)^3/12, 0.004 rad at w T = 0.36.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from plant.law_registry import LAWS, law

Array = np.ndarray

INPUTS = ("reference", "disturbance", "power")
OUTPUTS = ("value", "rate", "command", "sliding")


@dataclass(frozen=True)
class StateSpace:
    """Real matrices of a linear time-invariant system.

    x' = a x + b u and y = c x + d u; the shapes are (n, n), (n, m), (p, n) and (p, m).
    """

    a: Array
    b: Array
    c: Array
    d: Array

    def at(self, s: Array) -> Array:
        """Return the transfer matrix (k, p, m) at complex frequencies s (k,) [rad/s]."""
        resolvent = np.asarray(s)[:, None, None] * np.eye(len(self.a)) - self.a
        return self.c @ np.linalg.solve(resolvent, np.broadcast_to(self.b, (len(resolvent), *self.b.shape))) + self.d

    def channel(self, source: str, target: str) -> tuple[Array, Array, Array]:
        """Return the channel from one of INPUTS to one of OUTPUTS.

        It is (a, b (n, 1), c (1, n)) of a closed loop.
        """
        i, j = INPUTS.index(source), OUTPUTS.index(target)
        return self.a, self.b[:, i : i + 1], self.c[j : j + 1]


@dataclass(frozen=True)
class Factors:
    """True over nominal: mass and inertia of the vehicle, time constant of its rotors."""

    mass: float = 1.0
    inertia: float = 1.0
    lag: float = 1.0


@dataclass(frozen=True)
class RotorLag:
    """Rotors as the actuator: dead time T, low-pass, lag and lead.

        e^(-sT) (1 + lead s)/((1 + smoothing s)(1 + lag s))

    Attributes:
        lag: Time constant of the lag [s].
        delay: Dead time T [s].
        lag_aware: True if the law uses the lagged output, by a model with the nominal lag and no lead, or only the
            delayed command.
        order: Order of the Pade approximant, 0 (no delay at all), 1 or 2.
        lead: Time constant of the lead, of yaw, by the rotors' inertia [s].
        smoothing: Time constant of the low-pass on yaw torque [s].
    """

    lag: float
    delay: float
    lag_aware: bool = True
    order: int = 1
    lead: float = 0.0
    smoothing: float = 0.0

    def model(self, factors: Factors) -> StateSpace:
        """Return the state space from u to (delivered, known)."""
        ahead = dead_time(self.delay, self.order if self.delay > 0.0 else 0)
        if self.smoothing > 0.0:
            ahead = _in_series(ahead, _first_order([self.smoothing], [0.0]))
        lag = self.lag * factors.lag
        if self.lag_aware:
            return _in_series(ahead, _first_order([lag, self.lag], [self.lead, 0.0]))
        rotors = _first_order([lag], [self.lead])
        passed = StateSpace(
            rotors.a, rotors.b, np.append(rotors.c, [[0.0]], axis=0), np.append(rotors.d, [[1.0]], axis=0)
        )
        return _in_series(ahead, passed)


@dataclass(frozen=True)
class TiltLoop:
    """The attitude loop as the actuator of a horizontal position axis: reference angle in, angle out, both times gravity.

    lag_aware: true if the law uses the measured angle, false for the setpoint.
    """

    attitude: "AxisLoop"
    lag_aware: bool = True

    def model(self, factors: Factors) -> StateSpace:
        """Return the state space from u to (delivered, known)."""
        a, b, c = closed_loop(self.attitude, factors).channel("reference", "value")
        seen = c if self.lag_aware else np.zeros_like(c)
        return StateSpace(a, b, np.concatenate([c, seen], axis=0), np.array([[0.0], [float(not self.lag_aware)]]))


@dataclass(frozen=True)
class AxisLoop:
    """One axis of a controller, the subject of a certificate.

    Attributes:
        law: Name of its law.
        gains: Its Gains record.
        actuator: Actuator of u.
        loop: "attitude", where the true inertia scales the acceleration, or "position", where the true mass does.
        from_observer: Whether the law takes the rate from its observer.
    """

    law: str
    gains: Any
    actuator: RotorLag | TiltLoop
    loop: str = "attitude"
    from_observer: bool = False

    def closed(self, factors: Factors) -> StateSpace:
        """Return the loop from INPUTS to OUTPUTS; states: y, y', those of the actuator, those of the law."""
        return _closed(self, factors)


class Loop(Protocol):
    """The subject of a certificate: the name of a law, its Gains record, and the loop that it closes."""

    @property
    def law(self) -> str: ...  # noqa: D102
    @property
    def gains(self) -> Any: ...  # noqa: D102
    def closed(self, factors: Factors) -> StateSpace:
        """Return the loop from INPUTS to OUTPUTS."""
        ...


MODELLED = frozenset(name for name, entry in LAWS.items() if entry.continuous is not None)
"""Names of the laws that have a continuous form: those that certificates and designs can speak of."""

WITH_SECTOR = frozenset(name for name, entry in LAWS.items() if entry.sector is not None)
"""Names of the laws whose continuous form leaves out a part of the feedback that lies in a sector."""


def controller(law_name: str, gains: Any, from_observer: bool) -> StateSpace:
    """Return the law from (r, y, y', known) to (u, S).

    It must be in `MODELLED`, and has no direct way from `known` to u.
    """
    form = law(law_name).continuous
    assert form is not None, law_name
    return StateSpace(*[np.array(part) for part in form(gains, from_observer)])


def sector(axis: Loop) -> float:
    """Return kappa [1/s]: the part of the feedback outside the form lies between 0 and kappa S; 0 where there is none."""
    kappa = law(axis.law).sector
    return 0.0 if kappa is None else kappa(axis.gains)


def closed_loop(axis: Loop, factors: Factors | None = None) -> StateSpace:
    """Return the loop from INPUTS to OUTPUTS.

    "power" is phi: what is taken off the command; closing it with phi(S) gives the law that flies.
    """
    return axis.closed(factors or Factors())


def _closed(axis: AxisLoop, factors: Factors) -> StateSpace:
    form, act = controller(axis.law, axis.gains, axis.from_observer), axis.actuator.model(factors)
    assert not form.d[:, 3].any(), "the law would answer at once to what it has just asked for"
    n = 2 + len(act.a) + len(form.a)
    rows = np.eye(n + len(INPUTS))
    y, v, (r, w, phi) = rows[0], rows[1], rows[n:]
    x_act, x_law = rows[2 : 2 + len(act.a)], rows[2 + len(act.a) : n]
    wanted, s = form.c @ x_law + form.d[:, :3] @ np.stack([r, y, v])
    u = wanted - phi
    delivered, seen = act.c @ x_act + act.d * u
    inertia = factors.inertia if axis.loop == "attitude" else factors.mass
    slopes = [
        [v, delivered / inertia + w],
        act.a @ x_act + act.b * u,
        form.a @ x_law + form.b @ np.stack([r, y, v, seen]),
    ]
    ahead, out = np.concatenate(slopes, axis=0), np.stack([y, v, u, s])
    return StateSpace(ahead[:, :n], ahead[:, n:], out[:, :n], out[:, n:])


def is_stable(a: Array) -> bool:
    """Return True if all eigenvalues of a lie in the left half-plane.

    They are off its edge by 1e-9 of the largest.
    """
    poles = np.linalg.eigvals(a)
    return bool(poles.real.max(axis=0) < -1e-9 * np.abs(poles).max(axis=0))


def _first_order(lags: list[float], leads: list[float]) -> StateSpace:
    """(1 + lead s)/(1 + lag s) side by side, from one input."""
    per = 1.0 / np.array(lags)[:, None]
    through = per * np.array(leads)[:, None]
    return StateSpace(-np.diagflat(per), per, np.diagflat(1.0 - through), through)


def _in_series(first: StateSpace, then: StateSpace) -> StateSpace:
    a = np.block([[first.a, np.zeros((len(first.a), len(then.a)))], [then.b @ first.c, then.a]])
    b = np.concatenate([first.b, then.b @ first.d], axis=0)
    return StateSpace(a, b, np.concatenate([then.d @ first.c, then.c], axis=1), then.d @ first.d)


def dead_time(delay: float, order: int) -> StateSpace:
    """Pade approximant of exp(-s delay) with as many zeros as poles."""
    if order == 0:
        return StateSpace(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)))
    if order == 1:
        return StateSpace(np.array([[-2.0 / delay]]), np.array([[2.0 / delay]]), np.array([[2.0]]), np.array([[-1.0]]))
    assert order == 2, order
    # 1 - s T/(1 + s T/2 + s^2 T^2/12), with time counted in T: states of one size.
    return StateSpace(
        np.array([[0.0, 1.0], [-12.0, -6.0]]) / delay,
        np.array([[0.0], [12.0]]) / delay,
        np.array([[0.0, -1.0]]),
        np.array([[1.0]]),
    )
