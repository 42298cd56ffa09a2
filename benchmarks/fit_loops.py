"""Loops tuned on fitted plants, judged on the true ones: 20 logs of the six plants of `benchmarks.plant_fit`, three laws each.

A log becomes a table, a fit with all structures in competition, the study that `tuner fit` writes, gains by `tuner run`, and C99.
The compiled C99 then controls the true plant, whose dead time need not be whole control periods: the plant is sampled by the
matrix exponential, and nothing of the simulation or margins of the tool takes part. The loop is linear, so the response of the
output to an impulse on it is the sensitivity S, and 1/S - 1 the loop's frequency response.

    python -m benchmarks.fit_loops > benchmarks/results/fit_loops.md         # 40 minutes of a processor; needs a C compiler
"""

import argparse
import ctypes
import subprocess
import tempfile
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.linalg import expm

import tuner
from benchmarks.plant_fit import CASES, Case, simulate

Array = np.ndarray
LAWS = ("pi", "pid", "adrc")
N_LOGS, FIRST_SEED = 20, 5000
MAX_MS = 2.0
"""Limit on the peak sensitivity in the studies of `tuner fit`."""
CHANGES = {"search.population": 16, "search.generations": 6, "scenario.0.held_out": 32, "scenario.1.held_out": 32}
"""Shorter searches than those that `tuner fit` writes, for time."""
IMPULSE = 1e-3
N_STEPS = 4096
"""Control periods of a response."""
WRAPPER = """
#include "loop_controller.h"
static loop_state state;
void begin(void) { loop_measured y = {0}; loop_input u = {0}; loop_init(&state, &y, &u); }
float step(float setpoint, float value) {
    loop_reference r = {0}; loop_measured y = {0}; loop_input u = {0};
    r.y.value = setpoint; y.y = value;
    loop_step(&state, &r, &y, &u);
    return u.u;
}
"""


@dataclass(frozen=True)
class Judgement:
    """A tuned loop on the true plant.

    Attributes:
        case: Name of the plant.
        law: Law of the loop.
        structure: Structure that the fit chose.
        ms: Peak sensitivity; infinity for an unstable loop.
        delay_margin: Further dead time that the loop tolerates [control periods].
        least_margin: Limit of the study on it on the fitted plant.
        worst_error: Largest error after a step of the setpoint and of the load, over the error that counts as lost.
    """

    case: str
    law: str
    structure: str
    ms: float
    delay_margin: float
    least_margin: float
    worst_error: float

    @property
    def is_within(self) -> bool:
        """Whether the loop is stable, and its sensitivity and errors are within the study's limits."""
        return self.ms <= MAX_MS and self.worst_error < 1.0


class TruePlant:
    """A plant with a dead time, sampled at a control period [s] with its input held."""

    def __init__(self, case: Case, period: float) -> None:
        denominator = np.array(case.denominator) / case.denominator[0]
        n = len(denominator) - 1
        numerator = np.zeros(n)
        numerator[: len(case.numerator)] = np.array(case.numerator)[::-1] / case.denominator[0]
        system = np.zeros((n + 1, n + 1))
        system[: n - 1, 1:n] = np.eye(n - 1)
        system[n - 1, :n] = -denominator[:0:-1]
        system[n - 1, n] = 1.0
        whole, rest = divmod(case.dead_time / period, 1.0)
        late, early = expm(system * rest * period), expm(system * (1.0 - rest) * period)
        self._step = (early @ late)[:n, :n]
        # For a part `rest` of a period the input of the period before acts.
        self._before, self._now = early[:n, :n] @ late[:n, n], early[:n, n]
        self._output, self._state = numerator, np.zeros(n)
        self._queue = [0.0] * (int(whole) + 1)

    @property
    def output(self) -> float:
        """Output at the begin of the period."""
        return float(self._output @ self._state)

    def move(self, value: float) -> None:
        """Hold an input for a period."""
        self._queue.append(value)
        before, now = self._queue[0], self._queue[1]
        self._queue.pop(0)
        self._state = self._step @ self._state + self._before * before + self._now * now


class Code:
    """C99 of a controller, compiled."""

    def __init__(self, folder: Path) -> None:
        (folder / "wrapper.c").write_text(WRAPPER, encoding="utf-8")
        library = folder / "loop.so"
        sources = [str(folder / name) for name in ("wrapper.c", "loop_controller.c")]
        subprocess.run(
            ["cc", "-std=c99", "-O1", "-ffp-contract=off", "-fPIC", "-shared", *sources, "-lm", "-o", library],
            check=True,
        )
        self._code = ctypes.CDLL(str(library))
        self._code.step.restype = ctypes.c_float
        self._code.step.argtypes = [ctypes.c_float, ctypes.c_float]

    def begin(self) -> None:
        """Start at rest."""
        self._code.begin()

    def step(self, setpoint: float, value: float) -> float:
        """Return the command for a period."""
        return float(self._code.step(setpoint, value))


