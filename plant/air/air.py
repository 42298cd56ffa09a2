"""The air of one scenario: mean wind, turbulence, gust and injected accelerations, sampled before the flight.

Columns of the result, one row per control period: wind velocity in the world (ENU) [m/s] 0:3; gust rates p, q, r of the
air about body axes (FLU) [rad/s] 3:6; injected acceleration in the world [m/s2] 6:9; injected angular acceleration in
the body [rad/s2] 9:12. The gust rates are those of a vehicle that is level at yaw 0, where body and world axes
coincide.

Random numbers in their order: the generator spawns three children, always all three. Child 0: the wind direction in [0,
2 pi) (drawn even where it is given), then per step the 5 normals u, v1, v2, w1, w2. Child 1: per step the 3 normals p,
q3, r3. Child 2: per step the 6 normals of the injection. So switching an option on or off leaves the bits of all others
alone, and a longer run begins with the bits of a shorter one. For one scenario at two steps, sample at the finer step
and take every n-th row.
"""

from functools import lru_cache
from math import cos, pi, radians, sin
from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from plant.air.dryden import Dryden, forming
from plant.air.gust import gust_wind
from plant.air.injection import shape_injection
from plant.air.linear_process import sample
from plant.air.spec import AirSpec
from plant.air.window import gate

__all__ = ["COLUMNS", "WIND_COLUMNS", "AirSpec", "draw_air", "steady_wind", "summary"]

Array = NDArray[np.float64]

COLUMNS = 12
# Those that are always there: the wind. Gust rates and injections come behind and are left out when all zero.
WIND_COLUMNS = 3


class _Plan(NamedTuple):
    """The part of the air that all scenarios of a spec share.

    gate (K,); wind without turbulence (K, 3) [m/s], `along` in wind axes and `fixed` in the world; gated sigma of u, v
    and w (K, 3) [m/s] and of p (K,) [rad/s]; samplers, or None where there is no turbulence.
    """

    gate: Array
    along: Array
    fixed: Array
    sigma: Array
    roll_sigma: Array
    processes: Dryden | None


def draw_air(spec: AirSpec, dt: float, generator: Generator, out: Array) -> None:
    """Draw the air of one scenario into (steps, 12), or (steps, 3) where it is a wind alone, at the times k dt [s].

    Columns as in the module's docstring. It is a function of the arguments alone when the generator is fresh: from
    `plant.seeds.generator`.
    """
    assert dt > 0.0 and len(out), "dt and steps come from a checked study"
    plan = _plan(spec, dt, len(out))
    turbulence, rates, injection = generator.spawn(3)
    angle = _wind_direction(spec, turbulence)
    out[:, WIND_COLUMNS:] = 0.0
    wind = plan.along
    if plan.processes is not None:
        gusts, spin = _turbulence(plan, plan.processes, turbulence, rates if spec.angular_rates else None)
        wind = wind + gusts
        if spin is not None:
            out[:, 3:6] = _turned(spin, angle)
    np.add(_turned(wind, angle), plan.fixed, out=out[:, :WIND_COLUMNS])
    if spec.injection is not None:
        normals = injection.standard_normal((len(out), 6))
        out[:, 6:12] = shape_injection(spec.injection, dt, plan.gate, normals)


def steady_wind(spec: AirSpec, generator: Generator) -> Array:
    """Return the mean wind (3,) [m/s] of `draw_air`, world ENU, from a fresh generator."""
    if not spec.mean_wind:
        return np.zeros(3)
    angle = _wind_direction(spec, generator.spawn(1)[0])
    return spec.wind_speed * np.array([cos(angle), sin(angle), 0.0])


def summary(spec: AirSpec) -> dict[str, float | str]:
    """Return the numbers of the turbulence for a report, in SI units.

    "airspeed" is V_eff; length, sigma and tau follow for each axis, lengths in the convention of the specification.
    "frozen_field_ratio" is sigma_u over airspeed; the model holds where it is much smaller than 1.
    """
    field = spec.field
    out: dict[str, float | str] = {
        "spec": spec.spec,
        "intensity": spec.intensity,
        "altitude": spec.altitude,
        "mean_wind": spec.wind_speed,
        "airspeed": field.airspeed,
        "frozen_field_ratio": field.sigma[0] / field.airspeed,
    }
    for axis, length, sigma, tau in zip("uvw", field.length, field.sigma, field.tau, strict=True):
        out |= {f"length_{axis}": length, f"sigma_{axis}": sigma, f"tau_{axis}": tau}
    if spec.angular_rates:
        out |= {f"tau_{axis}": tau for axis, tau in zip("pqr", field.rate_tau, strict=True)}
        out["sigma_p"] = field.roll_rate_sigma
    return out


@lru_cache(maxsize=16)
def _plan(spec: AirSpec, dt: float, steps: int) -> _Plan:
    time = np.arange(steps, dtype=np.float64) * dt
    along, fixed = np.zeros((steps, 3)), np.zeros((steps, 3))
    if spec.mean_wind:
        along[:, 0] = spec.wind_speed
    if spec.gust is not None:
        target = along if isinstance(spec.gust.direction, str) else fixed
        target += gust_wind(time, spec.gust)
    field, factor = spec.field, gate(time, spec.window)
    sigma, roll_sigma = factor[:, None] * np.array(field.sigma), factor * field.roll_rate_sigma
    return _Plan(factor, along, fixed, sigma, roll_sigma, forming(field, dt) if max(field.sigma) > 0.0 else None)


def _turbulence(
    plan: _Plan, processes: Dryden, turbulence: Generator, rates: Generator | None
) -> tuple[Array, Array | None]:
    """Return gated gusts u, v, w and, with a generator for them, gated rates p, q, r, each (K, 3) in wind axes."""
    normals = turbulence.standard_normal((len(plan.gate), 5))
    u = sample(processes.u, normals[:, :1])[:, 0]
    if rates is None:
        v = sample(processes.v.leading(2, 1), normals[:, 1:3])[:, 0]
        w = sample(processes.w.leading(2, 1), normals[:, 3:5])[:, 0]
        return np.stack([u, v, w], axis=1) * plan.sigma, None
    more = rates.standard_normal((len(plan.gate), 3))
    v, r = sample(processes.v, np.column_stack([normals[:, 1:3], more[:, 2]])).T
    w, q = sample(processes.w, np.column_stack([normals[:, 3:5], more[:, 1]])).T
    p = sample(processes.p, more[:, :1])[:, 0]
    spin = np.stack([p * plan.roll_sigma, q * plan.sigma[:, 2], r * plan.sigma[:, 1]], axis=1)
    return np.stack([u, v, w], axis=1) * plan.sigma, spin


def _wind_direction(spec: AirSpec, turbulence: Generator) -> float:
    """Return the direction that the mean wind blows to, counter-clockwise from East [rad]; drawn even where it is given."""
    drawn = turbulence.uniform(0.0, 2.0 * pi)
    return drawn if spec.wind_direction_deg is None else radians(spec.wind_direction_deg)


def _turned(wind_axes: Array, angle: float) -> Array:
    """Return vectors (K, 3) of wind axes (downwind, left, up) in the world; angle from East [rad]."""
    u, v, w = wind_axes.T
    return np.stack([cos(angle) * u - sin(angle) * v, sin(angle) * u + cos(angle) * v, w], axis=1)
