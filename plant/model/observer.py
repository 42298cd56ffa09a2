"""Linear state observer between measured outputs and channels.

The current estimator of G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., section 8.2:
z = p + M (y - C p) with the prediction p = A z + B u of the period before. Its coordinates are outputs, so C picks measured
ones.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from plant.records import record_type


@dataclass(frozen=True)
class Observer:
    """An observer as numbers.

    Args:
        outputs: Names of the n outputs that it estimates, as many as the plant has states.
        inputs: Names of the m inputs of the plant.
        measured: Names of the p outputs that sensors measure.
        filtered: Whether channels read estimates of the measured outputs too.
        title: Keys and values that describe it; two of one plant with one title are the same.
        numbers: Outputs (n) and inputs (m) at rest, then A (n, n), B (n, m) and M (n, p) by rows.
    """

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    measured: tuple[str, ...]
    filtered: bool
    title: str
    numbers: tuple[float, ...]

    @property
    def numbers_type(self) -> Any:
        """Record of the numbers."""
        n, m, p = range(len(self.outputs)), range(len(self.inputs)), range(len(self.measured))
        names = [*[f"y_{i}" for i in n], *[f"u_{k}" for k in m]]
        for letter, columns in (("a", n), ("b", m), ("m", p)):
            names += [f"{letter}_{i}_{j}" for i in n for j in columns]
        return record_type("Observer", dict.fromkeys(names, float))

    def reading(self, output: str) -> str:
        """Return the expression of an output as channels read it."""
        is_estimate = output in self.outputs and (self.filtered or output not in self.measured)
        return f"estimate_{output}" if is_estimate else f"seen.{output}"

    @property
    def start_lines(self) -> list[str]:
        """Lines that start the estimates where the plant rests."""
        return [f"    estimate_{name} = nominal.observer.y_{i}" for i, name in enumerate(self.outputs)]

    @property
    def step_lines(self) -> list[str]:
        """Lines that predict every output and correct it by what is measured."""
        about, predicted, corrected = "nominal.observer", list[str](), list[str]()
        for i, name in enumerate(self.outputs):
            terms = [
                *[
                    f"{about}.a_{i}_{j} * (kept.estimate.{other} - {about}.y_{j})"
                    for j, other in enumerate(self.outputs)
                ],
                *[f"{about}.b_{i}_{k} * (kept.in_force.{u} - {about}.u_{k})" for k, u in enumerate(self.inputs)],
            ]
            predicted.append(f"    predicted_{name} = {_sum([f'{about}.y_{i}', *terms])}")
            terms = [f"{about}.m_{i}_{j} * innovation_{y}" for j, y in enumerate(self.measured)]
            corrected.append(f"    estimate_{name} = {_sum([f'predicted_{name}', *terms])}")
        innovations = [f"    innovation_{name} = seen.{name} - predicted_{name}" for name in self.measured]
        return [*predicted, *innovations, *corrected]


def _sum(terms: Sequence[str]) -> str:
    return " + ".join(terms)