def errors_of(
    code: Code, case: Case, period: float, setpoint: float = 0.0, load: float = 0.0, impulse: float = 0.0
) -> Array:
    """Return the output less the setpoint (N_STEPS,), from rest, under a setpoint, a load and an impulse on the output."""
    plant, values = TruePlant(case, period), np.empty(N_STEPS)
    code.begin()
    for k in range(N_STEPS):
        measured = plant.output + (impulse if k == 1 else 0.0)
        values[k] = measured - setpoint
        if not abs(measured) < 1e6:
            values[k:] = np.inf
            break
        plant.move(code.step(setpoint, measured) + load)
    return values


def margins_of(response: Array) -> tuple[float, float]:
    """Return peak sensitivity and delay margin [periods] from the output after an impulse of 1."""
    if not np.all(np.isfinite(response)) or np.abs(response[-100:]).max() > 1e-2 * np.abs(response).max():
        return np.inf, 0.0
    frequencies = np.pi * np.arange(1, 8 * N_STEPS + 1) / (8 * N_STEPS)
    # The impulse comes with the second sample.
    sensitivity = np.fft.rfft(response[1:], 16 * N_STEPS)[1:]
    loop = 1.0 / sensitivity - 1.0
    crossings = np.flatnonzero(np.diff(np.signbit(np.abs(loop) - 1.0)))
    phase = np.mod(np.angle(-loop[crossings]), 2.0 * np.pi)
    margins = phase / frequencies[crossings]
    return float(np.abs(sensitivity).max()), float(margins.min(initial=np.inf))


def judged(case: Case, seed: int, home: Path) -> Iterator[Judgement]:
    """Yield the judgement of each law that is tuned on a fit of a log; home: folder to be made."""
    home.mkdir()
    experiment, table = simulate(case, seed), home / "log.csv"
    columns = np.column_stack([experiment.time, experiment.inputs, experiment.outputs])
    np.savetxt(table, columns, delimiter=",", header="time,u,y", comments="", fmt="%.9g")
    found = tuner.fit(table, input="u", output="y")
    for law in LAWS:
        folder = home / law
        folder.mkdir()
        file = folder / "loop.toml"
        file.write_text(found.study(law), encoding="utf-8")
        yield Judgement(case.name, law, found.document.outputs[0].structure, *measured(case, file, folder))


def measured(case: Case, file: Path, folder: Path) -> tuple[float, float, float, float]:
    """Return Ms, delay margin, its limit and the largest error of the loop that a study tunes, on the true plant."""
    study = tuner.load_study(file, CHANGES, kind=tuner.PlantStudy)
    results = tuner.run(study, folder / "results", threads=1, watcher=tuner.Watcher())
    tuner.export(results.gains(), "c99", folder / "c99", flights=2, force=True, watcher=tuner.Watcher())
    code, period = Code(folder / "c99"), study.system.timing.control_period
    tables = tomllib.loads(file.read_text(encoding="utf-8"))
    size = float(tables["scenario"][0]["reference"]["y"]["size"])
    load = float(tables["scenario"][1]["disturbance"]["u_load"]["size"])
    responses = [errors_of(code, case, period, setpoint=size), errors_of(code, case, period, load=load)]
    worst = max(float(np.abs(each).max()) for each in responses) / float(tables["channel"][0]["lost_beyond"])
    limits = [float(each["min"]) for each in tables["margin"] if each["quantity"] == "delay_periods"]
    impulse = errors_of(code, case, period, impulse=IMPULSE) / IMPULSE
    return *margins_of(impulse), max(limits, default=0.0), worst


HEAD = (
    "| plant | law | structure of the fit | Ms (at most 2) | delay margin [periods] | largest error over that of a loss | |",
    "|---|---|---|---:|---:|---:|---|",
)


def main() -> None:
    """Print the table of all loops."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=N_LOGS)
    parser.add_argument("--from", type=int, default=0, dest="first")
    given = parser.parse_args()
    print(
        "| plant | law | structure of the fit | Ms (at most 2) | delay margin [periods] | largest error over that of a loss | |"
    )
    print("|---|---|---|---:|---:|---:|---|")
    rows = []
    with tempfile.TemporaryDirectory() as home:
        for i in range(given.first, given.logs):
            case = CASES[i % len(CASES)]
            for row in judged(case, FIRST_SEED + i, Path(home) / str(i)):
                rows.append(row)
                print(text_of(row), flush=True)
    print(f"\n{sum(each.is_within for each in rows)} of {len(rows)} loops are within their limits.")


def text_of(row: Judgement) -> str:
    """Return a row of the table."""
    mark = "within" if row.is_within else "**beyond**"
    margin = f"{row.delay_margin:.2f} (limit {row.least_margin:g})"
    return f"| {row.case} | {row.law} | {row.structure} | {row.ms:.3f} | {margin} | {row.worst_error:.2f} | {mark} |"


if __name__ == "__main__":
    main()
