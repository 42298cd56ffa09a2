"""The contract of a plant: records with units, equations that are pure and work at rest, the same numbers on every backend."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from plant.contract.breach import Breach, found
from plant.model.plant_model import PlantModel, plant_from
from plant.records import flatten, pack, size, zeros

SAMPLES = 6
# Spread of states and inputs about rest, and of parameters about their nominal values; what sums in another order may differ by.
ABOUT, FACTOR, RELATIVE = 1.0, 0.1, 1e-9


def breaches(names: Mapping[str, Any], name: str, file: str) -> list[Breach]:
    """Return what a plant, described by a module's names, breaks, with the lines."""
    plant: list[PlantModel] = []

    def checked() -> Iterator[Breach]:
        plant.append(plant_from(names, name, file))
        yield from clauses(plant[0])

    return found(checked, _Owner(names), file)


class _Owner:
    """The names of a module as attributes."""

    def __init__(self, names: Mapping[str, Any]) -> None:
        self.__dict__.update(names)


def clauses(plant: PlantModel) -> Iterator[Breach]:
    """Yield what a plant whose records are right breaks."""
    for name in ("derivative", "output"):
        yield from _is_pure(plant, name)
        yield from _backends_agree(plant, name)


def samples(plant: PlantModel) -> list[tuple[Any, ...]]:
    """Return random arguments of its equations about rest, where these have a value; rest itself where they have none."""
    draw = np.random.default_rng(2)
    state, command = plant.rest(plant.parameters)
    rest = (state, command, zeros(plant.Disturbance), plant.parameters)
    kinds = (plant.State, plant.Input, plant.Disturbance)
    middles = (flatten(state), flatten(command), [0.0] * size(plant.Disturbance))
    cases = []
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
    """Return whether arguments lie in the domain of the equations: a tank has no level below 0, and no flight goes on there."""
    try:
        return bool(np.isfinite([*flatten(plant.derivative(*case)), *flatten(plant.output(*case))]).all())
    except (ArithmeticError, ValueError):
        return False


def _is_pure(plant: PlantModel, name: str) -> Iterator[Breach]:
    function = getattr(plant, name)
    for case in samples(plant):
        if flatten(function(*case)) != flatten(function(*case)):
            yield Breach(name, "gives other numbers when it is asked again; it must hang on its arguments alone")
            return


def _backends_agree(plant: PlantModel, name: str) -> Iterator[Breach]:
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
            yield Breach(name, f"gives other numbers on {backend} than in Python")


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
