"""PID gains beside those of pycollimator's autotuner, at its own limits: `python -m benchmarks.autotuner`.

The autotuner (tests/clients/pycollimator.txt, installed by tests/clients/install.py) makes the integrated absolute error of a
unit step small under limits on the peaks of both sensitivities, which it works out without the filter on its derivative. Ours
searches the same gains for the loop as it flies at 2 kHz, once under the limits that were asked for and once under the peaks
that the autotuner's gains have with the filter. All are judged here by the continuous loop, C = kp + ki/s + kd s/(1 + s/100):
its error from the exact response, its peaks on a grid.
"""

import json
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.signal import tf2ss

import tuner

Array = np.ndarray
PYTHON = Path(__file__).parents[1] / ".clients" / "pycollimator" / "bin" / "python"
FILTER, PERIOD, DURATION = 100.0, 0.0005, 20.0
"""Pole of the derivative filter [rad/s], our control period [s], length of a response [s]."""


class State(NamedTuple):
    """The level behind each lag."""

    first: Annotated[float, "1"]
    second: Annotated[float, "1"]
    third: Annotated[float, "1"]


class Input(NamedTuple):
    """The command of the controller."""

    command: Annotated[float, "1"]


class Disturbance(NamedTuple):
    """A shift of the output: the loop sees of it what it sees of a set point that steps the other way."""

    shift: Annotated[float, "1"]


class Parameters(NamedTuple):
    """The lags."""

    first_lag: Annotated[float, "s"] = 1.0
    second_lag: Annotated[float, "s"] = 1.0
    third_lag: Annotated[float, "s"] = 1.0


class Output(NamedTuple):
    """The level behind all lags, shifted."""

    level: Annotated[float, "1"]


def derivative(state: State, input: Input, disturbance: Disturbance, p: Parameters) -> State:  # noqa: A002, ARG001
    """Three lags in series."""
    return State(
        (input.command - state.first) / p.first_lag,
        (state.first - state.second) / p.second_lag,
        (state.second - state.third) / p.third_lag,
    )


def output(state: State, input: Input, disturbance: Disturbance, p: Parameters) -> Output:  # noqa: A002, ARG001
    """The last lag, shifted."""
    return Output(state.third + disturbance.shift)


class Case(NamedTuple):
    """Lags of the plant [s], the limit on both peaks, and the gains from which the autotuner begins."""

    lags: tuple[float, float, float]
    peak: float
    start: tuple[float, float, float]

    @property
    def transfer(self) -> tuple[Array, Array]:
        """Numerator and denominator in falling powers of s."""
        first, second, third = ([lag, 1.0] for lag in self.lags)
        return np.ones(1), np.convolve(np.convolve(first, second), third)


CASES = (
    Case((1.0, 1.0, 1.0), 1.4, (1.0, 0.5, 0.5)),
    Case((1.0, 1.0, 1.0), 2.0, (1.0, 0.5, 0.5)),
    Case((1.0, 0.5, 0.25), 1.4, (1.0, 0.5, 0.2)),
    Case((1.0, 0.2, 0.2), 1.59, (1.0, 0.5, 0.2)),
)


class Judged(NamedTuple):
    """Integrated absolute error of a unit step, and the peaks of sensitivity and complementary sensitivity."""

    error: float
    ms: float
    mt: float


def judged(case: Case, gains: Any) -> Judged:
    """Return the figures of the continuous loop."""
    kp, ki, kd = gains
    n, d = case.transfer
    c, e = np.array([kp + kd * FILTER, kp * FILTER + ki, ki * FILTER]), np.array([1.0, FILTER, 0.0])
    forward, loop = np.convolve(n, c), np.convolve(d, e)
    closed = np.polyadd(loop, forward)
    s = 1j * np.geomspace(1e-3, 1e4, 20000)
    sensitivity = np.polyval(loop, s) / np.polyval(closed, s)
    peaks = [float(np.max(np.abs(value), axis=0)) for value in (sensitivity, 1.0 - sensitivity)]
    return Judged(step_error(loop, closed), *peaks)


