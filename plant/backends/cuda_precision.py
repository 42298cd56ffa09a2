"""Model functions in single precision: every number that is written in them becomes a float32.

Numba takes a literal for a double and promotes whatever meets it, so one `0.5 * h` would turn a step into double precision.
"""

from types import CodeType, FunctionType
from typing import Any

import numpy as np

from plant.backends.rebind import Rebinder, Wrap


class CudaRebinder(Rebinder):
    """Rebinds model functions to one precision: float32 or float64."""

    def __init__(self, names: dict[str, Any], wrap: Wrap, real: type[np.floating]) -> None:
        super().__init__(names, wrap)
        self._real = real

    def _rebound(self, function: FunctionType) -> FunctionType:
        rebound = super()._rebound(function)
        rebound.__code__ = self._with_numbers(rebound.__code__)
        return rebound

    def _with_numbers(self, code: CodeType) -> CodeType:
        return code.replace(co_consts=tuple(self._number(value) for value in code.co_consts))

    def _translate(self, name: str, value: Any) -> Any:
        return self._number(super()._translate(name, value))

    def _number(self, value: Any) -> Any:
        return self._real(value) if isinstance(value, float) and self._real is not np.float64 else value
