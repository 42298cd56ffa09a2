"""A linear plant by its numbers: a transfer function or a state space, written out as the file of a plant would be.

Numbers that are not 0 are its parameters, so that a study may spread them. A disturbance enters with each input ("u_load"), and
one adds to each output ("y_shift").
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import log2
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import numpy as np

from plant.errors import InputError, check_name
from plant.model.plan import check_identifiers
from plant.model.plant_model import PlantModel, plant_from
from plant.model.units import per_time, quotient
from plant.texts import check_text

Rows = Sequence[Sequence[float]]
# Most states: of a dense matrix they are a thousand products in each stage of a Runge-Kutta step, which compile in seconds.
MAX_STATES = 32
# Largest power of 2, and 1 over the smallest, that states of a transfer function are scaled by: about 1e100.
WIDEST = 332
ZERO = "0.0"


class SignalNames(NamedTuple):
    """Names of the signals of a linear plant, by default u, y and x1 on; units by name, by default "1"."""

    inputs: Sequence[str] = ()
    outputs: Sequence[str] = ()
    states: Sequence[str] = ()
    units: Mapping[str, str] = MappingProxyType({})

    def completed(self, **counts: int) -> "SignalNames":
        """Return names and units for so many inputs, outputs and states; InputError with the key where those given do not fit."""
        if not 1 <= counts["states"] <= MAX_STATES:
            raise InputError(f"this plant has {counts['states']} states; allowed: 1 to {MAX_STATES}")
        groups: dict[str, list[str]] = {}
        for letter, (key, count) in zip("uyx", counts.items(), strict=True):
            usual = [letter] if count == 1 and letter != "x" else [f"{letter}{i + 1}" for i in range(count)]
            groups[key] = names = list(getattr(self, key)) or usual
            if len(names) != count:
                raise InputError(f"given {len(names)} names; this plant has {count} {key}", key=key)
            check_identifiers(key, names)
        signals = [name for names in groups.values() for name in names]
        for name, unit in self.units.items():
            check_name("signal", name, signals, key=f"units.{name}")
            check_text(unit, 40, key=f"units.{name}")
        return SignalNames(**groups, units={name: self.units.get(name) or "1" for name in signals})


NAMELESS = SignalNames()


def linear_plant(name: str, numbers: Mapping[str, Mapping[str, Any]], names: SignalNames = NAMELESS) -> PlantModel:
    """Return the plant of `transfer_function` or `state_space` as a study has it; InputError with the key inside [plant]."""
    ((key, table),) = numbers.items()
    try:
        plant = {"transfer_function": _transfer_function, "state_space": _state_space}[key](
            name, names, *table.values()
        )
    except InputError as error:
        raise error.located(key=key) from None
    # A view of units cannot go to another process.
    return replace(plant, make=partial(linear_plant, name, numbers, names._replace(units=dict(names.units))))


def _transfer_function(
    name: str, given: SignalNames, numerator: Sequence[float], denominator: Sequence[float]
) -> PlantModel:
    """Return a plant of coefficients from the highest power of s down, in the phase variables of its controllable form.

    Parameters are b0, b1, ... of the numerator and a0, a1, ... of the denominator, by the power of s.
    """
    for key, each in (("numerator", numerator), ("denominator", denominator)):
        if not each or each[0] == 0.0:
            message = f"given {list(each)}; the first coefficient must not be 0: leave it out"
            raise InputError(message, key=f"transfer_function.{key}")
    n = len(denominator) - 1
    if len(numerator) > n + 1:
        message = f"its degree {len(numerator) - 1} is above {n}, that of the denominator, and no plant differentiates its input"
        raise InputError(f"{message}; write the fast poles into the denominator", key="transfer_function.numerator")
    names = given.completed(inputs=1, outputs=1, states=n)
    w, size = _scales(denominator)
    ratio = quotient(names.units[names.outputs[0]], names.units[names.inputs[0]])
    powers = ["", "s", *(f"s{k}" for k in range(2, n + 1))]
    above, below = [*reversed(numerator), *[0.0] * (n + 1 - len(numerator))], [*reversed(denominator)]
    parameters = {
        f"b{k}": (f"{powers[k]} {ratio}".strip().removesuffix(" 1"), value) for k, value in enumerate(above) if value
    }
    parameters |= {f"a{k}": (powers[k] or "1", value) for k, value in enumerate(below) if value}
    a, b = (
        [f"p.{letter}{k}" if value else ZERO for k, value in enumerate(of)]
        for letter, of in (("a", below), ("b", above))
    )
    last = [f"-{a[k]} * {w ** (k - n + 1)!r} / {a[n]}" if below[k] else ZERO for k in range(n)]
    moves = [*([repr(w) if j == i + 1 else ZERO for j in range(n)] for i in range(n - 1)), last]
    pushes = [*[[ZERO]] * (n - 1), [f"{size * w ** (1 - n)!r} / {a[n]}"]]
    shows = [
        f"({b[k]} - {b[n]} * {a[k]} / {a[n]}) * {w**k / size!r}" if above[k] or above[n] else ZERO for k in range(n)
    ]
    at_once = [f"{b[n]} / {a[n]}" if above[n] else ZERO]
    return _plant_of(name, f"Transfer function of order {n}", names, parameters, moves, pushes, [shows], [at_once])


def _scales(denominator: Sequence[float]) -> tuple[float, float]:
    """Return the frequency [rad/s] and the size that phase variables are counted in, to be about as large as the input.

    Powers of 2, so that they round nothing; the frequency is near the geometric mean of the poles that are not 0.
    """
    sizes = [(k, log2(abs(value))) for k, value in enumerate(reversed(denominator)) if value]
    (low, smallest), (top, largest) = sizes[0], sizes[-1]
    w = round((smallest - largest) / max(top - low, 1))
    size = round(max(value + k * w for k, value in sizes))
    if max(abs(top * w), abs(size)) > WIDEST:
        message = "its coefficients lie too far apart; take another unit of time"
        raise InputError(message, key="transfer_function.denominator")
    return 2.0**w, 2.0**size


def _state_space(name: str, given: SignalNames, a: Rows, b: Rows, c: Rows, d: Rows = ()) -> PlantModel:
    """Return the plant x' = A x + B u, y = C x + D u; matrices by rows, D left out is 0.

    Parameters are "a_1_2" and so on, by row and column from 1.
    """
    n, m, q = len(a), len(b[0]) if b else 0, len(c)
    matrices = {"A": (a, n, n), "B": (b, n, m), "C": (c, q, n), "D": (d or [[0.0] * m] * q, q, m)}
    for key, (matrix, rows, columns) in matrices.items():
        if 0 in (rows, columns) or [len(row) for row in matrix] != [columns] * rows:
            message = (
                f"must have {rows} rows of {columns} numbers, because A has {n} rows, B {m} columns and C {q} rows"
            )
            raise InputError(message, key=f"state_space.{key}")
    if not np.any(b) and not np.any(d):
        message = "all numbers are 0, so no input moves anything; allowed: one that is not 0"
        raise InputError(message, key="state_space.B")
    names = given.completed(inputs=m, outputs=q, states=n)
    inputs, outputs, states, units = names
    parameters: dict[str, tuple[str, float]] = {}
    written: dict[str, list[list[str]]] = {}
    for key, of, by in (("A", states, states), ("B", states, inputs), ("C", outputs, states), ("D", outputs, inputs)):
        matrix = matrices[key][0]
        written[key] = [[ZERO] * len(by) for _ in of]
        for i, j in np.argwhere(matrix).tolist():
            over, under = per_time(units[of[i]]) if of is states else units[of[i]], units[by[j]]
            parameter = f"{key.lower()}_{i + 1}_{j + 1}"
            parameters[parameter] = quotient(over, under) if over != per_time(under) else "1/s", float(matrix[i][j])
            written[key][i][j] = f"p.{parameter}"
    return _plant_of(name, f"State space of order {n}", names, parameters, *written.values())


def _plant_of(
    name: str,
    title: str,
    names: SignalNames,
    parameters: Mapping[str, tuple[str, float]],
    *matrices: list[list[str]],
) -> PlantModel:
    """Return the plant of matrices A, B, C and D of expressions of parameters p; parameters: unit and value by name."""
    inputs, outputs, states, units = names

    def fields(group: Sequence[str], suffix: str = "") -> list[str]:
        return [f"{each}{suffix}: Annotated[float, {units[each]!r}]" for each in group]

    records = {
        "State": fields(states),
        "Input": fields(inputs),
        "Output": fields(outputs),
        "Disturbance": [*fields(inputs, "_load"), *fields(outputs, "_shift")],
        "Parameters": [f"{each}: Annotated[float, {unit!r}] = {value!r}" for each, (unit, value) in parameters.items()],
    }
    lines = ["\n    ".join([f"class {kind}(NamedTuple):", *each]) for kind, each in records.items()]
    signals = [*(f"state.{each}" for each in states), *(f"(input.{each} + disturbance.{each}_load)" for each in inputs)]
    a, b, c, d = matrices
    rates, shown = (
        [
            " + ".join(f"{entry} * {signal}" for entry, signal in zip(row, signals, strict=True) if entry != ZERO)
            for row in map(list.__add__, left, right)
        ]
        for left, right in ((a, b), (c, d))
    )
    moved = ", ".join(rate or f"{ZERO} * {signals[0]}" for rate in rates)
    seen = ", ".join(f"{terms or ZERO} + disturbance.{each}_shift" for terms, each in zip(shown, outputs, strict=True))
    for function, result in (("derivative", f"State({moved})"), ("output", f"Output({seen})")):
        lines.append(f"def {function}(state, input, disturbance, p):\n    return {result}")
    defined: dict[str, Any] = {"__name__": __name__, "__doc__": title, "Annotated": Annotated, "NamedTuple": NamedTuple}
    exec(compile("\n".join(lines), f"<{name}>", "exec"), defined)
    return plant_from(defined, name)


def numbers_of(system: object) -> dict[str, dict[str, Any]]:
    """Return a system of python-control or scipy.signal as the key and the table that [plant] of a study has for it.

    Raises InputError where it is no system, discrete in time, or a transfer function of several inputs or outputs.
    """
    if getattr(system, "dt", None) not in (None, 0):
        raise InputError(
            "the system is discrete in time; give that in continuous time, which is sampled here", key="plant"
        )
    matrices = {key: getattr(system, key, None) for key in "ABCD"}
    if matrices["A"] is not None:
        return {"state_space": {key: np.asarray(matrix, dtype=float).tolist() for key, matrix in matrices.items()}}
    ratio = getattr(system, "to_tf", lambda: system)()
    table = {}
    for key, name in (("numerator", "num"), ("denominator", "den")):
        given = getattr(ratio, name, None)
        if given is None:
            usage = "give the names of a plant, or a linear system of python-control or scipy.signal"
            raise InputError(f"given {type(system).__name__}; {usage}", key="plant")
        while len(given) == 1 and np.ndim(given[0]):
            given = given[0]
        if np.ndim(given[0]):
            raise InputError("a transfer function has one input and one output here; give a state space", key="plant")
        table[key] = np.trim_zeros(np.asarray(given, dtype=float), "f").tolist()
    return {"transfer_function": table}
