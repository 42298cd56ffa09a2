"""One source, every backend: a law gives the same numbers in Python, on arrays, in CasADi and compiled; C can be made of it."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from plant.backends import array, lanes, symbolic, tracing
from plant.contract.axis import LOOPS, H
from plant.contract.violation import ContractViolation
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law
from plant.records import flatten, pack, size

SAMPLES = 6
# Of each number, or of 1 where it is smaller: what sums in another order may differ by.
RELATIVE = 1e-12
INPUTS = (Channel, Setpoint, Measured, Applied)


class Sample(NamedTuple):
    """Random gains, memory and inputs of a law, as far from rest as flights go."""

    gains: Any
    memory: Any
    inputs: tuple[Any, ...]


def samples(law: Law, loop: str) -> list[Sample]:
    """Return random samples of one loop."""
    draw = np.random.default_rng(2)
    return [_sample(law, loop, draw) for _ in range(SAMPLES)]


def _sample(law: Law, loop: str, draw: np.random.Generator) -> Sample:
    gains = law.Gains(*[draw.uniform(g.span(loop).low, g.span(loop).high) for g in law.gains])
    b0 = 300.0 if loop == "attitude" else 1.0
    memory = pack(law.Memory, draw.normal(size=size(law.Memory)).tolist())
    inputs = (
        Channel(b0, float(draw.integers(2))),
        Setpoint(*draw.normal(size=3).tolist()),
        Measured(*draw.normal(size=2).tolist()),
        Applied(*(draw.normal(size=2) / b0).tolist()),
    )
    return Sample(gains, memory, inputs)


def code_can_be_made_of_it(law: Law) -> Iterator[ContractViolation]:
    """Traced to a graph of operations, as exports to C are: prepare on numbers, start and step on signals, no `if` on a value."""
    graph, bind = tracing.Graph(), tracing.rebinder()
    constants = graph.inputs(law.Constants, "constants.")
    bind(law.start)(constants, graph.inputs(Measured, "m."), graph.input("held"))
    memory, inputs = graph.inputs(law.Memory, "memory."), [graph.inputs(kind, f"{kind.__name__}.") for kind in INPUTS]
    result = bind(law.step)(memory, constants, *inputs, graph.input("h"))
    if not (isinstance(result, tuple) and len(result) == 2 and type(result[1]) is law.Memory):
        yield ContractViolation("step", "does not give (command, Memory) when it is traced")


def backends_agree(law: Law) -> Iterator[ContractViolation]:
    """Arrays, CasADi and compiled lanes give what Python gives, of prepare and step, to rounding."""
    evaluators = (("NumPy", _on_arrays(law)), ("CasADi", _in_casadi(law)), ("the compiled lanes", _compiled(law)))
    for loop in LOOPS:
        cases = samples(law, loop)
        wanted = np.array([_run(_as_it_is, law, case) for case in cases])
        scale = np.maximum(np.abs(wanted), 1.0)
        for name, evaluate in evaluators:
            if not np.allclose(evaluate(cases) / scale, wanted / scale, rtol=RELATIVE, atol=RELATIVE):
                yield ContractViolation("step", f"gives other numbers on {name} than in Python, in the {loop} loop")


def _as_it_is(function: Callable[..., Any]) -> Callable[..., Any]:
    return function


def _run(bind: Callable[..., Any], law: Law, case: Sample) -> list[Any]:
    command, memory = bind(law.step)(case.memory, bind(law.prepare)(case.gains, H), *case.inputs, H)
    return [command, *flatten(memory)]


def _on_arrays(law: Law) -> Callable[[list[Sample]], np.ndarray]:
    bind = array.rebinder()

    def evaluate(cases: list[Sample]) -> np.ndarray:
        gains, memory = (_columns(kind, [case[i] for case in cases]) for i, kind in enumerate((law.Gains, law.Memory)))
        inputs = tuple(_columns(kind, [case.inputs[i] for case in cases]) for i, kind in enumerate(INPUTS))
        leaves = _run(bind, law, Sample(gains, memory, inputs))
        return np.stack([np.broadcast_to(leaf, len(cases)) for leaf in leaves], axis=1)

    return evaluate


def _columns(kind: Any, records: list[Any]) -> Any:
    """Return a record whose leaves are arrays over several records."""
    return pack(kind, [np.array(leaf) for leaf in zip(*[flatten(record) for record in records], strict=True)])


def _in_casadi(law: Law) -> Callable[[list[Sample]], np.ndarray]:
    step = symbolic.symbolic_function("step", law.step, (law.Memory, law.Constants, *INPUTS, float))
    prepare = symbolic.symbolic_function("prepare", law.prepare, (law.Gains, float))

    def evaluate(cases: list[Sample]) -> np.ndarray:
        rows = [
            step(flatten(case.memory), prepare(flatten(case.gains), H), *[flatten(part) for part in case.inputs], H)
            for case in cases
        ]
        return np.array([np.array(row).ravel() for row in rows])

    return evaluate


def _compiled(law: Law) -> Callable[[list[Sample]], np.ndarray]:
    prepare, step = law.prepare, law.step

    def both(gains: Any, memory: Any, channel: Any, setpoint: Any, measured: Any, applied: Any, h: float) -> Any:
        return step(memory, prepare(gains, h), channel, setpoint, measured, applied, h)

    # One function is compiled in two thirds of the time of two.
    native = lanes.compiled(both)

    def evaluate(cases: list[Sample]) -> np.ndarray:
        results = [native(case.gains, case.memory, *case.inputs, H) for case in cases]
        return np.array([[command, *flatten(memory)] for command, memory in results])

    return evaluate
