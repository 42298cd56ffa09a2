"""Golden vectors: what the controller takes, gives and keeps over short flights, as the model functions work it out.

The flights are closed loops, so that the controller mostly works between its limits, where most constants show; leaps of the
reference and every eighth measurement, which is far off, take it to them. Another eighth of the instants lies next to what is
asked for, where sliding mode laws are linear. A flight ends where something becomes infinite or NaN, which exported C refuses.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from plant.backends.c_code import Real, literal
from plant.errors import InputError
from tuner.exchange.c99.precision import matrix
from tuner.exchange.c99.sources import Instant, Program
from tuner.exchange.texts import filled

STEPS = 200
# How many times more noise there is where a measurement is far off, how often it is, and when one lies next to what is asked for.
FAR_OFF, OFTEN, NEXT_TO = 150.0, 8, 3


@dataclass(frozen=True)
class Vectors:
    """One entry point: rows of what it takes, gives and then keeps, in the order of the members, (steps, .).

    start: what its init takes; initial: the state after it, and the output that a refused step would then give.
    Both are empty for an entry point that keeps nothing.
    """

    start: np.ndarray
    initial: np.ndarray
    inputs: np.ndarray
    outputs: np.ndarray
    states: np.ndarray

    @property
    def keeps(self) -> bool:
        """Whether there is a state."""
        return self.initial.size > 0


def golden(program: Program, real: Real, steps: int = STEPS) -> dict[str, Vectors]:
    """Return the vectors of each entry point that is flown."""
    with np.errstate(all="ignore"):
        return {entry.name: _fly(entry.flight(real, steps), real) for entry in program.entries if entry.flight}


def _fly(flight: Iterator[Instant], real: Real) -> Vectors:
    """Return the rows of a flight; InputError where the first step overflows."""
    start, _, initial = map(_leaves, next(flight))
    rows: list[list[np.ndarray]] = []
    # What is no longer finite may raise in the plant, too.
    with suppress(ArithmeticError, ValueError):
        for instant in flight:
            row = [_leaves(part) for part in instant]
            if not all(np.isfinite(part).all() for part in row):
                break
            rows.append(row)
    if not rows:
        message = f"given gains under which the first command is no finite {real.name}; take others"
        raise InputError(message, key="gains")
    return Vectors(start, initial, *map(np.array, zip(*rows, strict=True)))


def _leaves(records: tuple[Any, ...]) -> np.ndarray:
    return np.concatenate([matrix(part)[:, 0] for part in records]) if records else np.zeros(0)


def golden_header(vectors: Mapping[str, Vectors], real: Real, prefix: str, words: Mapping[str, object]) -> str:
    """Write golden.h; prefix: of all names; words: p, P, real, digest, tool, and in `what` what the gains are of."""
    texts = [_entry_texts(name, entry, real, prefix) for name, entry in vectors.items()]
    defines, arrays = ("\n".join(text[0] for text in texts), "\n\n".join(text[1] for text in texts))
    return filled("tuner.exchange.c99", "golden.h", **words, defines=defines, arrays=arrays)


def _entry_texts(entry: str, vectors: Vectors, real: Real, prefix: str) -> tuple[str, str]:
    """Write sizes and arrays of the vectors of one entry point; those of a step are called after what stands before "step"."""
    name = entry.removesuffix("step") if vectors.keeps else f"{entry}_"

    def array(word: str, rows: np.ndarray) -> str:
        lines = ",\n".join(f"    {{{_row(row, real)}}}" for row in rows)
        return f"static const {prefix}_real golden_{name}{word}[{len(rows)}][{rows.shape[1]}] = {{\n{lines}\n}};"

    inputs, outputs = array("inputs", vectors.inputs), array("outputs", vectors.outputs)
    if not vectors.keeps:
        return f"#define GOLDEN_MEASUREMENTS {len(vectors.inputs)}u", f"{inputs}\n\n{outputs}"
    sizes = {
        "STEPS": len(vectors.inputs),
        "INITIAL": len(vectors.initial),
        "OUTPUTS": vectors.outputs.shape[1],
        "STATES": vectors.states.shape[1],
    }
    arrays = [
        *[
            f"static const {prefix}_real golden_{name}{word}[{len(values)}] = {{{_row(values, real)}}};"
            for word, values in (("start", vectors.start), ("initial", vectors.initial))
        ],
        inputs,
        outputs,
        array("states", vectors.states),
    ]
    return "\n".join(f"#define GOLDEN_{name.upper()}{word} {size}u" for word, size in sizes.items()), "\n\n".join(
        arrays
    )


def differs(real: Real, words: Mapping[str, object]) -> str:
    """Write the function that compares numbers bit for bit."""
    return filled("tuner.exchange.c99", "differs.c", **words, digits=17 if real.name == "double" else 9).rstrip()


def _row(values: np.ndarray, real: Real) -> str:
    # Numbers as they are: what is too small to be normal stays so.
    return ", ".join(literal(float(value), real, raised=False).strip("()") for value in values)
