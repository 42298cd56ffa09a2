"""Coverage of the 95 % intervals of `tuner fit` on logs of six plants whose numbers are known.

Each plant is sampled by python-control with the input held over twenty parts of a sampling interval, so that dead times need not
be whole samples. Noise is an autoregressive moving average that the fit does not know; two plants are under feedback.

    python -m benchmarks.plant_fit --logs 300 > benchmarks/results/plant_fit.md         # 25 minutes of a processor
"""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from tuner.extensions.plant_fit.estimate import Problem
from tuner.extensions.plant_fit.intervals import FittedPlant
from tuner.extensions.plant_fit.reading import Experiment, make_experiment
from tuner.extensions.plant_fit.selection import choose
from tuner.extensions.plant_fit.structures import STRUCTURES

Array = np.ndarray
PARTS = 20
"""Parts of a sampling interval."""


@dataclass(frozen=True)
class Case:
    """A plant with known numbers, and how its logs are made.

    Attributes:
        name: Name in the table.
        structure: Structure by its name on the command line.
        numerator: Coefficients from the highest power of s.
        denominator: The same.
        dead_time: Dead time [s], a whole number of parts.
        numbers: Known numbers by name.
        period: Sampling interval [s].
        noise: Standard deviation of the noise's innovations.
        noise_filter: Numerator and denominator of the noise in z^-1.
        hold: Samples between changes of the input or setpoint.
        feedback: Gains of a PI controller, proportional and integral; none in an open loop.
        n_samples: Samples of a log.
    """

    name: str
    structure: str
    numerator: tuple[float, ...]
    denominator: tuple[float, ...]
    dead_time: float
    numbers: Mapping[str, float]
    period: float
    noise: float
    noise_filter: tuple[tuple[float, ...], tuple[float, ...]] = ((1.0,), (1.0,))
    hold: int = 15
    feedback: tuple[float, float] | None = None
    n_samples: int = 600


CASES = (
    Case("first order, open", "first-order", (2.0,), (10.0, 1.0), 3.35, {"K": 2.0, "T": 10.0, "L": 3.35}, 1.0, 0.15),
    Case(
        "second order, open, coloured", "second-order", (1.8,), (120.0, 23.0, 1.0), 2.2,
        {"K": 1.8, "w": 120.0**-0.5, "zeta": 0.5 * 23.0 / 120.0**0.5, "L": 2.2}, 1.0, 0.05, ((1.0, 0.4), (1.0, -0.8)), 40,
    ),
    Case(
        "oscillating, open, coloured", "second-order", (0.5,), (0.25, 0.2, 1.0), 0.13,
        {"K": 0.5, "w": 2.0, "zeta": 0.2, "L": 0.13}, 0.1, 0.02, ((1.0, -0.5), (1.0, -0.9)), 25,
    ),
    Case(
        "zero in the right half-plane, open", "second-order-with-a-zero", (-2.4, 1.2), (12.0, 8.0, 1.0), 0.0,
        {"K": 1.2, "w": 12.0**-0.5, "zeta": 4.0 / 12.0**0.5, "Tz": -2.0}, 0.5, 0.05, ((1.0,), (1.0, -0.6)), 25,
    ),
    Case(
        "first order, closed, coloured", "first-order", (2.0,), (10.0, 1.0), 3.0,
        {"K": 2.0, "T": 10.0, "L": 3.0}, 1.0, 0.1, ((1.0, 0.5), (1.0, -0.9)), 30, (1.0, 0.08),
    ),
    Case(
        "integrating with a lag, closed", "integrating-with-a-lag", (0.3,), (4.0, 1.0, 0.0), 1.25,
        {"K": 0.3, "T": 4.0, "L": 1.25}, 0.5, 0.05, ((1.0,), (1.0, -0.7)), 40, (0.4, 0.0),
    ),
)  # fmt: skip


