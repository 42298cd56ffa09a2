"""The graphics card: whether there is one, what it is, and how much memory is free."""

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from plant.errors import how_to_install
from tuner.extensions.cuda.kernel import compiler, simulated

NO_CARD = "no CUDA device was found"
NO_COMPILER = f"numba-cuda is not installed ({how_to_install('cuda')})"
NO_TOOLKIT = "the compiler of the CUDA toolkit (NVVM) was not found"


@dataclass(frozen=True)
class Card:
    """A graphics card.

    Attributes:
        name: as the driver gives it.
        capability: of compute, for instance 9.0.
        processors: multiprocessors.
        driver: version of CUDA that it runs.
        release: of the driver itself, empty where the system does not tell.
    """

    name: str
    capability: tuple[int, int]
    processors: int
    driver: tuple[int, int]
    release: str = ""

    @property
    def words(self) -> str:
        """Everything but sources that decides the bits of a flight: the card's kind, the compiler, the driver's assembler."""
        major, minor = self.capability
        return f"sm_{major}{minor}, {compiler()}, CUDA {self.driver[0]}.{self.driver[1]}"


def missing() -> str | None:
    """Return the reason why no card can be used, or None."""
    if simulated():
        return None
    if find_spec("numba_cuda") is None:
        return NO_COMPILER
    from numba import cuda

    if not cuda.is_available():
        return NO_CARD
    from numba.cuda.cudadrv import nvvm

    return None if nvvm.is_available() else NO_TOOLKIT


def card() -> Card:
    """Return the card that flies: the first that CUDA shows (CUDA_VISIBLE_DEVICES chooses)."""
    from numba import cuda

    if simulated():
        return Card("simulator", (0, 0), 1, (0, 0))
    from numba.cuda.cudadrv.driver import get_version  # pyright: ignore[reportAttributeAccessIssue]

    device = cuda.get_current_device()
    name = device.name.decode() if isinstance(device.name, bytes) else str(device.name)
    major, minor = device.compute_capability[:2]
    return Card(name, (major, minor), device.MULTIPROCESSOR_COUNT, get_version(), _release())


def _release() -> str:
    """Return the release of the driver as Linux shows it."""
    try:
        first = Path("/proc/driver/nvidia/version").read_text(encoding="utf-8").splitlines()[0]
    except (OSError, IndexError):
        return ""
    return next((word for word in first.split() if word[0].isdigit() and "." in word), "")


def free_memory() -> float:
    """Return the bytes of the card's memory that are free."""
    from numba import cuda

    return float(cuda.current_context().get_memory_info().free)
