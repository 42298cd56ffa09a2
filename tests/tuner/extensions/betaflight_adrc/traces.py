"""Random tunes and signals, and the law run on them loop by loop, for the comparison with the firmware's code."""

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.betaflight_adrc import equations
from tuner.extensions.betaflight_adrc.equations import SCHEDULES
from tuner.extensions.betaflight_adrc.settings import AXES, BUILDS, Build, Tune, default_tune

Array = NDArray[np.float64]
N_LOOPS = 1200
ORDER = (
    "adrc_gyro_lpf_hz", "adrc_hover_throttle", "adrc_b0_law", "adrc_b0_scale_max", "adrc_b0_scale_min", "adrc_sigma_decay",
    "adrc_gated_z3_decay", "adrc_liftoff_throttle", "adrc_liftoff_gyro_dps", "adrc_liftoff_hold_ms", "adrc_ground_wc",
    "adrc_wc_ramp_ms", "adrc_ground_dgain", "adrc_sat_z3_inhibit", "adrc_td_hz", "pidsum_limit", "pidsum_limit_yaw",
)  # fmt: skip
"""Settings behind wc, wo and b0 of the three axes, in the row that a judge takes."""


def random_case(seed: int, build: Build = BUILDS["b11"]) -> tuple[Tune, float, Array]:
    """Return a tune of a build, the loop period [s], and signals by loop.

    Columns: rates [deg/s], setpoints [deg/s], applied and commanded collective, saturation.
    """
    rng = np.random.default_rng(seed)
    numbers = {
        **{f"adrc_wc_{axis}": float(rng.integers(20, 150)) for axis in AXES},
        **{f"adrc_wo_{axis}": float(rng.integers(40, 300)) for axis in AXES},
        **{f"adrc_b0_{axis}": float(rng.integers(500, 9000)) for axis in AXES},
        "adrc_gyro_lpf_hz": float(rng.choice([0, 100, 150, 250])),
        "adrc_hover_throttle": float(rng.integers(15, 50)),
        "adrc_b0_scale_max": float(rng.integers(1, 6)),
        "adrc_b0_scale_min": float(rng.choice([21, 50, 80, 100])),
        "adrc_sigma_decay": float(rng.integers(0, 20)),
        "adrc_gated_z3_decay": float(rng.integers(0, 400)),
        "adrc_liftoff_throttle": float(rng.integers(25, 60)),
        "adrc_liftoff_gyro_dps": float(rng.integers(10, 60)),
        "adrc_liftoff_hold_ms": float(rng.integers(0, 60)),
        "adrc_ground_wc": float(rng.choice([0, 5, 10, 40])),
        "adrc_wc_ramp_ms": float(rng.choice([0, 50, 100, 300])),
        "adrc_ground_dgain": float(rng.choice([0, 10, 40])),
        "adrc_td_hz": float(rng.choice([0, 0, 20, 60])),
        "adrc_b0_law": SCHEDULES[str(rng.choice(list(SCHEDULES)))],
        "adrc_sat_z3_inhibit": float(rng.integers(2)),
    }
    tune = default_tune(build).with_numbers({name: value for name, value in numbers.items() if build.has(name)})
    period = float(rng.choice([125e-6, 312e-6, 1e-3]))
    rates = np.cumsum(rng.standard_normal((N_LOOPS, 3)), axis=0) * rng.uniform(0.5, 3.0)
    setpoints = np.repeat(rng.uniform(-300.0, 300.0, (N_LOOPS // 200, 3)), 200, axis=0)
    lift = np.interp(
        np.arange(N_LOOPS), [0, 300, 600, N_LOOPS], [0.0, 0.1, rng.uniform(0.2, 0.9), rng.uniform(0.2, 0.9)]
    )
    commanded = np.clip(lift + 0.05 * rng.standard_normal(N_LOOPS), 0.0, 1.0)
    applied = np.clip(commanded + rng.uniform(0.0, 0.3, N_LOOPS), 0.0, 1.0)
    saturated = (rng.uniform(size=N_LOOPS) < 0.2).astype(float)
    return (
        tune,
        period,
        np.column_stack([rates + rng.standard_normal((N_LOOPS, 3)), setpoints, applied, commanded, saturated]),
    )


def settings_row(tune: Tune) -> list[float]:
    """Return the settings as the row of numbers that a judge takes."""
    return [
        *[tune.of(name, axis) for name in ("wc", "wo", "b0") for axis in AXES],
        *[tune.numbers[name] for name in ORDER],
    ]


def run_law(tune: Tune, period: float, signals: Array, kind: type = np.float64) -> Array:
    """Return P, I, D and the limited output of the axes by loop (n, 12), in the arithmetic of a kind of float."""
    h = kind(period)
    axes = [tune.axis(axis, float(h))._make(map(kind, tune.axis(axis, period))) for axis in AXES]
    constants = tune.gate(period)._make(map(kind, tune.gate(period)))
    gate = equations.SHUT._make(map(kind, equations.SHUT))
    values = signals.astype(kind)
    memories = [equations.seeded(rate)._replace(z2=kind(0), z3=kind(0), output=kind(0)) for rate in values[0, :3]]
    out, saturated = np.zeros((len(values), 12)), kind(0)
    for i, row in enumerate(values):
        after = equations.step_gate(gate, constants, np.abs(row[:3]).max(), row[6], row[7], h)
        for k in range(3):
            memory = equations.released(memories[k], gate, after)
            inhibited = saturated * kind(tune.numbers["adrc_sat_z3_inhibit"])
            terms, memory = equations.step_axis(memory, axes[k], after, row[k], row[3 + k], inhibited, h)
            output = np.clip(terms.p + terms.i + terms.d, -axes[k].limit, axes[k].limit)
            memories[k] = memory._replace(output=output)
            out[i, 4 * k : 4 * k + 4] = *terms, output
        gate, saturated = after, row[8]
    return out