def simulate(case: Case, seed: int) -> Experiment:
    """Return a log of a case."""
    import control

    rng = np.random.default_rng([2026, seed])
    n, fine = case.n_samples, case.period / PARTS
    system = control.ss(control.tf(list(case.numerator), list(case.denominator)))
    sampled = control.sample_system(system, fine, method="zoh")
    matrices = [np.asarray(getattr(sampled, key)) for key in "ABC"]
    late = round(case.dead_time / fine)
    moves = np.repeat(rng.choice([-1.0, 1.0], n // case.hold + 1), case.hold)[:n]
    moves[: case.hold] = 0.0
    noise = np.asarray(lfilter(*case.noise_filter, rng.normal(0.0, case.noise, n + 200)))[200:]
    run = _open if case.feedback is None else _closed
    inputs, clean = run(case, matrices, late, moves, noise)
    return make_experiment(case.period * np.arange(n), inputs, 5.0 + clean + noise)


def _open(case: Case, matrices: list[Array], late: int, moves: Array, noise: Array) -> tuple[Array, Array]:
    held = np.repeat(moves, PARTS)
    delayed = np.concatenate([np.zeros(late), held[: len(held) - late]])
    return moves, _stepped(matrices, delayed)[::PARTS]


def _stepped(matrices: list[Array], inputs: Array) -> Array:
    a, b, c = matrices
    state, outputs = np.zeros(len(a)), np.empty(len(inputs))
    for i, value in enumerate(inputs):
        outputs[i] = (c @ state)[0]
        state = a @ state + b[:, 0] * value
    return outputs


def _closed(case: Case, matrices: list[Array], late: int, moves: Array, noise: Array) -> tuple[Array, Array]:
    a, b, c = matrices
    assert case.feedback is not None
    kp, ki = case.feedback
    state, integral = np.zeros(len(a)), 0.0
    past = np.zeros(late + PARTS * len(moves))
    inputs, outputs = np.empty(len(moves)), np.empty(len(moves))
    for k, setpoint in enumerate(moves):
        outputs[k] = (c @ state)[0]
        error = setpoint - outputs[k] - noise[k]
        integral += ki * case.period * error
        inputs[k] = kp * error + integral
        past[late + k * PARTS : late + (k + 1) * PARTS] = inputs[k]
        for i in range(k * PARTS, (k + 1) * PARTS):
            state = a @ state + b[:, 0] * past[i]
    return inputs, outputs


def covered(case: Case, seed: int) -> dict[str, tuple[float, float, float]]:
    """Return estimate and interval of each known number, from a log."""
    experiment = simulate(case, seed)
    problem = Problem.of([experiment], 0, None, False)
    plant = FittedPlant.of(choose(problem, [STRUCTURES[case.structure]]))
    return {number.name: (number.value, number.low, number.high) for number in plant.numbers(0)}


def coverage(case: Case, logs: int) -> dict[str, tuple[float, float, float]]:
    """Return the coverage, mean and root mean square error of each known number of a case."""
    return coverage_of(case, [covered(case, seed) for seed in range(logs)])


def coverage_of(case: Case, rows: Sequence[Mapping[str, Sequence[float]]]) -> dict[str, tuple[float, float, float]]:
    """Return the coverage, mean and root mean square error of each known number; rows: of `covered`."""
    table = {}
    for name, true in case.numbers.items():
        values = np.array([row[name] for row in rows])
        # An end that was not found excludes nothing.
        outside = (values[:, 1] > true) | (true > values[:, 2])
        error = np.sqrt(np.mean((values[:, 0] - true) ** 2))
        table[name] = 1.0 - float(outside.mean()), float(values[:, 0].mean()), float(error)
    return table


def row_of(case: Case, table: Mapping[str, tuple[float, float, float]], logs: int) -> str:
    """Return a case's row of the table of results."""
    shown = ", ".join(f"{name} {share:.3f}" for name, (share, *_) in table.items())
    errors = ", ".join(f"{name} {mean:.4g} +- {error:.2g}" for name, (_, mean, error) in table.items())
    return f"| {case.name} | {logs} | {shown} | {errors} |"


HEAD = (
    "| plant | logs | share of 95 % intervals that contain the number | mean of estimates, root mean square error |",
    "|---|---:|---|---|",
)


def main() -> None:
    """Print the coverage of all cases."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=300)
    parser.add_argument("--case", type=int, default=None)
    given = parser.parse_args()
    print(*HEAD, sep="\n")
    for i, case in enumerate(CASES):
        if given.case in (None, i):
            print(row_of(case, coverage(case, given.logs), given.logs), flush=True)


if __name__ == "__main__":
    main()
