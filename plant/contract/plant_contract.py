"""The contract of a plant: records with units, equations that are pure and work at rest, the same numbers on every backend."""

from collections.abc import Callable, Iterator, Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

from plant.contract.violation import ContractViolation, violations_of
from plant.model.plant_model import PlantModel, plant_from
from plant.records import flatten, pack, size, zeros

SAMPLES = 6
# Spread of states and inputs about rest, and of parameters about their nominal values; what sums in another order may differ by.
ABOUT, FACTOR, RELATIVE = 1.0, 0.1, 1e-9


def violations_of_plant(names: Mapping[str, object], name: str, file: str) -> list[ContractViolation]:
    """Return the violations of a plant, described by a module's names."""
    plant: list[PlantModel] = []

    def checked() -> Iterator[ContractViolation]:
        plant.append(plant_from(names, name, file))
        yield from clauses(plant[0])

    return violations_of(checked, SimpleNamespace(**names), file)


def clauses(plant: PlantModel) -> Iterator[ContractViolation]:
    """Yield what a plant whose records are right breaks."""
    for name in ("derivative", "output"):
        yield from _is_pure(plant, name)
        yield from _backends_agree(plant, name)


def samples(plant: PlantModel) -> list[tuple[Any, ...]]:
    """Return random arguments of the equations about rest, in their domain; rest itself where there are none."""
    draw = np.random.default_rng(2)
    state, command = plant.rest(plant.parameters)
    rest = (state, command, zeros(plant.Disturbance), plant.parameters)
    kinds = (plant.State, plant.Input, plant.Disturbance)
    middles = (flatten(state), flatten(command), [0.0] * size(plant.Disturbance))
    cases: list[tuple[Any, ...]] = []
    for _ in range(SAMPLES):
        parts = [
            pack(kind, (np.array(middle) + ABOUT * draw.normal(size=len(middle))).tolist())
            for kind, middle in zip(kinds, middles, strict=True)
        ]
        nominal = np.array(flatten(plant.parameters), dtype=float)
        factors = 1.0 + FACTOR * draw.uniform(-1.0, 1.0, len(nominal))
        cases.append((*parts, pack(plant.Parameters, (nominal * factors).tolist())))
    return [case for case in cases if _has_value(plant, case)] or [rest]


def _has_value(plant: PlantModel, case: tuple[Any, ...]) -> bool:
    """Return True if arguments lie in the equations' domain: a tank has no level below 0."""
    try:
        return bool(np.isfinite([*flatten(plant.derivative(*case)), *flatten(plant.output(*case))]).all())
    except (ArithmeticError, ValueError):
        return False


def _is_pure(plant: PlantModel, name: str) -> Iterator[ContractViolation]:
    function = getattr(plant, name)
    for case in samples(plant):
        if flatten(function(*case)) != flatten(function(*case)):
            yield ContractViolation(
                name, "gives other numbers when it is asked again; it must hang on its arguments alone"
            )
            return


def _backends_agree(plant: PlantModel, name: str) -> Iterator[ContractViolation]:
    # Here, because the compilers take a second to import.
    from plant.backends.lanes import compiled

    function, cases = getattr(plant, name), samples(plant)
    wanted = np.array([flatten(function(*case)) for case in cases])
    kinds = (plant.State, plant.Input, plant.Disturbance, plant.Parameters)
    evaluators: dict[str, Callable[[], Any]] = {
        "NumPy": lambda: _on_arrays(function, kinds, cases),
        "CasADi": lambda: _in_casadi(function, kinds, cases),
        "the compiled lanes": lambda: [flatten(compiled(function)(*case)) for case in cases],
    }
    for backend, evaluate in evaluators.items():
        if not np.allclose(evaluate(), wanted, rtol=RELATIVE, atol=RELATIVE * (1.0 + np.abs(wanted).max())):
            yield ContractViolation(name, f"gives other numbers on {backend} than in Python")


def _on_arrays(function: Callable[..., Any], kinds: tuple[Any, ...], cases: list[tuple[Any, ...]]) -> np.ndarray:
    from plant.backends import array

    columns = [
        pack(kind, [np.array(leaf) for leaf in zip(*[flatten(case[i]) for case in cases], strict=True)])
        for i, kind in enumerate(kinds)
    ]
    leaves = flatten(array.rebinder()(function)(*columns))
    return np.stack([np.broadcast_to(leaf, len(cases)) for leaf in leaves], axis=1)


def _in_casadi(function: Callable[..., Any], kinds: tuple[Any, ...], cases: list[tuple[Any, ...]]) -> np.ndarray:
    from plant.backends import symbolic

    made = symbolic.symbolic_function("plant", function, kinds)
    rows = [made(*[flatten(part) for part in case]) for case in cases]
    return np.array([np.array(row).ravel() for row in rows])
