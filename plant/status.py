"""How a flight ended."""

from enum import Enum


class Status(Enum):
    """The end of a flight. The first that is met, in the order non-finite, tilt, position, is kept for ever."""

    COMPLETED = "the flight was completed"
    TILTED = "the vehicle tilted beyond the limit"
    LOST = "the vehicle left the position limit"
    NON_FINITE = "the state became non-finite or absurdly large"

    @property
    def code(self) -> int:
        """Number that kernels and result files carry for this status."""
        return list(Status).index(self)


COMPLETED, TILTED, LOST, NON_FINITE = (float(status.code) for status in Status)
