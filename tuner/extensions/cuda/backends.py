"""The graphics card as two backends, in double and in single precision; its compiler is imported where it flies."""

from objectives.engine import Engine
from objectives.flown_system import FlownSystem
from tuner.engines.registry import Backend


def _missing() -> str | None:
    from tuner.extensions.cuda import card

    return card.missing()


def _backend(precision: str) -> Backend:
    def engine(system: FlownSystem, root: int) -> Engine:
        from tuner.extensions.cuda.engine import CudaEngine

        return CudaEngine(system, root, precision)

    return Backend(f"cuda-{precision},", _missing, engine)


DOUBLE, SINGLE = _backend("float64"), _backend("float32")
