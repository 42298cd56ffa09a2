"""Gain of a sampled loop from a disturbance to an output."""

from typing import Any

import numpy as np
from scipy.linalg import expm

from objectives.margins.closing import close_terms
from objectives.margins.loop_margins import gains_of_terms
from objectives.margins.plant_period import PlantPeriod
from objectives.plant_system import PlantSystem
from plant.errors import InputError, check_name
from plant.model.slope import linear_equations
from plant.records import paths, size

Array = np.ndarray
# Frequencies of the grid, and the lowest as a share of half the sampling rate.
N_POINTS, MIN_SHARE = 120, 1e-5
# Places around the frequency of a mode, in half-widths of its resonance.
RESONANCE_OFFSETS = np.array([-2.0, -1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0, 2.0])
# Numbers of matrices that are solved at once.
MAX_NUMBERS = 2_000_000


class DisturbanceResponse:
    """Response of an output to a disturbance, under any gains.

    Args:
        system: The plant with its loops.
        disturbance: Name of a field of Disturbance.
        output: Name of an output.
        parameters: Parameters of the plant, by default the nominal ones.
    """

    def __init__(self, system: PlantSystem, disturbance: str, output: str, parameters: Any = None) -> None:
        plant = system.plant
        if not hasattr(plant, "derivative"):
            raise InputError("an FMU has no equations; limit a metric of its flights instead", key="disturbance")
        check_name("disturbance", disturbance, paths(plant.Disturbance), key="disturbance")
        check_name("output", output, paths(plant.Output), key="output")
        parameters = system.parameters if parameters is None else parameters
        self._period = PlantPeriod(system, parameters)
        if self._period.periods > 1:
            raise InputError(
                "channels step at several rates, so a sine is answered at several frequencies and has no gain; limit a metric "
                "of flights instead",
                key="output",
            )
        self._shown = paths(self._period.state).index(f"body.shown.{output}")
        self._entry = _held_disturbance(system, parameters, paths(plant.Disturbance).index(disturbance))

    def peaks(self, gains: Array) -> Array:
        """Return the largest gain (n,) over frequency, infinite for unstable loops.

        gains: gains rows (n, g).
        """
        term = gains_of_terms(self._period, gains)[:, 0]
        a = close_terms(self._period.phases(gains)[0], term).a
        return np.array([self._peak(each) for each in a])

    def _peak(self, a: Array) -> float:
        if not np.isfinite(a).all():
            return np.inf
        entry = np.zeros(len(a))
        entry[: len(self._entry)] = self._entry
        seen = _connected(a, entry, self._shown)
        if not seen[self._shown]:
            return 0.0
        a, entry, shown = a[seen][:, seen], entry[seen], int(np.count_nonzero(seen[: self._shown]))
        poles = np.linalg.eigvals(a)
        if np.abs(poles).max() >= 1.0:
            return np.inf
        grid = np.concatenate([[0.0], np.pi * np.geomspace(MIN_SHARE, 1.0, N_POINTS), _near(poles)])
        return float(np.abs(response(a, entry, shown, grid)).max())


def response(a: Array, entry: Array, shown: int, angles: Array) -> Array:
    """Return the transfer function (f,) from w to a state: x+ = a x + entry w.

    Args:
        a: The loop (x, x).
        entry: Column (x,) of the disturbance.
        shown: Number of the state.
        angles: Frequencies (f,) [rad in a period].
    """
    unit, parts = np.eye(len(a)), []
    for part in np.array_split(np.exp(1j * angles), 1 + len(angles) * a.size // MAX_NUMBERS):
        right = np.broadcast_to(entry[:, None].astype(complex), (len(part), len(a), 1))
        parts.append(np.linalg.solve(part[:, None, None] * unit - a, right)[:, shown, 0])
    return np.concatenate(parts)


def _connected(a: Array, entry: Array, shown: int) -> Array:
    """Return True (x,) for states between disturbance and output.

    Others, such as an idle integral, have no part in it.
    """
    links, target = a != 0.0, np.arange(len(a)) == shown
    return _reached(links, entry != 0.0) & _reached(links.T, target)


def _reached(links: Array, begin: Array) -> Array:
    reached = begin
    while not np.array_equal(more := reached | (links @ reached), reached):
        reached = more
    return reached


def _near(poles: Array) -> Array:
    """Return angles (f,) around those of poles, up to half a turn."""
    seen = poles[np.abs(poles) > 0.0]
    width = -np.log(np.abs(seen))
    return np.clip(np.abs(np.angle(seen))[:, None] + width[:, None] * RESONANCE_OFFSETS, 0.0, np.pi).ravel()


def _held_disturbance(system: PlantSystem, parameters: Any, column: int) -> Array:
    """Return the body (b,) after a control period under a unit disturbance: states, actuators, outputs."""
    plant: Any = system.plant
    equations = linear_equations(plant, parameters)
    m = size(plant.Input)
    b, d = equations.b[:, m + column], equations.d[:, m + column]
    n = len(b)
    generator = np.zeros((n + 1, n + 1))
    generator[:n, :n], generator[:n, n] = equations.a, b
    moved = expm(system.timing.control_period * generator)[:n, n]
    return np.concatenate([moved, np.zeros(m), equations.c @ moved + d])