def step_error(loop: Array, closed: Array) -> float:
    """Return the integrated absolute error of a unit step that loop/closed turns into the error."""
    h = 1e-3
    a, b, c, d = tf2ss(loop, closed)
    size = len(a)
    moved = expm(np.block([[a * h, b * h], [np.zeros((1, size + 1))]]))
    state, errors = np.zeros(size), np.empty(round(DURATION / h))
    for k in range(errors.size):
        errors[k] = c[0] @ state + d[0, 0]
        state = moved[:size, :size] @ state + moved[:size, size]
    return float(np.sum(np.abs(errors), axis=0)) * h


CLIENT = """
import json, sys
import jax
jax.config.update("jax_enable_x64", True)
from collimator.library import TransferFunction
from collimator.optimization.pid_autotuning import AutoTuner
case = json.loads(sys.argv[1])
tuner = AutoTuner(TransferFunction(case["num"], case["den"]), n=case["filter"], sim_time=case["seconds"], metric="IAE",
                  pid_gains_0=case["start"], Ms=case["peak"], Mt=case["peak"])
print(json.dumps([float(value) for value in tuner.tune()[0]]))
"""


def autotuned(case: Case) -> list[float]:
    """Return the gains of the autotuner."""
    n, d = case.transfer
    asked = {
        "num": n.tolist(),
        "den": d.tolist(),
        "filter": FILTER,
        "seconds": DURATION,
        "start": case.start,
        "peak": case.peak,
    }
    done = subprocess.run([PYTHON, "-c", CLIENT, json.dumps(asked)], capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def ours(case: Case, ms: float, mt: float) -> list[float]:
    """Return the gains that our search recommends under limits on the peaks of sensitivity and complementary sensitivity."""
    ranges = {"kp": (0.2, 20.0), "ki": (0.1, 10.0), "kd": (0.05, 20.0)}
    searched = {f"level.{name}": {"low": low, "high": high} for name, (low, high) in ranges.items()}
    names = ("first_lag", "second_lag", "third_lag")
    tables = {
        "title": "Three lags in series",
        "seed": 1,
        "plant": {"control_period": PERIOD, "parameters": dict(zip(names, case.lags, strict=True))},
        "channel": [{"name": "level", "law": "pid", "output": "level", "to": "command", "limit": 20.0}],
        "gains": {"level.t_f": 1.0 / FILTER, **searched},
        "scenario": [
            {
                "name": "shift",
                "duration": DURATION,
                "search": 1,
                "held_out": 2,
                "disturbance": {"shift": {"kind": "step"}},
            }
        ],
        "objective": [{"metric": "iae.level"}],
        "margin": [{"quantity": "ms", "max": ms}, {"quantity": "mt", "max": mt}],
        "search": {"algorithm": "cmaes", "population": 16, "generations": 60},
    }
    study = tuner.make_study(tables, plant=globals())
    with TemporaryDirectory() as folder:
        recommended = tuner.run(study, Path(folder) / "results").recommended
    assert recommended is not None
    return [recommended[f"level.{name}"] for name in ranges]


def main() -> None:
    """Print the table."""
    print("| lags [s] | limit | gains of | kp, ki, kd | IAE | Ms | Mt |")
    print("|---|---:|---|---|---:|---:|---:|")
    for case in CASES:
        theirs = autotuned(case)
        reached = judged(case, theirs)
        rows = {
            "pycollimator": theirs,
            "gainproof": ours(case, case.peak, case.peak),
            "gainproof, at those peaks": ours(case, reached.ms, max(reached.mt, case.peak)),
        }
        for who, gains in rows.items():
            error, ms, mt = judged(case, gains)
            lags, numbers = (", ".join(f"{value:.4g}" for value in each) for each in (case.lags, gains))
            print(f"| {lags} | {case.peak:g} | {who} | {numbers} | {error:.4f} | {ms:.4f} | {mt:.4f} |", flush=True)


if __name__ == "__main__":
    main()
