"""The casadi backend: the model as CasADi expressions, for exact linearisation and gradients of the loop that flies."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca

from plant.backends.rebind import Rebinder
from plant.records import flatten, pack, size


def _clip(a: Any, low: Any, high: Any) -> Any:
    return ca.fmin(ca.fmax(a, low), high)


def _hypot(a: Any, b: Any) -> Any:
    return ca.sqrt(a * a + b * b)


NAMES: dict[str, Any] = {
    "absolute": ca.fabs,
    "asin": ca.asin,
    "atan2": ca.atan2,
    "both": ca.logic_and,
    "clip": _clip,
    "cos": ca.cos,
    "either": ca.logic_or,
    "exp": ca.exp,
    "floor": ca.floor,
    "hypot": _hypot,
    "log": ca.log,
    "maximum": ca.fmax,
    "minimum": ca.fmin,
    "select": ca.if_else,
    "sign": ca.sign,
    "sin": ca.sin,
    "sqrt": ca.sqrt,
    "tan": ca.tan,
    "tanh": ca.tanh,
}


def rebinder(stand_ins: Mapping[Callable[..., Any], Callable[..., Any]] | None = None) -> Rebinder:
    """Return a rebinder to CasADi operations; stand_ins: what is called in place of a model function."""
    return Rebinder(NAMES, stand_ins=stand_ins)


def symbolic_function(name: str, function: Callable[..., Any], kinds: Sequence[Any]) -> ca.Function:
    """Return the CasADi function of a model function: arguments are records or scalars (`float`), each one a column."""
    bound = rebinder()(function)
    columns, arguments = [], []
    for i, kind in enumerate(kinds):
        column = ca.SX.sym(f"a{i}", 1 if kind is float else size(kind))
        columns.append(column)
        arguments.append(column if kind is float else pack(kind, [column[j] for j in range(column.numel())]))
    result = bound(*arguments)
    leaves = flatten(result) if isinstance(result, tuple) else [result]
    return ca.Function(name, columns, [ca.vertcat(*leaves)])
