"""The event whose probability is estimated, and the estimate of it.

A limit function maps independent standard normals to the demand over the capacity of each failure mode; the event is that one
of them reaches 1. Estimators know nothing else of what fails, so flights, plants and closed forms of a textbook are all alike.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from objectives.risk.measures import Interval

Array = NDArray[np.float64]


class LimitFunction(Protocol):
    """Demand over capacity of failure modes, of independent standard normals.

    Attributes:
        dimension: numbers of one vector of standard normals; 0 where nothing is random.
        modes: names of the failure modes, at least one.
    """

    @property
    def dimension(self) -> int: ...  # noqa: D102

    @property
    def modes(self) -> tuple[str, ...]: ...  # noqa: D102

    def values(self, normals: Array) -> Array:
        """Return demand over capacity (n, m) of normals (n, d): a pure function of each row.

        A missing value is NaN and counts as a failure of that mode. Rows may be evaluated in any order, on any
        number of threads.
        """
        ...


class Status(StrEnum):
    """End of an estimate.

    ESTIMATED: the interval is as narrow as asked for.
    WIDE: the evaluations allowed were spent before it was.
    BELOW: the probability is smaller than the smallest asked for; `high` bounds it.
    UNREACHED: no evaluation failed, and nothing brought the event nearer: it may be impossible; `high` bounds it.
    CERTAIN: every evaluation failed; `low` bounds the probability.
    DETERMINISTIC: the limit function has no randomness, so one evaluation decides between 0 and 1.
    """

    ESTIMATED = "estimated"
    WIDE = "wide"
    BELOW = "below"
    UNREACHED = "unreached"
    CERTAIN = "certain"
    DETERMINISTIC = "deterministic"


class Method(StrEnum):
    """Estimator of a probability."""

    CRUDE = "crude Monte Carlo"
    SPLITTING = "splitting"
    EVALUATION = "one evaluation"


class Replica(NamedTuple):
    """One unbiased estimate: a function of limit function, plan, seed and number alone; JSON numbers, so it can be kept.

    Attributes:
        number: number of the stream that it drew from.
        probability: probability of the event.
        ladders: probability of the target of each ladder.
        curve: probability that the largest demand reaches each level of the estimate's curve.
        evaluations: rows of the limit function evaluated.
    """

    number: int
    probability: float
    ladders: tuple[float, ...]
    curve: tuple[float, ...]
    evaluations: int


class ModeEstimate(NamedTuple):
    """Probability of one failure mode and its share of the event.

    Attributes:
        name: name of the mode.
        probability: probability that the mode's demand reaches 1, whatever the other modes do.
        interval: interval of the probability at the level of the estimate.
        share: share of the event's probability; shares add up to more than 1 where modes coincide.
        share_interval: interval of the share.
    """

    name: str
    probability: float
    interval: Interval
    share: float
    share_interval: Interval


class Curve(NamedTuple):
    """Probability that the largest demand over capacity reaches each level."""

    levels: Array
    probability: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class TailEstimate:
    """Probability of the event and the interval that holds it at `level`; one-sided where `status` says that it bounds.

    Modes that no ladder reached have no part in them; their own bounds stand in `modes`.
    """

    status: Status
    method: Method
    probability: float
    low: float
    high: float
    level: float
    evaluations: int
    replicas: tuple[Replica, ...]
    modes: tuple[ModeEstimate, ...]
    curve: Curve


class Progress(NamedTuple):
    """A replica that has just been completed, and the estimate so far."""

    replica: Replica
    probability: float
    low: float
    high: float
    evaluations: int
    expected_evaluations: int


OnProgress = Callable[[Progress], None]
